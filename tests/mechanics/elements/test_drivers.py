"""The registry of drivers: what holds for every form, and a form that is added."""

import re
from typing import Annotated, Any, Literal

import numpy as np
import pytest
from pydantic import Field

import lienumba
from lienumba.groups import so3
from lienumba.keys.facts import Unit
from lienumba.keys.types import Timed3
from lienumba.mechanics.elements.drivers import DRIVERS, VELOCITY, BodyDriver, driver_form, type_of
from lienumba.mechanics.mechanism.kinematics import View
from lienumba.mechanics.mechanism.model import Driver
from lienumba.mechanics.system import dynamics, kkt
from lienumba.numerics.number import Vector
from lienumba.scenario.schema.json_schema import json_schema
from tests.facade import Instant, Model, ScenarioError, resolve
from tests.rigs.scenarios import start_of


def test_every_motion_is_of_one_form() -> None:
    motions = [motion for kind in DRIVERS.values() for motion in kind.motions]
    assert sorted(motions) == sorted({*motions})
    for kind in DRIVERS.values():
        assert all(type_of(Driver("d", motion, (0,), (0.0,))) is kind for motion in kind.motions)


@pytest.mark.parametrize(
    ("table", "form"),
    [
        ({"joint": "hinge"}, "joint"),
        ({"joint": "hinge", "body": "top"}, "joint"),
        ({"joint": "hinge", "body": "top", "motion": "point"}, "point"),
        ({"motion": "orientation"}, "orientation"),
        ({"motion": "joint"}, None),
        ({"motion": ["point"]}, None),
        ({}, None),
        ("point", None),
    ],
)
def test_a_table_says_which_form_it_is(table: Any, form: str | None) -> None:
    assert driver_form(table) == form


@pytest.mark.parametrize(
    ("driver", "row"),
    [
        ({"joint": "hinge", "rate": "cos(2*t)/2 + 1"}, 5),
        ({"joint": "hinge", "value": "sin(2*t)/4 + t"}, 5),
        ({"body": "free", "motion": "point", "value": [0, 0, "sin(2*t)/4"]}, 8),
        ({"body": "free", "motion": "angular_velocity", "value": [0, 0, "cos(2*t)/2"]}, 11),
    ],
    ids=["rate", "value", "point", "angular_velocity"],
)
def test_what_is_driven_accelerates_as_prescribed(driver: dict[str, Any], row: int) -> None:
    """By - sin(2 t) along or about z, whatever the velocities are."""
    axes = {"axes": [[0, 0, 1]] * 2, "references": [[1, 0, 0]] * 2, "angle": 0.0, "rate": 1.5}
    hinge = {"name": "hinge", "type": "revolute", "bodies": ["ground", "arm"], "points": [[0, 0, 0], [1, 0, 0]], **axes}
    body = {"mass": 2.0, "inertia": [1.0, 2.0, 2.5]}
    free = {"name": "free", "position": [0, 0, 0], "rotation": [1, 0, 0, 0], **body}
    moves = {"bodies": [{"name": "arm", **body}, free], "joints": [hinge], "drivers": [driver]}
    model, states = start_of({"model": moves, "integrator": {"step": 0.01, "end_time": 1.0}})
    now = Instant(tuple(map(tuple, states.tolist())), 0.35)
    solution = dynamics.accelerations(model, kkt.Structure.of(model), now)
    assert solution.x[row] == pytest.approx(-np.sin(0.7), rel=1e-12)


class VelocityDriver(BodyDriver):
    own_level = VELOCITY
    letter = "m"

    motion: Literal["velocity"]
    value: Annotated[Timed3, Unit("m s-1")] = Field(description="the velocity of the mass centre in m/s: 3 numbers")

    @classmethod
    def residual(cls, model: Model, driver: Driver, wanted: Vector, view: View) -> Vector:
        x, y, z = wanted
        return so3.subtract(view[driver.bodies[-1]].v, (x, y, z))


def lift(**driver: Any) -> dict[str, Any]:
    box = {"name": "box", "mass": 2.0, "inertia": [1, 1, 1], "position": [0, 0, 0], "rotation": [1, 0, 0, 0]}
    drive = {"name": "lift", "body": "box", "motion": "velocity", "value": [0.5, 0, "3*t"], **driver}
    return {
        "model": {"bodies": [box], "drivers": [drive]},
        "integrator": {"step": 0.01, "end_time": 1.0},
        "quantities": [{"name": "pull", "type": "driver_effort", "driver": "lift"}],
    }


def test_a_form_that_is_added_runs_with_its_units_schema_and_efforts() -> None:
    vary = {"drivers.lift.value[0]": {"distribution": "uniform", "low": 0.1, "high": 0.2}}
    with DRIVERS.temporarily(VelocityDriver):
        ds = lienumba.run(lift() | {"sweep": {"runs": 3, "vary": vary}})
        assert "VelocityDriver" in json_schema()["$defs"]
    t, x = ds.time.values, ds["drivers.lift.value[0]"]
    assert (ds.status == 0).all()
    np.testing.assert_allclose(ds.position.values[:, :, 0, 0], x.values[:, None] * t, atol=1e-12)
    np.testing.assert_allclose(ds.position.values[:, :, 0, 2], np.tile(1.5 * t * t, (3, 1)), atol=1e-12)
    np.testing.assert_allclose(ds.pull.values[..., 2], 2.0 * (9.81 + 3.0), atol=1e-9)
    assert x.attrs["units"] == "m s-1"
    assert ds.pull.attrs["units"] == "N"


@pytest.mark.parametrize(
    ("keys", "sentence"),
    [
        ({"motion": "velocty"}, 'model.drivers.lift.motion = "velocty": is not known; the nearest known name is "velo'),
        ({"point": [0, 0, 0]}, "model.drivers.lift.point has no meaning for the motion velocity; leave it out (it "),
        ({"body": "bax"}, 'model.drivers.lift.body = "bax": is not a body of the model; the nearest known name is "b'),
    ],
)
def test_what_is_written_wrong_of_it_is_told(keys: dict[str, Any], sentence: str) -> None:
    with DRIVERS.temporarily(VelocityDriver), pytest.raises(ScenarioError, match=re.escape(sentence)):
        resolve(lift(**keys))


def test_a_speed_that_jumps_is_an_impact_of_which_a_warning_tells() -> None:
    with DRIVERS.temporarily(VelocityDriver):
        (warning,) = resolve(lift(value=[0, 0, "where(t < 0.5, 0, 1)"])).warnings
    assert "the speed that it prescribes jumps by 1 at t = 0.5" in str(warning)
