"""Where the series of dexpinv may be cut: a method of order p needs ad^j up to j = p - 2, and cut before it falls to
the order of the first term that is missing. On the heavy top against its exact motion; odd Bernoulli numbers are 0."""

import numpy as np
import pytest

import lienumba
from tests.facade import METHODS
from tests.rigs.scenarios import TOP, exact_top, scenario, state_at

END = 0.1
STEPS = {"rk4": (5e-4, 2.5e-4), "dp54": (5e-4, 2.5e-4), "dop853": (2.5e-3, 1.25e-3)}
ORDERS = {  # by the number of terms
    "rk4": {0: 2, 2: 4, "closed": 4},
    "dp54": {0: 2, 1: 3, 2: 5, 3: 5, "closed": 5},
    "dop853": {0: 2, 1: 3, 2: 5, 3: 5, 4: 7, 5: 7, 6: 8, "closed": 8},
}


def flat(state):
    return np.concatenate([np.ravel(part) for part in state])


def end(method, step, terms=None):
    data = scenario(TOP, step, END, method=method, projection=("none", "none"))
    data["integrator"] |= {} if terms is None else {"dexpinv": terms}
    return flat(state_at(lienumba.run(data).isel(run=0)))


@pytest.mark.parametrize(("method", "terms"), [(m, n) for m, orders in ORDERS.items() for n in orders])
def test_a_cut_costs_what_it_should(method, terms):
    top = exact_top(END)
    exact = flat((top.r, top.R, top.v, top.omega))
    errors = [np.abs(end(method, step, terms) - exact).max() for step in STEPS[method]]
    assert np.log2(errors[0] / errors[1]) == pytest.approx(ORDERS[method][terms], abs=0.2), errors


@pytest.mark.parametrize("method", ["rk4", "dop853"])
def test_by_default_it_is_cut_where_the_method_no_longer_sees_it(method):
    step = STEPS[method][0]
    assert (end(method, step, METHODS[method].order - 2) == end(method, step)).all()
