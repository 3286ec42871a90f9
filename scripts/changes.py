"""What changes leave of a method, on deployments of eight panels with 16 changes each: times of changes against minimal
coordinates, momenta and books of energy for several tolerances, and the order of dop853 with steps of one length, which
changes cut.

Usage: .venv/bin/python scripts/changes.py [RUNS] [COMPARED]    (1000 and 20: two minutes; prints a table)
"""

import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

import lienumba

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from tests.oracles.changing import scenarios
from tests.oracles.changing.panels import Course, deploy

CHAIN, Q, LATCH, LET_GO, END = scenarios.eight()
TOLERANCES = (1e-12, 1e-13, 3e-14)
STEPS = [round(120 * 2 ** (n / 8)) for n in range(15)]  # of a run


def known(stiffness: np.ndarray = CHAIN.stiffness) -> Course:
    """One deployment in minimal coordinates."""
    return deploy(replace(CHAIN, stiffness=stiffness), Q, np.zeros(11), LATCH, LET_GO, END)


def springs(runs: int) -> np.ndarray:
    """Scattered ones (runs, 8)."""
    return CHAIN.stiffness * np.random.default_rng(4).uniform(0.9, 1.1, (runs, 8))


def deployments(stiffness: np.ndarray, tolerance: float) -> Any:
    """With these springs, stored at 41 times."""
    data = scenarios.panels(CHAIN, Q, LATCH, LET_GO, END)
    data["integrator"]["tolerance"] = tolerance
    data["output"]["times"] = np.linspace(0, END, 41).tolist()
    data["sweep"] = scenarios.table({f"forces.spring_{i}.stiffness": stiffness[:, i] for i in range(8)})
    return lienumba.run(data, progress=False)


def books(ds: Any) -> list[float]:
    """Of what changes took: momenta, the worst of all runs at the end, half of the runs there, the worst at all times;
    the residual of energy likewise (the worst at the end, and at all times)."""
    lost = ds.energy_lost.values
    moved = np.sqrt(2 * sum(CHAIN.m) * lost)[:, None]
    drift = np.max([abs(ds[f"momentum.{x}"]).max("axis").values / moved for x in ("linear", "angular")], axis=0)
    residual = abs(ds.energy_residual.values) / lost[:, None]
    return [drift[:, -1].max(), np.median(drift[:, -1]), drift.max(), residual[:, -1].max(), residual.max()]


def order(steps: list[int]) -> tuple[float, list[float]]:
    """Of the times of changes, by a straight line through the logarithms of their errors; and these (s)."""
    course, errors = known(), []
    for n in steps:
        data = scenarios.panels(CHAIN, Q, LATCH, LET_GO, END)
        data["integrator"] = {"method": "dop853", "step": END / n, "end_time": END, "coordinates": "joint"}
        ds = lienumba.run(data, progress=False)
        errors.append(float(np.sqrt(np.mean((ds.change_time.values[0] - course.times) ** 2))))
    return float(-np.polyfit(np.log(steps), np.log(errors), 1)[0]), errors


def main() -> None:
    runs, compared = (int(x) for x in (*sys.argv[1:], *("1000", "20")[len(sys.argv) - 1 :]))
    stiffness = springs(runs)
    ds = deployments(stiffness, TOLERANCES[0])
    least, most = int(ds.changes.min()), int(ds.changes.max())
    print(f"{runs} deployments, {int((ds.status == 0).sum())} good, {least} to {most} changes")
    late, taken = [], []
    for n in range(min(compared, runs)):
        course, own = known(stiffness[n]), ds.isel(run=n)
        late.append(np.abs(own.change_time.values[: len(course.times)] - course.times).max())
        taken.append(abs(float(own.energy_lost) - sum(course.lost)))
    print(f"times of changes, {len(late)} runs:  {max(late):.1e} s")
    print(f"energy taken, the same:      {max(taken):.1e} J of {float(ds.energy_lost.mean()):.0f}")
    print("tolerance  momenta: end, half of the runs, any time  energy: end, any time")
    for tolerance in TOLERANCES:
        print(f"{tolerance:.0e}     ", *(f"{x:.1e}" for x in books(deployments(stiffness, tolerance))))
    found, errors = order(STEPS)
    print("dop853, steps of one length: " + ", ".join(f"{n}: {x:.0e} s" for n, x in zip(STEPS, errors, strict=True)))
    print(f"order of the times:          {found:.1f}")


if __name__ == "__main__":
    main()
