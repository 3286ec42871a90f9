"""Potentials of the user's own against built-in springs; and the parameters of laws in sweeps."""

from typing import Any

import numpy as np
import pytest

from lienumba.compiler import native
from lienumba.engine.programs import program_of
from lienumba.scenario.start.prepare import prepare
from tests.facade import resolve
from tests.laws.rigs import close, order, own, pair, pendulum, run

MOTION = ("position", "rotation", "velocity", "angular_velocity", "joint_force", "joint_torque")
ENERGIES = ("energy", "kinetic_energy", "potential_energy", "work", "energy_residual")
ENDS = {"bodies": ["arm", "ball"], "points": [[0.1, 0, -0.2], [0, 0.05, 0.15]]}
BUILT_IN = {"name": "own", "type": "spring_damper", **ENDS, "stiffness": 30, "free_length": 0.8}


def test_a_potential_is_the_built_in_spring():
    built_in = run(pair(BUILT_IN))
    energy = own("spring_energy", bodies=["arm", "ball"], returns="potential",
                 parameters={"stiffness": 30, "length": 0.8})  # fmt: skip
    written = run(pair(energy))
    close(written, built_in, *MOTION, *ENERGIES)
    assert not written.work.any()
    drift = [float(np.abs(run(pair(energy, step=h)).energy_residual).max()) for h in (4e-3, 2e-3)]
    assert order(drift) > 3.7, drift


@pytest.mark.parametrize(("stiffness", "length"), [(30, "0.8 + 0.2*sin(7*t)"), ("30 + 9*cos(5*t)", 0.8)])
def test_a_potential_that_time_changes_does_work(stiffness, length):
    built_in = run(pair(BUILT_IN | {"stiffness": stiffness, "free_length": length}))
    energy = own("spring_energy", bodies=["arm", "ball"], returns="potential",
                 parameters={"stiffness": stiffness, "length": length})  # fmt: skip
    written = run(pair(energy))
    close(written, built_in, *MOTION, *ENERGIES)
    assert np.abs(written.work).max() > 0.01


def test_a_potential_of_an_angle_is_a_torsion_spring():
    """Over several turns."""
    coil = {"name": "own", "type": "torsion_spring", "joint": "hinge", "stiffness": 0.1, "free_angle": "0.2 + t"}
    written = own("coil_energy", joints=["hinge"], returns="potential", parameters={"stiffness": 0.1, "rest": "0.2+t"})
    start = {"rate": 25.0, "output": {"every": 0.1}}
    a, b = run(pendulum(coil, **start)), run(pendulum(written, **start))
    close(b, a, *MOTION, *ENERGIES, atol=1e-9)
    assert b.potential_energy.max() > 0.5 * 0.1 * (5 * np.pi) ** 2


# ---------------------------------------------------------------- sweeps
def swept(path: str, kp: Any, runs: int = 5) -> dict[str, Any]:
    law = own("pd", joints=["hinge"], parameters={"kp": kp, "kd": 2, "target": "kp/40" if kp == "kp" else 1})
    data = pendulum(law, end=0.3) | {"parameters": {"kp": 20}} if kp == "kp" else pendulum(law, end=0.3)
    vary = {path: {"distribution": "uniform", "low": 10, "high": 30}}
    return data | {"sweep": {"runs": runs, "seed": 3, "vary": vary}}


@pytest.mark.parametrize(("path", "kp"), [("parameters.kp", "kp"), ("forces.own.parameters.kp", 20)])
def test_its_parameters_can_be_swept(path, kp):
    ds = run(swept(path, kp))
    assert len(np.unique(ds[path])) == 5
    for n in range(5):
        number = float(ds[path][n])
        numbers = {"kp": number, "kd": 2, "target": number / 40 if kp == "kp" else 1}
        alone = run(pendulum(own("pd", joints=["hinge"], parameters=numbers), end=0.3))
        np.testing.assert_array_equal(ds.position[n], alone.position[0])
        np.testing.assert_array_equal(ds.work[n], alone.work[0])


def test_another_number_compiles_nothing(monkeypatch):
    emitted = []
    emit = native.emit
    monkeypatch.setattr(native, "emit", lambda *x: emitted.append(1) or emit(*x))
    data = swept("forces.own.parameters.kp", 20, runs=10_000)
    data["integrator"] = {"step": 0.01, "end_time": 0.05}
    data["output"] = {"times": [0.05]}
    ds = run(data)
    assert len(np.unique(ds.position.values[:, -1, 0, 0])) == 10_000
    emitted.clear()
    run(swept("forces.own.parameters.kp", 21, runs=7))
    assert not emitted

    def text(data: dict[str, Any]) -> list[str]:
        scenario = resolve(data)
        return [k.text() for k in program_of(scenario, prepare(scenario, [0]), True).kernels.values()]

    assert text(data) == text(pendulum(*swept("forces.own.parameters.kp", 7)["model"]["forces"]))
