"""Runs the mechanics of one mechanism on symbols by the freedoms of its joints.

A state is one element: that of all moves of the tree, and behind it the states of laws; bodies are where these put
them. Joints of the tree need no projection.
"""

from collections.abc import Sequence
from dataclasses import replace

from lienumba.compiler.emit import Kernel
from lienumba.compiler.series import Linear
from lienumba.compiler.symbols import Graph
from lienumba.groups.state import ELEMENT, State
from lienumba.integrators import layout
from lienumba.integrators.methods import step_control
from lienumba.integrators.tracing import law_states
from lienumba.integrators.tracing import tracer as seen
from lienumba.integrators.tracing.joint.chart import JointChart
from lienumba.integrators.tracing.law_states import sampled
from lienumba.integrators.tracing.row_selection import RowSelection
from lienumba.integrators.tracing.tracer import BODIES, Correction, Dynamics, Part, Tracer, flat
from lienumba.mechanics.mechanism.kinematics import Instant
from lienumba.mechanics.mechanism.model import Model
from lienumba.mechanics.system import constraints, dynamics, kkt, projection
from lienumba.mechanics.system.switches import permanent
from lienumba.mechanics.tree import equations, reactions
from lienumba.mechanics.tree.links import Tree, tree_of
from lienumba.mechanics.tree.locking import locked
from lienumba.mechanics.tree.motion import read_state, state_of
from lienumba.mechanics.tree.posture import Posture
from lienumba.mechanics.tree.spanning import joints_of, ties_of
from lienumba.numerics.number import Number, Vector
from lienumba.numerics.operations import is_zero

FEW = 24  # rates, beyond which none waits: composite bodies cost the square of a chain's length
NEAR = 1, 2  # rates that may wait; where there are rotors, which leave nothing zero, even in large mechanisms


