"""A scenario by lienumba and by the engine here: how far they are apart."""

from dataclasses import dataclass
from typing import Any

import numpy as np

import lienumba
from tests.oracles.mechanisms.engine import Mechanism
from tests.oracles.mechanisms.quantities import REACTIONS, SEEN, joint_load

BOUND = 1e-7  # of a deviation, relative to the largest of its numbers, or to 1
RESIDUAL = 100.0  # of the energy, in tolerances


@dataclass(frozen=True)
class Comparison:
    """status: of the run; deviations: by what it is, relative to 1 or the largest number; residual: of the energy, in
    tolerances of the energies."""

    status: int
    deviations: dict[str, float]
    residual: float

    @property
    def worst(self) -> float:
        return max(self.deviations.values(), default=np.inf)


def compare(data: dict[str, Any]) -> Comparison:
    """Run it both ways; a ScenarioError or a SingularError is the caller's."""
    m = Mechanism(data["model"])
    history = m.run(data["output"]["times"])
    ds = lienumba.run(data, workers=1, progress=False).isel(run=0)
    found: dict[str, float] = {}
    if int(ds["status"]):
        return Comparison(int(ds["status"]), found, np.inf)
    for n, now in enumerate(history):
        there = ds.isel(time=n)

        def same(name: str, wanted: Any, got: Any) -> None:
            wanted, got = np.asarray(wanted, float), np.asarray(got, float)
            off = np.abs(got - wanted).max() / max(1.0, float(np.abs(wanted).max()))
            found[name] = max(found.get(name, 0.0), float(off) if np.isfinite(off) else np.inf)

        s = now.state
        for name, x in (("position", s.r), ("rotation", s.R), ("velocity", s.v), ("angular_velocity", s.w)):
            same(name, x, there[name])
        same("kinetic_energy", m.kinetic(now), there["kinetic_energy"])
        for name, joint in m.joints.items():
            if now.unique and "bodies" in joint:
                force, torque = joint_load(m, now, joint)
                same(f"force of {joint['type']}", force, there["joint_force"].sel(joint=name))
                same(f"torque of {joint['type']}", torque, there["joint_torque"].sel(joint=name))
        for quantity in data["model"].get("quantities", []):
            if now.unique or quantity["type"] not in REACTIONS:
                for part, x in SEEN[quantity["type"]](m, now, quantity).items():
                    full = f"{quantity['name']}.{part}" if part else quantity["name"]
                    if quantity["type"] == "joint" and "angle" in part:  # whose turns are counted there
                        x = x + 2 * np.pi * np.round((float(there[full]) - x) / (2 * np.pi))
                    same(f"{quantity['type']} {part}".strip(), x, there[full])
    size = max(1.0, *(float(np.abs(ds[name]).max()) for name in ("kinetic_energy", "work")))
    tolerance = data["integrator"]["tolerance"]
    return Comparison(0, found, float(np.abs(ds["energy_residual"]).max()) / (tolerance * size))
