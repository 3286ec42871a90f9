"""Locks of joints of a tree: rates that stand still, where others would be constraints.

A rate that is locked does not leave the elimination: its share is multiplied by 0, and q'' = 0. A ball stands still as
a whole, so that where something else may hold a part of it (a loop, a driver) its lock is rows, of which those that say
something new are used.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from lienumba.mechanics.elements.joints import JOINTS
from lienumba.mechanics.mechanism.model import Lock, Model
from lienumba.mechanics.system.constraints import constraints_of, rows_of
from lienumba.mechanics.system.switches import JOINT, LOCK, is_ball
from lienumba.mechanics.tree.links import Tree
from lienumba.numerics.operations import maximum


@dataclass(frozen=True)
class Locked:
    """What locks make of rates. number: of the constraint; joint: index; rates: what its rows (of C) hold."""

    number: int
    joint: int
    rates: dict[int, tuple[int, ...]]


def locked(model: Model, tree: Tree) -> Iterator[Locked]:
    """The locks that hold rates of the tree."""
    every = list(zip(constraints_of(model), rows_of(model), strict=True))
    tied = {*tree.joints}
    alone = all(n in tied or not c.rows or (c.switch and c.switch.what != JOINT) for n, (c, _) in enumerate(every))
    for number, (c, rows) in enumerate(every):
        if c.switch is not None and c.switch.what == LOCK:
            lock = model.locks[c.switch.index]
            rates = _rates(model, tree, lock, rows.start) if alone or not is_ball(lock) else {}
            if rates:
                yield Locked(number, lock.joint, rates)


def _rates(model: Model, tree: Tree, lock: Lock, first: int) -> dict[int, tuple[int, ...]]:
    """Of each rate the rows of C that hold it; empty if this is not known of every row."""
    links = [link for link in tree.links if link.joint == lock.joint]
    left = {rate for link in links for rate in link.rates}
    found: dict[int, tuple[int, ...]] = {}
    rest: list[int] = []
    for row, name in enumerate(lock.coordinates, first):
        along = [link.first_rate for link in links if link.move.gain(name, link.pitch) is not None]
        if along:
            found[along[0]] = (row,)
            left.discard(along[0])
        else:
            rest.append(row)
    names = {x.name for x in JOINTS[model.joints[lock.joint].type].independent()}
    if rest and set(lock.coordinates) != names:
        return {}
    return found | {rate: tuple(rest) for rate in left if rest}


def free(model: Model, tree: Tree, masks: Mapping[int, Any]) -> dict[int, Any]:
    """0 for every rate that stands still now, or 1, of those that locks may hold. masks: of the rows of C."""
    found: dict[int, Any] = {}
    for lock in locked(model, tree) if masks else ():
        for rate, rows in lock.rates.items():
            held = masks[rows[0]]
            for row in rows[1:]:
                held = maximum(masks[row], held)
            found[rate] = found.get(rate, 1.0) * (1.0 - held)
    return found
