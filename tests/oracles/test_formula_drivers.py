"""Drivers that read positions: couplings of one's own, against minimal coordinates."""

from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import lienumba
from tests.rigs.observed import run
from tests.rigs.pendulum import G, J, L, M, pendulum

I_B, M_B, L_B = 0.03 + 0.9 * 0.3**2, 0.9, 0.3


def coupled(value: str, step: float) -> dict[str, Any]:
    """Two pendulums side by side; the second one's angle is a formula of the first."""
    data = pendulum("0.3*cos(4*t)", [
        {"name": "first", "type": "joint", "joint": "hinge"}, {"name": "second", "type": "joint", "joint": "other"},
        {"name": "tip", "type": "point", "body": "rod"}, {"name": "motor", "type": "driver_effort", "driver": "tie"},
    ])  # fmt: skip
    model = data["model"]
    hinge = model["joints"][0] | {"references": [[0, 0, 1], [0, 0, 1]]}
    other = hinge | {"name": "other", "bodies": ["ground", "bob"], "points": [[0, 1, 0], [0, 0, L_B]]}
    model["joints"] = [hinge, other]
    model["bodies"].append({"name": "bob", "mass": M_B, "inertia": [0.03, 0.03, 0.03]})
    model["drivers"] = [{"name": "tie", "joint": "other", "value": value}]
    del data["parameters"]
    return data | {"integrator": {"step": step, "end_time": 0.8}}


# the formula, and what it is of t and the angle q: f, f_q, f_qq, f_t, f_qt, f_tt
COUPLINGS = {
    "an angle": (
        "0.5*first.angle + 0.1*sin(first.angle) + 0.2*sin(3*t)",
        lambda t, q: (0.5 * q + 0.1 * np.sin(q) + 0.2 * np.sin(3 * t), 0.5 + 0.1 * np.cos(q), -0.1 * np.sin(q),
                      0.6 * np.cos(3 * t), 0 * q, -1.8 * np.sin(3 * t)),
    ),
    "a point and the time": (
        "0.4 + 2*tip.x*cos(2*t)",
        lambda t, q: (0.4 - 2 * L * np.sin(q) * np.cos(2 * t), -2 * L * np.cos(q) * np.cos(2 * t),
                      2 * L * np.sin(q) * np.cos(2 * t), 4 * L * np.sin(q) * np.sin(2 * t),
                      4 * L * np.cos(q) * np.sin(2 * t), 8 * L * np.sin(q) * np.cos(2 * t)),
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", COUPLINGS)
def test_a_driver_that_reads_a_position_couples_without_loss(case):
    """Against minimal coordinates: the coupling's forces do no work but for what depends on the time."""
    text, f = COUPLINGS[case]
    I = J + M * L * L  # noqa: E741

    def parts(t, q, dq):
        x, x_q, x_qq, x_t, x_qt, x_tt = f(t, q)
        bias = x_qq * dq**2 + 2 * x_qt * dq + x_tt
        load = M_B * G * L_B * np.sin(x)
        torque = 0.3 * np.cos(4 * t) - M * G * L * np.sin(q)
        ddq = (torque - x_q * (I_B * bias + load)) / (I + I_B * x_q**2)
        return x, x_q * dq + x_t, ddq, I_B * (x_q * ddq + bias) + load

    def rates(t, y):
        return [y[1], parts(t, *y)[2]]

    found = []
    for step in (0.01, 0.005):
        ds = run(coupled(text, step)).isel(run=0)
        found.append(float(np.abs(ds.energy_residual).max()))
    assert np.abs(ds.work).max() > 0.1
    assert np.log2(found[0] / found[1]) > 3.7
    times = ds.time.values
    q, dq = solve_ivp(rates, (0, times[-1]), [1.0, 6.0], "DOP853", t_eval=times, rtol=1e-12, atol=1e-12).y
    x, dx, _, effort = parts(times, q, dq)
    np.testing.assert_allclose(ds["first.angle"], q, rtol=0, atol=1e-6)
    np.testing.assert_allclose(ds["first.rate"], dq, rtol=0, atol=1e-5)
    np.testing.assert_allclose(ds["second.angle"], x, rtol=0, atol=1e-6)
    np.testing.assert_allclose(ds["second.rate"], dx, rtol=0, atol=1e-5)
    np.testing.assert_allclose(ds["motor"], effort, rtol=0, atol=1e-4)


def test_a_driver_that_follows_itself_is_an_error_of_the_scenario():
    with pytest.raises(lienumba.ScenarioError):
        run(coupled("second.angle", 0.01))
