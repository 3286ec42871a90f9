"""When switched constraints turn on and off, and what is to be known of them then."""

from collections.abc import Sequence
from typing import Any

from lienumba.mechanics.elements.quantities import evaluate
from lienumba.mechanics.mechanism import kinematics
from lienumba.mechanics.mechanism.kinematics import OFF, STICK, Instant
from lienumba.mechanics.mechanism.massless import with_lent_masses
from lienumba.mechanics.mechanism.model import Limit, Model
from lienumba.mechanics.system import constraints
from lienumba.mechanics.system.switched import laws, scales
from lienumba.mechanics.system.switches import CONTACT, FRICTION, JOINT, LIMIT, LOCK, Switch, switches_of
from lienumba.numerics.number import Number, Vector
from lienumba.numerics.operations import absolute, maximum, minimum, sqrt, where

NEVER = (0.0, 0.0)
NEGLIGIBLE = 1e-12
LEAVES = 1e-6  # of a length: what comes apart overlaps by no more, as the drivers have it
ROUNDING = 1e-9  # of the speeds of bodies
FAINT = 1e-3  # of the speed that friction gives bodies that nothing holds
ENDS = 5e-10  # of the speed that gravity gives within a length: what slides slower may have come to rest
BRAKED = 0.01  # of gravity: what is braked by more ends by itself, if it goes
BEGUN = 1e-4  # of gravity: what grows by more has begun
STRAIGHT = 10.0  # times as much along as across
TURNED = 0.5  # the cotangent of the angle by which sliding turns before its direction is kept anew


def contact_guards(
    model: Model, now: Instant, multipliers: Sequence[Number], accelerations: Sequence[Number], mask: Sequence[Number],
    adaptive: bool,
) -> list[Any]:  # fmt: skip
    """The two guard functions of each switch, true where above 0. The first: a closed contact is pulled, an open one
    overlaps. The second: what sticks carries more than the limit of its friction, or, where others hold it, is moved by
    these (m/s or rad/s); what slides reverses or creeps; an open gap grows (m/s). Gaps are relative to their lengths.
    accelerations: of all bodies (6 k); mask: of all rows of C; adaptive: whether a tolerance, or collocation, resolves
    how friction turns beside rest."""
    first, lengths = constraints.permanent_rows(model), scales.lengths(model, now)
    gaps, rates = constraints.residual(model, now)[first:], constraints.rates(model, now)[first:]
    everything, speeds = (
        kinematics.still(now, tuple(range(len(model.bodies)))),
        constraints.sizes(model, now)[2][first:],
    )
    found: list[Any] = []
    for switch in switches_of(model):
        if switch.what in (JOINT, LOCK):
            found += NEVER
            continue
        mode, own = now.modes[switch.key], slice(switch.first, switch.first + switch.rows)
        reactions = [-mu for mu in multipliers[first:][own]]
        tangents = slice(switch.rows - switch.tangents, switch.rows)
        kept, least = laws.heading(model, switch, everything, mode.memory)
        back = _turned(tuple(rates[own][tangents]), kept, least)
        if switch.tangents > 1:
            rows = range(first + own.start, first + own.stop)[tangents]
            creeps = _creeps(model, now, lengths[switch.first], rates[own][tangents], rows, accelerations)
            if switch.compliant and adaptive:  # what began with what is faster goes on until it turns
                creeps = where(mode.memory[-1] > 0.0, creeps, back)
            back = maximum(back, creeps)
        pushed = laws.length(reactions[tangents]) - _holds(model, switch, now, reactions)
        if switch.what == FRICTION:
            fast = maximum(speeds[switch.first], _alone(model, switch, now, lengths[switch.first]))
            moved = maximum(absolute(rates[switch.first]) - ROUNDING * fast, _strained(model, switch, now))
            pushed = where(mask[first + switch.first] > 0.0, pushed, moved)
        turns = where(mode.on > STICK, back, pushed) if switch.tangents else 0.0
        if switch.what == FRICTION:
            found += [0.0, turns]
        else:
            overlap = -gaps[switch.first] / lengths[switch.first]
            found.append(where(mode.on > OFF, -reactions[0], _overlaps(overlap, rates[switch.first])))
            found.append(where(mode.on > OFF, turns, rates[switch.first]))
    return found


