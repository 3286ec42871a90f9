"""The neighbour test of a program that simulates many runs at once: does a run feel the runs beside it?

`check(simulate, inputs)` returns what it found. `simulate` takes a dict of inputs, each an array with one number for
each run, and returns a dict of arrays whose first axis is the runs. docs/neighbours.md shows how to write one.

Usage: scripts/neighbours [FILE.py | SCENARIO.toml]...

FILE.py defines `simulate` and `inputs`. A scenario of lienumba has to vary something. By default: scenarios.
"""

import runpy
import sys
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

import lienumba
from lienumba.scenario.reading.loading import load

Array = npt.NDArray[Any]
Simulate = Callable[[Mapping[str, Array]], Mapping[str, Array]]
ROOT = Path(__file__).parents[1]
SCENARIOS = ("heavy_top_monte_carlo", "bouncing_ball", "solar_array", "arm_pd")
RUNS = 17  # no multiple of a number of lanes
POISONS = (np.nan, np.inf, 1e60, 0.0)
CHANGE = 2.0**-20  # relative, of an input that is varied


@dataclass(frozen=True)
class Finding:
    """rule: which rule; passed; checks: how many times; text: what broke it first."""

    rule: str
    passed: bool
    checks: int
    text: str = ""


def check(simulate: Simulate, inputs: Mapping[str, Any]) -> list[Finding]:
    """Apply the five rules to a program.

    Parameters
    ----------
    simulate : callable
        From inputs, a dict of arrays (runs,), to results, a dict of arrays (runs, ...). It may raise an exception for
        inputs that it refuses.
    inputs : mapping
        The declared inputs, all of which shall matter. At least three runs.

    Returns
    -------
    list of Finding
        Of the rules "repeated", "alone", "reversed", "poisoned", "varied: neighbours", "varied: own run".
    """
    given = {name: np.array(x, float) for name, x in inputs.items()}
    (runs,) = {len(x) for x in given.values()}
    if runs < 3:
        raise ValueError(f"inputs have {runs} runs: must be at least 3; give more")
    base = rows(simulate(given))
    order = np.arange(runs)[::-1]
    places = sorted({0, runs // 2, runs - 1})
    backwards = rows(simulate({name: x[order] for name, x in given.items()}))
    return [
        _finding("repeated", iter([_differences(base, rows(simulate(given)))])),
        _finding("alone", _alone(simulate, given, base, places)),
        _finding("reversed", iter([_differences(base[order], backwards)])),
        _finding("poisoned", _poisoned(simulate, given, base, places)),
        *_varied(simulate, given, base, places),
    ]


def rows(results: Mapping[str, Array]) -> Array:
    """The bits of each run (runs, bytes)."""
    parts = [np.ascontiguousarray(x) for x in results.values()]
    return np.concatenate([x.reshape(len(x), -1).view(np.uint8) for x in parts], axis=1)


def _differences(base: Array, other: Array, apart: int | None = None) -> str:
    """Which runs differ, in words, or nothing; `apart`: a run that may."""
    if base.shape != other.shape:
        return f"the results have another shape: {other.shape} instead of {base.shape}"
    moved = np.flatnonzero((base != other).any(axis=1))
    return ", ".join(f"run {run} moves" for run in moved if run != apart)


def _finding(rule: str, found: Iterator[str]) -> Finding:
    texts = list(found)
    broken = [text for text in texts if text]
    return Finding(rule, not broken, len(texts), broken[0] if broken else "")


def _alone(simulate: Simulate, given: Mapping[str, Array], base: Array, places: list[int]) -> Iterator[str]:
    for run in places:
        own = rows(simulate({name: x[run : run + 1] for name, x in given.items()}))
        yield "" if np.array_equal(own, base[run : run + 1]) else f"run {run} has other bits alone"


def _changed(given: Mapping[str, Array], name: str, run: int, value: float) -> dict[str, Array]:
    own = given[name].copy()
    own[run] = value
    return {**given, name: own}


def _poisoned(simulate: Simulate, given: Mapping[str, Array], base: Array, places: list[int]) -> Iterator[str]:
    """A poison that is refused is none."""
    for name in given:
        for n, poison in enumerate(POISONS):
            run = places[n % len(places)]
            try:
                other = rows(simulate(_changed(given, name, run, poison)))
            except Exception:
                continue
            moved = _differences(base, other, run)
            yield f"{name} = {poison} in run {run}: {moved}" if moved else ""


def _varied(simulate: Simulate, given: Mapping[str, Array], base: Array, places: list[int]) -> list[Finding]:
    neighbours, own = [], []
    for n, name in enumerate(given):
        run = places[n % len(places)]
        value = given[name][run] * (1 + CHANGE) or CHANGE
        other = rows(simulate(_changed(given, name, run, value)))
        moved = _differences(base, other, run)
        neighbours.append(f"{name} = {value} in run {run}: {moved}" if moved else "")
        own.append("" if (base[run] != other[run]).any() else f"{name} = {value} in run {run}: nothing moves")
    return [_finding("varied: neighbours", iter(neighbours)), _finding("varied: own run", iter(own))]


# ---------------------------------------------------------------- lienumba
def of_scenario(path: Path) -> tuple[Simulate, dict[str, Array]]:
    """A scenario's runs as a function of what it varies, and its first samples."""
    written = load(path)
    first = lienumba.run(path, overrides={"sweep.runs": RUNS})
    samples = {name: first[name].values[first.run.values >= 0] for name in written["sweep"]["vary"]}

    def simulate(inputs: Mapping[str, Array]) -> dict[str, Array]:
        columns = {name: x.tolist() for name, x in inputs.items()}
        runs = len(next(iter(columns.values())))
        ds = lienumba.run(written | {"sweep": {"runs": runs, "sampler": "table", "table": {"columns": columns}}})
        return {str(name): x.values for name, x in ds.data_vars.items() if x.dims[:1] == ("run",)}

    return simulate, samples


def of_file(path: Path) -> tuple[Simulate, dict[str, Array]]:
    """What a Python file defines as `simulate` and `inputs`."""
    names = runpy.run_path(str(path))
    return names["simulate"], names["inputs"]


def main(given: list[str]) -> int:
    worst = 0
    for name in given or [f"{ROOT}/scenarios/{name}.toml" for name in SCENARIOS]:
        path = Path(name)
        found = check(*(of_scenario if path.suffix == ".toml" else of_file)(path))
        print(path.name)
        for one in found:
            print(f"  {'passed' if one.passed else 'FAILED'}  {one.rule:20} {one.checks:4} checks  {one.text}".rstrip())
        worst |= not all(one.passed for one in found)
    return int(worst)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
