"""Steps land on the points of tables: the order is kept, the bits do not depend on the company.

A rod on a hinge, pushed about it by a table; between the points the truth is smooth, and SciPy starts anew at each.
"""

import copy
from functools import cache
from itertools import pairwise
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline

import lienumba
from lienumba.batch.integrate import discontinuities
from lienumba.integrators.tracing import step_kernels
from lienumba.mechanics.system.discontinuities import Discontinuity
from tests.facade import METHODS
from tests.rigs.scenarios import chain

M, L, J, G = 1.5, 0.4, 0.02, 9.81
END = 0.64
TIMES = [-0.1, 0.0313, 0.1, 0.1771, 0.25, 0.2731, 0.3937, 0.5113, 0.63, 0.9]
VALUES = [0.0, 6.0, -5.0, 3.0, 8.0, -4.0, 0.0, 7.0, -2.0, 1.0]
ROD: dict[str, Any] = {
    "model": {
        "bodies": [{"name": "rod", "mass": M, "inertia": [J, J, J], "angular_velocity": [0, 4, 0],
                    "rotation": {"axis": [0, 1, 0], "angle": 1.0}}],
        "joints": [{"name": "hinge", "type": "revolute", "bodies": ["ground", "rod"],
                    "points": [[0, 0, 0], [0, 0, L]], "axes": [[0, 1, 0], [0, 1, 0]]}],
        "forces": [{"name": "motor", "type": "torque", "body": "rod", "value": [0, "2*push(t)", 0]}],
    },
}  # fmt: skip


def rod(step: float, kind: str, *, value: str = "2*push(t)", times: Any = TIMES, values: Any = VALUES, **sections: Any):
    data = copy.deepcopy(ROD)
    data["model"]["forces"][0]["value"][1] = value
    table = {"times": list(times), "values": list(values), "interpolation": kind, "outside": "hold"}
    data["tables"] = {"push": table}
    data["integrator"] = {"step": step, "end_time": END}
    return data | {"output": {"every": END / 4}} | sections


def run(data: dict[str, Any], **options: Any) -> Any:
    dataset = lienumba.run(data, **{"workers": 1, **options})
    assert (dataset.status == 0).all()
    return dataset


def motion(ds: Any) -> np.ndarray:
    """Angle and rate of every run (runs, times, 2), but for the start."""
    R = ds.rotation.values[:, 1:, 0]
    return np.stack([np.arctan2(R[..., 0, 2], R[..., 0, 0]), ds.angular_velocity.values[:, 1:, 0, 1]], axis=2)


def off(ds: Any, *truths: Any) -> np.ndarray:
    """How far every run is from its truth (times, 2) at most, the rate by that of its swing."""
    return np.linalg.norm((motion(ds) - np.array(truths)) * [1.0, 0.2], axis=2).max(axis=1)


def solved(rates: Any, cuts: Any) -> np.ndarray:
    """Angle and rate after each quarter of the run (4, 2); rates(t, y, the middle of the piece)."""
    every = sorted({0.0, END, *(n * END / 4 for n in range(1, 4)), *(t for t in cuts if 0 < t < END)})
    y, found = [1.0, 4.0], {}
    for a, b in pairwise(every):
        y = solve_ivp(rates, (a, b), y, "DOP853", args=(0.5 * (a + b),), rtol=1e-13, atol=1e-13).y[:, -1]
        found[b] = y
    return np.array([found[n * END / 4] for n in range(1, 5)])


def swing(y: Any, torque: float) -> list[float]:
    return [y[1], (torque - M * G * L * np.sin(y[0])) / (J + M * L * L)]


def piecewise(kind: str, times: Any, values: Any):
    """The function of t that a table is, in front of and behind the points too; t tells the piece by `within`."""
    x, y = np.array(times), np.array(values)

    def f(t: float, within: float) -> float:
        n = int(np.searchsorted(x, within, side="right")) - 1
        if not 0 <= n < len(x) - 1:
            return float(y[0] if n < 0 else y[-1])
        return float(y[n] + (kind == "linear") * (y[n + 1] - y[n]) / (x[n + 1] - x[n]) * (t - x[n]))

    return f


