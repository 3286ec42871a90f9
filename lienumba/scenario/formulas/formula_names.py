"""What formulas may read of the mechanism: the components of its quantities, and what each needs to be known."""

from dataclasses import replace
from typing import NamedTuple

from lienumba.mechanics.elements import quantities
from lienumba.mechanics.elements.drivers import DRIVERS, driver_form
from lienumba.mechanics.elements.events import ends_run, time_of
from lienumba.mechanics.elements.inputs import has_state, input_form
from lienumba.mechanics.elements.joints import JOINTS, coordinate_kinds
from lienumba.mechanics.elements.quantities import NOISES, QUANTITIES
from lienumba.mechanics.mechanism import model as m
from lienumba.mechanics.mechanism.model import NOT_YET, Law, Model
from lienumba.scenario.base.code import PYTHON
from lienumba.scenario.base.paths import INPUTS
from lienumba.scenario.base.problems import tables, well_named
from lienumba.scenario.base.toml import Keys, table_in


class Known(NamedTuple):
    """`sketch`: a model with the quantities that are well-formed, and of joints and drivers no more than these need."""

    sketch: Model

    @property
    def names(self) -> frozenset[str]:
        """Every component, and every state of a law, as formulas call it."""
        seen = self.sketch
        found = {quantities.joined(q.name, c) for q in seen.quantities for c in quantities.components(seen, q)}
        return frozenset(found | {f"{f.name}.{state}" for f in seen.forces for state in f.initial} | {*seen.held})

    def level(self, name: str) -> int:
        return quantities.level(self.sketch, name)

    def is_state(self, name: str) -> bool:
        """Whether it is a state of a law."""
        first = quantities.owner(name)[0]
        kept = any(q.name == first and has_state(q) for q in self.sketch.quantities)
        return kept or any(f.name == first for f in self.sketch.forces)

    def described(self, name: str) -> str:
        """What a component of the level of velocities is."""
        if any(q.name == name and q.type in NOISES for q in self.sketch.quantities):
            return "a noise, which has no rate"
        if quantities.is_input(name):
            return "which is a state" if self.is_state(name) else "which depends on velocities"
        return "a state of a law" if self.is_state(name) else "a velocity"

    def singular(self, name: str) -> bool:
        """Whether a component has no derivative somewhere, as the angle of a rotation."""
        first, rest = quantities.owner(name)
        return any(q.name == first and rest in quantities.kind_of(q).singular for q in self.sketch.quantities)

    def with_values(self, used: dict[str, frozenset[str]]) -> "Known":
        """With what each expression reads, by its name."""
        laws = {name: Law(abs, {}, tuple(sorted(names & self.names))) for name, names in used.items()}
        named = tuple(replace(q, value=laws.get(q.name, 0.0)) if _has_value(q) else q for q in self.sketch.quantities)
        return Known(replace(self.sketch, quantities=named))


def _has_value(quantity: m.Quantity) -> bool:
    """Whether a quantity may be given by a formula; the schema refuses that of others later."""
    return quantities.is_input(quantity.name) or "value" in quantities.kind_of(quantity).model_fields


def known_of(model: object) -> Known:
    """What the tables of a model, not yet checked, let formulas read; what is wrong in them is passed over."""
    model = model if isinstance(model, dict) else {}
    joints = {str(t.get("name")): t for t in tables(model.get("joints")) if t.get("type") in JOINTS}
    drivers = {str(t.get("name")): t for t in tables(model.get("drivers")) if _is_driver(t)}
    stub = [m.Joint(name, str(t.get("type")), ()) for name, t in joints.items()]
    sketch = Model((0.0, 0.0, 0.0), (), tuple(stub), tuple(_driver(name, t, joints) for name, t in drivers.items()))
    inputs = [_input(name, x) for name, x in table_in(model, INPUTS).items()]
    found = [
        kind.sketch(t, [*joints], [*drivers])
        for section, types in (("quantities", QUANTITIES), ("noise", NOISES))
        for t in tables(model.get(section))
        if (kind := types.get(str(t.get("type")))) is not None and well_named(kind, t)
    ]
    laws = [t for t in tables(model.get("forces")) if t.get("type") == PYTHON]
    forces = tuple(m.Force(str(t.get("name")), PYTHON, (), initial=table_in(t, "states")) for t in laws)
    named = [str(t.get("name")) for t in tables(model.get("events")) if not ends_run(t.get("action"))]
    held = dict.fromkeys(map(time_of, named), NOT_YET)
    every = tuple(q for q in (*found, *inputs) if q is not None)
    return Known(replace(sketch, quantities=every, forces=forces, held=held))


def _input(name: str, value: object) -> m.Quantity | None:
    """As much of an input as tells whether it is a state; None for a number, which is no quantity."""
    if isinstance(value, int | float) and not isinstance(value, bool):
        return None
    form = input_form(value) if isinstance(value, dict) else None
    filtered = {"filter": 0.0} if isinstance(value, dict) and "filter" in value else {}
    return m.Quantity(quantities.joined(INPUTS, name), form or "formula", numbers=filtered)


def _is_driver(table: Keys) -> bool:
    form = driver_form(table)
    return form is not None and well_named(DRIVERS[form], table)


def _driver(name: str, table: Keys, joints: dict[str, Keys]) -> m.Driver:
    """As much of a driver as tells what its effort is."""
    kinds = coordinate_kinds(joints.get(str(table.get("joint")), {}).get("type"))
    return DRIVERS[driver_form(table) or ""].sketch(name, table, kinds)
