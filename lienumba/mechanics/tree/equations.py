"""The equations of motion and the projections of a mechanism by the freedoms of its joints.

What acts, and the constraints that close loops, are those of the bodies in the ground's axes
(`lienumba.mechanics.system`), turned to the links; joints of the tree have no equations. Weight is the acceleration of
the ground the other way.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from lienumba.groups import so3
from lienumba.mechanics.mechanism.kinematics import Instant
from lienumba.mechanics.mechanism.massless import with_lent_masses
from lienumba.mechanics.mechanism.model import Body
from lienumba.mechanics.system import constraints, dynamics, kkt
from lienumba.mechanics.system.switched.border import FrictionCoupling
from lienumba.mechanics.tolerances import LEAST_PIVOT
from lienumba.mechanics.tree import acting
from lienumba.mechanics.tree.articulated import Loads, Reduction, carried, gathered
from lienumba.mechanics.tree.inertia import Six, times
from lienumba.mechanics.tree.motion import centre
from lienumba.mechanics.tree.posture import Posture
from lienumba.numerics.number import Number
from lienumba.numerics.operations import is_zero, where

NOTHING: Six = (0.0,) * 6


@dataclass(frozen=True)
class Solution:
    """rates: q'' of the tree, or a correction along them; mu: of every row of C, 0 for the joints of the tree; links:
    the acceleration of every link that goes with them; nonsingular, row_weights, margin: see `kkt.Solution`."""

    rates: list[Any]
    mu: list[Any]
    links: list[Six]
    nonsingular: Any
    row_weights: list[Any]
    margin: Any

    @property
    def x(self) -> list[Any]:
        return self.rates


def accelerations(
    posture: Posture,
    structure: kkt.Structure,
    mask: Sequence[Number],
    expected: Sequence[Number] | None = None,
    baumgarte: float | None = None,
) -> Solution:
    """q'' of the tree and the multipliers of what closes loops. structure: `kkt.Structure.closing`; expected: q'' as
    it is where the constraints lose their rank."""
    tree = posture.tree
    coupling = constraints.friction_coupling(posture.model, posture.now)
    loads, rows, xi = _acting(posture, structure, structure.weights(mask, coupling), baumgarte)
    if not structure.looped:
        return _solved(posture, structure, loads, xi, mask, coupling)
    rates = [posture.free.get(n, 1.0) * x for n, x in enumerate(expected or [0.0] * tree.freedoms)]
    there = carried(tree, posture.links, loads, rates)
    xi = _less(xi, rows, there)
    solution = _solved(posture, structure, _relative_to(loads, there, rates, xi), xi, mask, coupling)
    rates = kkt.corrected(structure, rates, solution.rates, solution.margin)
    return Solution(
        rates,
        solution.mu,
        carried(tree, posture.links, loads, rates),
        solution.nonsingular,
        solution.row_weights,
        solution.margin,
    )


def _acting(
    posture: Posture, structure: kkt.Structure, mask: Sequence[Number], baumgarte: float | None
) -> tuple[Loads, Mapping[int, Mapping[int, Six]], list[Any]]:
    """What acts on the links, the rows that close loops by link, and what these demand."""
    model, tree = posture.model, posture.tree
    g = dynamics.gravity(model, posture.t)
    ground = (*so3.scale(-1.0, g), 0.0, 0.0, 0.0)
    C: kkt.Entries = {}
    xi: list[Any] = [0.0] * structure.rows
    if structure.order:
        C = acting.in_use(constraints.jacobian(model, posture.now), mask, structure)
        xi = constraints.required(model, posture.now, baumgarte)
    apart, resisting = acting.rotors_apart(posture, structure.rows)
    C = C | apart
    rows = acting.by_link(posture, C)
    xi = acting.without_centrifugal(posture, C, rows, [*xi, *resisting.values()], g)
    along = {force.name: found for force in model.forces if (found := acting.along(posture, force)) is not None}
    armatures = [link.armature for link in tree.links for _ in link.rates]
    loads = Loads(
        [acting.rigid(tree, link, model.bodies) for link in tree.links], acting.wrenches(posture, set(along)),
        acting.efforts(along.values()), armatures, biases=[link.bias for link in posture.links], ground=ground,
        rows=rows, resisting={row: xi[row] for row in resisting},
    )  # fmt: skip
    return loads, rows, xi


def is_regular(posture: Posture, structure: kkt.Structure) -> bool:
    """Whether no constraint may lose its rank, and no rotor stands apart."""
    apart = acting.rotors_apart(posture, structure.rows)[1]
    return not (structure.looped or structure.from_singular or apart)


def missing(
    posture: Posture, structure: kkt.Structure, mask: Sequence[Number], rates: Sequence[Number], mu: Sequence[Number],
    baumgarte: float | None, glued: bool = False,
) -> list[Any]:  # fmt: skip
    """What is missing along every rate, and of every row in use, where the rates change so, with these multipliers of
    the rows in use, of what slides those of normals alone; glued: of what sticks as of any other row, and what slides
    has no friction. A rate that is locked lacks what it changes by."""
    coupling = None if glued else constraints.friction_coupling(posture.model, posture.now)
    loads, rows, xi = _acting(posture, structure, structure.weights(mask, coupling), baumgarte)
    there = carried(posture.tree, posture.links, loads, rates)
    rest = _relative_to(loads, there, rates, xi)
    wrenches = list(rest.wrenches)
    every: list[Any] = [0.0] * structure.rows
    for row, multiplier in zip(structure.order, mu, strict=True):
        every[row] = multiplier
    every = _reactions(posture, structure, loads, mask, coupling, every)
    for row in structure.order:
        for place, y in rows.get(row, {}).items():
            wrenches[place] = tuple(f - every[row] * c for f, c in zip(wrenches[place], y, strict=True))
    wanted = _less(xi, rows, there)
    for row in loads.resisting:
        for place, y in rows[row].items():
            wrenches[place] = tuple(f + wanted[row] * c for f, c in zip(wrenches[place], y, strict=True))
    along = list(gathered(posture.tree, posture.links, replace(rest, wrenches=wrenches)))
    for rate, free in posture.free.items():
        along[rate] = free * along[rate] - (1.0 - free) * rates[rate]
    return [*along, *(mask[row] * wanted[row] for row in structure.order)]


def reactions(
    posture: Posture, structure: kkt.Structure, mask: Sequence[Number], multipliers: Sequence[Number]
) -> list[Any]:
    """As `dynamics.reactions`."""
    coupling = constraints.friction_coupling(posture.model, posture.now)
    loads = _acting(posture, structure, structure.weights(mask, coupling), None)[0]
    return _reactions(posture, structure, loads, mask, coupling, multipliers)


def _reactions(
    posture: Posture, structure: kkt.Structure, loads: Loads, mask: Sequence[Number], coupling: FrictionCoupling | None,
    multipliers: Sequence[Number],
) -> list[Any]:  # fmt: skip
    if coupling is None:
        return [*multipliers]
    reduction = Reduction(posture.tree, posture.links, loads, posture.waiting, posture.free)
    eliminated = _closing(posture, structure, reduction, [0.0] * structure.rows, mask, coupling)[0]
    return eliminated.reactions(mask, multipliers)


def changed(posture: Posture, structure: kkt.Structure, mask: Sequence[Number], missing: Sequence[Number]) -> list[Any]:
    """By how much more its rates change, and by how much its multipliers, with what was missing."""
    tree, model = posture.tree, posture.model
    C = acting.in_use(constraints.jacobian(model, posture.now), mask, structure) if structure.order else {}
    loads = Loads(
        [acting.rigid(tree, link, model.bodies) for link in tree.links], [NOTHING] * len(tree.links),
        dict(enumerate(missing[: tree.freedoms])), [link.armature for link in tree.links for _ in link.rates],
        rows=acting.by_link(posture, C),
    )  # fmt: skip
    g: list[Any] = [0.0] * structure.rows
    for row, x in zip(structure.order, missing[tree.freedoms :], strict=True):
        g[row] = x
    solution = _solved(posture, structure, loads, g, mask)
    return [*solution.rates, *(solution.mu[row] for row in structure.order)]


def closure(
    posture: Posture, structure: kkt.Structure, mask: Sequence[Number], x: Sequence[Number], before: Instant
) -> Solution:
    """The next total correction x along the rates of what closes over a gap, of the bodies' moves from `before`, least
    by their masses:  J^T M d + C^T mu = 0,  Phi = 0."""
    lent, bodies = with_lent_masses(posture.model).bodies, posture.model.bodies
    moves: list[Any] = []
    for now, then in zip(posture.now.bodies, before.bodies, strict=True):
        moves += so3.subtract(then[0:3], now[0:3])
        moves += so3.log(so3.multiply(so3.transpose(now[3:12]), then[3:12]))
    missing = acting.of_bodies(posture, _weighed(bodies, moves))
    loads = replace(_metric(posture, structure, mask, lent, False), wrenches=missing)
    g = [-m * phi for m, phi in zip(mask, constraints.residual(posture.model, posture.now), strict=True)]
    solution = _solved(posture, structure, loads, g, mask, bodies=lent)
    return replace(solution, rates=[a + b for a, b in zip(x, solution.rates, strict=True)])


def _weighed(bodies: Sequence[Body], x: Sequence[Number]) -> list[Any]:
    """M x, of all bodies (6 k)."""
    return kkt.rest(dynamics.body_masses(bodies), {}, [0.0] * len(x), [], [-c for c in x], [])[0]


def position_correction(
    posture: Posture, structure: kkt.Structure, mask: Sequence[Number], x: Sequence[Number]
) -> Solution:
    """The next total correction along the rates, as `projection.position_correction` has it for bodies: with the
    metric |r - r^|^2 + |R - R^|^2 at `posture`, which is q^ moved by x."""
    tree = posture.tree
    bodies = tuple(Body(body.name, 1.0, (2.0, 2.0, 2.0, 0.0, 0.0, 0.0)) for body in posture.model.bodies)
    loads = _metric(posture, structure, mask, bodies, False)
    g = [-phi for phi in constraints.residual(posture.model, posture.now)]
    moved = carried(tree, posture.links, Loads(loads.inertia, loads.wrenches), x)
    g = _less(g, loads.rows, [tuple(-c for c in a) for a in moved])
    return _solved(posture, structure, loads, [m * c for m, c in zip(mask, g, strict=True)], mask, bodies=bodies)


def velocity_correction(
    posture: Posture, structure: kkt.Structure, mask: Sequence[Number], weights: Sequence[Body], armatures: bool
) -> Solution:
    """The smallest change of all rates with which C v = -Phi_t. weights: what the bodies weigh in its metric;
    armatures: whether these count, too."""
    g = [-rate for rate in constraints.rate_and_bias(posture.model, posture.now)[0]]
    loads = _metric(posture, structure, mask, weights, armatures)
    wanted = [m * c for m, c in zip(mask, g, strict=True)]
    return _solved(posture, structure, loads, wanted, mask, bodies=() if armatures else weights)


def tangential(posture: Posture, structure: kkt.Structure, mask: Sequence[Number], x: Sequence[Number]) -> list[Any]:
    """As `projection.tangential`, of rates."""
    loads = _metric(posture, structure, mask, posture.model.bodies, True)
    less, none = [-c for c in x], [0.0] * structure.rows
    there = carried(posture.tree, posture.links, loads, less)
    return _solved(posture, structure, _relative_to(loads, there, less, none), none, mask).rates


def _metric(
    posture: Posture, structure: kkt.Structure, mask: Sequence[Number], weights: Sequence[Body], armatures: bool
) -> Loads:
    """No load, on bodies of these weights."""
    tree = posture.tree
    C = acting.in_use(constraints.jacobian(posture.model, posture.now), mask, structure)
    own = [link.armature if armatures else 0.0 for link in tree.links for _ in link.rates]
    inertia = [acting.rigid(tree, link, weights) for link in tree.links]
    apart, resisting = acting.rotors_apart(posture, structure.rows) if armatures else ({}, {})
    rows = acting.by_link(posture, C | apart)
    still = dict.fromkeys(resisting, 0.0)
    return Loads(inertia, [NOTHING] * len(tree.links), armatures=own, rows=rows, resisting=still)


def constraint_matrix(
    posture: Posture, structure: kkt.Structure, mask: Sequence[Number], weights: Sequence[Body]
) -> dict[tuple[int, int], Any]:
    """-C A^-1 C^T of the constraints that close loops, its lower triangle by rows."""
    loads = _metric(posture, structure, mask, weights, False)
    reduction = Reduction(posture.tree, posture.links, loads, free=posture.free)
    return {(i - reduction.n, j - reduction.n): x for (i, j), x in reduction.matrix.items()}


def _solved(
    posture: Posture, structure: kkt.Structure, loads: Loads, g: Sequence[Number], mask: Sequence[Number],
    coupling: FrictionCoupling | None = None, bodies: Sequence[Body] = (),
) -> Solution:  # fmt: skip
    """bodies: as they weigh in the loads, if these are not the model's with its rotors."""
    reduction = Reduction(posture.tree, posture.links, loads, posture.waiting, posture.free)
    rows = structure.rows
    if not structure.order:
        rates, links = reduction.solution({})
        return Solution(rates, [0.0] * rows, links, 1.0, [1.0] * rows, 1.0)
    eliminated, wanted, pulled = _closing(posture, structure, reduction, g, mask, coupling, bodies)
    solved = eliminated.solve([], wanted, pulled)
    used = set(structure.order)
    mu = [solved.mu[row] if row in used else 0.0 for row in range(rows)]
    rates, links = reduction.solution({row: mu[row] for row in used})
    if structure.from_singular:
        rates = [where(solved.margin > LEAST_PIVOT, x, 0.0) for x in rates]
    return Solution(rates, mu, links, solved.nonsingular, solved.row_weights, solved.margin)


