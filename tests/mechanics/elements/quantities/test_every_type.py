"""Every type of quantity that the registry knows, whatever it is: levels, parts, keys, messages, runs."""

from dataclasses import replace
from typing import Any, Literal

import numpy as np
import pytest

import lienumba
from lienumba.compiler.symbols import Graph, live
from lienumba.groups import so3
from lienumba.groups.state import ELEMENT
from lienumba.keys.conversions import vec3
from lienumba.keys.types import Two
from lienumba.mechanics.elements import quantities
from lienumba.mechanics.elements.names import Names
from lienumba.mechanics.elements.quantities import OBSERVED, POSITION, QUANTITIES, Observed, Part
from lienumba.mechanics.elements.quantities.base import QuantityType, name_of
from lienumba.mechanics.mechanism.kinematics import View
from lienumba.mechanics.mechanism.model import Quantity
from lienumba.mechanics.system.switches import switches_of
from lienumba.numerics.number import Vector
from lienumba.numerics.operations import sqrt
from lienumba.scenario.formulas.formula_names import known_of
from lienumba.scenario.start.build import build
from tests.facade import Instant, Model, ScenarioError, resolve
from tests.mechanics.elements.force_cases import frame
from tests.mechanics.elements.forces.test_every_type import scenario as rig

NAMES = {"bodies": "b", "joints": "sleeve", "drivers": "turn", "contacts": "floor", "limits": "stop"}
SINGULAR = {"bodies": "body", "joints": "joint", "drivers": "driver", "contacts": "contact", "limits": "limit"}
LISTED = {"momentum": 1, "distance": 2}  # names of bodies
FLOOR = {"name": "floor", "type": "point_plane", "bodies": ["b", "ground"], "points": [[0, 0, 0], [0, 0, -9]],
         "stiffness": 10.0}  # fmt: skip
STOP = {"name": "stop", "joint": "sleeve", "coordinate": "displacement", "high": 90.0}
HOLD = {"name": "hold", "when": "sin(t) > 2", "action": "lock", "joint": "sleeve", "coordinate": "displacement"}
REFERENCES = [(name, key) for name, kind in QUANTITIES.items() for key in kind.references()]
VELOCITIES = 12  # the first row of them in the state of a body


def keys_of(name: str, **more: Any) -> dict[str, Any]:
    """The example of a type as a scenario has it."""
    kind = QUANTITIES[name]
    named: dict[str, Any] = {
        key: NAMES[x.to] for key, x in kind.references().items() if kind.model_fields[key].is_required()
    }
    if name == "distance":
        named = {"bodies": ["ground", NAMES["bodies"]]}
    return {"name": f"seen_{name}", "type": name, **named, **kind.example, **more}


def scenario(*named: dict[str, Any], **more: Any) -> dict[str, Any]:
    data = rig(**more)
    data["model"]["drivers"] = [{"name": "turn", "joint": "sleeve", "coordinate": "angle", "value": "0.7 + 1.5*t"}]
    types = {x["type"] for x in named}
    data["model"] |= {"contacts": [FLOOR] if "contact" in types else [], "limits": [STOP] if "limit" in types else []}
    return data | {"quantities": list(named), "events": [HOLD] if "lock" in types else []}


def model_of(name: str, **more: Any) -> Model:
    built = build(resolve(scenario(keys_of(name, **more))), {})[0]
    return replace(built, joints=tuple(replace(joint, frames=(frame(1), frame(2))) for joint in built.joints))


def reads_velocities(x: object) -> bool:
    return any(
        getattr(y, "op", "") == "input" and y.args[0] == "state" and y.args[1] % ELEMENT >= VELOCITIES
        for node in live((x,))
        for y in (node, *node.args)
    )


@pytest.mark.parametrize("name", QUANTITIES)
def test_parts_have_the_numbers_that_rows_give_and_levels_say_what_they_read(name: str) -> None:
    m, graph = model_of(name), Graph()
    (quantity,) = m.quantities
    now = Instant(tuple(tuple(graph.inputs("state", ELEMENT, ELEMENT * i)) for i in range(2)), graph.input("clock", 0))
    numbers = [graph.inputs("seen", n, 100 * n) for n in (12, 3, 3, 1)]
    switches = {(x.what, x.name): graph.inputs("seen", x.rows, 500) for x in switches_of(m)}
    observed = Observed(numbers[0], numbers[1], numbers[2], [numbers[3]], switches)
    found = dict(quantities.observe(m, now, observed))
    parts = quantities.parts(m, quantity)
    assert {quantities.joined(quantity.name, x.name): len(x.components) for x in parts} == {
        key: len(rows) for key, rows in found.items()
    }
    rows = [x for part in found.values() for x in part]
    for component, row in zip(quantities.components(m, quantity), rows, strict=True):
        level = quantities.level(m, quantities.joined(quantity.name, component))
        seen = {y.args[0] for node in live((row,)) for y in (node, *node.args) if getattr(y, "op", "") == "input"}
        assert level == OBSERVED or "seen" not in seen
        assert level > POSITION or not reads_velocities(row)


