"""One step of the bodies' states in a chart, for any explicit tableau: with exponential coordinates it is that of
Runge-Kutta-Munthe-Kaas on the state-space group (Terze et al. 2015, eq. 20).

The paper's f*_i are the `slopes` here, its u_i the coordinates `u` of a stage, w_n those of the end of the step.
"""

from collections.abc import Callable, Sequence

from lienumba.groups.state import State
from lienumba.integrators.methods.charts import Chart, Coordinates, Field
from lienumba.integrators.methods.tableau import Row, Tableau
from lienumba.numerics.number import Number, Vector
from lienumba.numerics.operations import is_zero, maximum

Bodies = Sequence[State]
Slopes = Sequence[Coordinates]  # of each body, about where it was


def slope(chart: Chart, x: Bodies, u: Slopes, F: Callable[[Bodies], Sequence[Field]]) -> Slopes:
    """u' at u about x (Terze et al. 2015, eq. 19): how the coordinates of all bodies move where they move by F."""
    at = tuple(chart.moved(body, z) for body, z in zip(x, u, strict=True))
    return tuple(chart.slope(*each) for each in zip(x, u, at, F(at), strict=True))


def combination(chart: Chart, h: Number, exponentials: Sequence[Row], slopes: Slopes) -> tuple[Coordinates, Number]:
    """u of one body from its slopes and the weights of one exponential, or of two behind one another; and no less than
    its squared rotation (rad^2)."""
    u, *others = [weighted(scaled(h, row), slopes) for row in exponentials]
    rotation = chart.rotation(u)
    for w in others:
        rotation = 2.0 * (rotation + chart.rotation(w))
        u = chart.composed(u, w)
    return u, rotation


def scaled(h: Number, row: Row) -> list[Number]:
    """h times weights."""
    return [h * float(w) if w else 0.0 for w in row]


def weighted(weights: Sequence[Number], slopes: Sequence[Vector]) -> Vector:
    """sum_j w_j f_j."""
    (first, f), *rest = [(w, f) for w, f in zip(weights, slopes, strict=False) if not is_zero(w)]
    u = tuple(first * c for c in f)
    for w, f in rest:
        u = tuple(total + w * c for total, c in zip(u, f, strict=True))
    return u


def advanced(chart: Chart, h: Number, tableau: Tableau, x: State, slopes: Slopes) -> tuple[State, Number, Number]:
    """One body at the end of a step: its new state, the squared rotation, and the sum of squares of the move."""
    w, rotation = combination(chart, h, tableau.exponentials(len(tableau.b)), slopes)
    square: Number = 0.0
    for c in w:
        square = square + c * c
    return chart.settled(chart.moved(x, w)), rotation, square


def step(
    chart: Chart,
    tableau: Tableau,
    x: Bodies,
    t: Number,
    h: Number,
    stage: Callable[[Bodies, Slopes, Number], Slopes],
    first: Slopes = (),
) -> tuple[Bodies, Number, Number, list[list[Coordinates]]]:
    """One step of size h from x at time t (Terze et al. 2015, eq. 20).

    `stage(x, u, t)` is the slope at u about x, which is exactly zero in the first stage; first: that of each body where
    it is known. Returns the new state, the largest squared rotation of a stage (rad^2), the sum of squares of the move,
    which tells whether all of it is finite, and the slopes of all stages, body by body.
    """
    slopes: list[list[Coordinates]] = [[f] for f in first] or [[] for _ in x]
    rotation: Number = 0.0
    square: Number = 0.0
    begun = len(slopes[0])
    for n, (row, c) in enumerate(zip(tableau.A[begun:], tableau.c[begun:], strict=True), begun):
        u: list[Coordinates] = []
        for f in slopes:
            z, turned = combination(chart, h, tableau.exponentials(n), f) if any(row) else (origin(chart), 0.0)
            rotation = maximum(turned, rotation)
            u.append(z)
        for f, new in zip(slopes, stage(x, tuple(u), t + float(c) * h), strict=True):
            f.append(new)
    end: list[State] = []
    for body, f in zip(x, slopes, strict=True):
        state_, turned, length = advanced(chart, h, tableau, body, f)
        rotation = maximum(turned, rotation)
        square = square + length
        end.append(state_)
    return tuple(end), rotation, square, slopes


def origin(chart: Chart) -> tuple[float, ...]:
    """The coordinates of x itself."""
    return (0.0,) * chart.size
