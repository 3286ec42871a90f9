"""The chart of all joints: the coordinates u of every move about the state with which a step begins.

One element holds them all: the states of the moves (`lienumba.mechanics.mechanism.moves`), and behind them those of
laws. u has as many numbers for the places as there are rates, then the rates, then the states of laws.
"""

from dataclasses import dataclass

from lienumba.integrators.layout import REPORTS
from lienumba.integrators.methods.charts import Chart, Coordinates, Field
from lienumba.mechanics.tree.links import Link, Tree
from lienumba.mechanics.tree.motion import state_of
from lienumba.numerics.number import Number, Vector
from lienumba.numerics.operations import maximum

Element = Vector


@dataclass(frozen=True)
class JointChart(Chart):
    """tree: of the model on symbols; terms: of dexpinv, where joints turn about any axis; laws: numbers of their
    states."""

    tree: Tree
    terms: int | None
    laws: int
    plain: bool = False
    orthogonal: bool = True

    @property
    def size(self) -> int:
        """No less than what a stage reports, which stands behind."""
        return max(2 * self.tree.freedoms + self.laws, REPORTS)

    def moved(self, x: Element, u: Coordinates) -> Element:
        z: list[Number] = []
        for link in self.tree.links:
            z += link.move.moved(state_of(link, x), self.own(link, u), link.pitch)
        first, behind = 2 * self.tree.freedoms, self.tree.state
        return (*z, *(a + b for a, b in zip(x[behind:], u[first : first + self.laws], strict=True)))

    def slope(self, x: Element, u: Coordinates, at: Element, f: Field) -> Coordinates:
        """f: q'' of the tree, and the rates of the laws' states."""
        n, every = self.tree.freedoms, []
        for link in self.tree.links:
            a = tuple(f[link.first_rate : link.first_rate + link.move.freedoms])
            every.append(link.move.slope(self.own(link, u), state_of(link, at), a, self.terms))
        return self._joined(every, f[n:])

    def back(self, u: Coordinates, slope: Coordinates) -> Coordinates:
        every = [link.move.pulled(self.own(link, u), self.own(link, slope), self.terms) for link in self.tree.links]
        first = 2 * self.tree.freedoms
        return self._joined(every, slope[first : first + self.laws])

    def composed(self, u: Coordinates, w: Coordinates) -> Coordinates:
        every = [link.move.composed(self.own(link, u), self.own(link, w)) for link in self.tree.links]
        first = 2 * self.tree.freedoms
        laws = tuple(a + b for a, b in zip(u[first:], w[first:], strict=True))
        return self._joined(every, laws[: self.laws])

    def rotation(self, u: Coordinates) -> Number:
        largest: Number = 0.0
        for link in self.tree.links:
            if link.move.turns:
                largest = maximum(link.move.turned(self.own(link, u)), largest)
        return largest

    def settled(self, x: Element) -> Element:
        """The element with its rotations orthogonal again after roundoff."""
        z: list[Number] = []
        for link in self.tree.links:
            z += link.move.settled(state_of(link, x))
        return (*z, *x[self.tree.state :])

    def own(self, link: Link, u: Coordinates) -> Vector:
        """The coordinates of one link: of its place, then of its rates."""
        first, count = link.first_rate, link.move.freedoms
        rates = self.tree.freedoms + first
        return (*u[first : first + count], *u[rates : rates + count])

    def _joined(self, every: list[Vector], laws: Vector) -> Coordinates:
        places = [x for link, own in zip(self.tree.links, every, strict=True) for x in own[: link.move.freedoms]]
        rates = [x for link, own in zip(self.tree.links, every, strict=True) for x in own[link.move.freedoms :]]
        padding = self.size - 2 * self.tree.freedoms - self.laws
        return (*places, *rates, *laws, *(0.0,) * padding)


def displacement(tree: Tree, x: Element, along: Vector, size: int) -> Coordinates:
    """The coordinates of a displacement along the rates."""
    u: list[Number] = []
    for link in tree.links:
        own = tuple(along[rate] for rate in link.rates)
        u += link.move.tangent(state_of(link, x), own)
    return (*u, *(0.0,) * (size - len(u)))