@pytest.mark.parametrize("name", QUANTITIES)
def test_what_formulas_know_before_the_check_is_what_the_model_gives(name: str) -> None:
    """`sketch` says of a table what the class says of the model."""
    m, data = model_of(name), scenario(keys_of(name))
    known = known_of(data["model"] | {"quantities": data["quantities"]})
    components = {quantities.joined(m.quantities[0].name, x) for x in quantities.components(m, m.quantities[0])}
    assert known.names == components
    assert {x: known.level(x) for x in components} == {x: quantities.level(m, x) for x in components}


@pytest.mark.parametrize(("name", "key"), REFERENCES)
def test_a_name_that_nothing_has_is_refused_at_its_place(name: str, key: str) -> None:
    kind = QUANTITIES[name].references()[key].to
    listed, wrong = LISTED.get(name, 0), f"{NAMES[kind]}_"
    with pytest.raises(ScenarioError) as caught:
        resolve(scenario(keys_of(name, **{key: [wrong, "ground"][:listed] if listed else wrong})))
    at = f"quantities.seen_{name}.{key}{'[0]' if listed else ''}"
    assert str(caught.value).startswith(f'{at} = "{wrong}": is not a {SINGULAR[kind]} of the model; ')


def test_all_types_at_once_are_stored_with_the_same_bits_in_every_lane() -> None:
    every = [keys_of(name) for name in QUANTITIES]
    vary = {"bodies.b.mass": {"distribution": "uniform", "low": 1, "high": 2}}
    many, one = (lienumba.run(scenario(*every, runs=runs, vary=vary), workers=1) for runs in (9, 1))
    for quantity in (m := build(resolve(scenario(*every)), {})[0]).quantities:
        for part in quantities.parts(m, quantity):
            name = quantities.joined(quantity.name, part.name)
            assert many[name].attrs["units"] == part.units
            assert np.isfinite(many[name]).all()
            assert many[name].isel(run=0).values.tobytes() == one[name].isel(run=0).values.tobytes()


class Gap(QuantityType):
    """The distance of two points."""

    type: Literal["gap"]
    bodies: list[str] = name_of("bodies", "ground", description="the names of two bodies")
    points: Two

    @classmethod
    def level(cls, quantity: Quantity, component: str) -> int:
        return POSITION

    @classmethod
    def parts(cls, model: Model, quantity: Quantity) -> tuple[Part, ...]:
        return (Part("", "m", "distance"),)

    @classmethod
    def rows(cls, model: Model, quantity: Quantity, view: View, observed: Observed | None) -> Vector:
        p, q = (view[i].point(quantity.numbers[key]) for i, key in zip(quantity.bodies, "pq", strict=True))
        d = so3.subtract(q, p)
        return (sqrt(so3.dot(d, d)),)

    def to_model(self, names: Names) -> Quantity:
        numbers = {key: vec3(point) for key, point in zip("pq", self.points, strict=True)}
        return Quantity(self.name, self.type, tuple(names.bodies[name] for name in self.bodies), numbers=numbers)


def test_a_type_of_ones_own_is_stored_varied_and_read() -> None:
    gap = {"name": "gap", "type": "gap", "bodies": ["ground", "b"], "points": [[0, 0, 1], [0, 0, 0]]}
    twice = {"name": "twice", "type": "expression", "value": "2*gap"}
    vary = {"quantities.gap.points[0][2]": {"distribution": "uniform", "low": 1, "high": 3}}
    with QUANTITIES.temporarily(Gap):
        ds = lienumba.run(scenario(gap, twice, runs=9, vary=vary), workers=1)
        with pytest.raises(ScenarioError, match=r'quantities\.gap\.bodies\[1\] = "c": is not a body of the model'):
            resolve(scenario(gap | {"bodies": ["a", "c"]}))
    points = np.array([0, 0, 1]) * ds["quantities.gap.points[0][2]"].values[:, None, None]
    wanted = np.linalg.norm(ds["position"].sel(body="b").values - points, axis=-1)
    np.testing.assert_allclose(ds["gap"], wanted, rtol=1e-14)
    assert (ds["twice"] == 2 * ds["gap"]).all()
    assert ds["gap"].attrs["units"] == "m"
