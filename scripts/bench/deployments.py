"""Deployments of eight panels on a free hub, that are let go and latch one after the other: 16 changes in each run.
Timed against the same runs whose hinges are free from the start and never latch."""

from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from bench.cases import Case
from bench.checks import Check
from bench.clock import Spent, Stopwatch
from lienumba.batch.execute import execute, tasks
from lienumba.batch.integrate import Chunk
from lienumba.engine import programs
from lienumba.scenario.resolve import resolve
from lienumba.scenario.start.prepare import prepare
from tests.oracles.changing import scenarios

if TYPE_CHECKING:
    from collections.abc import Callable

    from rich.console import Console

TOLERANCES = ("1e-9", "1e-11")
CHANGES = 16


def deployment(tolerance: float, runs: int, changes: bool) -> dict[str, Any]:
    """Keys and values; the stiffness of every spring differs from run to run."""
    scatter = np.random.default_rng(2015)
    data = scenarios.panels(*scenarios.eight())
    data["integrator"]["tolerance"] = tolerance
    data["output"]["variables"] = []
    columns = {f"forces.{x['name']}.stiffness": scatter.uniform(2.0, 4.0, runs) for x in data["model"]["forces"]}
    data["sweep"] = scenarios.table(columns)
    if not changes:
        data["events"] = []
        for joint in data["model"]["joints"]:
            joint.pop("locked", None)
    return data


class Deployments:
    """All runs, ready to be integrated. steps, changes: of a run, on average."""

    def __init__(self, tolerance: float, runs: int, changes: bool) -> None:
        resolved = resolve(deployment(tolerance, runs, changes))
        prepared = prepare(resolved, range(runs))
        self.batch = programs.batch_of(resolved, prepared, *programs.compiled_of(resolved, prepared, True))
        found = self._run()
        self.steps, self.rejected, self.changes = (
            float(np.mean(np.concatenate([getattr(chunk, name) for chunk in found])))
            for name in ("steps", "rejected", "change_counts")
        )
        self.missing = max(abs(chunk.change_counts - CHANGES).max() for chunk in found) if changes else 0.0

    def _run(self) -> list[Chunk]:
        found = list(execute(tasks(self.batch, 1, lambda chunk: chunk), 1, lambda _: None))
        if failed := {int(code) for chunk in found for code in chunk.codes} - {0}:
            raise RuntimeError(f"deployments failed: codes {failed}")
        return found

    def spend(self) -> Spent:
        watch = Stopwatch()
        seconds = sum(chunk.seconds for chunk in self._run())
        return Spent(watch.spent().wall, seconds)


def deployment_cases(tolerances: tuple[str, ...], runs: int) -> tuple[list[Case], list[Check], dict[str, Any]]:
    """Their unit of work is a run; and of each case steps and changes of a run."""
    cases, checks, counts = [], [], {}
    for tolerance in tolerances:
        for key, words, changes in (("free", "no latches", False), ("latching", "latching", True)):
            these = Deployments(float(tolerance), runs, changes)
            name, label = f"deploy_{tolerance}_{key}", f"tolerance {tolerance}, {words}"
            cases.append(Case(name, label, 1, runs, partial(Deployments.spend, these)))
            counts[name] = {"steps": these.steps, "rejected": these.rejected, "changes": these.changes}
            if changes:
                checks.append(Check(f"deployments, {label}: changes that a run lacks", these.missing, 0.5))
    return cases, checks, counts


def ratios(keys: list[str], ratio: "Callable[[str, str], float]") -> dict[str, float]:
    """Of runs that latch to those that do not; ratio(slow, fast): within rounds."""
    pairs = [(key, key.replace("_latching", "_free")) for key in keys if key.startswith("deploy_")]
    return {f"{slow}/{fast}": ratio(slow, fast) for slow, fast in pairs if slow != fast}


def show(found: dict[str, Any], console: "Console") -> None:
    from rich.table import Table

    rows, counts = found["rows"], found["deployments"]
    table = Table(title="Deployments of eight panels, dop853, coordinates of the joints, one thread; medians")
    table.add_column("", no_wrap=True)
    for name in ("µs of core time per run", "steps, with rejected", "changes", "to no latches", "per step"):
        table.add_column(name, justify="right")
    for key, count in counts.items():
        free = key.replace("_latching", "_free")
        ratio = found["ratios"].get(f"{key}/{free}")
        tried, others = (x["steps"] + x["rejected"] for x in (count, counts[free]))
        each = (f"{ratio:.2f}", f"{ratio * others / tried:.2f}") if ratio else ("", "")
        steps = f"{count['steps']:.1f} + {count['rejected']:.1f}"
        table.add_row(rows[key]["label"], f"{rows[key]['ns'] * 1e-3:,.0f}", steps, f"{count['changes']:.1f}", *each)
    console.print(table)