def _closing(
    posture: Posture, structure: kkt.Structure, reduction: Reduction, g: Sequence[Number], mask: Sequence[Number],
    coupling: FrictionCoupling | None, bodies: Sequence[Body] = (),
) -> tuple[kkt.Eliminated, list[Any], list[Any]]:  # fmt: skip
    """The elimination of what closes loops, and what is wanted and pulled along its rows."""
    n, rows = reduction.n, structure.rows
    matrix = {(i - n, j - n): x for (i, j), x in reduction.matrix.items()}
    scales = None
    if structure.looped:
        lent = with_lent_masses(posture.model)
        masses = dynamics.body_masses(bodies) if bodies else dynamics.mass_matrix(lent, posture.now)
        C = acting.in_use(constraints.jacobian(posture.model, posture.now), mask, structure)
        scales = kkt.scales(structure, masses, C, len(posture.model.bodies))
    eliminated = kkt.Eliminated.of(structure, matrix, {}, mask, coupling, scales)
    pulled = [reduction.right.get(n + row, 0.0) for row in range(rows)]
    used, weights = set(structure.order), structure.weights(mask, coupling)
    wanted = [m * x if row in used else 0.0 for row, (m, x) in enumerate(zip(weights, g[:rows], strict=True))]
    return eliminated, wanted, pulled


