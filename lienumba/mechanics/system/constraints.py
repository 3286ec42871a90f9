"""The flat system's constraints: Phi and psi, their rates, the Jacobian C and the bias, all derived from the laws.

Rows come joint by joint, then driver by driver, and behind these permanent ones switch by switch
(`lienumba.mechanics.system.switches`). A constraint holds on one of three levels: "position" (Phi = 0),
"rate" (Phi exists only up to a constant: its rate is prescribed) or "velocity" (psi(q, v, t) = 0, affine in v).
C v' = xi = -bias;  C v = -Phi_t, or -psi(q, 0, t).
"""

from collections.abc import Sequence
from functools import partial, reduce
from typing import Any, NamedTuple

from lienumba.groups import so3
from lienumba.mechanics.elements import drivers, user_laws
from lienumba.mechanics.elements.joints import JOINTS
from lienumba.mechanics.elements.quantities import bodies_of, evaluate
from lienumba.mechanics.mechanism import kinematics
from lienumba.mechanics.mechanism.kinematics import OFF, STICK, Instant, Law, Mode, View
from lienumba.mechanics.mechanism.massless import with_lent_masses
from lienumba.mechanics.mechanism.model import GROUND, Body, Driver, Joint, Model, once_per_model
from lienumba.mechanics.system.body_axes import GLOBAL, Axes
from lienumba.mechanics.system.switched import laws
from lienumba.mechanics.system.switched.border import FrictionCoupling
from lienumba.mechanics.system.switches import CONTACT, FRICTION, JOINT, LIMIT, LOCK, RIGID, Switch, switches_of
from lienumba.numerics.jets import lift
from lienumba.numerics.number import Matrix, Number, Vector
from lienumba.numerics.operations import absolute, is_zero, maximum, sqrt, where


class Constraint(NamedTuple):
    """kinds: one letter for each row, "m" for a length, "r" for an angle (m/s and rad/s below position level); own:
    whether its law is of the user's own; ties: whether it could do without the other constraints of its bodies;
    indifferent: whether its law knows only how its bodies lie to each other; vector: how many of its first rows are
    components of a vector, those behind depend on no axes; switch: that turns it on and off; tangents: whether it holds
    only where nothing slides."""

    name: str
    bodies: tuple[int, ...]
    kinds: str
    level: str
    law: Law
    own: bool = False
    ties: bool = True
    indifferent: bool = False
    vector: int = 0
    switch: Switch | None = None
    tangents: bool = False

    @property
    def rows(self) -> int:
        return len(self.kinds)


def constraints_of(model: Model) -> list[Constraint]:
    """All constraints in the order of their rows."""
    found = [_joint(model, n) if j.active and not j.switched else _open(j) for n, j in enumerate(model.joints)]
    found += [_driver(model, driver) for driver in model.drivers]
    switches = switches_of(model)
    for switch in switches:
        if switch.what == JOINT:
            found.append(_joint(model, switch.index)._replace(indifferent=False, vector=0, switch=switch))
    for x in laws.laws(model) if switches else ():
        found.append(
            Constraint(
                x.switch.name, x.bodies, x.kinds, x.level, x.law, indifferent=x.level == "position", switch=x.switch,
                tangents=x.tangents,
            )
        )  # fmt: skip
    return found


def _joint(model: Model, index: int) -> Constraint:
    joint = model.joints[index]
    if joint.code is not None:
        ends = tuple(dict.fromkeys((*user_laws.ends_of(model, joint.code, joint.bodies, joint.numbers), *joint.bodies)))
        law = partial(user_laws.residual, model, index)
        return Constraint(joint.name, ends, joint.code.returns, joint.code.level, law, own=True)
    kind = JOINTS[joint.type]
    return Constraint(
        joint.name, joint.bodies, kind.kinds(joint), "position", partial(kind.equations, model, index),
        indifferent=True, vector=kind.vector,
    )  # fmt: skip


def _open(joint: Joint) -> Constraint:
    """Of a joint that holds nothing, or whose rows are those of a switch."""
    return Constraint(joint.name, joint.bodies, "", "position", lambda view: ())


