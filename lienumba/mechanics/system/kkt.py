"""[A C^T; C 0] [x; mu] = [f; g] (Terze et al. 2015, eqs. 13, 29) by a sparse L D L^T, executed on whatever the numbers
are.

On symbols the elimination unrolls to exactly the operations that its pattern needs. The order of the blocks makes
pivoting unnecessary (`lienumba.mechanics.system.elimination_order`). A row whose mask is 0 is left out: its multiplier
is 0.

Closed loops may pass positions where C loses rank. There a pivot vanishes, and its equation, divided by it, is noise:
Runge-Kutta stages lie beside the constraints, by more than the pivot. So the solution is sought as an expected one plus
a correction, and what the weak equation says of the correction is faded out. (A pivot moved by a small number, the
usual remedy, forgets the constraint force instead, which costs energy.)
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from lienumba.mechanics.system.structure import Entries as Entries
from lienumba.mechanics.system.structure import Structure as Structure
from lienumba.mechanics.system.switched.border import Border, FrictionCoupling
from lienumba.mechanics.tolerances import (
    HALF_FADED_MARGIN,
    HALF_FADED_PIVOT,
    LEAST_PIVOT,
    MULTIPLIER_RTOL,
    MULTIPLIER_SHIFT,
    SCALE_ROUNDOFF,
    SINGULAR_PIVOT,
    WEAK_PIVOT,
)
from lienumba.numerics.number import Number
from lienumba.numerics.operations import is_zero, maximum, minimum, where

Vectors = tuple[list[Any], list[Any]]  # of the size of x, and of that of mu


class Solution(NamedTuple):
    """x (6 k), mu (m); `by`: the elimination, to be used again."""

    x: list[Any]
    mu: list[Any]
    by: "Eliminated"

    @property
    def nonsingular(self) -> Any:
        """1, or 0 where a constraint depends on the others; `PARADOX` where friction leaves no solution."""
        return (
            self.by.nonsingular if self.by.border is None else minimum(self.by.border.nonsingular, self.by.nonsingular)
        )

    @property
    def row_weights(self) -> list[Any]:
        """In closed loops, for each row 1, or less where it is faded."""
        return self.by.row_weights

    @property
    def margin(self) -> Any:
        """In closed loops, the smallest pivot of a constraint relative to its scale."""
        return self.by.margin


@dataclass
class _Factors:
    """The elimination while it goes on: positions are those of the order."""

    order: tuple[int, ...]
    n: int  # velocities
    by_bodies: list[Any] = field(default_factory=list)  # the diagonal, kept in two sums for the constraint rows: what
    by_joints: list[Any] = field(default_factory=list)  # the bodies give, the scale, and what constraints take away
    column: list[dict[int, Any]] = field(default_factory=list)
    inverse: list[Any] = field(default_factory=list)
    parts: list[dict[tuple[int, bool], Any]] = field(default_factory=list)  # of by_bodies: (body, whether it turns)
    ends: list[set[int]] = field(default_factory=list)  # bodies that a row ties, by itself or through eliminated rows

    @staticmethod
    def of(order: tuple[int, ...], n: int, A: Entries, C: Entries, diagonal: dict[int, Number]) -> "_Factors":
        size = len(order)
        place = {variable: position for position, variable in enumerate(order)}
        factors = _Factors(
            order, n, [0.0] * size, [0.0] * size, [{} for _ in order], [None] * size, [{} for _ in order],
            [set() for _ in order],
        )  # fmt: skip
        for row, c in C:
            factors.ends[place[n + row]].add(c // 6)
        for row, x in diagonal.items():
            factors.by_bodies[place[n + row]] = x
        for (i, j), value in [*A.items(), *(((n + row, c), x) for (row, c), x in C.items())]:
            low, high = sorted((place[i], place[j]))
            if low == high:
                factors.by_bodies[low] = factors.by_bodies[low] + value
            else:
                factors.column[low][high] = value
        return factors

    def eliminate(self, j: int, pivot: Number) -> None:
        self.inverse[j] = 1.0 / pivot
        entries = sorted(self.column[j].items())
        scaled = [(i, value * self.inverse[j]) for i, value in entries]
        diagonal = self.by_joints if self.order[j] >= self.n else self.by_bodies
        body, turns = self.order[j] // 6, self.order[j] % 6 >= 3
        for i in self.column[j] if diagonal is self.by_joints else ():
            self.ends[i] |= self.ends[j]
        for a, (i, value) in enumerate(entries):
            for i2, factor in scaled[a:]:
                if i2 == i:
                    diagonal[i] = diagonal[i] - factor * value
                    if diagonal is self.by_bodies and body in self.ends[i]:
                        self.parts[i][body, turns] = self.parts[i].get((body, turns), 0.0) + factor * value
                else:
                    self.column[i][i2] = self.column[i].get(i2, 0.0) - factor * value
        self.column[j] = dict(scaled)

    def smallest(self, rows: list[int]) -> Any:
        """Of the parts of the scale of these rows: what shifting or turning one of their bodies gives to any of them.
        By this neither a small mechanism nor a light body between heavy ones looks singular. (What rotors carry over
        from other bodies may be as small as they are, and would let singular positions look regular.)"""
        parts: dict[tuple[int, bool], Any] = {}
        for j in rows:
            for part, value in self.parts[j].items():
                parts[part] = maximum(value, parts[part]) if part in parts else value
        found: list[Any] = []
        for body in dict.fromkeys(body for body, _ in parts):
            shift, turn = (parts.get((body, turns), 0.0) for turns in (False, True))
            less, more = minimum(shift, turn), maximum(shift, turn)
            found.append(where(less > SCALE_ROUNDOFF * more, less, more))
        least: Any = found[0] if found else 0.0
        for part in found[1:]:
            least = minimum(part, least)
        return least

    def left(self, first: int) -> list[list[Any]]:
        """C K^-1 C^T of the constraints from a position on, once all before it is eliminated."""
        last = range(first, len(self.order))
        S: list[list[Any]] = [[0.0 for _ in last] for _ in last]
        for i in last:
            S[i - first][i - first] = -(self.by_bodies[i] + self.by_joints[i])
            for j in range(first, i):
                S[i - first][j - first] = S[j - first][i - first] = -self.column[j].get(i, 0.0)
        return S

    def forward(self, f: Sequence[Number], g: Sequence[Number], row_weights: Sequence[Number]) -> list[Any]:
        y = [(f[v] if v < self.n else g[v - self.n]) for v in self.order]
        for j, variable in enumerate(self.order):
            if self.inverse[j] is None:
                break
            if variable >= self.n:
                y[j] = row_weights[variable - self.n] * y[j]
            for i, factor in self.column[j].items():
                y[i] = y[i] - factor * y[j]
        return y

    def backward(self, y: list[Number], border: "Border | None" = None) -> Vectors:
        last = len(y)
        if border is not None:
            last -= len(border.mask)
            y[last:] = border.solve(y[last:])
        for j in reversed(range(last)):
            y[j] = y[j] * self.inverse[j]
            for i, factor in self.column[j].items():
                y[j] = y[j] - factor * y[i]
        solved: list[Any] = [0.0] * (max(self.order, default=-1) + 1)
        for position, variable in enumerate(self.order):
            solved[variable] = y[position]
        return solved[: self.n], solved[self.n :]


class Eliminated(NamedTuple):
    """[A C^T; C 0] as L D L^T, for any number of right-hand sides. nonsingular, row_weights, margin: as in Solution."""

    structure: Structure
    factors: _Factors
    nonsingular: Any
    row_weights: list[Any]
    margin: Any
    border: Border | None = None

    @staticmethod
    def of(
        structure: Structure, A: Entries, C: Entries, mask: Sequence[Number], coupling: FrictionCoupling | None = None,
        scales: Mapping[int, Number] | None = None,
    ) -> "Eliminated":  # fmt: skip
        """C: its masked rows are 0, but for those that lean. Without bodies, A is the matrix of the constraints after
        all else is eliminated, and scales are those of its rows."""
        n = 6 * structure.bodies
        order = structure.order_for(A) if n else structure.order
        together = structure.friction_rows if coupling is not None else ()
        used = set(order[: len(order) - len(together)])
        diagonal = {
            row: m - 1.0 for row, m in enumerate(mask) if n + row in used and not (isinstance(m, float) and m == 1.0)
        }
        factors = _Factors.of(order, n, A, C, diagonal)
        place = {variable: position for position, variable in enumerate(order)}
        row_weights: list[Any] = [1.0] * structure.rows
        nonsingular: Any = 1.0
        margin: Any = 1.0
        for j, variable in enumerate(order[: len(order) - len(together)]):
            scale = factors.by_bodies[j]
            pivot = scale + factors.by_joints[j]
            if variable >= n and structure.looped and variable - n < structure.switched:
                idle = diagonal.get(variable - n, 0.0)  # -1 of a masked row, which has no other scale
                if n:
                    alike = [place[n + row] for row in structure.alike[variable - n]]
                    scale = idle - (1.0 + idle) * factors.smallest(alike)
                elif scales is not None:
                    scale = idle - (1.0 + idle) * scales[variable - n]
                part = pivot / scale
                if not n and structure.switched < structure.rows and not structure.from_singular:
                    says = factors.by_bodies[j] / scale  # nothing where locks hold all that it is about
                    part, pivot = (where(says > SCALE_ROUNDOFF, x, y) for x, y in ((part, 1.0), (pivot, scale)))
                margin = minimum(part, margin)
                faded = part * part / (part * part + HALF_FADED_PIVOT * HALF_FADED_PIVOT)
                row_weights[variable - n] = where(part > WEAK_PIVOT, 1.0, faded)
                pivot = where(part > LEAST_PIVOT, pivot, LEAST_PIVOT * scale)
            elif variable >= n:
                nonsingular = where(SINGULAR_PIVOT * scale - pivot > 0.0, nonsingular, 0.0)  # NaN is not
            factors.eliminate(j, pivot)
        if not together or coupling is None:
            return Eliminated(structure, factors, nonsingular, row_weights, margin)
        S = factors.left(len(order) - len(together))
        border = Border.of(S, together, [mask[row] for row in together], coupling)
        return Eliminated(structure, factors, nonsingular, row_weights, margin, border)

    def solve(self, f: Sequence[Number], g: Sequence[Number], pulled: Sequence[Number] | None = None) -> Solution:
        """g: of a masked row 0; pulled: what forces have added to it already, where velocities have been eliminated."""
        x, mu = self.factors.backward(self._forward(f, g, pulled), self.border)
        if self.structure.looped and self.structure.from_singular:
            x = [where(self.margin > LEAST_PIVOT, dx, 0.0) for dx in x]
        return Solution(x, mu, self)

    def missing(self, f: Sequence[Number], g: Sequence[Number], pulled: Sequence[Number] | None = None) -> list[Any]:
        """C x - g of the rows that are solved together, where none of them has a multiplier."""
        assert self.border is not None
        return [-y for y in self._forward(f, g, pulled)[-len(self.border.mask) :]]

    def reactions(self, mask: Sequence[Number], mu: Sequence[Number]) -> list[Any]:
        """See `kkt.reactions`."""
        found: list[Any] = [m * x for m, x in zip(mask, mu, strict=True)]
        if self.border is not None:
            names = self.structure.friction_rows
            for row, x in zip(names, self.border.reactions([found[row] for row in names]), strict=True):
                found[row] = x
        return found

    def _forward(self, f: Sequence[Number], g: Sequence[Number], pulled: Sequence[Number] | None) -> list[Any]:
        factors, every = self.factors, [1.0] * self.structure.rows
        pulled = [0.0] * len(g) if pulled is None else pulled
        if not self.structure.looped:
            return factors.forward(f, [a + b for a, b in zip(g, pulled, strict=True)], every)
        by_forces = factors.forward(f, pulled, every)
        by_constraints = factors.forward([0.0] * len(f), g, self.row_weights)
        return [a + b for a, b in zip(by_forces, by_constraints, strict=True)]

    def numbers(self) -> list[Any]:
        """All that `solve` reads beside the right-hand sides."""
        columns = [x for column in self.factors.column for x in column.values()]
        return [*columns, *self.factors.inverse, *self.row_weights, self.nonsingular, self.margin]

    def with_numbers(self, numbers: Sequence[Number]) -> "Eliminated":
        """An elimination with other numbers, in the order of `numbers`."""
        given = iter(numbers)
        column = [{i: next(given) for i in column} for column in self.factors.column]
        inverse = [next(given) for _ in self.factors.inverse]
        factors = _Factors(self.factors.order, self.factors.n, column=column, inverse=inverse)
        row_weights = [next(given) for _ in self.row_weights]
        return Eliminated(self.structure, factors, next(given), row_weights, next(given))


def scales(structure: Structure, A: Entries, C: Entries, bodies: int) -> dict[int, Any]:
    """Of the rows of a structure without bodies, which lose all their freedoms at once where they lose one: what
    shifting or turning one of these bodies gives to them, as where bodies are eliminated."""
    n, rows = 6 * bodies, [row for row in structure.order if row < structure.switched]
    order, place = (*range(n), *(n + row for row in rows)), {row: n + i for i, row in enumerate(rows)}
    factors = _Factors.of(order, n, A, {(row, c): x for (row, c), x in C.items() if row in place}, {})
    for j in range(n):
        factors.eliminate(j, factors.by_bodies[j])
    alike = {row: [place[other] for other in structure.alike[row] if other in place] for row in rows}
    return {row: factors.smallest(alike[row]) for row in rows}


def diagonal(rows: Sequence[int], A: Entries, C: Entries, bodies: int) -> list[Any]:
    """C A^-1 C^T of each of these rows with itself, as where bodies are eliminated."""
    n, place = 6 * bodies, {row: i for i, row in enumerate(rows)}
    own = {(place[row], c): x for (row, c), x in C.items() if row in place}
    factors = _Factors.of(tuple(range(n + len(rows))), n, A, own, {})
    for j in range(n):
        factors.eliminate(j, factors.by_bodies[j])
    return [-x for x in factors.by_bodies[n:]]


def solve(
    structure: Structure,
    A: Entries,
    C: Entries,
    f: Sequence[Number],
    g: Sequence[Number],
    mask: Sequence[Number] | None = None,
    expected: Sequence[Number] | None = None,
    coupling: FrictionCoupling | None = None,
) -> Solution:
    """`A`: symmetric and positive definite, entries (i, j) with i >= j, block diagonal but for what rotors of the
    structure's mechanism couple; `C`: entries (row, column).

    mask: 1 or 0 for each row; expected: what x is where C loses its rank (6 k), 0 if omitted; for closed loops;
    coupling: if contacts slide.
    """
    eliminated, f, g = _eliminated(structure, A, C, f, g, mask, expected, coupling)
    solution = eliminated.solve(f, g)
    if not structure.looped or expected is None:
        return solution
    return solution._replace(x=corrected(structure, expected, solution.x, solution.margin))


def corrected(structure: Structure, x: Sequence[Number], dx: Sequence[Number], margin: Number) -> list[Any]:
    """An expected solution with its correction. In the core of a singular position the direction of the lost row is
    noise, and with it what is left along the motion: there a run coasts, where steps are short enough for that."""
    whole = [a + b for a, b in zip(x, dx, strict=True)]
    if not structure.coasts:
        return whole
    trust = margin * margin / (margin * margin + HALF_FADED_MARGIN * HALF_FADED_MARGIN)
    return [where(margin > WEAK_PIVOT, c, a + trust * b) for a, b, c in zip(x, dx, whole, strict=True)]


def border(
    structure: Structure,
    A: Entries,
    C: Entries,
    f: Sequence[Number],
    g: Sequence[Number],
    mask: Sequence[Number],
    expected: Sequence[Number] | None = None,
) -> tuple[list[list[Any]], list[Any]]:
    """What is left of a `Structure.bordered` once all else is eliminated, whatever the masks of these last rows: S, and
    b = C x - g where they have no multipliers, such that these multipliers change it to b - S mu."""
    eliminated, f, g = _eliminated(structure, A, C, f, g, mask, expected, FrictionCoupling())
    assert eliminated.border is not None
    return eliminated.border.S, eliminated.missing(f, g)


def reactions(
    structure: Structure,
    A: Entries,
    C: Entries,
    mask: Sequence[Number],
    coupling: FrictionCoupling | None,
    mu: Sequence[Number],
) -> list[Any]:
    """The multipliers of all rows from those of the rows in use: what slides leans on its normal force, which contacts
    that say the same share."""
    if coupling is None:
        return [m * x for m, x in zip(mask, mu, strict=True)]
    f = [0.0] * 6 * structure.bodies
    return _eliminated(structure, A, C, f, mu, mask, None, coupling)[0].reactions(mask, mu)


def _eliminated(
    structure: Structure, A: Entries, C: Entries, f: Sequence[Number], g: Sequence[Number],
    mask: Sequence[Number] | None, expected: Sequence[Number] | None, coupling: FrictionCoupling | None,
) -> tuple[Eliminated, Sequence[Number], Sequence[Number]]:  # fmt: skip
    """With the right-hand sides, in closed loops what an expected solution leaves of them."""
    mask = mask or [1.0] * structure.rows
    weights = structure.weights(mask, coupling)
    C = {key: weights[key[0]] * x for key, x in C.items() if not is_zero(weights[key[0]])}
    g = [m * x for m, x in zip(weights, g, strict=True)]
    eliminated = Eliminated.of(structure, A, C, mask, coupling)
    if structure.looped and expected is not None:
        f, g = rest(A, C, f, g, expected, [0.0] * structure.rows)
    return eliminated, f, g


def rest(
    A: Entries, C: Entries, f: Sequence[Number], g: Sequence[Number], x: Sequence[Number], mu: Sequence[Number]
) -> Vectors:
    """What a solution leaves of the right-hand sides."""
    rest_f, rest_g = list(f), list(g)
    for (i, j), value in A.items():
        rest_f[i] = rest_f[i] - value * x[j]
        if i != j:
            rest_f[j] = rest_f[j] - value * x[i]
    for (row, c), value in C.items():
        rest_f[c] = rest_f[c] - value * mu[row]
        rest_g[row] = rest_g[row] - value * x[c]
    return rest_f, rest_g


def least_multipliers(structure: Structure, A: Entries, C: Entries, mu: Sequence[Number]) -> list[Any]:
    """The multipliers of minimum norm with the same C^T mu, over all rows: iterated Tikhonov regularisation of
    C A^-1 C^T. `A`, positive definite, does not change them; with lengths near those of the mechanism few directions
    are weak. What is weak all the same, near singular positions, is left over by the first shift for the second."""
    n, rows = 6 * structure.bodies, structure.rows
    f, g = rest(A, C, [0.0] * n, [0.0] * rows, [0.0] * n, [-m for m in mu])  # f = C^T mu
    x: list[Any] = [0.0] * n
    least: list[Any] = [0.0] * rows
    for shift, relative, iterations in ((MULTIPLIER_SHIFT, 0.0, 4), (0.0, MULTIPLIER_RTOL, 2)):
        factors = _Factors.of(structure.order, n, A, C, {})
        for j, variable in enumerate(structure.order):
            moved = shift - relative * factors.by_bodies[j] if variable >= n else 0.0
            factors.eliminate(j, factors.by_bodies[j] + factors.by_joints[j] - moved)
        for _ in range(iterations):
            dx, dmu = factors.backward(factors.forward(*rest(A, C, f, g, x, least), [1.0] * rows))
            x = [a + b for a, b in zip(x, dx, strict=True)]
            least = [a + b for a, b in zip(least, dmu, strict=True)]
    return least


def schur_complement(structure: Structure, A: Entries, C: Entries) -> tuple[list[Any], list[Any]]:
    """What the rows of C that may be masked say beyond those that may not: the Schur complement of [A C^T; C 0] once
    all else is eliminated (lower triangle, row by row), and the scale of each row: its diagonal of C A^-1 C^T."""
    n, masked = 6 * structure.bodies, set(structure.masked)
    needed = [v for v in structure.order if v >= n and v - n not in masked]
    order = (*range(n), *needed, *(n + row for row in structure.masked))
    factors = _Factors.of(order, n, A, C, {})
    for j in range(n + len(needed)):
        factors.eliminate(j, factors.by_bodies[j] + factors.by_joints[j])
    S = factors.left(n + len(needed))
    triangle = [S[i][j] for i in range(len(S)) for j in range(i + 1)]
    return triangle, [-factors.by_bodies[i] for i in range(n + len(needed), len(order))]
