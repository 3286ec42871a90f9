"""The linear system of a generalised-alpha step in the stabilised form of index 2.

Unknown are the accelerations a, the rates of laws' states, the multipliers mu, and eta of every row of C that holds
positions: q = ... + h^2 p a + G eta and v = ... + h g a, with G = C^T at the start of the step. Asked for are the
equations of motion, C v = b and Phi(q) = 0 at its end (Arnold, Bruels and Cardona 2015, section 5), so that no
projection has to move what a stiff force holds:

    along:  M - h g F_v - h^2 p F_q,  C^T,  -F_q G;    rates:  C, and by q over h g;    positions:  C, C G / h^2 p.

eta leaves with the multiplier of its row; behind it stands C G / h^2 p, which is definite as C M^-1 C^T is.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

from lienumba.integrators.tracing.implicit import stage_system
from lienumba.integrators.tracing.linear.equations import Linear
from lienumba.integrators.tracing.tracer import Tracer
from lienumba.mechanics.system import constraints
from lienumba.numerics.number import Number
from lienumba.numerics.operations import is_zero

Columns = dict[int, dict[int, Any]]  # of G: what each eta moves


def holding(tracer: Tracer) -> list[int]:
    """Which of the rows in use hold positions."""
    levels = [c.level for c in constraints.constraints_of(tracer.graph()[1]) for _ in range(c.rows)]
    return [n for n, row in enumerate(tracer.used) if levels[row] == "position"]


def columns(start: Linear, held: Sequence[int]) -> Columns:
    """G, from the derivatives at the start of the step."""
    found: Columns = {m: {} for m in held}
    for (row, m), x in start.block("along", "mu").items():
        if m in found:
            found[m][row] = -x
    return found


@dataclass(frozen=True)
class System:
    """rows of the matrix, what it is solved for, and the order in which variables leave."""

    rows: stage_system.Rows
    right: list[Any]
    order: list[int]


def system(
    tracer: Tracer, linear: Linear, G: Columns, weights: tuple[Any, Any], h: Any, mask: Sequence[Number],
    unknown: Sequence[Sequence[Any]],
) -> System:  # fmt: skip
    """The system whose solution the unknowns change by; weights: p and g."""
    n, laws, count = stage_system.unknowns(tracer)
    place, rate = h * h * weights[0], h * weights[1]
    starts = {"along": 0, "laws": n, "rates": n + laws, "positions": n + laws + count}
    scales: dict[str, Any] = {"rates": -1.0 / rate, "positions": -1.0 / place}
    size = n + laws + count + len(G)
    number = {m: n + laws + count + k for k, m in enumerate(G)}  # of eta, and of the row of positions
    rows: stage_system.Rows = [{} for _ in range(size)]
    right: list[Any] = [0.0] * size

    def add(row: int, column: int, x: Any) -> None:
        rows[row][column] = rows[row].get(column, 0.0) + x

    for name, first in starts.items():
        every = {m: number.get(m, -1) if name == "positions" else first + m for m in range(len(linear.values[name]))}
        scale = scales.get(name, 1.0)
        for m, x in enumerate(linear.values[name]):
            if every[m] >= 0 and name in scales:
                right[every[m]] = scale * x
        for by, column, factor in (("q", 0, place), ("v", 0, rate), ("laws", n, rate)):
            for (m, c), x in linear.block(name, by).items():
                if every[m] >= 0:
                    add(every[m], column + c, -(scale * factor * x))
                    for e, own in G.items() if by == "q" else ():
                        if c in own:
                            add(every[m], number[e], -(scale * x * own[c]))
        for by, column in (("a", 0), ("mu", n + laws)) if name in ("along", "laws") else ():
            for (m, c), x in linear.block(name, by).items():
                add(first + m, column + c, -x)
    right[0:n] = linear.along
    for m in range(laws):
        add(n + m, n + m, 1.0)
        right[n + m] = linear.laws[m] - unknown[1][m]
    for m, row in enumerate(tracer.used):
        off = 1.0 - mask[row]
        if is_zero(off):
            continue
        for variable, x in (
            (n + laws + m, unknown[2][m]),
            *([(number[m], unknown[3][[*G].index(m)])] if m in G else ()),
        ):
            add(variable, variable, off)
            right[variable] = right[variable] - off * x
    order: list[int] = []
    for variable in stage_system.order_of(tracer):
        order += [variable, *([number[variable - n - laws]] if variable - n - laws in number else [])]
    return System(rows, right, order)


def apart(tracer: Tracer, solution: Sequence[Any]) -> list[list[Any]]:
    """The changes of accelerations, of the rates of laws' states, of multipliers and of eta."""
    n, laws, count = stage_system.unknowns(tracer)
    return [[*solution[a:b]] for a, b in pairwise((0, n, n + laws, n + laws + count, len(solution)))]