class JointTracer(Tracer):
    """As `Tracer`; `structure`: of the rows in use that close loops, `closing`: of all permanent ones that do; `glued`:
    see `equations.missing`."""

    glued = False

    def _structure(self, model: Model, selection: RowSelection, fixed: bool) -> kkt.Structure:
        tied = joints_of(ties_of(model)) | {lock.number for lock in locked(model, self.tree(model))}
        self.closing = kkt.Structure.closing(permanent(model), tied, selection.rows, (), selection.singular)
        masked, dropped = ((), selection.dropped) if fixed else (selection.rows, ())
        return kkt.Structure.closing(model, tied, masked, dropped, selection.singular)

    def _elements(self, model: Model) -> tuple[int, int, int]:
        tree = self.tree(model)
        self.laws = sum(self.law_states.sizes.values())
        self.waiting = self._waiting(tree)
        return 1, tree.state + self.laws, tree.freedoms

    def tree(self, model: Model) -> Tree:
        """The tree of a model on symbols; the last one is remembered."""
        known = getattr(self, "_known", None)
        if known is None or known[0] is not model:
            known = self._known = model, tree_of(model)
        return known[1]

    def chart_of(self, model: Model) -> JointChart:
        return JointChart(self.tree(model), self.method.terms, self.laws)

    def posture(
        self, model: Model, state: Sequence[State], augmented: Vector, t: Number, within: Number | None = None
    ) -> Posture:
        tree, element = self.tree(model), state[0]
        angles = dict(zip(self.augmented.angles, augmented, strict=False))
        laws = self.law_states.apart(element[tree.state :])
        modes = self.augmented.modes(model, augmented)
        mask, rows = self.augmented.mask(augmented, self.structure.rows), constraints.rows_of(model)
        held = [range(rows[x.number].start, rows[x.number].stop) for x in locked(model, tree)]
        locks = {row: mask[row] for own in held for row in own}
        return Posture(model, tree, element[: tree.state], t, angles, within, laws, self.waiting, modes, locks)

    def _waiting(self, tree: Tree) -> int:
        """How many rates may wait in the elimination: where there are few, what takes the fewest operations. Behind a
        branch all that waits is to be remembered at once, which costs more than operations tell."""
        if tree.freedoms > FEW:
            return 0 if all(is_zero(link.armature) for link in tree.links) else NEAR[-1]
        parents = [link.parent for link in tree.links]
        branches = len(set(parents)) < len(parents)
        return min((0, *NEAR) if branches else (0, *NEAR, tree.freedoms), key=self._operations)

    def _operations(self, waiting: int) -> int:
        """Count the operations of the accelerations, without forces and closing constraints."""
        graph, model = self.graph()
        free = replace(model, forces=(), drivers=())
        tree = self.tree(model)
        rows = constraints.rows_of(model)
        locks = dict(enumerate(graph.inputs("extra", rows[-1].stop if model.locks else 0)))
        posture = Posture(free, tree, graph.inputs("state", tree.state), waiting=waiting, locks=locks)
        rates = equations.accelerations(posture, kkt.Structure(0, 0, ()), []).rates
        return Kernel("count", tuple(rates), 0).counts()["operations"]

    def mask(self, augmented: Vector) -> list[Number]:
        mask = super().mask(augmented)
        used = {*self.structure.order}
        return [m if row in used else 0.0 for row, m in enumerate(mask)]

    def moving(
        self, model: Model, posture: seen.Posture, mask: list[Number], expected: list[Number] | None
    ) -> tuple[list[Vector], Dynamics]:
        posture = _tree(posture)
        solution = equations.accelerations(posture, self.structure, mask, expected, self.method.baumgarte)
        laws = self.law_states.together(law_states.rates(model, posture.now)) if self.laws else []
        found = Dynamics(solution.rates, solution.mu, solution.nonsingular, solution.margin)
        return [(*solution.rates, *laws)], found

    def moving_implicitly(
        self, graph: Graph, model: Model, posture: seen.Posture, mask: list[Number]
    ) -> tuple[list[Vector], Dynamics, Linear] | None:
        posture, n, used = _tree(posture), self.tree(model).freedoms, self.structure.order
        if self.augmented.switches or not equations.is_regular(posture, self.structure):
            return None
        unknown = graph.inputs("unknown", n + len(used))
        rates, multipliers = unknown[:n], unknown[n:]
        laws = self.law_states.together(law_states.rates(model, posture.now)) if self.laws else []

        def solve(graph: Graph, rest: Sequence[Number]) -> list[Number]:
            at_start = self.now(*self.graph(graph))[0]
            return equations.changed(_tree(at_start), self.structure, mask, rest)

        rest = equations.missing(posture, self.structure, mask, rates, multipliers, self.method.baumgarte)
        mu: list[Number] = [0.0] * self.structure.rows
        for row, multiplier in zip(used, multipliers, strict=True):
            mu[row] = multiplier
        return [(*rates, *laws)], Dynamics([*rates], mu, 1.0, 1.0), Linear(unknown, rest, solve)

    def missing(
        self, model: Model, posture: seen.Posture, mask: list[Number], a: Sequence[Number], mu: Sequence[Number],
        used: Sequence[int],
    ) -> list[Number]:  # fmt: skip
        posture, multipliers = _tree(posture), [mu[row] for row in self.structure.order]
        rates: list[Number] = []
        for link in posture.tree.links:
            rates += link.move.along(state_of(link, tuple(posture.z)), tuple(a[rate] for rate in link.rates))
        damping = self.method.baumgarte
        found = equations.missing(posture, self.structure, mask, rates, multipliers, damping, self.glued)
        rows = dict(zip(self.structure.order, found[self.velocities :], strict=True))
        along: list[Number] = []
        for link in posture.tree.links:
            along += link.move.tangent(state_of(link, tuple(posture.z)), tuple(found[rate] for rate in link.rates))
        return [*along, *(rows[row] for row in used)]

    def reactions(self, model: Model, posture: seen.Posture, mask: list[Number], mu: Sequence[Number]) -> list[Number]:
        return equations.reactions(_tree(posture), self.structure, mask, [m * x for m, x in zip(mask, mu, strict=True)])

    def field(self, model: Model, state: Sequence[State], a: Sequence[Number], laws: Sequence[Number]) -> list[Vector]:
        return [(*self.carried(model, state, a), *laws)]

    def gathered(self, q: Sequence[Number], v: Sequence[Number], laws: Sequence[Number]) -> list[Vector]:
        return [(*q, *v, *laws, *(0.0,) * (self.chart.size - 2 * self.velocities - len(laws)))]

    def apart(self, u: Sequence[Vector]) -> tuple[list[Number], list[Number], list[Number]]:
        n = self.velocities
        return list(u[0][:n]), list(u[0][n : 2 * n]), list(u[0][2 * n : 2 * n + self.laws])

    def carried(self, model: Model, state: Sequence[State], a: Sequence[Number]) -> list[Number]:
        rates: list[Number] = []
        for link in self.tree(model).links:
            rates += link.move.along(state_of(link, state[0]), tuple(a[rate] for rate in link.rates))
        return rates

    @property
    def coordinates(self) -> tuple[range, range]:
        return range(self.velocities), range(self.velocities, 2 * self.velocities)

    @property
    def moving_elements(self) -> int:
        return 1

    def law_rows(self) -> list[int]:
        first = self.tree(self.graph()[1]).state
        return [first + n for n in range(self.laws)]

    def rates(self, model: Model, state: Sequence[State], F: Sequence[Vector]) -> list[Number]:
        tree, found = self.tree(model), list[Number]()
        for link in tree.links:
            own = tuple(F[0][rate] for rate in link.rates)
            found += link.move.rates(state_of(link, state[0]), own, link.pitch)
        return [*found, *F[0][tree.freedoms :]]

    def velocity_rows(self, model: Model) -> list[int]:
        links = self.tree(model).links
        ends = [(link.first_state + link.move.state, link.move.freedoms) for link in links]
        return [row for end, count in ends for row in range(end - count, end)]

    def parts(self, model: Model) -> list[Part]:
        tree, found = self.tree(model), list[Part]()
        for link in tree.links:
            rows, move = range(link.first_state, link.first_state + link.move.state), link.move
            for kind, _, part in move.kinds():
                own = range(move.state)[part] if part is not None else move.turning
                assert own is not None
                found.append(Part(kind, rows[own.start : own.stop]))
        return [*found, *(Part(4, range(row, row + 1)) for row in range(tree.state, tree.state + self.laws))]

    def observed(
        self, model: Model, posture: seen.Posture, mask: list[Number], expected: list[Number] | None
    ) -> tuple[list[Number], list[Number]]:
        posture = _tree(posture)
        solution = equations.accelerations(posture, self.structure, mask, expected, self.method.baumgarte)
        accelerations = equations.body_accelerations(posture, solution.links)
        return accelerations, reactions.multipliers(posture, accelerations, solution.mu)

    def reported(
        self, model: Model, posture: seen.Posture, mask: list[Number], expected: list[Number] | None, found: Dynamics
    ) -> tuple[list[Number], list[Number]]:
        return self.observed(model, posture, mask, expected)

    def sampled(self, graph: Graph, model: Model, posture: seen.Posture) -> list[Number]:
        element = self.state(graph, "state")[0]
        laws = self.law_states.together(sampled(model, posture.now))
        return [*element[: self.tree(model).state], *laws]

    def error_square(
        self, graph: Graph, model: Model, estimates: Sequence[Sequence[Vector]], x: Sequence[State], y: Sequence[State]
    ) -> Number:
        tolerance = graph.inputs("clock", layout.TOLERANCES, layout.TOLERANCE)
        tree, chart, squares = self.tree(model), self.chart_of(model), []
        for link in tree.links:
            own = [chart.own(link, z) for z in estimates[0]]
            for kind, place, part in link.move.kinds():
                sizes = () if part is None else tuple(state_of(link, s[0])[part] for s in (x, y))
                squares.append(step_control.kind_error_square([z[place] for z in own], kind, sizes, tolerance))
        for law in range(self.laws):
            changes = tuple(z[2 * tree.freedoms + law] for z in estimates[0])
            a, b = (s[0][tree.state + law] for s in (x, y))
            squares.append(step_control.state_error_square(changes, a, b, tolerance))
        return step_control.worst(squares)

    def allowed(self, model: Model, posture: seen.Posture, mask: list[Number], change: list[Number]) -> list[Number]:
        posture, found = _tree(posture), list[Number]()
        along = equations.tangential(posture, self.structure, mask, self.carried(model, (tuple(posture.z),), change))
        for link in posture.tree.links:
            found += link.move.tangent(state_of(link, tuple(posture.z)), tuple(along[rate] for rate in link.rates))
        return found

    def velocity_projected(
        self, graph: Graph, model: Model, posture: seen.Posture, mask: list[Number]
    ) -> tuple[list[Number], Correction]:
        posture, weight = _tree(posture), projection.WEIGHTS[self.method.velocity]
        solution = equations.velocity_correction(posture, self.structure, mask, weight.bodies(model), weight.rotors)
        return self._moved(graph, posture, solution.rates), solution

    def _moved(self, graph: Graph, posture: Posture, change: Sequence[Number]) -> list[Number]:
        """The rows of the element with rates changed by this."""
        element = list(self.state(graph, "state")[0])
        for link in posture.tree.links:
            along = tuple(change[rate] for rate in link.rates)
            first = link.first_state + link.move.places
            for n, x in enumerate(link.move.tangent(state_of(link, tuple(element)), along)):
                element[first + n] = element[first + n] + x
        return element

    def border(
        self, model: Model, posture: seen.Posture, mask: list[Number], expected: list[Number] | None
    ) -> tuple[list[list[Number]], list[Number]]:
        return equations.border(_tree(posture), self.structure, mask, expected, self.method.baumgarte)

    def kicked(
        self, graph: Graph, model: Model, posture: seen.Posture, mask: list[Number], impulses: Sequence[Number]
    ) -> tuple[list[Number], list[Number]]:
        posture = _tree(posture)
        solution = equations.kicked(posture, self.structure, mask, impulses)
        return self._moved(graph, posture, solution.rates), solution.mu

    def schur(self, model: Model, posture: seen.Posture) -> tuple[list[Number], list[Number]]:
        """With the scales that rows have where bodies are free: rows across a plane in which all moves are rounding."""
        every = [1.0] * self.closing.rows
        matrix = equations.constraint_matrix(_tree(posture), self.closing, every, dynamics.shaped(model))
        triangle, _ = kkt.schur_complement(self.closing, matrix, {})
        C = constraints.jacobian(model, posture.now)
        return triangle, kkt.diagonal(self.closing.masked, dynamics.shapes(model), C, len(model.bodies))

    def counted(self, solution: Correction, mask: list[Number], level: str) -> list[Number]:
        counts = super().counted(solution, mask, level)
        used = {*self.structure.order}
        return [count if row in used else 0.0 for row, count in enumerate(counts)]

    def with_law_states(self, graph: Graph, elements: Sequence[State]) -> list[Number]:
        return flat(elements)

    def levels(self) -> set[str]:
        model = self.graph()[1]
        every, tied = constraints.constraints_of(model), {*self.tree(model).joints}
        tied |= {lock.number for lock in locked(model, self.tree(model))}
        return {constraint.level for n, constraint in enumerate(every) if n not in tied and constraint.rows}

    def shown(self, now: Instant) -> dict[str, list[Number]]:
        return {BODIES: flat(now.bodies)}