def border(
    posture: Posture, structure: kkt.Structure, mask: Sequence[Number], expected: Sequence[Number] | None,
    baumgarte: float | None,
) -> tuple[list[list[Any]], list[Any]]:  # fmt: skip
    """As `dynamics.border`."""
    tree, structure, posture = posture.tree, structure.bordered(), replace(posture, locks={})
    mask = dynamics.unswitched(structure, mask)
    loads, rows, xi = _acting(posture, structure, structure.weights(mask, FrictionCoupling()), baumgarte)
    if structure.looped:
        rates = list(expected or [0.0] * tree.freedoms)
        there = carried(tree, posture.links, loads, rates)
        xi = _less(xi, rows, there)
        loads = _relative_to(loads, there, rates, xi)
    reduction = Reduction(tree, posture.links, loads, posture.waiting)
    eliminated, wanted, pulled = _closing(posture, structure, reduction, xi, mask, FrictionCoupling())
    assert eliminated.border is not None
    return eliminated.border.S, eliminated.missing([], wanted, pulled)


def kicked(posture: Posture, structure: kkt.Structure, mask: Sequence[Number], impulses: Sequence[Number]) -> Solution:
    """As `dynamics.kicked`, of the rates."""
    posture = replace(posture, locks={})
    mask = dynamics.unswitched(structure, mask)
    C = constraints.jacobian(posture.model, posture.now)
    loads = _metric(posture, structure, mask, posture.model.bodies, True)
    wrenches, own = list(loads.wrenches), {key: x for key, x in C.items() if key[0] >= structure.switched}
    for row, by_link in acting.by_link(posture, own).items():
        impulse = impulses[row - structure.switched]
        for place, y in by_link.items():
            wrenches[place] = tuple(f + impulse * c for f, c in zip(wrenches[place], y, strict=True))
    return _solved(posture, structure, replace(loads, wrenches=wrenches), [0.0] * structure.rows, mask)


