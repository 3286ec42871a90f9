"""Statistics over the runs of a variable, at each of its other labels: in blocks of labels, with all runs of each. What
is on the disk need not fit into the memory, and since a file holds whole runs together, it is read by windows of runs,
as many labels at a time as may be kept. What is found bears the labels again."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import prod
from typing import Any

import numpy as np
import xarray as xr

from lienumba.analysis.outcomes import of_sweep
from lienumba.errors import ScenarioError
from lienumba.keys.units import factors, written
from lienumba.store.layout import FULL, RUN, texts
from lienumba.store.windows import windows
from lienumba.words import show, suggestion

BLOCK_BYTES = 2**27
STORED = (*RUN, FULL)  # dimensions along which a file has chunks
KEPT_BYTES = 2**30  # of what is on the disk, at a time: most files are read once
COUNT = texts("1", "runs that have a value")

Found = dict[str, np.ndarray]
Described = Mapping[str, tuple[Sequence[str], Mapping[str, Any]]]  # by name, dimensions behind the labels; attributes


@dataclass(frozen=True)
class Block:
    """values (labels, runs, ...): of some labels all the runs, at least one, NaN where one is missing; runs: what these
    are called; first: the number of the first label."""

    values: np.ndarray
    runs: np.ndarray
    first: int


class RunStatistics:
    """The runs of the variable `x` along `dim`, without the nominal one if there are others; core: the dimensions of
    what each of them has at a label; new: those of what is found, which `x` must not have."""

    def __init__(self, x: xr.DataArray, dim: str, *core: str, new: Sequence[str] = ()) -> None:
        check_numbers(x, dim, *core)
        if dim in core:
            others = [f'"{name}"' for name in x.dims if name not in core]
            remedy = f"give one of {', '.join(others)}" if others else "there is none to take it over"
            raise ScenarioError(f"dim = {show(dim)}: is a dimension of each value, not of runs; {remedy}")
        check_free(x, *(name for name in new if name != dim))
        others = [str(name) for name in x.dims if name not in (dim, *core)]
        self.x, self.dim, self.core = x, dim, core
        self.dims = tuple(sorted(others, key=lambda name: (name not in STORED, -x.sizes[name])))  # blocks: of the first
        self.sizes = tuple(x.sizes[name] for name in self.dims)
        self.counted = of_sweep(x, dim) if dim in STORED else np.ones(x.sizes[dim], bool)

    def blocks(self) -> Iterator[Block]:
        length, rest = self.sizes[0] if self.dims else 1, prod(self.sizes[1:])
        runs = self.x[self.dim].values[self.counted]
        core = [self.x.sizes[name] for name in self.core]
        row = 8 * max(rest * len(runs) * prod(core), 1)
        step = max(1, BLOCK_BYTES // row)
        kept = step if self.x._in_memory or self.dim not in STORED else max(step, KEPT_BYTES // row)
        for first in range(0, max(length, 1), kept):
            part = self._all_runs(slice(first, min(first + kept, length)))
            for start in range(0, max(len(part), 1), step):
                values = part[start : start + step]
                values = values.reshape(len(values) * rest, len(runs), *core)
                nothing = np.full((len(values), 1, *core), np.nan)
                yield Block(values if len(runs) else nothing, runs, (first + start) * rest)

    def _all_runs(self, labels: slice) -> np.ndarray:
        """Of some labels along the first dimension the values of all runs that count (labels, ..., runs, ...)."""
        x = self.x.isel({self.dims[0]: labels}) if self.dims else self.x.expand_dims("label")
        dims = (*(self.dims or ("label",)), self.dim, *self.core)
        shape = [x.sizes[name] for name in dims]
        shape[-1 - len(self.core)] = number = int(self.counted.sum())
        found, first = np.empty(shape), 0
        by_runs = np.moveaxis(found, -1 - len(self.core), 0)
        for few in windows(x.to_dataset(name="x"), ["x"], self.dim, self.counted) if number else ():
            values = few["x"].transpose(self.dim, *(name for name in dims if name != self.dim)).values
            by_runs[first : first + len(values)] = values
            first += len(values)
        return found

    def gather(self, work: Callable[[Block], Found]) -> Found:
        """What is found at all labels (labels, ...), by name."""
        found = [work(block) for block in self.blocks()]
        return {name: np.concatenate([one[name] for one in found]) for name in found[0]}

    def place(self, number: int) -> str:
        """A label, by its number, for people."""
        indices = np.unravel_index(number, self.sizes) if self.dims else ()
        return ", ".join(f"{name} {self.x[name].values[k]}" for name, k in zip(self.dims, indices, strict=True))

    def labelled(self, found: Found, described: Described, labels: Mapping[str, object] | None = None) -> xr.Dataset:
        """What was found with its dimensions and attributes, and how many runs there are; labels: of dimensions that
        `x` does not have."""
        order = [str(name) for name in self.x.dims if name in self.dims]
        data = {"runs": xr.Variable((), int(self.counted.sum()), texts("1", "runs, with those that have no value"))}
        for name, (dims, attributes) in described.items():
            values = found[name].reshape((*self.sizes, *found[name].shape[1:]))
            data[name] = xr.Variable((*self.dims, *dims), values, dict(attributes)).transpose(*order, *dims)
        left = {dim for variable in data.values() for dim in variable.dims}
        coordinates = {name: x for name, x in self.x.coords.items() if set(x.dims) <= left}
        return xr.Dataset({name: data[name] for name in (*described, "runs")}, {**coordinates, **(labels or {})})


def check_numbers(x: object, *dims: str) -> None:
    """Refuse what is no variable of numbers with these dimensions."""
    if not isinstance(x, xr.DataArray) or x.dtype.kind not in "biuf":
        raise ScenarioError(f'{_kind(x)} has no numbers to compare; give one variable, such as ds["position"]')
    for dim in dims:
        if dim not in x.dims:
            raise ScenarioError(f"{show(dim)} is no dimension of {_name(x)}; {suggestion(str(dim), map(str, x.dims))}")


def check_free(x: xr.DataArray, *dims: str) -> None:
    """Refuse a variable that has dimensions called like those of what is found."""
    for dim in dims:
        if dim in x.dims:
            raise ScenarioError(
                f'{_name(x)} has a dimension "{dim}", which the result needs; rename it, such as by '
                f'x.rename({dim}="{dim}_before")'
            )


def _name(x: xr.DataArray) -> str:
    return f"the variable {x.name}" if x.name else "the variable"


def _kind(x: object) -> str:
    if isinstance(x, xr.DataArray):
        return f"{_name(x)} of type {x.dtype}"
    return "a whole dataset" if isinstance(x, xr.Dataset) else f"an object of type {type(x).__name__}"


def check_probability(name: str, value: float) -> None:
    """Refuse what is no number between 0 and 1."""
    single = not isinstance(value, Sequence) and np.ndim(value) == 0
    if not single or np.asarray(value).dtype.kind not in "iuf" or not 0.0 < value < 1.0:
        raise ScenarioError(f"{name} = {show(value)}: must be above 0 and below 1, such as 0.95")


def power(units: str, exponent: float) -> str:
    """A power of units such as "m s-1"; exponent 2: "m2 s-2"."""
    found = factors(units)
    return f"({units})^{exponent:g}" if found is None else written([(x, n * exponent) for x, n in found])