@cache
def exact(kind: str, delay: float = 0.0, scale: float = 2.0, times: Any = None, values: Any = None) -> np.ndarray:
    """The motion under scale*push(t - delay): smooth pieces, one after the other."""
    times, values = times or tuple(TIMES), values or tuple(VALUES)
    f = piecewise(kind, times, values)
    return solved(lambda t, y, within: swing(y, scale * f(t - delay, within - delay)), [t + delay for t in times])


STEPS = {1: 4e-4, 2: 2e-3, 3: 4e-3, 4: 4e-3}


@pytest.mark.parametrize("method", ["euler", "heun", "kutta3", "rk4"])
@pytest.mark.parametrize("kind", ["hold", "linear"])
def test_the_order_is_kept(kind, method):
    order = METHODS[method].order
    errors = []
    for halvings in range(3):
        data = rod(STEPS[order] / 2**halvings, kind)
        data["integrator"]["method"] = method
        errors += off(run(data), exact(kind)).tolist()
    assert np.log2(errors[0] / errors[2]) / 2 == pytest.approx(order, abs=0.2), errors


SPLINE = [0.0313, 0.1, 0.2, 0.33, 0.45, 0.9], [0.0, 6.0, -5.0, 3.0, 8.0, -4.0]


@pytest.mark.parametrize(("value", "a", "b"), [("2*push(t)", 0.0, 1.0), ("2*push(0.45*t - 0.1)", -0.1, 0.45)])
def test_a_spline_bends_at_its_ends_alone(value, a, b):
    """Its third derivative jumps at its points, which costs no order, but makes the errors less regular."""
    spline = CubicSpline(*SPLINE)
    start = SPLINE[0][0]

    def push(t: float, within: float) -> float:
        return float(spline(a + b * t)) if a + b * within > start else SPLINE[1][0]

    truth = solved(lambda t, y, within: swing(y, 2 * push(t, within)), [(x - a) / b for x in SPLINE[0]])
    errors = [
        off(run(rod(h, "cubic", value=value, times=SPLINE[0], values=SPLINE[1])), truth)[0] for h in (0.016, 1e-3)
    ]
    assert np.log2(errors[0] / errors[1]) > 4 * 3.5


@pytest.mark.parametrize("step", [1e-3, 0.01, 0.02])
def test_a_spline_whose_points_are_denser_than_the_steps(step):
    """Measured, with noise, at every millisecond."""
    times = np.linspace(0, 1, 1001)
    values = np.sin(7 * times) + 0.1 * np.random.default_rng(0).standard_normal(1001)
    spline = CubicSpline(times, values)
    truth = solved(lambda t, y, _: swing(y, 2 * float(spline(t))), [])
    assert off(run(rod(step, "cubic", times=times, values=values)), truth)[0] < 0.02


def curved(times: Any, values: Any, value: str, f: Any) -> float:
    """How far a run is off whose table is read at 0.5*t + t**2; f: what is made of the table's value."""
    with pytest.warns(
        UserWarning, match="steps cannot land on the points of push, because its argument is no straight"
    ):
        ds = run(rod(2e-3, "linear", value=value, times=times, values=values))
    read, cuts = piecewise("linear", times, values), [-0.25 + np.sqrt(0.0625 + x) for x in times if x > 0]
    truth = solved(lambda t, y, s: swing(y, f(read(0.5 * t + t**2, 0.5 * s + s**2))), cuts)
    return float(off(ds, truth)[0])


def test_an_argument_that_is_no_straight_line_is_told():
    assert curved(TIMES, VALUES, "2*push(0.5*t + t**2)", lambda x: 2 * x) < 2e-3


def test_nothing_beyond_the_values_of_a_table_is_read():
    """A valve that closes within 0.1 ms: the root of what is below 0 is no number."""
    closing = [0, 0.18845, 0.18855, 2], [1.0, 1.0, 0.0, 0.0]
    assert curved(*closing, "2*sqrt(push(0.5*t + t**2))", lambda x: 2 * np.sqrt(abs(x))) < 1e-2


