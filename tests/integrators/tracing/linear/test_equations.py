"""Partial derivatives of the equations of motion, of every element of the registries, in both coordinates: against
central differences of the same equations with fifty digits, and by floats against the equations themselves. A new joint
or force is tested here by its example."""

from dataclasses import replace
from itertools import pairwise
from typing import Any

import mpmath as mp
import numpy as np
import pytest

from lienumba.compiler import tape
from lienumba.compiler.derivatives import partials
from lienumba.compiler.series import FUNCTIONS
from lienumba.compiler.symbols import Graph
from lienumba.integrators.methods.charts import JOINT
from lienumba.integrators.tracing.joint.tracer import JointTracer
from lienumba.integrators.tracing.linear.equations import Equations
from lienumba.integrators.tracing.method import Method
from lienumba.integrators.tracing.row_selection import UNIQUE
from lienumba.integrators.tracing.template import split
from lienumba.integrators.tracing.tracer import Tracer
from lienumba.mechanics.tree.motion import read_state
from lienumba.numerics.operations import sqrt, where
from lienumba.numerics.vector_math import ROUND
from lienumba.scenario.start.prepare import Prepared, prepare
from tests.facade import JOINTS, Model, resolve
from tests.mechanics.elements.forces.test_every_type import TYPES, keys_of
from tests.mechanics.elements.forces.test_every_type import scenario as with_force
from tests.rigs.every_law import DRIVERS, alone

H = mp.mpf(10) ** -16
COORDINATES = ["lie", JOINT]
MANY_DIGITS = FUNCTIONS | {name: getattr(mp, name) for name in ("sin", "cos", "exp", "log", "sqrt", "tanh", "atan2")}
MANY_DIGITS |= {
    "+": lambda a, b: mp.nint(a + b) if ROUND in (abs(a), abs(b)) else a + b,  # what leaves whole numbers to a double
    "fma": lambda a, b, c: mp.nint(a * b + c) if abs(c) == ROUND else a * b + c,
}


def with_law() -> dict[str, Any]:
    """A body that falls while a law with a state of its own turns it."""

    def sway(body: Any, states: Any, gain: Any, t: Any) -> Any:
        lagging = gain * states.lag * states.lag
        push = body.force((lagging, 0.0, body.velocity[1] * body.position[2]), at=(0.1, 0.2, 0.0))
        return [push, body.torque((0.0, t * body.angular_velocity[0], lagging), frame="body")], [
            body.velocity[0] - 3.0 * states.lag
        ]

    body = {
        "name": "b",
        "mass": 2.0,
        "inertia": [0.5, 0.6, 0.7],
        "position": [0.1, 0.2, 0.3],
        "rotation": {"axis": [1, 1, 0], "angle": 0.4},
        "velocity": [1, 2, 3],
        "angular_velocity": [0.3, 0.2, 0.1],
    }
    force = {
        "name": "sway",
        "type": "python",
        "function": sway,
        "bodies": ["b"],
        "states": {"lag": 0.7},
        "parameters": {"gain": 1.5},
    }
    return {"model": {"bodies": [body], "forces": [force]}, "integrator": {"step": 1e-3, "end_time": 0.1}}  # fmt: skip


def scenarios() -> dict[str, dict[str, Any]]:
    short = {"integrator": {"step": 1e-3, "end_time": 0.1}}
    found = {f"joint {name}": JOINTS[name].example() | short for name in JOINTS}
    found |= {f"force {name}": with_force(keys_of(name)) for name in TYPES}
    found |= {f"driver {n}": alone("drivers", n)[0] for n in range(len(DRIVERS))}
    return found | {"force python": with_law()}


CASES = scenarios()


def rows(tracer: Tracer, prepared: Prepared) -> list[float]:
    """Of the state of the first run."""
    bodies = np.reshape(prepared.states[0], (-1, 18))
    laws = tracer.law_states.initial(prepared.model)
    if isinstance(tracer, JointTracer):
        tree = tracer.tree(prepared.model)
        elements = [*read_state(prepared.model, tree, [tuple(x.tolist()) for x in bodies])]
        elements += tracer.law_states.together(laws)
    else:
        elements = [*bodies.ravel(), *(x for element in tracer.law_states.placed(laws) for x in element)]
    augmented = tracer.augmented.start(prepared.angles, UNIQUE, 1)[0]
    return [float(np.ravel(x)[0]) for x in (*elements, *augmented)]


def traced(case: str, way: str) -> tuple[Tracer, Prepared, list[float], list[float]]:
    """The tracer, what it is of, a state that moves, and the numbers of the model."""
    resolved = resolve(CASES[case], allow_code=True)
    prepared = prepare(resolved, resolved.labels[:1])
    template, numbers = split(prepared.model)
    made = JointTracer if way == JOINT else Tracer
    tracer = made(template, Method("rk4", "none", "none", coordinates=way), UNIQUE, False)
    state = rows(tracer, prepared)
    rng = np.random.default_rng(3)
    for row in tracer.velocity_rows(tracer.graph()[1]):
        state[row] += 0.3 * rng.standard_normal()
    return tracer, prepared, state, [float(np.ravel(x)[0]) for x in numbers]