def _driver(model: Model, driver: Driver) -> Constraint:
    """With what it prescribes as a function of other bodies, it is a constraint of these, too."""
    kind = drivers.type_of(driver)
    ends = kind.acts_on(model, driver, bodies_of(model, *driver.value))

    def law(view: View) -> Vector:
        return kind.residual(model, driver, tuple(evaluate(model, x, view) for x in driver.value), view)

    return Constraint(driver.name, ends, kind.kinds(driver), kind.level(driver), law, ties=kind.ties)


def permanent_rows(model: Model) -> int:
    """How many rows are always there; those of switched constraints stand behind them."""
    return sum(c.rows for c in constraints_of(model)) - sum(switch.rows for switch in switches_of(model))


@once_per_model
def rows_of(model: Model) -> tuple[slice, ...]:
    """Which rows belong to each constraint."""
    slices: list[slice] = []
    first = 0
    for constraint in constraints_of(model):
        slices.append(slice(first, first + constraint.rows))
        first = slices[-1].stop
    return tuple(slices)


def residual(model: Model, now: Instant, axes: Axes = GLOBAL) -> list[Any]:
    """Phi (m, or 1 for angles), every row; 0 where there is none (Terze et al. 2015, eqs. 10c, 25, 36, B.1)."""
    rows: list[Any] = []
    for n, c in enumerate(constraints_of(model)):
        found = c.law(kinematics.still(now, c.bodies)) if c.level == "position" else (0.0,) * c.rows
        rows += axes.turned(n, now, found, c.vector)
    return rows


def globally(model: Model, now: Instant, mu: Sequence[Number], axes: Axes) -> list[Any]:
    """Multipliers of every row, which are in these axes, in global ones."""
    rows: list[Any] = []
    for n, (c, own) in enumerate(zip(constraints_of(model), rows_of(model), strict=True)):
        rows += axes.turned_back(n, now, mu[own], c.vector)
    return rows


def rates(model: Model, now: Instant, axes: Axes = GLOBAL) -> list[Any]:
    """The rate C v + Phi_t or psi of every row (m/s or rad/s)."""
    rows: list[Any] = []
    for n, c in enumerate(constraints_of(model)):
        found = map(lift, c.law(kinematics.moving(kinematics.still(now, c.bodies))))
        rows += axes.turned(n, now, [x.a if c.level == "velocity" else x.b for x in found], c.vector)
    return rows


def rate_and_bias(model: Model, now: Instant, axes: Axes = GLOBAL) -> tuple[list[Any], list[Any]]:
    """The rate C v + Phi_t or psi of every row (m/s or rad/s), and its derivative at constant velocities, the bias
    (Terze et al. 2015, eqs. 11, 26, 37, B.2)."""
    rates: list[Any] = []
    biases: list[Any] = []
    for n, c in enumerate(constraints_of(model)):
        for row in map(lift, c.law(kinematics.moving(axes.view(n, now, c.bodies)))):
            rates.append(row.a if c.level == "velocity" else row.b)
            biases.append(row.b if c.level == "velocity" else row.c)
    return rates, biases


def required(model: Model, now: Instant, damping: float | None = None, axes: Axes = GLOBAL) -> list[Any]:
    """xi of every row: what C v' has to be (Terze et al. 2015, eqs. 12, 27, 35, 41, B.6). With damping (1/s) violations
    decay at this rate, critically damped (Baumgarte 1972): xi - 2 damping Phi' - damping^2 Phi, or xi - damping psi
    where there is no Phi."""
    rates, biases = rate_and_bias(model, now, axes)
    if damping is None:
        return [-x for x in biases]
    xi: list[Any] = []
    violations = residual(model, now, axes)
    for c, rows in zip(constraints_of(model), rows_of(model), strict=True):
        factor = 2.0 * damping if c.level == "position" else damping
        for row in range(rows.start, rows.stop):
            xi.append(-biases[row] - factor * rates[row] - damping * damping * violations[row])
    return xi


def time_rate(model: Model, now: Instant) -> list[Any]:
    """Phi_t or psi(q, 0, t) of every row: what the prescription moves by itself."""
    rates: list[Any] = []
    for c in constraints_of(model):
        for row in map(lift, c.law(kinematics.waiting(now, c.bodies))):
            rates.append(row.a if c.level == "velocity" else row.b)
    return rates