DELAYS = {"parameters.delay": {"distribution": "uniform", "low": -0.05, "high": 0.2},
          "parameters.scale": {"distribution": "uniform", "low": 0.5, "high": 2.0}}  # fmt: skip


def delayed(step: float, kind: str, runs: int = 11, **sections: Any) -> dict[str, Any]:
    data = rod(step, kind, value="scale*push(t - delay)", **sections)
    return data | {"parameters": {"delay": 0.01, "scale": 2}, "sweep": {"runs": runs, "seed": 4, "vary": DELAYS}}


@pytest.mark.parametrize("kind", ["hold", "linear"])
def test_every_run_lands_where_its_own_table_is(kind):
    coarse, fine = (run(delayed(step, kind)) for step in (4e-3, 1e-3))
    delays, scales = coarse["parameters.delay"].values, coarse["parameters.scale"].values
    assert len(set(delays)) == 11
    truths = [exact(kind, d, s) for d, s in zip(delays, scales, strict=True)]
    np.testing.assert_allclose(np.log2(off(coarse, *truths) / off(fine, *truths)) / 2, 4, atol=0.2)


@pytest.mark.parametrize("staged", [False, True])
@pytest.mark.parametrize("kind", ["hold", "linear"])
def test_no_bit_depends_on_the_company(kind, staged, monkeypatch):
    """Neighbours that land elsewhere, workers, chunks: a run is the same alone."""
    if staged:
        monkeypatch.setattr(step_kernels, "INLINE", 0)
    sections = {"output": {"every": 0.16}}
    whole = run(delayed(0.02, kind, 19, **sections))
    others = [
        run(delayed(0.02, kind, 19, **sections), workers=3),
        run(delayed(0.02, kind, 19, **sections), runs=[17, 3]),
    ]
    others += [run(delayed(0.02, kind, 19, **sections), runs=[n]) for n in (0, 9, 18)]
    for other in others:
        labels = other.run.values
        for name in ("position", "rotation", "angular_velocity", "work", "joint_force", "position_iterations"):
            np.testing.assert_array_equal(other[name], whole[name].sel(run=labels), err_msg=name)
    delay, scale = (float(whole[f"parameters.{name}"][9]) for name in ("delay", "scale"))
    written = rod(0.02, kind, value=f"{scale!r}*push(t - {delay!r})", **sections)
    np.testing.assert_allclose(run(written).position[0], whole.position[9], rtol=0, atol=1e-13)


@pytest.mark.parametrize("kind", ["hold", "linear"])
def test_stage_by_stage_lands_alike(kind, monkeypatch):
    whole = run(delayed(0.02, kind))
    monkeypatch.setattr(step_kernels, "INLINE", 0)
    np.testing.assert_allclose(motion(run(delayed(0.02, kind))), motion(whole), rtol=0, atol=1e-12)


@pytest.mark.parametrize("kind", ["hold", "linear"])
def test_a_large_mechanism_keeps_the_order(kind):
    """Five links take more than one kernel; steps against steps a quarter as long."""

    def places(step: float) -> np.ndarray:
        data = chain(5)
        data["model"]["forces"] = [{"type": "torque", "body": "link2", "value": [0, "0.3*push(t)", "0.1*push(t)"]}]
        data["tables"] = {"push": {"times": [t / 4 for t in TIMES], "values": VALUES, "interpolation": kind}}
        data["integrator"] = {"step": step, "end_time": 0.16}
        return run(data | {"output": {"times": [0.16]}}).position.values[0, -1]

    x = [places(step) for step in (2e-3, 1e-3, 5e-4)]
    assert np.log2(np.abs(x[0] - x[1]).max() / np.abs(x[1] - x[2]).max()) == pytest.approx(4, abs=0.25)


