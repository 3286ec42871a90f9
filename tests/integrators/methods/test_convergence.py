"""The measured order of every method: on the heavy top against its exact motion, on a constrained double pendulum
and on a loop with rods against SciPy's DOP853 on the naive twin's equations. All with projection, the top without."""

from functools import cache
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from tests.facade import METHODS
from tests.oracles.reference import naive
from tests.rigs.scenarios import LOOP, PENDULUM, TOP, exact_top, scenario, simulate, state_at, twin_of

PROJECTIONS = [("none", "none"), ("local", "mass")]
END = {"top": 0.1, "pendulum": 0.32, "loop": 0.32}
MECHANISMS = {"top": TOP, "pendulum": PENDULUM, "loop": LOOP}
STEPS: dict[str, dict[int | str, float]] = {  # the coarsest, in the asymptotic range, by order or method
    "top": {1: 1e-5, 2: 2e-4, 3: 5e-4, 4: 1e-3, "dp54": 1e-3, "dop853": 2e-2, "taylor": 3.125e-3},
    "pendulum": {1: 1e-4, 2: 2e-3, 3: 4e-3, 4: 8e-3, "dp54": 8e-3, "tsit54": 4e-3, "dop853": 2e-2},
    "loop": {1: 1e-4, 2: 2e-3, 3: 4e-3, 4: 8e-3, "dp54": 8e-3},
}
CASES = [
    (name, method)
    for name, steps in STEPS.items()
    for method, tableau in METHODS.items()
    if method in steps or tableau.order in steps
]


def flat(state: Any) -> np.ndarray:
    return np.concatenate([np.ravel(part) for part in state])


@cache
def reference(name: str) -> np.ndarray:
    """The state at the end, exact to about 1e-11."""
    if name == "top":
        exact = exact_top(END[name])
        return flat((exact.r, exact.R, exact.v, exact.omega))
    twin, start = twin_of(scenario(MECHANISMS[name], 1e-3, END[name]))
    k = len(start[0])

    def rate(_: float, y: np.ndarray) -> np.ndarray:
        r, R, v, w = (part.reshape(shape) for part, shape in zip(
            np.split(y, (3 * k, 12 * k, 15 * k)), ((k, 3), (k, 3, 3), (k, 3), (k, 3)), strict=True))  # fmt: skip
        a, _ = naive.accelerations(*twin, r, R, v, w)
        turning = [Ri @ naive.hat(wi) for Ri, wi in zip(R, w, strict=True)]
        return flat((v, turning, a[:, :3], a[:, 3:]))

    return solve_ivp(rate, (0, END[name]), flat(start), "DOP853", rtol=1e-13, atol=1e-13).y[:, -1]


@pytest.mark.parametrize(
    ("name", "method", "projection"),
    [(*case, p) for case in CASES for p in PROJECTIONS if case[0] == "top" or p != ("none", "none")],
    ids=lambda x: "+".join(x) if isinstance(x, tuple) else x,
)
def test_measured_order(name: str, method: str, projection: tuple[str, str]) -> None:
    order, exact = METHODS[method].order, reference(name)
    errors = []
    for halvings in range(3 if name == "top" else 2):
        step = STEPS[name].get(method, STEPS[name].get(order, 0.0)) / 2**halvings
        end = state_at(simulate(MECHANISMS[name], step, END[name], method=method, projection=projection))
        errors.append(np.abs(flat(end) - exact).max())
    slopes = np.log2(np.divide(errors[:-1], errors[1:]))
    assert slopes == pytest.approx(order, abs=0.2), errors
    assert (1e-9 if order < 5 else 1e-13) < errors[-1] < 0.02
