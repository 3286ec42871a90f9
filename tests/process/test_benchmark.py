"""The benchmark computes what it says it times. No timing is asserted."""

import json
import os
import subprocess
import sys

import numpy as np
import pytest

from tests.rigs.places import ROOT

SCRIPTS = ROOT / "scripts"
STEPS = 200


@pytest.fixture(scope="module")
def bench():
    """The helper modules of the script, by name."""
    sys.path.insert(0, str(SCRIPTS))
    try:
        from bench import cases, chains, deployments, engine, peak, rivals
    finally:
        sys.path.remove(str(SCRIPTS))
    found = (cases, chains, deployments, engine, peak, rivals)
    return {module.__name__.removeprefix("bench."): module for module in found}


@pytest.fixture(scope="module")
def sample(bench):
    return bench["engine"].tops(16)


@pytest.mark.parametrize("runs", [1, 16])
def test_numpy_agrees_with_the_engine(bench, sample, runs):
    cases = bench["cases"]
    records = cases.numpy_top(sample, runs).integrate(sample.states[:runs], bench["engine"].STEP, STEPS, cases.EVERY)
    batch = bench["engine"].top_batch(sample, "none", steps=STEPS, outputs=STEPS // cases.EVERY)
    np.testing.assert_allclose(records, bench["engine"].integrate(batch, 1)[:runs], rtol=0, atol=1e-9)


def test_the_first_top_is_the_papers_and_the_others_are_not(bench, sample):
    engine = bench["engine"]
    assert sample.masses[0] == engine.MASS
    assert tuple(sample.spins[0]) == engine.SPIN
    assert len(np.unique(sample.masses)) == 16


def test_acceleration_map_solves_the_kkt_system(bench, sample):
    engine = bench["engine"]
    runs, few = 16, 2
    m = engine.AccelerationMap(sample.model, sample.states, blocks=few)
    assert m.counts["fma"] > 0
    assert m.counts["flops"] >= m.counts["fma"] + m.counts["multiply"]
    found = m.out.transpose(0, 2, 1).reshape(runs, 9)
    first = few * engine.W // 2  # the parameters are those of the first block in every block
    for run in range(first):
        x, mass = sample.states[run], sample.masses[run]
        R, w, p, J = x[3:12].reshape(3, 3), x[15:18], np.array(engine.PIVOT), np.diag(engine.INERTIA)
        C = -np.hstack([np.eye(3), -R @ np.array([[0, -p[2], p[1]], [p[2], 0, -p[0]], [-p[1], p[0], 0]])])
        K = np.block([[mass * np.eye(3), np.zeros((3, 3)), C[:, :3].T], [np.zeros((3, 3)), J, C[:, 3:].T]])
        K = np.vstack([K, np.hstack([C, np.zeros((3, 3))])])
        b = [*(mass * np.array(engine.GRAVITY)), *np.cross(J @ w, w), *(R @ np.cross(w, np.cross(w, p)))]
        np.testing.assert_allclose(found[run], np.linalg.solve(K, b), rtol=0, atol=1e-9 * np.abs(b).max())


def test_chains_run_and_count(bench):
    flops = []
    for k in (1, 3, 6):
        chain = bench["chains"].Chain(k)
        flops.append(chain.flops / k)
        assert chain.run_steps * 4 * k == chain.evaluations
        assert chain.spend().core > 0
    assert 0 < flops[0] < flops[1] < flops[2] < 2 * flops[0]  # the first link hangs from the ground


def test_peak_is_positive(bench):
    assert bench["peak"].of_a_flop(100).core > 0


def test_installed_rivals_solve_the_same_top(bench):
    engine = bench["engine"]
    for rival in bench["rivals"].available(engine.STEP, round(engine.END_TIME / engine.STEP)):
        np.testing.assert_allclose(rival.mass_centre(), engine.MASS_CENTRE, rtol=0, atol=1e-6)


@pytest.mark.release
def test_quick_run_end_to_end(tmp_path):
    """The scalar loops take half the time to compile without LLVM's passes, and are kept apart from those with them."""
    target = tmp_path / "numbers.json"
    loops = {"NUMBA_OPT": "0", "NUMBA_CACHE_DIR": str(tmp_path)}
    done = subprocess.run(
        [sys.executable, SCRIPTS / "benchmark", "--quick", "--repeats", "1", "--chains", "1,4", "--json", target],
        capture_output=True, text=True, timeout=1200, env=os.environ | loops,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    found = json.loads(target.read_text())
    assert all(check["good"] for check in found["checks"])
    errors = {check["label"].partition(":")[0]: check["error"] for check in found["checks"]}
    for projection in ("none", "both"):  # the same method, so the same error after 20,000 steps
        for loop in ("naive Numba loop", "tuned Numba loop"):
            error = errors[f"{loop}, projection {projection}"]
            assert error == pytest.approx(errors[f"engine, projection {projection}"], rel=0, abs=1e-10)
    assert all(row["ns"] > 0 for row in found["rows"].values())
    assert {"naive_none/engine_none", "naive_none/engine_both", "peak_fraction_map", "chain_1/chain_4"} <= set(
        found["ratios"]
    )
    assert found["ratios"]["robot_ur5_lie_rotors/robot_ur5_lie"] > 0
    assert set(found["cold_compile_s"]) == {"1", "4"}
    assert "naive Numba loop" in done.stdout


def test_deployments_latch_and_count(bench):
    cases, checks, counts = bench["deployments"].deployment_cases(("1e-6",), 4)
    free, latching = (counts[case.key] for case in cases)
    assert (free["changes"], latching["changes"]) == (0, 16)
    assert all(check.good for check in checks)
    assert bench["deployments"].ratios([case.key for case in cases], lambda slow, fast: 2.0) == {
        "deploy_1e-6_latching/deploy_1e-6_free": 2.0
    }
