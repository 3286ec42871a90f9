"""Fast and wrong is worth nothing: every contestant is held against the exact motion in the same run."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from bench import cases, engine, naive_numba, rivals, tuned_numba

ALLOWED = 1e-6  # m at t = 2 s: RK4 with h = 1e-4 errs by 4.4e-7 without projection
CLOSE = 1e-9  # between two programs of the same method, after a short time


@dataclass(frozen=True)
class Check:
    label: str
    error: float
    allowed: float

    @property
    def good(self) -> bool:
        return bool(self.error <= self.allowed)


def _exact(label: str, mass_centre: Any) -> Check:
    return Check(f"{label}: mass centre at 2 s, error in m", _distance(mass_centre), ALLOWED)


def _distance(mass_centre: Any) -> float:
    return float(np.linalg.norm(np.asarray(mass_centre) - engine.MASS_CENTRE))


def run(sample: engine.Tops, found: list[rivals.Rival]) -> list[Check]:
    steps = round(engine.END_TIME / engine.STEP)
    few = engine.tops(8)
    done = []
    for projection in engine.METHODS:
        ends = engine.integrate(engine.top_batch(few, projection), 1)[0, -1, :3]
        done.append(_exact(f"engine, projection {projection}", ends))
        for label, module in (("naive Numba loop", naive_numba), ("tuned Numba loop", tuned_numba)):
            ends = cases.scalar(module, sample, 1, steps, projection == "both")[0, -1, :3]
            done.append(_exact(f"{label}, projection {projection}", ends))
    short = engine.top_batch(few, "none", steps=2 * cases.EVERY, outputs=2)
    numpy = cases.numpy_top(few, 8).integrate(few.states, engine.STEP, 2 * cases.EVERY, cases.EVERY)
    error = float(np.abs(engine.integrate(short, 1) - numpy).max())
    done.append(Check("NumPy against the engine, 8 runs, 0.02 s, whole state", error, CLOSE))
    return done + [_exact(rival.name, rival.mass_centre()) for rival in found]
