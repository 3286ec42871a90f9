"""Every chart is one: what it says of a motion is its derivative. And the same steps come out of it in one kernel or
stage by stage, at the method's order, whatever a mechanism has."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import lienumba
from lienumba.groups import so3
from lienumba.integrators.methods.charts import SE3, R3xSO3
from lienumba.integrators.methods.comparators import COORDINATES
from lienumba.integrators.tracing import step_kernels
from tests.groups.strategies import checked, directions, vectors
from tests.integrators.methods.test_convergence import END, reference
from tests.integrators.tracing.test_work import CRANK, double_pendulum
from tests.laws.rigs import exact, order, pendulum, run
from tests.laws.test_states import KNOWN, LOW_PASS, seen
from tests.rigs.in_charts import BOTH, CHARTS, NONE, numbers, run_in
from tests.rigs.scenarios import BENNETT, LOOP, PENDULUM, scenario

KINDS: dict[str, Any] = {"R3xSO3": R3xSO3(None), "SE3": SE3(None), **COORDINATES}
STEPPED = {name: chart for name, chart in CHARTS.items() if name not in ("R3xSO3", "SE3 closed")}
small = st.floats(-0.3, 0.3)


@st.composite
def elements(draw: st.DrawFn) -> Any:
    """Of S, its rotation away from half a turn and from the gimbal lock."""
    turn = tuple((draw(st.floats(0.0, 1.2)) * draw(directions())).tolist())
    return (*draw(vectors), *so3.exp(turn), *draw(vectors), *draw(vectors))


# ---------------------------------------------------------------- charts
@pytest.mark.parametrize("name", KINDS)
def test_the_slope_is_that_of_the_motion(name: str) -> None:
    chart = KINDS[name]

    @checked
    @given(elements(), st.tuples(*[small] * chart.size), vectors, vectors)
    def check(x: Any, u: Any, dv: Any, dw: Any) -> None:
        """d/dt of the element at u: r' = v, R' = R hat(w), and what is given of v' and w'."""
        at, e = chart.moved(x, u), 1e-5
        f = (*at[12:18], *dv, *dw)
        slope = chart.slope(x, u, at, f)
        ahead, behind = (
            np.array(chart.moved(x, tuple(c + s * du for c, du in zip(u, slope, strict=True)))) for s in (e, -e)
        )
        motion = (*f[0:3], *so3.multiply(at[3:12], so3.hat(f[3:6])), *dv, *dw)
        size = 1.0 + max(map(abs, slope))
        np.testing.assert_allclose((ahead - behind) / (2 * e), motion, rtol=0, atol=1e-8 * size**3)

    check()


@pytest.mark.parametrize("name", KINDS)
def test_zero_coordinates_are_where_it_is(name: str) -> None:
    chart, R = KINDS[name], so3.exp((0.3, -0.7, 0.2))
    x = (0.1, 2.0, -3.0, *R, 0.4, 5.0, -6.0, 0.7, 8.0, -9.0)
    assert len(x) == len(chart.moved(x, (0.0,) * chart.size))
    np.testing.assert_allclose(chart.moved(x, (0.0,) * chart.size), x, rtol=0, atol=4e-15)
    assert chart.rotation((0.0,) * chart.size) == 0.0


@pytest.mark.parametrize("name", KINDS)
def test_composed_coordinates_move_as_one_after_the_other(name: str) -> None:
    """In a vector space they add up."""
    chart, x = KINDS[name], (0.1, 2.0, -3.0, *so3.exp((0.3, -0.7, 0.2)), 0.4, 5.0, -6.0, 0.7, 8.0, -9.0)
    rng = np.random.default_rng(3)
    u, w = (tuple(row.tolist()) for row in rng.uniform(-0.5, 0.5, (2, chart.size)))
    both = chart.composed(u, w)
    if name in COORDINATES:
        assert both == pytest.approx(np.add(u, w), abs=1e-15)
    else:
        np.testing.assert_allclose(chart.moved(x, both), chart.moved(chart.moved(x, u), w), rtol=0, atol=2e-14)


@pytest.mark.parametrize("name", COORDINATES)
def test_a_quarter_of_a_turn_is_not_missed(name: str) -> None:
    """The limit where angles are counted: no turn up to there is larger than what is said of it."""
    chart, rng = COORDINATES[name], np.random.default_rng(5)
    for _ in range(50):
        R, u = so3.exp(tuple(rng.uniform(-1, 1, 3))), tuple(rng.uniform(-0.9, 0.9, 3))
        change = np.subtract(chart.of(so3.multiply(R, so3.exp(u))), chart.of(R))
        said = chart.rotation((0.0,) * 3 + tuple(change.tolist()) + (0.0,) * 6)
        assert said >= so3.dot(u, u) * (1 - 1e-12)


# ---------------------------------------------------------------- orders
@pytest.mark.parametrize(("chart", "projection"), [*((chart, BOTH) for chart in STEPPED), ("SE3", NONE)])
def test_the_order_on_two_skew_links(chart: str, projection: tuple[str, str]) -> None:
    steps = (8e-3, 4e-3)
    ends = [numbers(run_in(STEPPED[chart], PENDULUM, h, END["pendulum"], projection=projection)) for h in steps]
    errors = [np.abs(end - reference("pendulum")).max() for end in ends]
    assert np.log2(errors[0] / errors[1]) == pytest.approx(4, abs=0.2), errors
    assert errors[1] < 1e-5


@pytest.mark.parametrize("name", ["pendulum", "loop"])
def test_order_eight_on_se3(name: str) -> None:
    mechanism, steps = {"pendulum": (PENDULUM, (2e-2, 1e-2)), "loop": (LOOP, (8e-2, 4e-2))}[name]
    ends = [numbers(run_in(CHARTS["SE3"], mechanism, h, END[name], method="dop853")) for h in steps]
    errors = [np.abs(end - reference(name)).max() for end in ends]
    assert np.log2(errors[0] / errors[1]) == pytest.approx(8, abs=0.3), errors


def test_the_order_where_a_joint_is_driven() -> None:
    driven = double_pendulum(drivers=[CRANK])
    truth = numbers(run_in({}, driven, 4e-3, 0.4, method="dop853"))
    for chart in ("SE3", "cf4"):
        errors = [np.abs(numbers(run_in(CHARTS[chart], driven, h, 0.4)) - truth).max() for h in (1e-2, 5e-3)]
        assert np.log2(errors[0] / errors[1]) == pytest.approx(4, abs=0.2), (chart, errors)


@pytest.mark.parametrize("chart", STEPPED)
def test_states_of_laws_move_in_every_chart(chart: str) -> None:
    _, torque, more = KNOWN["low_pass"]
    truth = exact(torque, 1.0, (0.5, 1.0, *LOW_PASS["states"].values()), more=more)
    errors = []
    for h in (0.01, 0.005):
        data = pendulum(LOW_PASS, step=h)
        data["integrator"] |= STEPPED[chart]
        errors.append(np.abs(seen(run(data), LOW_PASS) - truth).max())
    assert order(errors) == pytest.approx(4, abs=0.2), errors


# ---------------------------------------------------------------- stage by stage
@pytest.mark.parametrize("chart", ["SE3", "quaternion", "cf4"])
def test_stage_by_stage_it_is_the_same_step(chart: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """A loop, which holds its accelerations, and laws with states behind a body; other numbers of coordinates."""
    law = pendulum(LOW_PASS, step=0.02, end=0.2)
    law["integrator"] |= STEPPED[chart]

    def ends() -> list[np.ndarray]:
        return [numbers(run_in(STEPPED[chart], LOOP, 2e-3, 0.1)), seen(run(law), LOW_PASS)]

    whole = ends()
    monkeypatch.setattr(step_kernels, "INLINE", 0)
    for a, b in zip(ends(), whole, strict=True):
        np.testing.assert_allclose(a, b, rtol=0, atol=1e-12)


def test_redundant_joints() -> None:
    """Bennett's linkage, where rows are dropped and accelerations are held; it closes with rotations only."""
    lie, se3 = (run_in(CHARTS[chart], BENNETT, 1e-3, 0.05) for chart in ("R3xSO3", "SE3"))
    assert 0 < np.abs(numbers(se3) - numbers(lie)).max() < 1e-9
    data = scenario(BENNETT, 1e-3, 0.1)
    data["integrator"] |= CHARTS["matrix"]
    assert lienumba.run(data)["status"].values.tolist() == [2]
