"""Loops whose rows say some things twice, with what sticks, slips and strikes: what switches keep is theirs, with every
method."""

from typing import Any

import numpy as np
import pytest

import lienumba

LENGTH, ACROSS, TILT = 0.5, 0.4, 0.5
METHODS = [("taylor", "joint"), ("taylor", "lie"), ("radau5", "joint")]


def parallel(**more: Any) -> dict[str, Any]:
    """A coupler on two equal cranks of hinges: three of the ten rows of its loop say nothing of their own."""
    crank = {"mass": 0.4, "inertia": [0.02, 0.02, 0.001]}
    lie = [float(np.cos(TILT / 2)), 0.0, float(np.sin(TILT / 2)), 0.0]
    along = LENGTH * np.array([np.sin(TILT), 0.0, np.cos(TILT)])
    bodies = [{"name": "p", "mass": 2.0, "inertia": [0.1] * 3, "position": (along + [ACROSS, 0, 0]).tolist()}]
    joints = []
    for n in range(2):
        foot = np.array([n * ACROSS, 0.0, 0.0])
        bodies.append({"name": f"c{n}", **crank, "position": (foot + 0.5 * along).tolist(), "rotation": lie})
        hinge = {"type": "revolute", "axis": [0, 1, 0]}
        joints.append({"name": f"g{n}", **hinge, "bodies": ["ground", f"c{n}"], "at": foot.tolist()})
        joints.append({"name": f"h{n}", **hinge, "bodies": [f"c{n}", "p"], "at": (foot + along).tolist()})
    forces = [{"type": "torsion_spring", "joint": "g0", "stiffness": 20.0, "damping": 0.3, "free_angle": 0.4},
              {"type": "actuator", "joint": "g1", "value": "9*sin(3*t)"}]  # fmt: skip
    forces += more.pop("forces", [])
    return {
        "model": {"bodies": bodies, "joints": joints, "forces": forces, **more},
        "quantities": [{"name": "crank", "type": "joint", "joint": "g0"}],
        "output": {"every": 0.1},
    }


DRY = parallel(forces=[{"type": "friction", "joint": "g0", "coulomb": 1.5, "static": 1.8}])
STOPPED = parallel(limits=[{"joint": "g0", "high": 0.3, "low": -0.3, "restitution": 0.5}])


@pytest.mark.parametrize(("method", "coordinates"), METHODS)
@pytest.mark.parametrize("scene", [DRY, STOPPED], ids=["dry", "stopped"])
def test_what_sticks_and_strikes_in_redundant_loops(scene: dict[str, Any], method: str, coordinates: str) -> None:
    def moved(**integrator: Any) -> Any:
        ds = lienumba.run({**scene, "integrator": {"end_time": 2.5, **integrator}}, progress=False)
        assert ds.status.item() == 0
        return ds

    expected = moved(method="dop853", tolerance=1e-11)
    assert expected.changes.item() > 0
    for length in ({"tolerance": 1e-10}, *([{"step": 0.01}] if method == "taylor" else [])):
        found = moved(method=method, coordinates=coordinates, **length)
        assert found.changes.item() == expected.changes.item()
        np.testing.assert_allclose(found["crank.angle"], expected["crank.angle"], rtol=0, atol=1e-8)
        assert found.steps.item() < (400 if method == "taylor" else 3000)
