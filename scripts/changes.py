"""What changes leave of a method, on deployments of eight panels with 16 changes each: times of changes against minimal
coordinates, momenta, books of energy, and the order of dop853 with steps of one length, which changes cut.

Usage: .venv/bin/python scripts/changes.py [RUNS] [COMPARED]    (1000 and 20: a minute; prints a table)
"""

import sys
from dataclasses import replace
from typing import Any

import numpy as np

import lienumba
from tests.oracles.changing import scenarios
from tests.oracles.changing.panels import Course, deploy

CHAIN, Q, LATCH, LET_GO, END = scenarios.eight()
STEPS = [round(120 * 2 ** (n / 8)) for n in range(15)]  # of a run


def known(stiffness: np.ndarray = CHAIN.stiffness) -> Course:
    """One deployment in minimal coordinates."""
    return deploy(replace(CHAIN, stiffness=stiffness), Q, np.zeros(11), LATCH, LET_GO, END)


def deployments(runs: int) -> tuple[Any, np.ndarray]:
    """With scattered springs (runs, 8)."""
    stiffness = CHAIN.stiffness * np.random.default_rng(4).uniform(0.9, 1.1, (runs, 8))
    data = scenarios.panels(CHAIN, Q, LATCH, LET_GO, END)
    data["sweep"] = scenarios.table({f"forces.spring_{i}.stiffness": stiffness[:, i] for i in range(8)})
    return lienumba.run(data, progress=False), stiffness


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
    ds, stiffness = deployments(runs)
    least, most = int(ds.changes.min()), int(ds.changes.max())
    print(f"{runs} deployments, {int((ds.status == 0).sum())} good, {least} to {most} changes")
    late, taken = [], []
    for n in range(min(compared, runs)):
        course, own = known(stiffness[n]), ds.isel(run=n)
        late.append(np.abs(own.change_time.values[: len(course.times)] - course.times).max())
        taken.append(abs(float(own.energy_lost) - sum(course.lost)))
    lost = ds.energy_lost.values
    moved = np.sqrt(2 * sum(CHAIN.m) * lost)
    drifts = [abs(ds[f"momentum.{x}"]).max(("time", "axis")).values / moved for x in ("linear", "angular")]
    momenta = np.max(drifts, axis=0)
    print(f"times of changes, {len(late)} runs:  {max(late):.1e} s")
    print(f"energy taken, the same:      {max(taken):.1e} J of {lost.mean():.0f}")
    print(f"momenta, of what moved:      {momenta.max():.1e}, in half of the runs {np.median(momenta):.1e}")
    print(f"energy residual, relative:   {float((abs(ds.energy_residual).max('time').values / lost).max()):.1e}")
    found, errors = order(STEPS)
    print("dop853, steps of one length: " + ", ".join(f"{n}: {x:.0e} s" for n, x in zip(STEPS, errors, strict=True)))
    print(f"order of the times:          {found:.1f}")


if __name__ == "__main__":
    main()
