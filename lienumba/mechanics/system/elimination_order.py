"""In which order the blocks of the KKT matrix may be eliminated without pivoting, and which order is cheapest.

A body's block is positive definite at any time. A joint's block is definite once all its bodies are gone and no other
joint of the same connected group of eliminated bodies still waits for a body: the rows met so far are then rows of the
full-rank C. With one body still to come it is definite if the eliminated group behind it is a tree, not tied to
ground, with no other waiting joint: the group hangs freely, so any load on it moves it (children before parents,
Baraff 1996). The rule of a plain minimum-degree order, "after one of its bodies", is wrong where there are loops.
These rules ask for a rank of C and a positive definite mass matrix, whichever bodies it couples: couplings (of rotors)
cost work, no safety.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

from lienumba.mechanics.mechanism.model import GROUND

BODY_ROWS = 6
Couplings = Sequence[tuple[int, int, bool]]


@dataclass
class _Group:
    """Eliminated bodies that eliminated joints connect."""

    bodies: set[int]
    joints: set[int] = field(default_factory=set)
    waiting: set[int] = field(default_factory=set)  # eliminated joints with a body still to come

    def joined(self, others: "list[_Group]", joint: int | None) -> "_Group":
        every = [self, *others]
        return _Group(
            set().union(*(g.bodies for g in every)),
            set().union(*(g.joints for g in every)) | (set() if joint is None else {joint}),
            set().union(*(g.waiting for g in every)),
        )

    def is_safe(self) -> bool:
        """Nothing waits; or one joint does, and the others make a tree: a tie to ground would be one joint too many."""
        if not self.waiting:
            return True
        inner = len(self.joints) - len(self.waiting)
        return len(self.waiting) == 1 and inner == len(self.bodies) - 1


class _Elimination:
    """One walk through the blocks: bodies 0..k-1, joints k..k+n-1; touched: bodies whose block is no longer constant,
    because of a joint or of a coupling."""

    def __init__(self, bodies: int, joints: list[tuple[tuple[int, ...], int]], couplings: Couplings = ()) -> None:
        self.k, self.joints = bodies, joints
        self.near: list[set[int]] = [set() for _ in range(bodies + len(joints))]
        for j, (ends, _) in enumerate(joints):
            for body in set(ends) - {GROUND}:
                self.near[body].add(bodies + j)
                self.near[bodies + j].add(body)
        self.touched: set[int] = set()
        for a, b, constant in couplings:
            self.near[a].add(b)
            self.near[b].add(a)
            self.touched |= set() if constant else {a, b}
        self.group: dict[int, _Group] = {}
        self.left = set(range(len(self.near)))
        self.order: list[int] = []
        self.cost = 0.0

    def rows(self, node: int) -> int:
        return BODY_ROWS if node < self.k else self.joints[node - self.k][1]

    def degree(self, node: int) -> int:
        return sum(self.rows(n) for n in self.near[node])

    def work(self, node: int) -> float:
        """Multiply-adds of eliminating a block."""
        d, s = self.degree(node), self.rows(node)
        if node >= self.k:
            return 0.5 * s * (d + 0.5 * s) ** 2
        return 0.5 * BODY_ROWS * (d + 0.5 * BODY_ROWS) ** 2 if node in self.touched else 1.5 * d * d + d

    def fill(self, node: int) -> int:
        near = sorted(self.near[node])
        pairs = ((a, b) for i, a in enumerate(near) for b in near[i + 1 :] if b not in self.near[a])
        return sum(self.rows(a) * self.rows(b) for a, b in pairs)

    def after(self, node: int) -> _Group | None:
        """The group that eliminating this node leaves, or None if its block may be singular."""
        if node < self.k:
            behind = [g for g in self._groups() if any(node in self._ends(j) for j in g.waiting)]
            group = _Group({node}).joined(behind, None)
            group.waiting = {j for j in group.waiting if not self._ends(j) <= group.bodies | {GROUND}}
            return group
        ends = self._ends(node)
        gone = [b for b in ends if b != GROUND and b not in self.left]
        coming = [b for b in ends if b != GROUND and b in self.left]
        if not gone or len(coming) > (1 if len(ends) < 3 else 0):
            return None
        first, *others = {id(g): g for g in (self.group[b] for b in gone)}.values()
        group = first.joined(others, node)
        if coming:
            group.waiting = group.waiting | {node}
        return group if group.is_safe() else None

    def take(self, node: int, group: _Group) -> None:
        self.cost += self.work(node)
        self.left.discard(node)
        self.order.append(node)
        for body in group.bodies:
            self.group[body] = group
        near = self.near[node]
        self.touched |= near if node >= self.k or node in self.touched else set()
        for other in near:
            self.near[other] = (self.near[other] | near) - {other, node}

    def _groups(self) -> list[_Group]:
        return list({id(g): g for g in self.group.values()}.values())

    def _ends(self, node: int) -> set[int]:
        return set(self.joints[node - self.k][0])


def elimination_order(bodies: int, joints: list[tuple[tuple[int, ...], int]], couplings: Couplings = ()) -> list[int]:
    """The cheapest safe order that the greedy rules find. `joints`: (bodies of the joint, its rows); `couplings`: two
    bodies that the mass matrix couples, and whether by constants.

    Returns block numbers, bodies 0..k-1, joints k..k+n-1.
    """
    rules: list[Callable[[_Elimination, int], tuple[float, ...]]] = [
        lambda walk, n: (walk.work(n), n),
        lambda walk, n: (walk.degree(n), -n),
        lambda walk, n: (walk.fill(n), walk.degree(n), -n),
        lambda walk, n: (n >= walk.k, walk.degree(n), n),  # all bodies, then the joints among themselves
    ]
    walks = []
    for rule in rules:
        walk = _Elimination(bodies, joints, couplings)
        while walk.left:
            for node in sorted(walk.left, key=lambda n: rule(walk, n)):
                group = walk.after(node)
                if group is not None:
                    walk.take(node, group)
                    break
        walks.append(walk)
    return min(walks, key=lambda walk: walk.cost).order