def derivative(model: Model, now: Instant, drifts: Sequence[Matrix]) -> list[Any]:
    """Of Phi, along a matrix for the R of every body; 0 where there is no position."""
    rows: list[Any] = []
    for c in constraints_of(model):
        view = kinematics.drifting(now, c.bodies, drifts)
        rows += [lift(row).b for row in c.law(view)] if c.level == "position" else [0.0] * c.rows
    return rows


def jacobian(model: Model, now: Instant, axes: Axes = GLOBAL) -> dict[tuple[int, int], Any]:
    """The entries of C that are not exactly zero, by (row, column); body i owns columns 6 i to 6 i + 5 (Terze et al.
    2015, eqs. 28, 34, 40, B.5)."""
    entries: dict[tuple[int, int], Any] = {}
    first = 0
    for n, c in enumerate(constraints_of(model)):
        for i in c.bodies:
            for row, values in enumerate([] if i == GROUND else block(c, n, now, i, axes)):
                entries |= {(first + row, 6 * i + m): x for m, x in enumerate(values) if not is_zero(x)}
        first += c.rows
    return entries


def block(c: Constraint, number: int, now: Instant, body: int, axes: Axes = GLOBAL) -> list[list[Any]]:
    """Of one constraint and one of its bodies in C: rows x 6."""
    view, along = axes.view(number, now, c.bodies), axes.directions(number, now, body)
    return kinematics.columns(c.law, view, body, c.level == "velocity", along)


def in_use(model: Model, now: Instant) -> list[Any]:
    """1 for every row that holds now, or 0: those of switched constraints that are off, and what slides."""
    found: list[Any] = []
    for c in constraints_of(model):
        if c.switch is None:
            found += [1.0] * c.rows
            continue
        mode = now.modes.get(c.switch.key, Mode(OFF, (0.0,)))
        slides = where(mode.on > STICK, 0.0, 1.0) if c.tangents else 1.0
        if c.switch.what == FRICTION:
            slides = where(absolute(mode.memory[0]) > 0.0, 0.0, slides)  # a load
        found += [where(mode.on > OFF, slides, 0.0)] * c.rows
    return found


def friction_coupling(model: Model, now: Instant) -> FrictionCoupling | None:
    """Of contacts how the forces along their tangents follow, where they slide, from those along their normals, and
    where they stick, from what they share with others; None where there is no friction of contacts."""
    found: dict[tuple[int, int], Any] = {}
    compliance: dict[tuple[int, int], Any] = {}
    for c, rows in zip(constraints_of(model), rows_of(model), strict=True):
        if c.tangents and c.switch is not None and c.switch.what == CONTACT:
            mode, still = (
                now.modes.get(c.switch.key, Mode(OFF, (0.0, 0.0, 1.0, *RIGID))),
                kinematics.still(now, c.bodies),
            )
            kinetic = model.contacts[c.switch.index].kinetic
            slides, (kept, slow) = mode.on > STICK, laws.heading(model, c.switch, still, mode.memory)
            # what does not slide has no direction: rates next to 0 would have none in which they go on, as a series
            moving = tuple(where(slides, lift(x).a, d) for x, d in zip(c.law(still), kept, strict=True))
            held: Vector = (0.0, 0.0)
            if c.switch.compliant:
                held, V = laws.compliance(model, c.switch, still, mode.memory)
                compliance |= {(rows.start + a, rows.start + b): V[a][b] for a in range(2) for b in range(2)}
            for n, (d, own) in enumerate(zip(laws.sliding(moving, kept, slow), held, strict=True)):
                found[rows.start + n, rows.start - 1] = where(slides, -(kinetic * d), own)
    return FrictionCoupling(found, compliance, in_use(model, now)) if found else None


def sliding_power(model: Model, now: Instant, multipliers: Sequence[Number]) -> Any:
    """What contacts that slide do (W)."""
    total: Any = 0.0
    for c, rows in zip(constraints_of(model), rows_of(model), strict=True):
        if c.tangents and c.switch is not None and c.switch.what == CONTACT:
            moving = (lift(x).a for x in c.law(kinematics.still(now, c.bodies)))
            for mu, rate in zip(multipliers[rows], moving, strict=True):
                total = total - mu * rate
    return total


