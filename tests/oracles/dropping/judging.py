"""What holds of anything that is thrown, however it tumbles."""

import time
from dataclasses import dataclass

import numpy as np

import lienumba
from tests.oracles.dropping.drawing import TOLERANCE, Drop

RESIDUAL = 100.0  # of the energy, in tolerances
SUNK = 1e-8  # m
HONEST = ("chattering", "friction_paradox", "contacts_not_solved", "friction_energy_gain", "contact_law_violated")
ON_ITS_FACE = ("step_too_short", "singular_constraints")  # of a disc, whose lowest point then leaps
FLAT = 1e-6  # the sine of how much it may lean there


@dataclass(frozen=True)
class Verdict:
    """How a run ended; its steps and changes; in tolerances of its largest energy the residual, and by how much the
    energy ever rose; by how much (m) anything was ever below a plane; core time (s) of a second run, all compiled;
    flat: whether a disc lies on its face at the end."""

    status: str
    steps: int
    changes: int
    residual: float
    rise: float
    sunk: float
    seconds: float
    flat: bool = False

    def problems(self) -> list[str]:
        """What should not be."""
        honest = ("success", *HONEST, *(ON_ITS_FACE if self.flat else ()))
        found = [] if self.status in honest else [self.status]
        if not self.residual < RESIDUAL:
            found.append(f"residual {self.residual:.1e}")
        if not self.rise < RESIDUAL:
            found.append(f"energy rises by {self.rise:.1e}")
        if not self.sunk < SUNK:
            found.append(f"sinks by {self.sunk:.1e} m")
        return found


def judge(thrown: Drop, again: bool = False) -> Verdict:
    """again: run twice, so that the core time is that of the motion alone."""
    for _ in range(1 + again):
        begin = time.process_time()
        run = lienumba.run(thrown.scenario, progress=False).isel(run=0)
        seconds = time.process_time() - begin
    names = dict(zip(run.status.flag_values.tolist(), run.status.flag_meanings.split(), strict=True))
    there = np.flatnonzero(np.isfinite(run.energy.values))
    energy = run.energy.values[there]
    x, R = run.position.values[there], run.rotation.values[there]
    unit = TOLERANCE * max(float(np.ptp(energy)), abs(float(energy[0])))
    return Verdict(
        names[int(run.status)],
        int(run.steps),
        int(run.changes),
        float(abs(run.energy_residual.values[there]).max() / unit),
        float(max(0.0, np.diff(energy).max(initial=0.0)) / unit),
        float(max(0.0, *(-thrown.gap(p, q) for p, q in zip(x, R, strict=True)))),
        seconds,
        thrown.leans(run.last_rotation.values) < FLAT,
    )
