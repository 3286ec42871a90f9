"""Every type of force that the registry knows, whatever it is: mathematics, units, messages, runs. A new type is tested
here by its `example`."""

from dataclasses import replace
from typing import Any, Literal

import numpy as np
import pytest

import lienumba
from lienumba.keys.types import Timed
from lienumba.mechanics.elements.forces import FORCES
from lienumba.mechanics.elements.forces.base import AlongJoint, BetweenPoints, Given, OnBody, quadratic
from lienumba.mechanics.elements.forces.numbers import number
from lienumba.mechanics.mechanism.kinematics import still
from lienumba.mechanics.mechanism.model import Force
from lienumba.mechanics.system import applied_forces
from lienumba.numerics.number import Number, Vector
from lienumba.scenario.base.units import units
from lienumba.scenario.start.build import build
from tests.facade import ScenarioError, resolve
from tests.mechanics.elements.force_cases import instant, model, moved, velocities

TYPES = [name for name in FORCES if name != "python"]  # whose keys are the user's own
NUMBERS = [(name, key) for name in TYPES for key in FORCES[name].numbers()]
BODY = {"mass": 2.0, "inertia": [0.5, 0.6, 0.7], "rotation": {"axis": [0, 1, 0], "angle": 0.3}}


def keys_of(name: str, **more: Any) -> dict[str, Any]:
    """The example of a type as a scenario has it, on two bodies and the joint between them."""
    kind = FORCES[name]
    where: dict[str, Any] = {}
    if issubclass(kind, BetweenPoints):
        where = {"bodies": ["a", "b"], "points": [[0.3, -0.2, 0.5], [-0.4, 0.1, 0.2]]}
    elif issubclass(kind, OnBody):
        where = {"body": "b"} | ({"point": [0.3, -0.2, 0.5]} if "point" in kind.model_fields else {})
    elif issubclass(kind, AlongJoint):
        where = {"joint": "sleeve", "coordinate": kind.kinds[-1]}
    return {"name": name, "type": name, **where, **kind.example, **more}


def scenario(*forces: dict[str, Any], step: float = 1e-3, end: float = 0.05, **sweep: Any) -> dict[str, Any]:
    """Two bodies on a sleeve that fly, turn and slide."""
    a = BODY | {"name": "a", "position": [0, 0, 0], "velocity": [0.1, 0, 0.2], "angular_velocity": [1, 2, 3]}
    sleeve = {
        "name": "sleeve", "type": "cylindrical", "bodies": ["a", "b"], "points": [[0.2, 0, 0], [0, 0, 0.1]],
        "axes": [[0, 0, 1], [0, 0, 1]], "angle": 0.7, "rate": 1.5, "displacement": 0.4, "speed": -0.6,
    }  # fmt: skip
    return {
        "model": {"bodies": [a, {key: x for key, x in BODY.items() if key != "rotation"} | {"name": "b"}],
                  "joints": [sleeve], "forces": list(forces)},
        "integrator": {"step": step, "end_time": end},
        "output": {"every": end},
        "sweep": sweep,
    }  # fmt: skip


def force_of(name: str) -> Force:
    """The example of a type, as kernels see it; what the start decides, too."""
    built = build(resolve(scenario(keys_of(name))), {})[0].forces[0]
    return replace(built, rest=FORCES[name].at_start(built, still(instant(5), built.bodies)))


@pytest.mark.parametrize("name", TYPES)
def test_a_type_has_an_example_with_which_it_acts(name: str) -> None:
    assert np.abs(applied_forces.generalized(model(force_of(name)), instant(1))).max() > 0.1


@pytest.mark.parametrize("seed", [0, 1, 2])
@pytest.mark.parametrize("name", TYPES)
def test_work_is_what_potential_and_power_say(name: str, seed: int) -> None:
    """Q u = power - dV/dt, by fourth-order differences of V while the clock runs."""
    m, now, h = model(force_of(name)), instant(seed), 1e-4
    u = velocities(now)
    V = [float(applied_forces.potential(m, moved(now, u, s * h, s * h))) for s in (-2, -1, 1, 2)]
    growth = (V[0] - 8.0 * V[1] + 8.0 * V[2] - V[3]) / (12.0 * h)
    work = np.dot(applied_forces.generalized(m, now), u)
    assert work == pytest.approx(applied_forces.power(m, now) - growth, rel=1e-8, abs=1e-7)


@pytest.mark.parametrize("name", [name for name in TYPES if FORCES[name].has_potential()])
def test_a_potential_depends_on_the_numbers_that_say_so_and_on_no_others(name: str) -> None:
    read: set[str] = set()

    class Recording(Given):
        def __getitem__(self, key: str) -> Any:
            read.add(key)
            return super().__getitem__(key)

    kind, force = FORCES[name], force_of(name)
    given = Recording(model(force), force, still(instant(1), (0, 1)))
    kind.potential(given, tuple(kind.coordinates(given, given.view)))
    assert read == {key for key, number in kind.numbers().items() if number.in_potential}


@pytest.mark.parametrize(("name", "key"), [x for x in NUMBERS if issubclass(FORCES[x[0]], AlongJoint)])
def test_what_reads_an_angle_over_its_turns_says_so(name: str, key: str) -> None:
    """Where the numbers that say so are 0, a force and its energy are the same a turn later."""
    kind, force = FORCES[name], force_of(name)
    if "angle" not in kind.kinds:
        return
    assert force.coordinate is not None
    counting = [key for key, number in kind.numbers().items() if number.counts_turns]
    without = {key: 0.0 if key in counting else x for key, x in force.numbers.items()}
    for numbers in (force.numbers, without):
        turned = replace(force, coordinate=replace(force.coordinate, kind="angle"), numbers=numbers)
        every = []
        for angle in (0.3, 0.3 + 2.0 * np.pi):
            m, now = model(turned), replace(instant(1), angles={0: angle})
            every.append([*applied_forces.generalized(m, now), applied_forces.potential(m, now)])
        if not kind.reads_angle(turned):
            np.testing.assert_allclose(every[0], every[1], rtol=1e-12, atol=1e-12)
            assert applied_forces.angle_joints(model(turned)) == set()
        else:
            assert applied_forces.angle_joints(model(turned)) == {0}


