"""The engine "numba" against the compiled one: each type of joint, tableau and projection, the paper's two examples and
a closed loop with redundant rows."""

from itertools import pairwise

import numpy as np
import pytest

import lienumba
from tests.facade import JOINTS
from tests.rigs.sweeps import linkage

pytestmark = [pytest.mark.release, pytest.mark.usefixtures("compiled")]
STATE = ["position", "rotation", "velocity", "angular_velocity"]
BOTH, NONE = {}, {"projection.position": "none", "projection.velocity": "none"}
WAYS = {
    "rk4": {"integrator.method": "rk4", **BOTH},
    "kutta3": {"integrator.method": "kutta3", **NONE},
    "euler": {"integrator.method": "euler", "projection.velocity": "identity"},
}
KINDS = [kind for kind in JOINTS if kind != "python"]


def differences(scenario, overrides):
    """The largest difference of each variable of a run by both engines."""
    one, other = (
        lienumba.run(scenario, overrides=overrides | engine, progress=False)
        for engine in ({}, {"integrator.engine": "numba"})
    )
    assert {*one.variables} == {*other.variables}
    assert (other.status == 0).all()
    return {
        name: float(np.abs(one[name].values - other[name].values).max())
        for name in one.data_vars
        if one[name].dtype.kind in "fi" and one[name].size
    }


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("way", WAYS)
def test_a_joint_moves_by_its_formulas_as_by_the_derivatives_of_its_residual(kind, way):
    scenario = JOINTS[kind].example() | {"integrator": {"step": 1e-3, "end_time": 0.2}, "output": {"every": 0.05}}
    found = differences(scenario, WAYS[way])
    assert max(found[name] for name in STATE) < 1e-11
    assert max(found.values()) < 1e-10


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("name", ["heavy_top", "satellite", "four_bar"])
@pytest.mark.filterwarnings("ignore:model.bodies.slider.inertia")
def test_the_examples_of_the_paper_and_a_loop(name, way):
    scenario = f"scenarios/{name}.toml"
    step = {"heavy_top": 1e-3, "satellite": 1e-2, "four_bar": 5e-4}[name]
    overrides = {"integrator.step": step, "integrator.end_time": 200 * step, "output.every": 50 * step}
    found = differences(scenario, WAYS[way] | overrides)
    assert max(found[name] for name in STATE) < 1e-11
    assert found["position_iterations"] == 0


def test_bodies_without_constraints():
    found = differences("scenarios/dzhanibekov.toml", {"integrator.end_time": 0.4, "output.every": 0.1})
    assert max(found.values()) < 1e-11


@pytest.mark.parametrize(("dexpinv", "method"), [("closed", "rk4"), (5, "dop853"), (0, "midpoint")])
def test_the_inverse_of_dexp_is_the_series_or_its_sum(dexpinv, method):
    keys = {"integrator.dexpinv": dexpinv, "integrator.method": method, "integrator.step": 2e-3}
    found = differences("scenarios/heavy_top.toml", keys | {"integrator.end_time": 0.1, "output.every": 0.02})
    assert max(found[name] for name in STATE) < 1e-11


def test_a_run_that_needs_other_redundant_rows_ends_with_a_status():
    ours, others = (lienumba.run(linkage(), overrides=engine) for engine in ({}, {"integrator.engine": "numba"}))
    assert (ours.status == 0).all()
    good = others.status.values == 0
    assert 0 < good.sum() < 20
    assert {*others.status.values[~good]} == {2}
    np.testing.assert_allclose(others.position.values[good], ours.position.values[good], rtol=0, atol=1e-12)


def test_the_order_is_that_of_the_tableau():
    """Of the free body of `scenarios/heavy_top.toml`: halving the step leaves a sixteenth of the error."""
    keys = {"integrator.engine": "numba", "integrator.end_time": 0.04, "output.every": 0.04} | NONE
    ends = [
        lienumba.run("scenarios/heavy_top.toml", overrides=keys | {"integrator.step": step}, progress=False)
        .rotation.isel(run=0, time=-1)
        .values
        for step in (1e-3, 5e-4, 2.5e-4)
    ]
    errors = [np.abs(a - b).max() for a, b in pairwise(ends)]
    assert 3.7 < np.log2(errors[0] / errors[1]) < 4.3
