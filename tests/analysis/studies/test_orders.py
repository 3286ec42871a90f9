"""Observed orders: of methods that have them by theory, and of errors made up."""

import numpy as np
import pytest
from scipy import stats
from scipy.optimize import curve_fit

import lienumba
from lienumba.analysis import orders, work_precision
from lienumba.analysis.studies.orders import fit
from lienumba.store.study_layout import Coordinate
from tests.facade import METHODS as REGISTERED
from tests.rigs.made_studies import METHODS, STEPS, study
from tests.rigs.studies import top

H = 0.1 / 2.0 ** np.arange(8)
NONE = np.zeros(len(H))


def test_methods_show_their_orders():
    names = ["euler", "heun", "kutta3", "rk4"]
    grid = {"integrator.step": [1e-3, 5e-4, 2.5e-4, 1.25e-4], "integrator.method": names}
    found = orders(lienumba.run(top(grid, output={"times": [0.0, 0.02, 0.04]})))
    assert found["order"].dims == ("error", "method")
    assert found["error"].values.tolist() == ["position", "rotation", "velocity", "angular_velocity"]
    for method in names:
        one = found.sel({"method": method})
        np.testing.assert_allclose(one["order"], REGISTERED[method].order, atol=0.2)
        assert (one["low"] < one["order"]).all()
        assert (one["high"] - one["low"] < 0.5).all()
        assert (one["points"] >= 3).all()
    np.testing.assert_allclose(found["finest"], 1.25e-4)


def test_the_law_is_found_as_by_nonlinear_least_squares():
    rng = np.random.default_rng(3)
    errors = 7.0 * H**4 * np.exp(3.0 * H + 0.05 * rng.standard_normal(len(H)))
    found = fit(H, errors, NONE)
    (_, order, _), covariance = curve_fit(lambda h, a, p, b: a + p * np.log(h) + b * h, H, np.log(errors))
    half = stats.t.ppf(0.975, len(H) - 3) * covariance[1, 1] ** 0.5
    assert found.points == len(H)
    assert found.order == pytest.approx(order, rel=1e-6)
    assert (found.low, found.high) == pytest.approx((order - half, order + half), rel=1e-6)
    assert (found.finest, found.coarsest) == (H[-1], H[0])


def test_three_points_are_a_line():
    errors = np.array([1.1, 1.0, 0.95]) * H[:3] ** 2
    found, known = fit(H[:3], errors, NONE[:3]), stats.linregress(np.log(H[:3]), np.log(errors))
    half = stats.t.ppf(0.975, 1) * known.stderr
    assert (found.low, found.order, found.high) == pytest.approx((known.slope - half, known.slope, known.slope + half))


@pytest.mark.parametrize(("points", "least", "most"), [(3, 0.935, 0.965), (4, 0.88, 0.965), (6, 0.85, 0.965)])
def test_the_interval_holds_the_order_as_often_as_it_says(points, least, most):
    """With three points in 95 %; where a range is to be found, and all scatter is chance, in nearly 90 %."""
    rng, h = np.random.default_rng(points), H[:points]
    fits = [fit(h, h**3 * np.exp(0.1 * rng.standard_normal(points)), 0.0 * h) for _ in range(1500)]
    held = np.mean([one.low <= 3.0 <= one.high for one in fits])
    assert least < held < most
    assert np.mean([one.points for one in fits]) > 0.9 * points


def test_the_range_ends_where_steps_are_too_coarse():
    found = fit(H, H**4 * (1.0 + (H / 0.02) ** 3), NONE)  # the second term takes over at 0.02
    assert found.coarsest < 0.02
    assert found.order == pytest.approx(4.0, abs=0.1)
    saturated = fit(H, np.minimum(1e6 * H**4, 3.0), NONE)
    assert saturated.order == pytest.approx(4.0, abs=1e-6)
    assert saturated.coarsest == H[H < 0.04][0]


def test_the_next_term_of_the_error_is_no_order():
    found = fit(H[:4], H[:4] ** 5 * (1.0 + 4.0 * H[:4]), NONE[:4])
    slopes = np.log2(H[:3] ** 5 * (1.0 + 4.0 * H[:3]) / (H[1:4] ** 5 * (1.0 + 4.0 * H[1:4])))
    assert slopes.min() > 5.06
    assert found.order == pytest.approx(5.0, abs=0.05)


