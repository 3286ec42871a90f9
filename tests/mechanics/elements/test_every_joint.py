"""What holds for every type of joint in the registry, shown by the example that it gives of itself."""

import copy
from dataclasses import replace
from typing import Annotated, Any, Literal

import numpy as np
import pytest
from pydantic import Field, ValidationError

import lienumba
from lienumba.keys.types import Number
from lienumba.mechanics.elements.joints import JointType, Own, coordinate
from lienumba.mechanics.elements.joints.keys import Angle, Displacement, OneAxis, Placed
from lienumba.mechanics.elements.joints.parts import across, along, parallel
from lienumba.mechanics.mechanism.kinematics import View
from lienumba.mechanics.mechanism.model import Coordinate
from lienumba.mechanics.system import constraints
from lienumba.numerics.number import Vector
from lienumba.scenario.schema.messages import problems
from lienumba.scenario.schema.scenario import ScenarioData
from lienumba.scenario.start.prepare import check_initial
from tests.facade import JOINTS, Instant, Model, ScenarioError, resolve
from tests.mechanics.system.test_random_mechanisms import after, close, matrix, slope, velocities

END, STEP = 0.3, 0.01
every = pytest.mark.parametrize("name", JOINTS)


def scenario(name: str, **more: Any) -> dict[str, Any]:
    integrator = {"step": STEP, "end_time": END, "method": "rk4"}
    return JOINTS[name].example() | {"integrator": integrator, "output": {"every": END}} | more


def started(name: str) -> tuple[Model, Instant]:
    nominal = check_initial(resolve(scenario(name)))
    return nominal.model, nominal.now


@every
def test_the_example_starts_on_its_joint_with_as_many_rows_as_it_says(name: str) -> None:
    model, now = started(name)
    constraint = constraints.constraints_of(model)[-1]
    own = constraints.rows_of(model)[-1]
    kind: type[JointType] = JOINTS[name]
    assert model.joints[-1].type == name
    assert len(constraints.residual(model, now)[own]) == len(constraint.kinds)
    if kind.row_kinds:
        assert constraint.kinds == kind.kinds(model.joints[-1])
        assert len(constraint.kinds) == len(kind.row_kinds)
    np.testing.assert_allclose(constraints.residual(model, now), 0.0, atol=1e-9)
    np.testing.assert_allclose(constraints.rate_and_bias(model, now)[0], 0.0, atol=1e-9)


@every
def test_jacobian_rate_and_bias_are_the_slopes_of_the_residual(name: str) -> None:
    model, now = started(name)
    C, rng = matrix(model, now), np.random.default_rng(5)
    for _ in range(3):
        u = rng.standard_normal(C.shape[1])
        close(C @ u, slope(lambda dt: constraints.residual(model, after(now, dt, u))))  # noqa: B023
    u = velocities(now) + rng.standard_normal(C.shape[1])
    bodies = tuple((*x[:12], *v) for x, v in zip(now.bodies, u.reshape(-1, 6).tolist(), strict=True))
    moving = replace(now, bodies=bodies)
    rate, bias = constraints.rate_and_bias(model, moving)
    close(rate, C @ u)
    close(bias, slope(lambda dt: matrix(model, after(moving, dt, u)) @ u), 10.0)


@every
def test_energy_is_kept_with_the_order_of_the_method(name: str) -> None:
    runs = [lienumba.run(scenario(name), overrides={"integrator.step": STEP / n}) for n in (1, 2, 16)]
    assert all((run.status == 0).all() for run in runs)
    errors = [float(np.abs(run.position - runs[-1].position).max()) for run in runs[:2]]
    if errors[0] > 1e-11:  # what moves no further is rounding
        assert errors[0] / errors[1] > 2**3.5
    assert float(np.abs(runs[-1].energy_residual).max()) < 1e-8
    assert float(runs[-1].position_violation.max()) < 1e-10


@every
def test_a_run_has_the_same_bits_in_any_lane(name: str) -> None:
    data = scenario(name)
    vary = {"bodies.first.mass": {"distribution": "uniform", "low": 1.8, "high": 2.2}}
    many = lienumba.run(data | {"sweep": {"runs": 11, "vary": vary}})
    few = lienumba.run(data | {"sweep": {"runs": 2, "vary": vary}})
    assert (many.status == 0).all()
    for variable in ("position", "rotation", "angular_velocity", "joint_force"):
        assert (many[variable].values[:2] == few[variable].values).all()


def sentences(data: dict[str, Any]) -> list[str]:
    with pytest.raises(ValidationError) as error:
        ScenarioData.model_validate(data)
    return [str(problem) for problem in problems(error.value, data)]


@every
def test_what_is_written_wrong_is_told_with_its_place(name: str) -> None:
    data = scenario(name)
    joint = data["model"]["joints"][-1]
    for key in (key for key, field in JOINTS[name].model_fields.items() if field.is_required() and key != "type"):
        without = copy.deepcopy(data)
        del without["model"]["joints"][-1][key]
        at = f"model.joints.{joint['name']}" if key != "name" else f"model.joints[{len(data['model']['joints']) - 1}]"
        (told,) = sentences(without)
        assert told.startswith(f"{at}.{key} is missing; give {JOINTS[name].model_fields[key].description}")
    joint["weight"] = 1
    (told,) = sentences(data)
    assert told.startswith(f"model.joints.{joint['name']}.weight is not a known key")


@every
def test_a_body_that_is_not_there_is_told(name: str) -> None:
    data = scenario(name)
    joint = data["model"]["joints"][-1]
    key = "bodies" if "bodies" in joint else "joints"
    joint[key] = ["nobody", *joint[key][1:]]
    with pytest.raises(ScenarioError, match=rf'model\.joints\.{joint["name"]}\.{key}\[0\] = "nobody": is not a'):
        resolve(data)


class Helical(Placed, OneAxis, Angle, Displacement):
    """A screw that says nothing but its equations."""

    row_kinds, coordinate_kinds = "mmrrm", ("angle", "displacement")

    type: Literal["helical"]
    lead: Annotated[Number, Own("m rad-1", 0.1)] = Field(description="the displacement in m per radian")

    @classmethod
    def equations(cls, model: Model, index: int, view: View) -> Vector:
        joint = model.joints[index]
        a, b = (view[i] for i in joint.bodies)
        turned = coordinate(model, Coordinate(index, "angle"), view)
        return (*across(joint, a, b), *parallel(joint, a, b), along(joint, a, b) - joint.numbers["lead"] * turned)


def test_a_joint_that_reads_its_angle_counts_its_turns() -> None:
    """A nut falls down a rod of 0.2 m per radian: c = g lead / (lead^2 + J/m) without end, over ten turns and more."""
    nut = {"name": "nut", "mass": 2.0, "inertia": [1, 1, 0.01], "position": [0, 0, 0], "rotation": [1, 0, 0, 0]}
    rod = {"name": "rod", "type": "helical", "bodies": ["ground", "nut"], "at": [0, 0, 0], "axis": [0, 0, 1]}
    data = {
        "model": {"bodies": [nut], "joints": [rod | {"lead": 0.2}]},
        "integrator": {"step": 1e-3, "end_time": 2.0},
    }
    with JOINTS.temporarily(Helical):
        ds = lienumba.run(data)
    angle = -9.81 * 0.2 / (0.2**2 + 0.01 / 2.0) * ds["time"].values ** 2 / 2.0
    assert angle[-1] < -10 * 2 * np.pi
    np.testing.assert_allclose(ds["position"][0, :, 0, 2], 0.2 * angle, rtol=1e-8, atol=1e-10)
    assert abs(ds["energy_residual"]).max() < 1e-6