def loads(model: Model, now: Instant, multipliers: Sequence[Number]) -> tuple[list[Any], list[Any]]:
    """Force (N) and torque (N m) of every joint, with its locks and stops, on its last body at its point there, global
    frame, 3 each.

    A joint without points acts at the mass centre.
    """
    forces: list[Any] = []
    torques: list[Any] = []
    every, rows = constraints_of(model), rows_of(model)
    for n, joint in enumerate(model.joints):
        parts = [m for m, c in enumerate(every) if c.switch is not None and _joint_of(model, c.switch) == n]
        own = [n, *(m for m in parts if every[m].level == "position")]
        body = (joint.bodies or every[n].bodies)[-1]
        load: list[Any] = [0.0] * 6
        view = kinematics.still(now, every[n].bodies)
        for m in own:
            c = every[m]
            columns = kinematics.columns(c.law, kinematics.still(now, c.bodies), body, c.level == "velocity")
            for row, mu in zip(columns, multipliers[rows[m]], strict=True):
                load = [total - x * mu for total, x in zip(load, row, strict=True)]
        place = view[body]
        force = (load[0], load[1], load[2])
        torque = so3.rotate(place.R, (load[3], load[4], load[5]))
        if joint.points is not None:
            torque = so3.subtract(torque, so3.cross(so3.rotate(place.R, joint.points[1]), force))
        forces += force
        torques += torque
    return forces, torques


def _joint_of(model: Model, switch: Switch) -> int | None:
    """The joint (index) that a switched constraint is, or on whose coordinate it acts; of a contact None."""
    if switch.what == JOINT:
        return switch.index
    if switch.what == LOCK:
        return model.locks[switch.index].joint
    which = model.limits[switch.index].coordinate if switch.what == LIMIT else None
    which = model.forces[switch.index].coordinate if switch.what == FRICTION else which
    return None if which is None else which.joint


def sizes(model: Model, now: Instant) -> tuple[list[Any], list[Any], list[Any]]:
    """For every row: the size of its joint (m), of its bodies' positions (m), and of its points' speeds (m/s); for
    angles 1, 0, and the bodies' angular velocities. What a violation compares with, whatever else is in the model."""
    reach: list[Any] = []
    far: list[Any] = []
    speed: list[Any] = []
    lent = with_lent_masses(model)
    own: list[Any] = [(j.points or (), JOINTS[j.type].reach(j)) for j in model.joints]
    own += [((d.point,), []) for d in model.drivers]
    switched = [c for c in constraints_of(model) if c.switch is not None]
    own += [_arms(model, c.switch) for c in switched if c.switch is not None]
    for c, (arms, lengths) in zip(constraints_of(model), own, strict=True):
        arm = largest([x for p in arms if p is not None for x in p])
        if c.own:  # nobody says what it reaches
            arm = largest([size_of(lent.bodies[i]) for i in c.bodies if i != GROUND])
        motions = [now.motion(i) for i in c.bodies if i != GROUND]
        position = largest([x for m in motions for x in m.r])
        turning = largest([x for m in motions for x in m.w])
        moving = largest([x for m in motions for x in m.v])
        for kind in c.kinds:
            angular = kind == "r"
            reach.append(1.0 if angular else reduce(lambda a, b: maximum(b, a), lengths, arm))
            far.append(0.0 if angular else position)
            speed.append(turning if angular else maximum(moving, arm * turning))
    return reach, far, speed


def _arms(model: Model, switch: Switch) -> tuple[Sequence[Any], list[Any]]:
    """The points of a switched constraint, and its lengths."""
    index = _joint_of(model, switch)
    if index is None:
        contact = model.contacts[switch.index]
        return contact.points, [*contact.numbers.values()]
    joint = model.joints[index]
    return joint.points or (), JOINTS[joint.type].reach(joint)


def size_of(body: Body) -> Any:
    """As long (m) as a slender bar of the same mass and inertia."""
    xx, yy, zz, *_ = body.inertia
    return sqrt(6.0 * (xx + yy + zz) / body.mass)


def largest(rows: Sequence[Number]) -> Any:
    """The largest absolute value of finite rows; 0 of none."""
    worst: Any = absolute(rows[0]) if rows else 0.0
    for row in rows[1:]:
        worst = maximum(worst, absolute(row))
    return worst
