"""Inputs that are states of their own, and how they stop at their limits.

A state x = s + shift, s moved by a law, shift a held number. At a limit it is that limit, and moves with it, for as
long as its rate leads beyond. Two events say so to the bit, "limited" and "free": they set at which limit it is (1 the
upper one, -1 the lower one, 0 none) and shift such that x is within its limits.
"""

from dataclasses import replace
from typing import Any, ClassVar

from pydantic import Field

from lienumba.keys.conversions import timed
from lienumba.keys.types import OR_FORMULA, Timed
from lienumba.mechanics.elements.events import SET
from lienumba.mechanics.elements.inputs.base import RATE, InputType, within
from lienumba.mechanics.elements.names import Names
from lienumba.mechanics.elements.quantities import POSITION, Observed, component, level
from lienumba.mechanics.elements.quantities.base import joined
from lienumba.mechanics.mechanism.kinematics import Instant, View, moving, still
from lienumba.mechanics.mechanism.model import HELD, Event, Law, Model, Quantity
from lienumba.numerics.expressions import Formula
from lienumba.numerics.jets import lift
from lienumba.numerics.operations import absolute, minimum, where

ABOVE, BELOW = "above", "below"  # by how much x is beyond its upper limit, and beyond its lower one
OVER, UNDER, OFF, CLEAR = "over", "under", "off", "clear"  # by how much it is so, or off either one, but for rounding
UP, DOWN = "up", "down"  # how fast its rate would lead beyond them
SHIFT, BACK = "shift", "back"  # the held number, and what it is with x within the limits
APART = 1e-6  # of a limit, and of how far a rate leads beyond it in 1 s: the error of what follows it


class StateInput(InputType):
    """A number of which the rate is given; at its limits it stays."""

    form: ClassVar[str] = "state"
    keeps: ClassVar[bool] = True

    rate: Timed = Field(description=f"the rate of the input in 1/s times its units {OR_FORMULA}, which may read it")

    def to_model(self, name: str, names: Names) -> Quantity:
        return replace(super().to_model(name, names), value=timed(self.rate))

    @classmethod
    def kept(cls, model: Model, quantity: Quantity, view: View, state: Any) -> Any:
        limits = cls.limits_of(model, quantity, view)
        if limits is None or not _stops(model, quantity):
            return within(limits, state)
        at, x = _held(model, quantity, view), state + _held(model, quantity, view, SHIFT)
        return where(at > 0.5, limits[1], where(at < -0.5, limits[0], x))

    @classmethod
    def moved(cls, model: Model, quantity: Quantity, view: View, state: Any) -> Any:
        rate, limits = cls.command(model, quantity, view), cls.limits_of(model, quantity, view)
        if limits is None:
            return rate
        if _stops(model, quantity):
            at, (low, high) = _held(model, quantity, view), cls._limit_rates(model, quantity, view)
            return where(at > 0.5, high, where(at < -0.5, low, rate))
        low, high = limits  # one comparison each: a step ends where the state stops or goes on, and nowhere else
        above, below = minimum(rate, state - high), minimum(-rate, low - state)
        return where(above >= 0.0, 0.0, where(below >= 0.0, 0.0, rate))

    @classmethod
    def level(cls, quantity: Quantity, component: str) -> int:
        return POSITION if component in (UP, DOWN) else super().level(quantity, component)

    @classmethod
    def reads(cls, quantity: Quantity, component: str) -> tuple[Any, ...]:
        return super().reads(quantity, RATE if component in (UP, DOWN) else component)

    @classmethod
    def number(cls, model: Model, quantity: Quantity, component: str, view: View, observed: Observed | None) -> Any:
        if component in (UP, DOWN):
            rate, (low, high) = cls.command(model, quantity, view), cls._limit_rates(model, quantity, view)
            return rate - high if component == UP else low - rate
        if component in (ABOVE, BELOW, BACK):
            limits, state = cls.limits_of(model, quantity, view), cls.state_of(model, quantity, view)
            assert limits is not None
            x = state + _held(model, quantity, view, SHIFT)
            if component == BACK:
                return within(limits, x) - state
            return x - limits[1] if component == ABOVE else limits[0] - x
        if component in (OVER, UNDER, OFF, CLEAR):
            limits = cls.limits_of(model, quantity, view)
            assert limits is not None
            upper = component in (OVER, OFF)
            beyond, leads = (
                cls.number(model, quantity, x, view, observed) for x in ((ABOVE, UP) if upper else (BELOW, DOWN))
            )
            apart = APART * (absolute(limits[1] if upper else limits[0]) + absolute(leads))
            return (beyond if component in (OVER, UNDER) else -beyond) - apart
        return super().number(model, quantity, component, view, observed)

    @classmethod
    def _limit_rates(cls, model: Model, quantity: Quantity, view: View) -> tuple[Any, Any]:
        """How fast the limits move."""
        limits = cls.limits_of(model, quantity, moving(view))
        assert limits is not None
        return lift(limits[0]).b, lift(limits[1]).b


def _stops(model: Model, quantity: Quantity) -> bool:
    """Whether events hold it at its limits."""
    return quantity.name in model.held