def moved(tracer: Tracer, model: Model, state: list[Any], u: list[Any]) -> list[Any]:
    """The rows of the state at the local coordinates u of all elements."""
    chart, found = tracer.chart_of(model), list(state)
    for n in range(tracer.moving_elements):
        own = slice(n * tracer.element, (n + 1) * tracer.element)
        found[own] = chart.moved(tuple(state[own]), tuple(u[n * chart.size : (n + 1) * chart.size]))
    return found


@pytest.mark.parametrize("way", COORDINATES)
@pytest.mark.parametrize("case", CASES)
def test_partial_derivatives_are_the_slopes_of_the_equations(
    case: str, way: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Along a random direction of all unknowns at once."""
    tracer, prepared, state, numbers = traced(case, way)
    equations, rng = Equations.of(tracer), np.random.default_rng(8)
    by = equations.columns
    a, mu = rng.standard_normal(len(by["a"])), rng.standard_normal(len(by["mu"]))
    found = equations.at(state, 0.3, a, mu, numbers.__getitem__)
    matrix = np.zeros((len(found.along + found.rows + found.laws), sum(map(len, by.values()))))
    for place, x in found.entries.items():
        matrix[place] = x
    along = rng.standard_normal(matrix.shape[1])
    places, velocities = tracer.coordinates
    elements, size = range(tracer.moving_elements), tracer.chart_of(prepared.model).size
    u = np.zeros(size * len(elements))
    u[[e * size + n for e in elements for n in places]] = along[by["q"]]
    u[[e * size + n for e in elements for n in velocities]] = along[by["v"]]
    values, ends = replace(equations, entries={}), []
    monkeypatch.setattr(tape, "FUNCTIONS", MANY_DIGITS)
    with mp.workdps(50):
        for h in (H, -H):
            there = moved(tracer, prepared.model, [mp.mpf(x) for x in state], [h * x for x in u.tolist()])
            for row, column in zip(tracer.law_rows(), by["laws"], strict=False):
                there[row] += h * along[column]
            shifted = [
                [x + h * dx for x, dx in zip(own, along[by[of]], strict=True)] for of, own in (("a", a), ("mu", mu))
            ]
            end = values.at(there, mp.mpf(0.3), *shifted, lambda row: mp.mpf(numbers[row]))
            ends.append([*end.along, *end.rows, *end.laws])
        slope = np.array([float((x - y) / (2 * H)) for x, y in zip(*ends, strict=True)])
    scale = np.abs(matrix) @ np.abs(along) + 1e-3 * np.abs(matrix).max()
    assert np.all(np.abs(slope - matrix @ along) <= 1e-12 * scale)


@pytest.mark.parametrize("way", COORDINATES)
@pytest.mark.parametrize("case", ["joint screw", "force bushing", "force python"])
def test_the_equations_are_left_nothing_by_the_accelerations_that_solve_them(case: str, way: str) -> None:
    tracer, prepared, state, numbers = traced(case, way)
    equations = Equations.of(tracer)
    sizes = [len(equations.columns[name]) for name in ("a", "mu")]
    there = (state, 0.3, *np.split(np.zeros(sum(sizes)), sizes[:1]), numbers.__getitem__)
    at_rest, part = equations.at(*there), equations.only(("a",), ("rows",)).at(*there)
    assert list(part.values) == ["rows"]
    assert (part.rows, part.block("rows", "a")) == (at_rest.rows, at_rest.block("rows", "a"))
    matrix = np.zeros((sum(sizes), sum(sizes)))
    for rows, first in (("along", 0), ("rows", sizes[0])):
        for columns, behind in (("a", 0), ("mu", sizes[0])):
            for (i, j), x in at_rest.block(rows, columns).items():
                matrix[first + i, behind + j] = x
    a = -np.linalg.solve(matrix, [*at_rest.along, *at_rest.rows])[: sizes[0]]
    ends = [n * tracer.element for n in range(tracer.elements + 1)]
    elements = [tuple(state[first:end]) for first, end in pairwise(ends)]
    posture = tracer.posture(prepared.model, elements, state[ends[-1] :], 0.3)
    F, _ = tracer.moving(prepared.model, posture, [1.0] * tracer.structure.rows, None)
    rates = tracer.rates(prepared.model, elements, F)
    expected = [rates[row] for row in tracer.velocity_rows(prepared.model)]
    np.testing.assert_allclose(a, [float(np.ravel(x)[0]) for x in expected], rtol=1e-9, atol=1e-9)


def test_nothing_that_where_does_not_choose_gets_into_a_derivative() -> None:
    graph = Graph(analytic=True)
    x = graph.input("x", 0)
    y = where(x > 1.0, 3.0 * x, where(x > 0.0, sqrt(x) * x, x * x))
    for at, slope in ((2.0, 3.0), (0.25, 0.75), (0.0, 0.0), (-1.0, -2.0)):
        found = partials([y, 2.0 * y], [{x: 1.0}])
        np.testing.assert_array_equal(tape.replayed([*found.values()], lambda *_: at), [slope, 2.0 * slope])  # noqa: B023
