"""Quantities of a model at a state, and formulas that read them or the states of laws."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from math import inf, nan
from typing import Any

from lienumba.mechanics.elements import joints
from lienumba.mechanics.elements.quantities.base import (
    POSITION,
    VELOCITY,
    Observed,
    Part,
    is_input,
    joined,
    kind_of,
    owner,
)
from lienumba.mechanics.mechanism import kinematics
from lienumba.mechanics.mechanism.kinematics import Instant, View
from lienumba.mechanics.mechanism.model import (
    EVENT_TIME,
    GROUND,
    HELD,
    Coordinate,
    Counted,
    Law,
    Model,
    Quantity,
    Timed,
)
from lienumba.numerics.evaluation import WITHIN
from lienumba.numerics.expressions import Formula
from lienumba.numerics.jets import Jet, lift
from lienumba.numerics.number import Number, Vector
from lienumba.numerics.operations import where


def evaluate(model: Model, x: Timed, view: View, observed: Observed | None = None) -> Any:
    """The number that a timed number is in a view."""
    if not callable(x):
        return x
    if isinstance(x, Formula):
        return x(view.t) if view.within is None else x(view.t, **{WITHIN: (view.within, frozenset())})
    if not isinstance(x, Law):
        return x(view.t)
    read = {name: component(model, name, view, observed) for name in x.quantities}
    return x(view.t, **read) if view.within is None else x(view.t, **read, **{WITHIN: (view.within, frozenset(read))})


def component(model: Model, name: str, view: View, observed: Observed | None = None) -> Any:
    """One number of a quantity, or a state of a law, by its name in formulas: "pointing.x", "pid.integral"."""
    first, rest = owner(name)
    held = rest if first == HELD else name
    if held in model.held and first in (HELD, EVENT_TIME):
        number = view.states.get(HELD, tuple(model.held.values()))[list(model.held).index(held)]
        return where(number >= 0.0, number, inf) if first == EVENT_TIME else number
    quantity = _named(model, first)
    if quantity is None:
        force = next(f for f in model.forces if f.name == first)
        states = view.states.get(first, tuple(force.initial.values()))
        return states[list(force.initial).index(rest)]
    return kind_of(quantity).number(model, quantity, rest, view, observed)


def rows(model: Model, quantity: Quantity, view: View, observed: Observed | None = None) -> Vector:
    """All numbers of a quantity, part by part."""
    return kind_of(quantity).rows(model, quantity, view, observed)


def parts(model: Model, quantity: Quantity) -> tuple[Part, ...]:
    """The variables that it gives."""
    return kind_of(quantity).parts(model, quantity)


def components(model: Model, quantity: Quantity) -> list[str]:
    """The names of its numbers, behind its own."""
    return [name for part in parts(model, quantity) for name in part.components]


def units(model: Model) -> dict[str, str]:
    """Those of every component, by its name in formulas, but for formulas of which nobody says them."""
    said = (
        (q, part) for q in model.quantities for part in parts(model, q) if part.units != "1" or not callable(q.value)
    )
    return {joined(q.name, name): part.units for q, part in said for name in part.components}


def observe(model: Model, now: Instant, observed: Observed | None) -> Iterator[tuple[str, list[Number]]]:
    """The rows of every variable that quantities give, by its name."""
    everything = kinematics.still(now, tuple(range(len(model.bodies))))
    for quantity in model.quantities:
        numbers = list(rows(model, quantity, everything, observed))
        for part in parts(model, quantity):
            size = len(part.components)
            yield joined(quantity.name, part.name), numbers[:size]
            numbers = numbers[size:]


def conditions(model: Model, now: Instant, observed: Observed | None) -> list[Number]:
    """A number for each event, above 0 where its condition holds."""
    everything = kinematics.still(now, tuple(range(len(model.bodies))))
    return [evaluate(model, event.when, everything, observed) for event in model.events]


def condition_rates(
    model: Model, now: Instant, accelerations: Sequence[Number] | None, rates: Mapping[str, Sequence[Number]]
) -> list[Number]:
    """How fast these numbers change (1/s), NaN where neither velocities nor what else is known say so: accelerations,
    and with these the rates of the states of laws."""
    view = kinematics.still(now, tuple(range(len(model.bodies))))
    if accelerations is None:
        return [_rate(model, x.when, kinematics.moving(view)) if moves(model, x.when) else nan for x in model.events]
    states = {name: tuple(map(Jet, x, rates[name])) if name in rates else x for name, x in view.states.items()}
    view = replace(kinematics.moving(view, accelerations), states=states)
    return [_rate(model, x.when, view) if flows(model, x.when) else nan for x in model.events]


def _rate(model: Model, x: Timed, moving: View) -> Any:
    return lift(evaluate(model, x, moving)).b


def bodies_of(model: Model, *numbers: Timed) -> tuple[int, ...]:
    """The bodies (indices) whose motion these numbers read."""
    found: dict[int, None] = {}
    for x in numbers:
        for name in x.quantities if isinstance(x, Law) else ():
            first, rest = owner(name)
            quantity = _named(model, first)
            if quantity is None:
                continue
            ends = (*quantity.bodies, quantity.relative_to, quantity.frame)
            if quantity.joint >= 0:
                ends += model.joints[quantity.joint].bodies
            found |= dict.fromkeys((*ends, *bodies_of(model, *kind_of(quantity).reads(quantity, rest))))
    return tuple(i for i in found if i != GROUND)


def counted_angles(model: Model) -> set[Counted]:
    """The angles of joints, over several turns, that quantities are."""
    of_joints = {q.joint for q in model.quantities if kind_of(q).reads_coordinates}
    every = {j: joints.JOINTS[model.joints[j].type].freedoms() for j in of_joints}
    return {Coordinate(j, x.name).counted for j, found in every.items() for x in found if x.counts}


def level(model: Model, name: str) -> int:
    """What a component needs to be known of the state; of an expression, what all in it need. States of laws can be
    differentiated no more than velocities; times of events stand still."""
    first, rest = owner(name)
    quantity = _named(model, first)
    if quantity is None:
        return POSITION if first == EVENT_TIME else VELOCITY
    kind = kind_of(quantity)
    inner = (name for x in kind.reads(quantity, rest) if isinstance(x, Law) for name in x.quantities)
    return max([kind.level(quantity, rest), *(level(model, x) for x in inner)])


def has_rate(model: Model, x: Timed) -> bool:
    """Whether the rate of a number follows from accelerations wherever it does not bend: it is of what moves."""
    return flows(model, x) and not any(_keeps(model, name) for y in _parts(model, x) for name in _names(y))


def flows(model: Model, x: Timed) -> bool:
    """Whether it does where the rates of the states of laws are known as well."""
    courses = any(_keeps(model, y) and _is_course(model, y) for z in _parts(model, x) for y in _names(z))
    return bends(model, x) is not None and needs(model, x) <= VELOCITY and not courses


def moves(model: Model, x: Timed) -> bool:
    """Whether the rate of a number follows from the velocities wherever it does not bend: it is of positions."""
    return bends(model, x) is not None and needs(model, x) == POSITION


def leaps(model: Model, x: Timed) -> bool:
    """Whether a number may be another one before and behind a time at which forces jump, or laws are sampled, where
    positions and velocities are the same."""
    return any(_leaps(model, _formula(y), _names(y)) for y in _parts(model, x))


def _leaps(model: Model, formula: Timed, names: tuple[str, ...]) -> bool:
    """Of a formula itself, and of what it reads."""
    if any(level(model, name) > VELOCITY or _keeps(model, name) for name in names):
        return True
    return formula.leaps if isinstance(formula, Formula) else callable(formula)


def _keeps(model: Model, name: str) -> bool:
    """Whether a component has a state, or a course, of its own."""
    quantity, rest = _named(model, owner(name)[0]), owner(name)[1]
    return quantity is None or not kind_of(quantity).reads(quantity, rest)


def _is_course(model: Model, name: str) -> bool:
    """Whether what keeps a state or a course of its own is no law that moves it."""
    first, _ = owner(name)
    return _named(model, first) is not None and not is_input(first)


def bends(model: Model, x: Timed) -> tuple[Timed, ...] | None:
    """Numbers at whose zeros this one may have, as far as formulas say, kinks or jumps, and nowhere else; None if there
    are no such ones."""
    found = list[Timed]()
    for y in _parts(model, x):
        formula = _formula(y)
        own = formula.bends if isinstance(formula, Formula) else ()
        if own is None:
            return None
        for z in own:
            read = tuple(name for name in _names(y) if name in z.used)
            found.append(replace(y, function=z, quantities=read) if isinstance(y, Law) else z)
    return tuple(found)


def needs(model: Model, x: Timed) -> int:
    """The highest `level` of what a number depends on."""
    return max((level(model, name) for y in _parts(model, x) for name in _names(y)), default=POSITION)


def _formula(x: Timed) -> Timed:
    return x.function if isinstance(x, Law) else x


def _names(x: Timed) -> tuple[str, ...]:
    """The components that a number reads itself."""
    return x.quantities if isinstance(x, Law) else ()


def _parts(model: Model, x: Timed) -> Iterator[Timed]:
    """The numbers that one depends on, itself first."""
    yield x
    for first, rest in map(owner, _names(x)):
        quantity = _named(model, first)
        for y in () if quantity is None else kind_of(quantity).reads(quantity, rest):
            yield from _parts(model, y)


def _named(model: Model, name: str) -> Quantity | None:
    return next((q for q in model.quantities if q.name == name), None)