def _held(model: Model, quantity: Quantity, view: View, what: str = "") -> Any:
    """At which limit it is held, or its shift."""
    return component(model, joined(HELD, quantity.name, what), view)


def held_at(model: Model, view: View) -> dict[str, Any]:
    """At which limit states are that stop at theirs, by their names: also those that are just there, and whose rates
    lead beyond, which an event says directly behind."""
    found = {}
    for x in model.quantities:
        if x.type == StateInput.form and _stops(model, x):
            above, below, up, down = (component(model, joined(x.name, key), view) for key in (ABOVE, BELOW, UP, DOWN))
            reached = where((above >= 0.0) & (up > 0.0), 1.0, where((below >= 0.0) & (down > 0.0), -1.0, 0.0))
            at = _held(model, x, view)
            found[x.name] = where(at == 0.0, reached, at)
    return found


def with_stops(model: Model) -> Model:
    """The model with the events that hold states at their limits, where these move with places and time."""
    events, held = [*model.events], dict(model.held)
    for x in model.quantities:
        if _is_limited(x) and _follows(model, x):
            events += _stopping(x.name, len(held))
            held |= {x.name: 0.0, joined(x.name, SHIFT): 0.0}
    return replace(model, events=tuple(events), held=held)


def _is_limited(quantity: Quantity) -> bool:
    """Whether it is a state with limits."""
    return quantity.type == StateInput.form and bool({"limit", "limits"} & quantity.numbers.keys())


def _follows(model: Model, quantity: Quantity) -> bool:
    """Whether it is known how fast its limits move: with places, the time, and what events set."""
    limits = quantity.numbers.get("limits", (quantity.numbers.get("limit"),))
    names = (name for x in limits if isinstance(x, Law) for name in x.quantities)
    return all(name.startswith(f"{HELD}.") or level(model, name) == POSITION for name in names)


def _stopping(name: str, place: int) -> tuple[Event, Event]:
    """What stops the input of this name at a limit, and lets it go on; place: of its first number among held ones.
    Where limits cross, x is the lower one."""
    own = {x: joined(name, x) for x in (ABOVE, BELOW, OVER, UNDER, OFF, CLEAR, UP, DOWN, BACK)}
    at = joined(HELD, name)

    def law(text: str, *names: str, condition: bool = False) -> Law:
        read = (at, *(own[x] for x in names)) if condition else tuple(own[x] for x in names)
        return Law(Formula(text.format(at=at, **own), frozenset(read), condition=condition), {}, read)

    free = "where({{at}} > 0 or {{at}} < 0, -1, {{{}}}) > 0 and {{{}}} > 0"
    reaches = f"({free.format(ABOVE, UP)}) or ({free.format(BELOW, DOWN)}) or {{{OVER}}} > 0 or {{{UNDER}}} > 0"
    leaves = (
        f"where({{at}} > 0, where({{{OFF}}} > 0, 1, -{{{UP}}}), where({{at}} < 0 and {{{ABOVE}}} + {{{BELOW}}} <= 0, "
        f"where({{{CLEAR}}} > 0, 1, -{{{DOWN}}}), -1)) > 0"
    )
    which = law("where({above} + {below} <= 0, where({above} > {below}, 1, -1), -1)", ABOVE, BELOW)
    limited = law(reaches, ABOVE, BELOW, OVER, UNDER, UP, DOWN, condition=True)
    goes_on = law(leaves, ABOVE, BELOW, OFF, CLEAR, UP, DOWN, condition=True)
    shift = (place + 1, law("{back}", BACK))
    return (
        Event(joined(name, "limited"), limited, False, action=SET.name, values=((place, which), shift)),
        Event(joined(name, "free"), goes_on, False, action=SET.name, values=((place, 0.0), shift)),
    )


class RestingInput(StateInput):
    """A state with limits as a search for equilibria has it: projected on what is within, so that it rests at a limit
    that its rate leads beyond."""

    form: ClassVar[str] = "resting state"

    @classmethod
    def kept(cls, model: Model, quantity: Quantity, view: View, state: Any) -> Any:
        return within(cls.limits_of(model, quantity, view), state)

    @classmethod
    def moved(cls, model: Model, quantity: Quantity, view: View, state: Any) -> Any:
        rate, (low, high) = cls.command(model, quantity, view), cls.limits_of(model, quantity, view) or (0.0, 0.0)
        return where(state + rate > high, high - state, where(state + rate < low, low - state, rate))


def resting_inputs(model: Model) -> Model:
    """The model whose inputs rest at their limits, too."""

    found = (replace(x, type=RestingInput.form) if _is_limited(x) else x for x in model.quantities)
    return replace(model, quantities=tuple(found))


def halted(model: Model, now: Instant) -> dict[str, tuple[Any]]:
    """Of the states of these inputs by their names, 1 for what is at a limit that its rate leads beyond, else 0."""
    view, found = still(now, tuple(range(len(model.bodies)))), {}
    for x in model.quantities:
        if x.type == RestingInput.form:
            moved = RestingInput.moved(model, x, view, RestingInput.state_of(model, x, view))
            found[x.name] = (where(moved == RestingInput.command(model, x, view), 0.0, 1.0),)
    return found
