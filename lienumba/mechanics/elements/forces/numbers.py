"""What the numbers of a force are: one record for each, from which its key, its units and its checks follow."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from pydantic import Field

from lienumba.errors import Problem
from lienumba.keys.formulas import constant
from lienumba.keys.types import OR_FORMULA, ZERO


@dataclass(frozen=True)
class Sign:
    """What a number must be, or had better be (`warns`). refused: what a sample that is not so would be, where no run
    may have it: "which <refused>"."""

    rule: str
    remedy: str
    broken: Callable[[Any], Any]  # of a number, or of an array of them
    warns: bool = False
    refused: str = ""


def positive(remedy: str, refused: str) -> Sign:
    """Of numbers that must be above 0 in every run."""
    return Sign("must be above 0", remedy, lambda x: x <= 0.0, refused=refused)


DISSIPATIVE = Sign("is negative, so it pushes away or feeds energy in", "check its sign", lambda x: x < 0.0, warns=True)
SIZE = Sign("must be at least 0", "give its size without a sign", lambda x: x < 0.0)


@dataclass(frozen=True)
class ForceNumber:
    """What a number of a force is. Where nothing is said, what is said is on the safe side.

    units: SI; a pair where they differ along a displacement and about an angle.
    in_potential: whether the potential depends on it; it may then read positions only.
    counts_turns: whether the force depends on the angle itself, over all turns, where this number is not 0.
    rate_with: another number of the force, with which the rate of this one matters.
    effective: without any such number the force does nothing.
    """

    units: str | tuple[str, str]
    sign: Sign | None = None
    in_potential: bool = True
    counts_turns: bool = True
    rate_with: str = ""
    effective: bool = False

    def units_of(self, kind: str | None) -> str:
        """Its units; kind: of the coordinate along which the force acts."""
        return self.units if isinstance(self.units, str) else self.units[kind == "angle"]


def number(
    text: str,
    units: str | tuple[str, str],
    sign: Sign | None = None,
    *,
    default: float | None = 0.0,
    size: int = 1,
    required: bool = False,
    omitted: str = "",
    in_potential: bool = True,
    counts_turns: bool = True,
    rate_with: str = "",
    effective: bool = False,
) -> Any:
    """A key that is a number of the force, or as many as `size`.

    text: what it is, with {} for its units, {0} and {1} for those along a displacement and about an angle; omitted:
    what it is where it is left out, if the default does not say so.
    """
    pair = (units,) if isinstance(units, str) else units
    written = [_written(x) for x in pair]
    said = text.replace("{}", " or ".join(written)).format(*written)
    vector = f": {size} numbers" if size > 1 else ""
    omit = f" (or omit it: {omitted})" if omitted else ""
    given: dict[str, Any] = {} if required else {"default": ZERO if size > 1 and default is not None else default}
    field = Field(description=f"{said}{vector} {OR_FORMULA}{omit}", **given)
    field.metadata.append(ForceNumber(units, sign, in_potential, counts_turns, rate_with, effective))
    return field


def faulty_limits(limit: float | str | None, limits: Sequence[float | str] | None) -> Iterator[Problem]:
    """What is wrong with the key limit, a size, and limits, the least and the largest value."""
    if limits is None:
        return
    if limit is not None:
        yield Problem("", "has both limit and limits", "leave one of them out")
    low, high = map(constant, limits)
    if low is not None and high is not None and low > high:
        yield Problem("limits", "has the larger number first", "give the least value first", limits)


def _written(units: str) -> str:
    """ "N s2 m-2" as people write it: N s^2/m^2."""
    above: list[str] = []
    below: list[str] = []
    for unit in units.split():
        symbol = unit.rstrip("-0123456789")
        power = unit[len(symbol) :]
        (below if power.startswith("-") else above).append(symbol + (f"^{n}" if (n := power.lstrip("-")) > "1" else ""))
    return " ".join(above) + "".join(f"/{unit}" for unit in below)
