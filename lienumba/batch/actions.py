"""What events do, as drivers know it (`lienumba.integrators.layout.ACTION`)."""

from collections.abc import Sequence

import numpy as np

from lienumba.integrators.drivers.workspace import Plan
from lienumba.integrators.layout import (
    ACT_NUMBERS,
    ENGAGES,
    KEPT_NUMBERS,
    LOCKS,
    RECORDS,
    RELEASES,
    SETS,
    SWITCH_NUMBERS,
)
from lienumba.mechanics.elements.events import ENGAGE, LOCK, RELEASE, SET, UNLOCK
from lienumba.mechanics.elements.quantities import bends, kept, signals, turning
from lienumba.mechanics.mechanism.model import INTEGRAL, KEPT, LARGEST, NONE, SMALLEST, Event, Law, Model, Timed
from lienumba.mechanics.system import switches
from lienumba.mechanics.system.switches import switches_of
from lienumba.numerics.expressions import Formula

ACTS = {LOCK.name: LOCKS, UNLOCK.name: RELEASES, RELEASE.name: RELEASES, ENGAGE.name: ENGAGES, SET.name: SETS}


def plan(model: Model, held: Sequence[int]) -> Plan:
    """Of all events, and of what is recorded; held: the rows of a state in which held numbers are."""
    acts, targets, value = [], list[int](), 0
    records, guards = _records(model) if model.measures else ([], [])
    every = signals(model) if model.measures else []
    for event in model.events:
        of = _targets(model, event, held)
        clock, written = held[event.clock] if event.clock >= 0 and not event.stop else -1, "." not in event.name
        action = ACTS.get(event.action, SETS if clock >= 0 else RECORDS)
        needed = _needed(model, event)
        acts.append((action, len(targets), len(of), value, int(event.once), needed, int(written), clock))
        targets += of
        value += len(event.numbers)
    return Plan(
        np.array([event.stop for event in model.events], np.int64),
        np.array(acts, np.int64).reshape(-1, ACT_NUMBERS),
        np.array(targets, np.int64),
        np.array([switch.numbers for switch in switches_of(model)], np.int64).reshape(-1, SWITCH_NUMBERS),
        np.array(records, np.int64).reshape(-1, KEPT_NUMBERS),
        np.array(guards, np.int64),
        np.array([bends(model, x) == () for x in every], np.int64),
    )


def _records(model: Model) -> tuple[list[tuple[int, ...]], list[int]]:
    """What is recorded of runs as a whole, and the guards of all records: the signals at whose zeros the value or the
    condition of a record has kinks or jumps, and the condition itself."""
    found, guards, every, kinks = list[tuple[int, ...]](), list[int](), signals(model), turning(model)
    texts = {_text(event.when): n for n, event in reversed([*enumerate(model.events)])}
    for x in kept(model):
        condition = None if x.condition == NONE else every[x.condition]
        event = NONE if condition is None else texts.get(_text(condition), NONE)
        own = [*kinks.get(x.value, ())] if x.kind in (INTEGRAL, LARGEST, SMALLEST) else []
        own += [] if condition is None else [*kinks.get(x.condition, ()), x.condition]
        found.append((KEPT.index(x.kind), x.value, x.condition, event, len(guards), len(own)))
        guards += own
    return found, guards


def at_events(model: Model) -> tuple[tuple[int, int, int], ...]:
    """Of records of values at events: their numbers, those of the events, and those of the signals."""
    names = [event.name for event in model.events]
    return tuple((n, names.index(x.event), x.value) for n, x in enumerate(kept(model)) if x.event)


def _text(x: Timed) -> str | None:
    """A condition as it is written without needless blanks; None of what is no formula."""
    formula = x.function if isinstance(x, Law) else x
    return formula.plain if isinstance(formula, Formula) else None


def _needed(model: Model, event: Event) -> int:
    """The switch that has to be on for an event to act: of the joint that it locks, if that may be gone; else -1."""
    wanted = (switches.JOINT, event.joint) if event.action == LOCK.name else None
    return next((n for n, switch in enumerate(switches_of(model)) if (switch.what, switch.index) == wanted), -1)


def _targets(model: Model, event: Event, held: Sequence[int]) -> list[int]:
    """The switches that an event turns, or the rows of a state that it sets."""
    if event.action == SET.name:
        return [held[place] for place, _ in event.values]
    wanted = [(switches.LOCK, lock) for lock in event.locks]
    if event.action in (RELEASE.name, ENGAGE.name):
        wanted = [(switches.JOINT, event.joint)]
    if event.action == RELEASE.name:  # with what locks it
        wanted += [(switches.LOCK, n) for n, lock in enumerate(model.locks) if lock.joint == event.joint]
    return [n for n, switch in enumerate(switches_of(model)) if (switch.what, switch.index) in wanted]