def place(tracer: Tracer) -> Kernel:
    """From a state to the bodies."""
    graph, model = tracer.graph()
    return tracer.kernel("place", flat(tracer.now(graph, model)[0].now.bodies))


def carry(tracer: Tracer) -> Kernel:
    """From a state, and the one before its bodies were moved, to rates by which these move as they did."""
    assert isinstance(tracer, JointTracer)
    graph, model = tracer.graph()
    now, time = _tree(tracer.now(graph, model)[0]), graph.input("clock", layout.TIME)
    before = tracer.posture(model, tracer.state(graph, "extra"), tracer.augmented_rows(graph), time)
    return tracer.kernel("carry", tracer._moved(graph, now, equations.carried_on(now, before.now)))


def read(tracer: Tracer) -> Kernel:
    """From the bodies to the state of the moves: by the same operations, to the bit, from which steps know the frames
    of the links. Where axes of joints are nearly parallel, rounding decides how these are turned about them."""
    graph, model = tracer.graph()
    bodies = [graph.inputs("state", ELEMENT, ELEMENT * i) for i in range(len(model.bodies))]
    return tracer.kernel("read", read_state(model, tree_of(model), bodies))


def _tree(posture: seen.Posture) -> Posture:
    assert isinstance(posture, Posture)
    return posture