def _overlaps(overlap: Number, rate: Number) -> Any:
    """How far what is open overlaps, in parts of its length; none as long as it comes apart from what it touches, but
    it may close again before it has parted."""
    return where(rate > 0.0, where(overlap < LEAVES, minimum(overlap, 0.0), overlap), overlap)


def friction_speeds(model: Model, now: Instant, multipliers: Sequence[Number]) -> list[Any]:
    """Of each switch how fast (m/s or rad/s) what touches moves along its friction: 0 where friction takes energy,
    above 0 where it gives some, which it never does."""
    first, everything = constraints.permanent_rows(model), kinematics.still(now, tuple(range(len(model.bodies))))
    rates, found = constraints.rates(model, now)[first:], list[Any]()
    for switch in switches_of(model):
        tangents = slice(switch.first + switch.rows - switch.tangents, switch.first + switch.rows)
        if switch.what not in (CONTACT, FRICTION) or not switch.tangents:
            found.append(0.0)
            continue
        mode, w = now.modes[switch.key], rates[tangents]
        force = [-mu for mu in multipliers[first:][tangents]]
        if switch.what == FRICTION:  # that slides is a load
            kept, _ = laws.heading(model, switch, everything, mode.memory)
            effort = _effort(model, switch, now, "coulomb")
            force = [where(mode.on > STICK, -effort * d, f) for d, f in zip(kept, force, strict=True)]
        power: Any = 0.0
        for f, x in zip(force, w, strict=True):
            power = power + f * x
        size = laws.length(force)
        found.append(where(size > 0.0, maximum(power, 0.0) / where(size > 0.0, size, 1.0), 0.0))
    return found


def redundant_speeds(model: Model, now: Instant, mask: Sequence[Number]) -> list[Any]:
    """Of each switch how fast (m/s or rad/s) a row moves that holds, and is not used since others say the same: 0,
    unless these do no longer. mask: of all rows of C."""
    first = constraints.permanent_rows(model)
    rates, speeds = constraints.rates(model, now)[first:], constraints.sizes(model, now)[2][first:]
    found = list[Any]()
    for switch in switches_of(model):
        fastest: Any = 0.0
        on = now.modes[switch.key].on
        for i in range(switch.first, switch.first + switch.rows):
            fast, idle = absolute(rates[i]), where(on > OFF, 1.0 - mask[first + i], 0.0)
            if i >= switch.first + switch.rows - switch.tangents:  # of what sticks
                idle = where(on > STICK, 0.0, idle)
            fastest = maximum(fastest, where(fast > ROUNDING * speeds[i], idle * fast, 0.0))
        found.append(fastest)
    return found


def _turned(sliding: Vector, kept: Vector, slow: Number) -> Any:
    """Above 0 (m/s or rad/s) where what slides has turned by more than 63 degrees from the direction that was kept, or
    slides back; slower than `slow` it has no direction to turn (see `laws.sliding`)."""
    back: Any = 0.0
    for x, d in zip(sliding, kept, strict=True):
        back = back - x * d
    if len(sliding) < 2:
        return back
    (x, y), (along, across) = sliding, kept
    # before a right angle: there friction changes its sign, and may turn the sliding back, so that no step ends behind
    return back + TURNED * laws.own(sliding, slow) * laws.length([x * across - y * along])


def _creeps(
    model: Model, now: Instant, length: Number, sliding: Sequence[Number], rows: Sequence[int], a: Sequence[Number]
) -> Any:
    """Above 0 (m/s) where sliding is slower than `ENDS` times the speed that gravity gives within the length, and does
    neither end nor grow by itself: it has missed 0 by rounding, or by the error of a step, and turns as fast as steps
    are short, even where friction brakes it from every side. Less than what the driver takes for rest."""
    pressing = scales.weight(model, now)
    least, speed = ENDS * sqrt(pressing * length), laws.length(sliding)
    C, (_, biases) = constraints.jacobian(model, now), constraints.rate_and_bias(model, now)
    grows: list[Any] = []
    for row in rows:
        rate: Any = biases[row]
        for (r, column), c in C.items():
            rate = rate + c * a[column] if r == row else rate
        grows.append(rate)
    (x, y), (dx, dy) = sliding, grows
    unit = where(speed > 0.0, speed, 1.0)
    growing, turning = (x * dx + y * dy) / unit, (x * dy - y * dx) / unit
    across = STRAIGHT * absolute(turning)
    ends, begins = minimum(growing + across, 0.0), maximum(growing - across, 0.0)  # 0 where it turns
    alone = where(pressing > 0.0, (begins / BEGUN - ends / BRAKED) / where(pressing > 0.0, pressing, 1.0), 0.0)
    return least * (1.0 - alone) - speed


