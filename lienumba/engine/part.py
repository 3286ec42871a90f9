"""A share of a sweep, as the jobs of a batch queue have one each."""

import re
from collections.abc import Sequence
from dataclasses import dataclass

from lienumba.errors import ScenarioError
from lienumba.scenario.resolve import Scenario
from lienumba.words import show


def share_of(labels: Sequence[int], given: object, resolved: Scenario) -> Sequence[int]:
    """Those of the labels that belong to a part, if a scenario has any."""
    part, data = SweepPart.parse(given), resolved.data
    if resolved.plan is not None:
        raise ScenarioError(
            f"part {part.number}/{part.of}: a study has none, because its points are compared; run it whole"
        )
    if data.sweep.stop is not None:
        raise ScenarioError(
            f"part {part.number}/{part.of}: a sweep that ends by sweep.stop has none, because only the whole knows "
            "when it has runs enough; take sweep.stop out, or run it whole"
        )
    return part.share(labels)


@dataclass(frozen=True)
class SweepPart:
    """The part `number` (from 1) of so many, which are as equal as can be."""

    number: int
    of: int

    @classmethod
    def parse(cls, given: object) -> "SweepPart":
        """Of a text such as "3/20", or of the two numbers."""
        match = re.fullmatch(r"\s*(\d+)\s*/\s*(\d+)\s*", given) if isinstance(given, str) else None
        numbers = [int(x) for x in match.groups()] if match else given
        if not isinstance(numbers, list | tuple) or len(numbers) != 2 or any(type(x) is not int for x in numbers):
            text = given if isinstance(given, str) else show(given)
            raise ScenarioError(f"part {text}: does not say which part of how many; give it such as 3/20")
        number, of = numbers
        if of < 1 or not 1 <= number <= of:
            last = max(of, 1)
            raise ScenarioError(f"part {number}/{of}: does not exist; parts count from 1/{last} to {last}/{last}")
        return cls(number, of)

    @property
    def suffix(self) -> str:
        """What keeps the files of parts apart."""
        return f".part{self.number}of{self.of}"

    def share(self, labels: Sequence[int]) -> Sequence[int]:
        """The labels of this part: consecutive ones."""
        if self.of > len(labels):
            raise ScenarioError(
                f"part {self.number}/{self.of}: there are more parts than runs, of which there are {len(labels)}; give "
                f"{len(labels)} parts at most"
            )
        first, last = (len(labels) * n // self.of for n in (self.number - 1, self.number))
        return labels[first:last]