class Winder(AlongJoint):
    """A spring of a joint whose stiffness has another name, and nothing said about it."""

    type: Literal["winder"]
    winding: Timed = number("the winding in {}", ("N m-1", "N m rad-1"))

    @staticmethod
    def potential(given: Given, c: Vector) -> Number:
        return quadratic(given["winding"], c[0])


def test_a_potential_of_an_angle_counts_turns_whatever_its_numbers_are_called() -> None:
    with FORCES.temporarily(Winder):
        force = replace(force_of("torsion_spring"), type="winder", numbers={"winding": 2.0})
        assert applied_forces.angle_joints(model(force)) == {0}
        assert applied_forces.angle_joints(model(replace(force, numbers={"winding": 0.0}))) == set()


class Choosy(Winder):
    """With a choice under a name of its own, which is no formula."""

    type: Literal["choosy"]  # type: ignore[assignment]
    flavour: Literal["sin", "tan"]


def test_a_choice_is_no_formula_whatever_its_key_is_called() -> None:
    with FORCES.temporarily(Choosy):
        spring = {"name": "spring", "type": "choosy", "joint": "sleeve", "coordinate": "angle", "winding": "2*k"}
        data = scenario(spring | {"flavour": "tan"}) | {"parameters": {"k": 1.5}}
        assert build(resolve(data), {})[0].forces[0].numbers == {"winding": 3.0}
        with pytest.raises(
            ScenarioError, match=r'spring\.flavour = "tam": must be "sin" or "tan"; the nearest is "tan"'
        ):
            resolve(scenario(spring | {"flavour": "tam"}) | {"parameters": {"k": 1.5}})


# ---------------------------------------------------------------- keys
@pytest.mark.parametrize(("name", "key"), NUMBERS)
def test_a_number_has_units_that_its_description_and_the_dataset_share(name: str, key: str) -> None:
    found = units(f"forces.{name}.{key}", dict(resolve(scenario(keys_of(name))).data.model))
    pair = FORCES[name].numbers()[key].units
    assert found in ((pair,) if isinstance(pair, str) else pair)
    description = FORCES[name].model_fields[key].description or ""
    assert description.partition("(or a formula of t")[1], description


@pytest.mark.parametrize(("name", "key"), NUMBERS)
def test_a_number_that_is_wrong_is_refused_at_its_place(name: str, key: str) -> None:
    vector = isinstance(FORCES[name].example.get(key), list)
    wrong = [1.0, "q", 1.0][: len(FORCES[name].example[key])] if vector else "q"
    with pytest.raises(ScenarioError) as caught:
        resolve(scenario(keys_of(name, **{key: wrong})))
    at = f"model.forces.{name}.{key}{'[1]' if vector else ''}"
    assert str(caught.value).splitlines()[0].startswith(f'{at} = "q": has the unknown name "q"')


@pytest.mark.parametrize(("name", "key"), [x for x in NUMBERS if FORCES[x[0]].numbers()[x[1]].sign])
def test_a_number_below_zero_is_told(name: str, key: str) -> None:
    sign, vector = FORCES[name].numbers()[key].sign, isinstance(FORCES[name].example.get(key), list)
    assert sign is not None
    at = f"model.forces.{name}.{key}{'[1]' if vector else ''}"
    data = scenario(keys_of(name, **{key: [0.0, -2.0, 0.0] if vector else -2.0}))
    wanted = f"{at} = -2.0: {sign.rule}; {sign.remedy}"
    if sign.warns:
        assert wanted in map(str, resolve(data).warnings)
    else:
        with pytest.raises(ScenarioError) as caught:
            resolve(data)
        assert wanted in str(caught.value).splitlines()


@pytest.mark.parametrize("name", [*TYPES, "python"])
def test_a_type_does_not_know_what_others_know(name: str) -> None:
    with pytest.raises(ScenarioError) as caught:
        resolve(scenario(keys_of(name, colour=3)))
    assert any(
        line.startswith(f"model.forces.{name}.colour is not a known key") for line in str(caught.value).splitlines()
    )


# ---------------------------------------------------------------- runs
def test_all_types_at_once_keep_the_energy_at_the_order_of_the_method() -> None:
    residuals = []
    for step in (2e-3, 1e-3):
        ds = lienumba.run(scenario(*map(keys_of, TYPES), step=step, end=0.1), workers=1)
        residuals.append(abs(float(ds["energy_residual"][0, -1])))
    assert residuals[0] / residuals[1] > 2.0**3.5
    assert residuals[1] < 1e-7


def test_all_types_have_the_same_bits_in_every_lane() -> None:
    """The first run of a block, and the same alone."""
    path = "forces.spring_damper.stiffness"
    vary = {path: {"distribution": "uniform", "low": 30, "high": 50}}
    many = lienumba.run(scenario(*map(keys_of, TYPES), runs=9, vary=vary), workers=1)
    one = lienumba.run(scenario(*map(keys_of, TYPES), runs=1, vary=vary), workers=1)
    for variable in ("position", "velocity", "rotation", "angular_velocity", "potential_energy", "work"):
        assert many[variable].isel(run=0).values.tobytes() == one[variable].isel(run=0).values.tobytes()
    assert len(np.unique(many["potential_energy"][:, -1])) == 9
