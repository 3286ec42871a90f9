"""Where friction turns faster than explicit steps of given length can follow: beside rest.

They follow it as long as a slip is stopped in more than about half a step. Contacts of bodies that joints or other
contacts connect are looked at together, since none of them comes to rest alone; but two, an edge, do one by one.
"""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, cast

from lienumba.mechanics.mechanism.kinematics import STICK, Instant
from lienumba.mechanics.mechanism.model import GROUND, Model
from lienumba.mechanics.system.switched import laws
from lienumba.mechanics.system.switches import Switch
from lienumba.numerics.number import Number, Vector
from lienumba.numerics.operations import absolute, maximum, minimum, where

UNBENT = 0.05  # of a speed: what it has across
PAIR = 2  # contacts, of an edge or in a groove
WHIRLS = 0.5  # of a step, in which a slip is stopped that explicit methods do not follow


def whirls(
    model: Model, now: Instant, contacts: Sequence[Switch], kept: Mapping[str, Vector], rates: Sequence[Number],
    reactions: Sequence[Number], S: Sequence[Sequence[Number]], step: Number,
) -> dict[str, Any]:  # fmt: skip
    """Of contacts with friction, by their names, above 0 (m/s) where all that slides together may have come to rest:
    friction f takes the power f w from it, which it would bring down by f S f in a unit of time, and nothing is faster
    than all friction could make it there. What slides straight on along the directions that were kept does not turn.
    rates, reactions, S: of all switched rows."""
    found: dict[str, Any] = {}
    for group in _together(model, contacts):
        f, speeds, bent = dict[int, Any](), list[Any](), list[Any]()
        friction, power, stops = (cast(Any, 0.0) for _ in range(3))
        for switch in group:
            tangents, slides = range(switch.first + 1, switch.first + switch.rows), now.modes[switch.key].on > STICK
            w, (along, across) = tuple(rates[i] for i in tangents), kept[switch.name]
            most = model.contacts[switch.index].kinetic * where(slides, maximum(reactions[switch.first], 0.0), 0.0)
            f |= {i: most * n for i, n in zip(tangents, laws.direction(w, (0.0, 0.0)), strict=True)}
            speeds.append(where(slides, laws.length(w), 0.0))
            bent.append(where(slides, absolute(w[0] * across - w[1] * along), 0.0) - UNBENT * speeds[-1])
            friction, power = friction + most, power + most * speeds[-1]
        for i, a in f.items():
            for j, b in f.items():
                stops = stops + a * S[i][j] * b
        slow = (WHIRLS * step * stops - power) / where(friction > 0.0, friction, 1.0)
        for switch, speed in zip(group, speeds, strict=True):
            gives = maximum(*(S[i][i] for i in range(switch.first + 1, switch.first + switch.rows)))
            slow = minimum(slow, WHIRLS * step * (friction * gives) - speed)
        turns = bent[0]
        for other in bent[1:]:
            turns = maximum(turns, other)
        found |= {switch.name: where(turns > 0.0, slow, minimum(slow, 0.0)) for switch in group}
    return found


def _together(model: Model, contacts: Sequence[Switch]) -> Iterator[list[Switch]]:
    """By bodies that something connects, though not the ground."""
    parts: list[set[int]] = []
    for bodies in (*(joint.bodies for joint in model.joints), *(contact.bodies for contact in model.contacts)):
        whole = {*bodies} - {GROUND}
        apart = [part for part in parts if not part & whole]
        parts = [*apart, whole.union(*(part for part in parts if part & whole))]
    for part in parts:
        group = [switch for switch in contacts if part & {*model.contacts[switch.index].bodies}]
        if group and len(group) != PAIR:
            yield group
