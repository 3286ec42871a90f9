"""`Prepared.kernels`: a loop of one's own in Numba has the bits of the engine, and the equations fit each other."""

import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import lienumba
from lienumba.engine.kernels.refusals import refuse
from lienumba.integrators.tracing import step_kernels
from lienumba.scenario.start.prepare import check_initial
from tests.facade import ScenarioError, resolve
from tests.rigs import parts
from tests.rigs.places import ROOT, SCENARIOS
from tests.rigs.sweeps import linkage

LOOP = '''"""A user's module."""

from numba import njit

from lienumba.kernels import prepare, step


@njit(cache=True)
def march(workspace, states, parameters, first, steps, h):
    failed = 0
    for block in range(len(states)):
        for n in range(first, first + steps):
            failed |= step(workspace, states[block], parameters[block], n * h, h)
    return failed


@njit(cache=True)
def renew(workspace, parameters):
    for block in range(len(parameters)):
        prepare(workspace, parameters[block])
'''
OTHER_PROCESS = """
import sys
import numpy as np
import lienumba
import loop
k = lienumba.prepare(sys.argv[1], overrides={"integrator.end_time": 0.1}).kernels()
x, p = k.start()
assert loop.march(k.workspace(), x, p, 0, 10, 1e-3) == 0
print(sum(loop.march.stats.cache_hits.values()), x.tobytes().hex())
"""


@pytest.fixture(scope="module")
def loop(tmp_path_factory: pytest.TempPathFactory) -> Any:
    """The module of a user, which Numba compiles once for all tests."""
    folder = tmp_path_factory.mktemp("loop")
    (folder / "loop.py").write_text(LOOP)
    sys.path.insert(0, str(folder))
    try:
        yield __import__("loop")
    finally:
        sys.path.remove(str(folder))
        del sys.modules["loop"]


def prepared(name: str, steps: int, **overrides: Any) -> tuple[Any, float]:
    h = resolve(SCENARIOS / f"{name}.toml").data.integrator.step
    assert h is not None
    settings = {"integrator.end_time": steps * h, "output.every": steps * h}
    return lienumba.prepare(SCENARIOS / f"{name}.toml", overrides=settings | overrides), h


def of_runs(k: Any, states: np.ndarray, parameters: np.ndarray, t: float) -> dict[str, np.ndarray]:
    """What is observed, by name: (runs,)."""
    workspace, found = k.workspace(), np.zeros((len(states), len(k.observed), 8))
    for block, out in enumerate(found):
        k.observe(workspace, states[block], parameters[block], t, out)
    return dict(zip(k.observed, found.transpose(1, 0, 2).reshape(len(k.observed), -1), strict=True))


CASES: dict[str, tuple[str, dict[str, Any]]] = {
    "top": ("heavy_top", {}),
    "no projection": ("heavy_top", {"projection.position": "none", "projection.velocity": "none"}),
    "redundant rows": ("four_bar", {}),
    "chord": ("four_bar", {"projection.chord": True}),
    "joint coordinates": ("arm_pd", {"integrator.coordinates": "joint"}),
    "joint coordinates, loop": ("four_bar", {"integrator.coordinates": "joint"}),
    "prescribed motion": ("slider_crank", {}),
    "stages": ("heavy_top", {}),
}


