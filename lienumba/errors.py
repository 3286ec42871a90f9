"""Errors that a user of lienumba meets, and the problems that they tell of: data, made into sentences at the end."""

import re
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from enum import Enum
from typing import Final, Literal, Self

from lienumba.words import plural, readable, show

MISSING = "is missing"
UNKNOWN = "is not a known key"
MOST, MOST_ALIKE = 100, 20  # sentences of an error


class Nothing(Enum):
    """Where no value belongs to a problem; None is one."""

    NOTHING = 0


NOTHING: Final = Nothing.NOTHING


@dataclass(frozen=True)
class Problem:
    """What is wrong, as a sentence says it: `place = value: rule; remedy`.

    place: of a key, as the file has it; verb: what is said of the key itself, such as MISSING; formula: by which the
    file writes the value; within: where that is, from the outermost on, such as a point of a study.
    """

    place: str
    rule: str
    remedy: str = ""
    value: object = field(default=NOTHING, hash=False)
    verb: str = field(default="", kw_only=True)
    formula: str | Literal[Nothing.NOTHING] = field(default=NOTHING, kw_only=True)
    within: tuple[str, ...] = field(default=(), kw_only=True)

    def __str__(self) -> str:
        values = dict.fromkeys(show(x) for x in (self.formula, self.value) if x is not NOTHING)
        key = " ".join(x for x in (" = ".join([self.place, *values]), self.verb) if x)
        text = ": ".join(x for x in (*self.within, key, self.rule) if x)
        return f"{text}; {self.remedy}" if self.remedy else text

    def below(self, place: str) -> "Problem":
        """The same, where its own place is a key of the table at another."""
        return replace(self, place=f"{place}.{self.place}" if self.place else place)

    def inside(self, place: str) -> "Problem":
        """The same, where all of which it tells is a part of something else, which is at this place."""
        return replace(self, within=(place, *self.within))


def missing(place: str, remedy: str, why: str = "") -> Problem:
    """The problem of a key that must be there."""
    return Problem(place, why, remedy, verb=MISSING)


class BadValueError(ValueError):
    """What is wrong with a value, said where it is not known at which place it stands."""

    def __init__(self, rule: str, remedy: str = "", key: str = "", value: object = NOTHING, verb: str = "") -> None:
        self.problem = Problem(key, rule, remedy, value, verb=verb)  # key: within the value, if it is a table
        super().__init__(rule, remedy, key, value, verb)

    def __str__(self) -> str:
        return str(self.problem)

    def at(self, place: str, value: object = NOTHING) -> Problem:
        """The problem of this value at its place."""
        problem = self.problem.below(place)
        return problem if self.problem.place else replace(problem, value=value)


def _read(problems: Iterable[Problem]) -> list[str]:
    """Sentences, as many as somebody reads: of problems that differ in numbers alone, the first ones."""
    found: list[str] = []
    alike: Counter[str] = Counter()
    left = 0
    for problem in problems:
        kind = re.sub(r"\d[\d.e+-]*", "#", f"{problem.verb} {problem.rule}")
        alike[kind] += 1
        if alike[kind] > MOST_ALIKE or len(found) == MOST:
            left += 1
        else:
            found.append(str(problem))
    more = f"{plural(left, 'more problem', 'more problems')} like these; correct these first"
    return [*found, more] if left else found


class ScenarioError(Exception):
    """Bad input: `str(error)` has a sentence for each problem, in a line of its own.

    Attributes
    ----------
    problems : tuple of Problem
        At least one: place, value, rule and remedy of each.
    """

    def __init__(self, *problems: Problem | str) -> None:
        super().__init__(*problems)
        self.problems = tuple(Problem("", x) if isinstance(x, str) else x for x in problems)

    @classmethod
    def at(cls, place: str, rule: str, remedy: str = "", value: object = NOTHING) -> Self:
        """One problem.

        Parameters
        ----------
        place : str
            The path of the key, as the file has it.
        rule : str
            What it breaks.
        remedy : str
            What to do instead.
        value : object
            What stands there, if a value belongs to it.

        Returns
        -------
        ScenarioError
            Of this problem.
        """
        return cls(Problem(place, rule, remedy, value))

    def __str__(self) -> str:
        return readable("\n".join(_read(self.problems)))

    def inside(self, place: str) -> Self:
        """The same, where all of which it tells is a part of something else.

        Parameters
        ----------
        place : str
            Where that is, such as a point of a study.

        Returns
        -------
        ScenarioError
            Whose sentences begin with the place.
        """
        return type(self)(*(x.inside(place) for x in self.problems))


class ClusterError(Exception):
    """A cluster is gone in the middle of its work: `str(error)` is the finished message."""


class ResultWarning(UserWarning):
    """Good runs that are not accurate: `str(warning)` names the certificate, the runs and the remedy."""