def test_errors_that_the_reference_cannot_tell_are_left_out():
    floor = np.full(len(H), 1e-9)
    found = fit(H, H**4 + 3e-9, floor)
    assert found.finest == H[(H**4 > 1e-7)][-1]
    assert found.order == pytest.approx(4.0, abs=0.05)
    nothing = fit(H, 0.0 * H, NONE)
    assert (nothing.points, np.isnan(nothing.order)) == (0, True)


def test_two_points_have_an_order_but_no_interval():
    found = fit(H[:2], H[:2] ** 2, NONE[:2])
    assert found.order == pytest.approx(2.0)
    assert np.isnan([found.low, found.high]).all()
    assert np.isnan(fit(H[:1], H[:1], NONE[:1]).order)
    assert np.isnan(fit(np.array([0.1, 0.1]), H[:2], NONE[:2]).order)  # one step is none


def test_medians_over_the_runs_that_succeed_somewhere():
    errors = np.array(STEPS) ** 2 * np.array([1.0, 2.0, 300.0, 5.0])[:, None, None] * np.ones((1, 2, 1))
    status = np.zeros(errors.shape, int)
    status[2] = 5  # never began
    status[1, 1, 0] = 1  # fails where the step is coarse
    found = orders(study(errors, status=status))
    np.testing.assert_allclose(found["order"], 2.0, rtol=1e-9)
    assert found["points"].sel(error="position").values.tolist() == [4, 3]
    assert found["coarsest"].sel(error="position").values == pytest.approx([0.08, 0.04])
    costs = work_precision(study(errors, status=status))
    assert costs["position_error"].dims == ("method", "step")
    np.testing.assert_allclose(costs["position_error"].sel({"method": "first"}), 2.0 * np.array(STEPS) ** 2)
    assert costs["failed"].values.tolist() == [[1, 1, 1, 1], [2, 1, 1, 1]]
    assert costs["evaluations"].sel({"method": "first"}).values.tolist() == [40, 80, 160, 320]
    assert costs["time_per_run"].attrs["units"] == "s"
    nowhere = work_precision(study(errors, status=3))
    assert nowhere["position_error"].isnull().all()
    assert orders(study(errors, status=3))["order"].isnull().all()


def test_cases_become_curves():
    steps, tolerances = [0.2, 0.1, 0.05, np.nan, np.nan, np.nan], [*[np.nan] * 3, 1e-2, 1e-4, 1e-6]
    grid = [
        Coordinate("method", "case", ["rk4"] * 6, "1", "integrator.method"),
        Coordinate("step", "case", steps, "s", "integrator.step"),
        Coordinate("tolerance", "case", tolerances, "1", "integrator.tolerance"),
    ]
    mean = np.array([0.2, 0.1, 0.05, 0.2, 0.1, 0.05])
    found = orders(study([np.where(np.isnan(tolerances), mean**4, mean**5)], grid, mean))
    assert found["order"].dims == ("error", "curve")
    assert found["method"].values.tolist() == ["rk4", "rk4"]
    assert found["along"].values.tolist() == ["step", "tolerance"]
    np.testing.assert_allclose(found["order"].sel(error="velocity"), [4.0, 5.0])


def test_one_curve_has_no_dimension():
    found = orders(study([np.array(STEPS) ** 3], [Coordinate("step", "step", STEPS, "s", "integrator.step")]))
    assert found["order"].dims == ("error",)
    assert found["order"].attrs == {"units": "1", "long_name": "observed order"}


def test_what_is_no_study_is_refused():
    with pytest.raises(lienumba.ScenarioError, match=r"^the dataset is not that of a study; "):
        work_precision(lienumba.run(top()))
    grid = [Coordinate("method", "method", METHODS, "1", "integrator.method")]
    with pytest.raises(lienumba.ScenarioError, match=r"^the study has no grid over integrator.step or integrator.tol"):
        orders(study([[1.0, 2.0]], grid, [0.1, 0.1]))