def carried_on(posture: Posture, before: Instant) -> list[Any]:
    """The change of all rates with which bodies move as they did before, as nearly as joints let them: least by their
    masses."""
    tree, bodies = posture.tree, posture.model.bodies
    pairs = list(zip(posture.now.bodies, before.bodies, strict=True))
    lost = [b - a for now, then in pairs for a, b in zip(now[12:18], then[12:18], strict=True)]
    inertia = [acting.rigid(tree, link, bodies) for link in tree.links]
    armatures = [link.armature for link in tree.links for _ in link.rates]
    loads = Loads(inertia, acting.of_bodies(posture, _weighed(bodies, lost)), armatures=armatures)
    return Reduction(tree, posture.links, loads, posture.waiting, posture.free).solution({})[0]


def _relative_to(loads: Loads, there: Sequence[Six], rates: Sequence[Number], xi: Sequence[Number]) -> Loads:
    """What is missing where the links accelerate so already. xi: what is missing of the rows."""
    wrenches = []
    for A, wrench, a in zip(loads.inertia, loads.wrenches, there, strict=True):
        wrenches.append(wrench if A is None else tuple(x - y for x, y in zip(wrench, times(A, a), strict=True)))
    assert loads.armatures is not None
    efforts = dict(loads.efforts)
    for n, (armature, rate) in enumerate(zip(loads.armatures, rates, strict=True)):
        if not is_zero(armature):
            efforts[n] = efforts.get(n, 0.0) - armature * rate
    resisting = {row: xi[row] for row in loads.resisting}
    return Loads(loads.inertia, wrenches, efforts, loads.armatures, rows=loads.rows, resisting=resisting)


def _less(xi: Sequence[Number], rows: Mapping[int, Mapping[int, Six]], there: Sequence[Six]) -> list[Any]:
    """xi - C a."""
    rest = list(xi)
    for row, by_link in rows.items():
        for place, y in by_link.items():
            for a, b in zip(y, there[place], strict=True):
                rest[row] = rest[row] - a * b
    return rest


def body_accelerations(posture: Posture, links: Sequence[Six]) -> list[Any]:
    """v' (global) and w' (body frame) of every body from those of the links, where weight is in these."""
    g = dynamics.gravity(posture.model, posture.t)
    found: list[Any] = []
    for body in range(len(posture.model.bodies)):
        place = posture.tree.of_body[body]
        link, moving, a = posture.tree.links[place], posture.links[place], links[place]
        assert link.frame is not None
        c = centre(link)
        inner = so3.add(so3.cross(a[3:6], c), so3.cross(moving.w, so3.cross(moving.w, c)))
        found += so3.add(so3.rotate(moving.R, so3.add(a[0:3], inner)), g)
        found += so3.rotate(link.frame.axes, a[3:6])
    return found
