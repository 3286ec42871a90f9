"""The units of every number that a sweep can vary."""

from typing import Any

import pytest

from lienumba.mechanics.elements.joints.couplings import Coupler
from lienumba.scenario.base.paths import numeric_paths
from lienumba.scenario.base.units import units
from tests.facade import resolve
from tests.rigs.scenario_example import example

ENDS = {"bodies": ["ground", "top"], "points": [[0, 0, 0], [0, -1, 0]]}
AXES = {"axes": [[0, 0, 1], [0, 0, 1]]}


def mechanism() -> dict[str, Any]:
    data = example(rotation={"axis": [0, 0, 1], "angle": 0})
    data["sweep"] = {}
    data["model"] |= {
        "joints": [
            {"name": "pivot", "type": "cylindrical", **ENDS, **AXES, "rate": 1},
            {"name": "slide", "type": "prismatic", **ENDS, **AXES, "displacement": 0},
            {"name": "rack", "type": "gear", "joints": ["pivot", "slide"], "coordinates": ["angle", "displacement"],
             "ratio": 2, "offset": 0},
            {"name": "mesh", "type": "coupler", "joints": ["slide", "slide"], "ratio": 2},
            {"name": "thread", "type": "screw", **ENDS, **AXES, "pitch": 0.1},
        ],
        "drivers": [
            {"name": "turn", "joint": "pivot", "coordinate": "angle", "rate": 1},
            {"name": "push", "joint": "slide", "value": 1},
            {"name": "lead", "body": "top", "motion": "point", "value": [1, 2, 3]},
            {"name": "spin", "body": "top", "motion": "angular_velocity", "value": [1, 2, "pi/60"]},
        ],
        "forces": [
            {"name": "spring", "type": "spring_damper", **ENDS, "stiffness": 1, "free_length": 1},
            {"name": "twist", "type": "torque", "body": "top", "value": [1, 2, 3]},
            {"name": "servo", "type": "actuator", "joint": "slide", "stiffness": 1, "limit": 2},
            {"name": "rub", "type": "friction", "joint": "pivot", "coordinate": "angle", "coulomb": 1},
            {"name": "mount", "type": "bushing", **ENDS, "stiffness": [1, 2, 3]},
            {"name": "air", "type": "drag", "body": "top", "quadratic": 1},
            {"name": "planet", "type": "point_mass_gravity", "bodies": ["ground", "top"], "mu": 1},
        ],
    }  # fmt: skip
    return data


@pytest.mark.parametrize(
    ("path", "expected"),
    [
        ("gravity[0]", "m s-2"),
        ("bodies.top.mass", "kg"),
        ("bodies.top.inertia[1]", "kg m2"),
        ("bodies.top.rotation.angle", "rad"),
        ("bodies.top.rotation.axis[0]", "1"),
        ("joints.pivot.points[1][0]", "m"),
        ("joints.pivot.axes[1][0]", "1"),
        ("joints.pivot.rate", "rad s-1"),
        ("joints.slide.displacement", "m"),
        ("joints.rack.ratio", "m rad-1"),
        ("joints.rack.offset", "m"),
        ("joints.mesh.ratio", "1"),
        ("joints.thread.pitch", "m"),
        ("drivers.turn.rate", "rad s-1"),
        ("drivers.push.value", "m"),
        ("drivers.lead.value[1]", "m"),
        ("drivers.spin.value[1]", "rad s-1"),
        ("forces.spring.stiffness", "N m-1"),
        ("forces.spring.free_length", "m"),
        ("forces.twist.value[0]", "N m"),
        ("forces.servo.stiffness", "N m-1"),
        ("forces.servo.limit", "N"),
        ("forces.servo.target", "m"),
        ("forces.rub.coulomb", "N m"),
        ("forces.rub.velocity", "rad s-1"),
        ("forces.mount.stiffness[0]", "N m-1"),
        ("forces.mount.rotational_stiffness[0]", "N m rad-1"),
        ("forces.air.quadratic", "N s2 m-2"),
        ("forces.planet.mu", "m3 s-2"),
    ],
)
def test_units(path: str, expected: str) -> None:
    model = mechanism()["model"]
    del model["joints"][3]  # couples a coordinate to itself: known to `units`, refused by `resolve`
    named = resolve(mechanism() | {"model": model}).data.model
    named.joints.append(Coupler(name="mesh", type="coupler", joints=["slide", "slide"], ratio=2.0))
    assert units(path, dict(named)) == expected


def test_every_number_of_a_model_has_units() -> None:
    data = mechanism()
    del data["model"]["joints"][3]
    named = dict(resolve(data).data.model)
    assert all(units(path, named) for path in numeric_paths(named))