@pytest.mark.parametrize("case", CASES)
def test_a_loop_over_step_has_the_bits_of_the_engine(case: str, loop: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    name, settings = CASES[case]
    if case == "stages":
        monkeypatch.setattr(step_kernels, "INLINE", 0)
    body = resolve(SCENARIOS / f"{name}.toml").data.model.bodies[-1]
    varied = {f"bodies.{body.name}.mass": (0.9 * body.mass, 1.1 * body.mass)}
    ready, h = prepared(name, 20, **settings, sweep=parts.sweep(11, varied))
    asked = [f"{part}.{body.name}.{x}" for part in ("position", "velocity", "angular_velocity") for x in "xyz"]
    k = ready.kernels(observe=asked)
    x, p = k.start()
    assert loop.march(k.workspace(), x, p, 0, 20, h) == 0
    ds, found = ready.run().isel(time=-1), of_runs(k, x, p, 20 * h)
    for name in asked:
        part, body_name, axis = name.split(".")
        assert found[name][:11].tobytes() == ds[part].sel(body=body_name, axis=axis).values.tobytes(), name


@pytest.mark.parametrize("coordinates", ["lie", "joint"])
def test_the_equations_hold_and_are_those_of_the_dataset(coordinates: str) -> None:
    point = {"name": "tip", "type": "point", "body": "rocker", "point": [0, 0, 0], "derivative": 2}
    scenario = resolve(SCENARIOS / "four_bar.toml").to_dict() | {"quantities": [point], "output": {"every": 0.1}}
    settings = {"integrator.coordinates": coordinates, "integrator.end_time": 0.1}
    ready = lienumba.prepare(scenario, overrides=settings)
    k = ready.kernels(observe=["tip.y", "joint_force.rocker_end.x"])
    x, p = k.start()
    workspace, r, e = k.workspace(), k.right_hand_side(), k.equation_arrays()
    k.rhs(workspace, x[0], p[0], 0.0, r)
    k.equations(workspace, x[0], p[0], 0.0, e)
    M, C, Q, xi, a, multipliers = (z[..., 0] for z in (e.M, e.C, e.Q, e.xi, r.a, r.multipliers))
    assert M.shape == (18, 18)
    assert C.shape == (20, 18)
    assert np.allclose(M, M.T)
    assert np.linalg.eigvalsh(M).min() > 0
    assert abs(M @ a + C.T @ multipliers - Q).max() < 1e-12 * abs(Q).max()
    assert abs(C @ a - xi).max() < 1e-12 * abs(xi).max()
    free = np.linalg.solve(M, Q)  # Gauss's principle: of all that C allows the nearest to the free motion
    push = np.linalg.lstsq(C @ np.linalg.solve(M, C.T), C @ free - xi, rcond=1e-10)[0]
    assert abs(free - np.linalg.solve(M, C.T @ push) - a).max() < 1e-9 * abs(a).max()
    ds = ready.run().isel(run=0, time=0)
    assert abs(ds["tip"].values - a[12:15]).max() < 1e-12 * abs(a).max()
    found = of_runs(k, x, p, 0.0)
    assert found["tip.y"][0] == ds["tip"].values[1]
    assert found["joint_force.rocker_end.x"][0] == ds.joint_force.sel(joint="rocker_end", axis="x")


def cart_and_pole(**keys: Any) -> Any:
    def push(cart: Any, *, force: Any) -> Any:
        return cart.force((force, 0, 0))

    system = lienumba.System("A cart and a pole")
    system.parameter("force", 0.5)
    system.body("cart", mass=1, inertia=[1, 1, 1], position=[0, 0, 0], velocity=[0, 0, 0])
    system.body("pole", mass=0.1, inertia=[0.0034, 0.0034, 0.0001])
    system.joint("rail", "prismatic", ["ground", "cart"], points=[[0, 0, 0]] * 2, axes=[[1, 0, 0]] * 2)
    system.joint(
        "pin", "revolute", ["cart", "pole"], points=[[0, 0, 0], [0, 0, -0.5]], axes=[[0, 1, 0]] * 2, angle=0.05
    )
    system.force("motor", type="python", function=push, bodies=["cart"], parameters={"force": "force"})
    system.integrator(step=0.01, end_time=0.2, **keys)
    system.output(every=0.2)
    return system


def test_a_row_that_changes_is_the_number_of_its_path(loop: Any) -> None:
    ready = lienumba.prepare(cart_and_pole(coordinates="joint"))
    k = ready.kernels(observe=["position.pole.x", "position.pole.z"])
    x, p = k.start()
    workspace = k.workspace()
    for path, value in (("bodies.pole.mass", 0.3), ("gravity[2]", -3.0)):
        p[:, k.row(path)] = value
        loop.renew(workspace, p)
    p[:, k.row("parameters.force")] = 2.5
    r = k.right_hand_side()
    k.rhs(workspace, x[0], p[0], 0.0, r)
    assert np.allclose(r.rates[0], r.a[0], rtol=1e-12)  # along the rail
    assert np.allclose(abs(r.rates[1]), abs(r.a[10]), rtol=1e-12)  # about the pin
    assert [k.needs_prepare(x) for x in ("parameters.force", "bodies.pole.mass")] == [False, True]
    assert loop.march(workspace, x, p, 0, 20, 0.01) == 0
    changed = {"parameters.force": 2.5, "bodies.pole.mass": 0.3, "gravity[2]": -3.0}
    ds, found = ready.run(changed).isel(run=0, time=-1), of_runs(k, x, p, 0.2)
    assert found["position.pole.x"][0] == ds.position.sel(body="pole", axis="x")
    assert found["position.pole.z"][0] == ds.position.sel(body="pole", axis="z")


def test_rows_of_a_state_are_named_as_in_the_dataset() -> None:
    ready, _ = prepared("four_bar", 2)
    k = ready.kernels()
    x, ds = k.start().states[0, :, 0], ready.run().isel(run=0, time=0)
    assert x[k.row("velocity.rocker.y")] == ds.velocity.sel(body="rocker", axis="y")
    assert x[k.row("rotation.crank.x.y")] == ds.rotation.sel(body="crank", axis="x", body_axis="y")
    assert x[k.row("angular_velocity.coupler.z")] == ds.angular_velocity.sel(body="coupler", axis="z")


def test_a_lane_that_fails_keeps_its_state_and_the_others_go_on(loop: Any) -> None:
    ready, h = prepared("heavy_top", 2)
    k = ready.kernels()
    x, p = k.start()
    good = x.copy()
    x[0, k.row("angular_velocity.top.x"), 3] = np.nan
    before, workspace = x.copy(), k.workspace()
    assert loop.march(workspace, x, p, 0, 2, h) == 1 << 3
    assert loop.march(workspace, good, p, 0, 2, h) == 0
    assert np.array_equal(x[0, :, 3], before[0, :, 3], equal_nan=True)
    assert np.array_equal(np.delete(x[0], 3, axis=1), np.delete(good[0], 3, axis=1))


def test_arrays_of_other_shapes_are_refused() -> None:
    k = prepared("heavy_top", 2)[0].kernels(observe=["position.top.x"])
    (x, p), workspace, out, r = k.start(), k.workspace(), np.zeros((1, 8)), k.right_hand_side()
    one, deep, plain = x[0], np.zeros((3, *x[0].shape)), np.zeros(18)
    for other in (one[:5], np.concatenate([one, one]), deep, plain, one[:, :4].copy()):
        with pytest.raises(ValueError, match="rows, 8"):
            k.step(workspace, other, p[0], 0.0, 1e-3)
    for other in (p, p[0, :-1], p[0].ravel()):
        with pytest.raises(ValueError, match="rows, 8"):
            k.step(workspace, one, other, 0.0, 1e-3)
    for other in (out[0], out[0, :1], np.zeros((2, 8))):
        with pytest.raises(ValueError, match="rows, 8"):
            k.observe(workspace, one, p[0], 0.0, other)
    for other in (r.rows[1:], r.rows.ravel()):
        with pytest.raises(ValueError, match="rows, 8"):
            k.rhs(workspace, one, p[0], 0.0, r._replace(rows=other))
    other = prepared("four_bar", 2)[0].kernels().start()
    with pytest.raises(ValueError, match="rows, 8"):
        k.step(workspace, other.states[0], other.parameters[0], 0.0, 1e-3)
    for other in (np.zeros(1000), k.workspace(2), 0):
        with pytest.raises(ValueError, match="was not made by this version"):
            k.step(other, one, p[0], 0.0, 1e-3)
    for other in (np.asfortranarray(one), one.astype(int), one.astype(np.float32), 3):
        with pytest.raises(ValueError, match="contiguous"):
            k.step(workspace, other, p[0], 0.0, 1e-3)
    workspace = prepared("heavy_top", 2)[0].kernels().workspace()
    with pytest.raises(ValueError, match="name variables"):
        k.observe(workspace, one, p[0], 0.0, out)


REFUSED: dict[str, tuple[str, dict[str, Any], str]] = {
    "tolerance": ("heavy_top", {"integrator.method": "dp54", "integrator.tolerance": 1e-6}, "give integrator.step"),
    "implicit": ("heavy_top", {"integrator.method": "radau5"}, "solves equations in each step"),
    "series": ("heavy_top", {"integrator.method": "taylor"}, "chooses its order in each step"),
    "switches": ("bouncing_ball", {}, "turns constraints on and off"),
    "events": ("separation", {}, "acts inside of a step"),
    "samples": ("arm_sampled", {}, "forces.shoulder_motor.every: samples the law between steps"),
    "kinks": ("thruster", {}, "kinks on which steps must end"),
    "noise": ("dish_in_gusts", {}, "noise: has kinks"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_is_no_single_call_is_refused(case: str) -> None:
    name, settings, said = REFUSED[case]
    scenario = resolve(SCENARIOS / f"{name}.toml", overrides=settings)
    with pytest.raises(ScenarioError, match=said) as error:
        refuse(scenario, check_initial(scenario))
    assert all("lienumba.run" in str(problem) for problem in error.value.problems)


def test_names_that_have_no_row_are_refused() -> None:
    system = cart_and_pole().to_dict()
    system["parameters"] |= {"half": 0.25, "still": 0.0}
    system["model"]["bodies"][1]["mass"] = "half*0.4"
    system["model"]["forces"].append(
        {"name": "wind", "type": "force", "body": "cart", "point": [0, 0, 0], "value": ["still", 0, 0]}
    )
    k = lienumba.prepare(system, allow_code=True).kernels()
    for name, said in (
        ("parameters.half", "decides about several numbers"),
        ("parameters.still", "compiled in"),
        ("bodies.pile.mass", "pole"),
        ("joints.pin.angle", "in no row"),
    ):
        with pytest.raises(ScenarioError, match=said):
            k.row(name)
    with pytest.raises(ScenarioError, match="is 3 numbers"):
        lienumba.prepare(system, allow_code=True).kernels(observe=["position.pole"])
    with pytest.raises(ScenarioError, match='the nearest known name is "kinetic_energy"'):
        lienumba.prepare(system, allow_code=True).kernels(observe=["kinetic_enrgy"])
    with pytest.raises(ScenarioError, match=r'the nearest known name is "velocity\.pole\..'):
        k.row("velocity.pole.q")
    with pytest.raises(ScenarioError, match="joint coordinates; read it by observe"):
        lienumba.prepare(cart_and_pole(coordinates="joint")).kernels().row("velocity.pole.z")
    with pytest.raises(ScenarioError, match="name what varies in"):
        k.start({"parameters.still": 2.0})


def test_tables_are_kept_once_and_a_single_name_is_observed() -> None:
    system = cart_and_pole().to_dict()
    system["tables"] = {"course": {"times": [-1, 0, 1, 2], "values": [0, 1, 3, 2], "interpolation": "cubic"}}
    system["model"]["forces"].append(
        {"name": "wind", "type": "force", "body": "cart", "point": [0, 0, 0], "value": ["course(at.x)", 0, 0]}
    )
    system["quantities"] = [{"name": "at", "type": "point", "body": "cart", "point": [0, 0, 0]}]
    k = lienumba.prepare(system, allow_code=True).kernels(observe="kinetic_energy")
    assert k.observed == ("kinetic_energy",)
    one, *others = [k.start() for _ in range(3)]
    assert len(k._tables) == 1
    assert all(x.parameters.tobytes() == one.parameters.tobytes() for x in others)


def test_another_process_finds_the_function_in_the_cache(loop: Any) -> None:
    scenario = SCENARIOS / "heavy_top.toml"
    k = lienumba.prepare(scenario, overrides={"integrator.end_time": 0.1}).kernels()
    x, p = k.start()
    loop.march(k.workspace(), x, p, 0, 10, 1e-3)
    done = subprocess.run(
        [sys.executable, "-c", OTHER_PROCESS, str(scenario)], capture_output=True, text=True, check=True,
        env=os.environ | {"PYTHONPATH": f"{Path(loop.__file__).parent}{os.pathsep}{ROOT}"},
    )  # fmt: skip
    hits, states = done.stdout.split()
    assert hits == "1"
    assert np.allclose(np.frombuffer(bytes.fromhex(states)), x.ravel(), rtol=0, atol=1e-12)


def test_a_run_that_needs_other_redundant_rows_keeps_its_state(loop: Any) -> None:
    ready = lienumba.prepare(linkage())
    k, h = ready.kernels(observe=["position.third.x"]), 2e-3
    x, p = k.start()
    workspace, stayed = k.workspace(), np.zeros((len(x), 8), bool)
    for n in range(80):
        for block in range(len(x)):
            before = x[block].copy()
            failed = loop.march(workspace, x[block : block + 1], p[block : block + 1], n, 1, h)
            stayed[block] |= np.array([failed >> lane & 1 for lane in range(8)], bool)
            for lane in np.flatnonzero([failed >> lane & 1 for lane in range(8)]):
                assert x[block][:, lane].tobytes() == before[:, lane].tobytes()
    ended = stayed.ravel()[:20]
    assert 0 < ended.sum() < 20
    ds, found = ready.run().isel(time=-1), of_runs(k, x, p, 0.16)["position.third.x"][:20]
    assert (found == ds.position.sel(body="third", axis="x").values)[~ended].all()