def _holds(model: Model, switch: Switch, now: Instant, reactions: Sequence[Number]) -> Any:
    """How large the force may be along the tangents of what sticks (N or N m)."""
    if switch.what == FRICTION:
        return _effort(model, switch, now, "static")
    return model.contacts[switch.index].static * reactions[0] if switch.what == CONTACT else 0.0


def _strained(model: Model, switch: Switch, now: Instant) -> Any:
    """By how much what the friction of a joint bears as a load is more than it holds; below 0 where it bears none."""
    load = absolute(now.modes[switch.key].memory[0])
    return where(load > 0.0, load - _effort(model, switch, now, "static"), -1.0)


def _effort(model: Model, switch: Switch, now: Instant, name: str) -> Any:
    """The effort of the friction of a joint (N or N m)."""
    everything = kinematics.still(now, tuple(range(len(model.bodies))))
    return evaluate(model, model.forces[switch.index].numbers[name], everything)


def _alone(model: Model, switch: Switch, now: Instant, length: Number) -> Any:
    """A speed (m/s or rad/s) with which those of a joint with friction compare at least: what nothing can move has no
    other. length: of its row."""
    return FAINT * sqrt(absolute(_effort(model, switch, now, "static")) * alone(model, now)[switch.first] * length)


def numbers(model: Model, now: Instant, rates: Sequence[Number], accelerations: Sequence[Number]) -> list[Any]:
    """Of each switch: restitution, static and kinetic coefficient, the speed (m/s or rad/s) below which nothing comes
    back, static and kinetic effort (N or N m), and its length and speed (see `scales`). rates, accelerations: of all
    rows that are switched."""
    found: list[Any] = []
    accelerations = scales.lasting(model, now, accelerations)
    lengths, speeds = scales.lengths(model, now), scales.speeds(model, now, rates, accelerations)
    for switch, speed in zip(switches_of(model), speeds, strict=True):
        own: tuple[Any, ...] = (0.0,) * 6
        if switch.unilateral:
            stop = model.limits[switch.index] if switch.what == LIMIT else model.contacts[switch.index]
            least = stop.rest_speed
            if least is None:
                least = scales.rest(model, now, switch, accelerations[switch.first])
            friction = (0.0, 0.0) if isinstance(stop, Limit) else (stop.static, stop.kinetic)
            own = (stop.restitution, *friction, least, 0.0, 0.0)
        elif switch.what == FRICTION:
            own = (0.0,) * 4 + tuple(_effort(model, switch, now, name) for name in ("static", "coulomb"))
            speed = maximum(speed, _alone(model, switch, now, lengths[switch.first]))
        found += (*own, lengths[switch.first], speed)
    return found


def memory(model: Model, now: Instant, rates: Sequence[Number]) -> list[Any]:
    """What all switches would keep if they were turned on now. rates: of all rows that are switched."""
    everything = kinematics.still(now, tuple(range(len(model.bodies))))
    found: list[Any] = []
    for switch in switches_of(model):
        own: Vector = tuple(rates[switch.first : switch.first + switch.rows])
        found += laws.keeps(model, switch, everything, own)
    return found


def alone(model: Model, now: Instant) -> list[Any]:
    """The diagonal of S as it would be for the bodies without their permanent constraints."""
    first, bodies = constraints.permanent_rows(model), with_lent_masses(model).bodies
    found: list[Any] = [0.0] * sum(switch.rows for switch in switches_of(model))
    for (row, column), x in constraints.jacobian(model, now).items():
        if row >= first:
            body = bodies[column // 6]
            mass = body.mass if column % 6 < 3 else (body.inertia[0] + body.inertia[1] + body.inertia[2]) / 3.0
            found[row - first] = found[row - first] + x * x / mass
    return found


def triangle(S: Sequence[Sequence[Number]], alone: Sequence[Number]) -> list[Any]:
    """The lower triangle of S, row by row; 0 in rows that say nothing beyond the permanent ones but for rounding: where
    the diagonal is negligible beside what it would be without these."""
    says = [where(S[i][i] > NEGLIGIBLE * scale, 1.0, 0.0) for i, scale in enumerate(alone)]
    return [says[i] * S[i][j] * says[j] for i in range(len(S)) for j in range(i + 1)]