def test_points_on_the_ends_of_steps_cut_nothing():
    """A table whose points are ends of steps but for rounding: the same steps as without them."""
    h = 0.02
    ends = np.arange(33) * h
    near = ends * (1 + 2e-16 * np.resize([1, -1, 0, 3, -2], 33))
    values = np.sin(7 * ends)
    for kind in ("hold", "linear"):
        one, two = (run(rod(h, kind, times=x, values=values)) for x in (ends, near))
        np.testing.assert_allclose(motion(two), motion(one), rtol=0, atol=1e-14)
        assert off(one, exact(kind, times=tuple(ends), values=tuple(values)))[0] < 1e-5
        plain = run(rod(h, kind, times=[0, 1], values=[1, 1]))
        flat = run(rod(h, kind, times=near, values=np.ones(33)))
        np.testing.assert_allclose(motion(flat), motion(plain), rtol=0, atol=1e-13)
        assert (flat.steps == 32).all()


def test_what_the_driver_gets():
    """Ends of steps to the bit where points are near; nothing from outside the run; each lane's own, ascending."""
    shared = Discontinuity(np.array([0.1 + 1e-16, 0.3 - 2e-12, -0.1, 0.9]))
    own = [Discontinuity(np.array([0.0]), -np.array(times)) for times in ([0.25, np.nan, 2e-12], [0.0, 0.05, 0.5])]
    times = discontinuities(SimpleNamespace(discontinuities=(shared, *own), h=0.1, end=0.5), slice(0, 3), 1)[0, :, :3]
    inf = np.inf
    assert times.T.tolist() == [
        [0.1, 0.25, 3 * 0.1, inf, inf],
        [0.05, 0.1, 3 * 0.1, inf, inf],
        [0.0, 0.1, 3 * 0.1, 0.5, inf],
    ]


def test_a_step_jumps_where_it_should_not_one_step_later():
    """A short kick: what is before it feels nothing, the rate after it is known."""
    data = rod(1e-3, "hold", times=[0, 0.3, 0.31, 1], values=[0, 50.0, 0, 0], output={"every": 0.01})
    data["model"]["gravity"] = [0, 0, 0]
    rate = run(data).angular_velocity.values[0, :, 0, 1]
    np.testing.assert_allclose(rate[:31], 4, rtol=1e-9)
    np.testing.assert_allclose(rate[31:], 4 + 100 * 0.01 / (J + M * L * L), rtol=1e-8)


@pytest.mark.parametrize("kind", ["hold", "linear"])
def test_five_thousand_rows(kind):
    """More points than steps: every step is cut into pieces, of a noise."""
    rng = np.random.default_rng(8)
    times = np.cumsum(rng.uniform(0.2, 1.0, 5000))
    times *= END / times[-1] * 1.01
    values = rng.standard_normal(5000)
    ds = run(rod(0.02, kind, times=times, values=values))
    assert ds.steps == 32
    f = np.repeat(values[:-1], 2) if kind == "hold" else np.c_[values[:-1], values[1:]].ravel()
    fine = np.c_[times[:-1], times[1:]].ravel()
    assert off(ds, by_rk4(fine, f, [n * END / 4 for n in range(1, 5)]))[0] < 1e-8


def by_rk4(times: np.ndarray, values: np.ndarray, ends: list[float]) -> np.ndarray:
    """The rod under torques that are straight between pairs of points, a step of RK4 in each piece; at these times."""
    y, found = np.array([1.0, 4.0]), {}
    pairs = [
        (0.0, times[0], values[0], values[0]),
        *zip(times[::2], times[1::2], values[::2], values[1::2], strict=True),
    ]
    for a, b, p, q in pairs:
        for c, d in pairwise([a, *(end for end in ends if a < end < b), b]):
            h, middle = d - c, 0.5 * (c + d)
            left, between, right = (2 * (p + (q - p) * (x - a) / (b - a)) for x in (c, middle, d))
            k1 = np.array(swing(y, left))
            k2 = np.array(swing(y + h / 2 * k1, between))
            k3 = np.array(swing(y + h / 2 * k2, between))
            y = y + h / 6 * (k1 + 2 * k2 + 2 * k3 + swing(y + h * k3, right))
            found[d] = y
    return np.array([found[end] for end in ends])
