"""The scenarios of the paper's examples against trusted solutions, at every stored time and in every part of the state.

The satellite's references come from minimal coordinates and agree with maximal ones to 1e-12, the heavy top's from
elliptic functions. As in the paper: RK4, order 4, few iterations of the projections.
"""

import json
import tomllib
from functools import cache
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import lienumba
from lienumba.scenario.resolve import Scenario
from tests.facade import resolve
from tests.oracles.paper.satellite import F_PJ, L_RJ, L_SJ
from tests.rigs.places import SCENARIOS

REFERENCES = Path(__file__).parent / "references"
MONTE_CARLO = SCENARIOS / "satellite_monte_carlo.toml"
VARIED = tomllib.loads(MONTE_CARLO.read_text(encoding="utf-8"))["sweep"]["vary"]
FILES = {
    "satellite": REFERENCES / "satellite.json",
    "satellite_with_reaction": REFERENCES / "satellite_with_reaction.json",
    "heavy_top": REFERENCES / "heavy_top.json",
}
PARTS = {"r": "position", "R": "rotation", "v": "velocity", "omega": "angular_velocity"}
REACTION = {"name": "reaction", "type": "force", "body": "slider_rod", "frame": "body", "value": (-F_PJ).tolist()}
PROJECTIONS = [("none", "none"), ("local", "mass"), ("local", "identity")]


def scenario(name: str, **overrides: Any) -> Scenario:
    """The scenario of a reference; "satellite_with_reaction" adds the force that the paper leaves out."""
    data = tomllib.loads((SCENARIOS / f"{name.removesuffix('_with_reaction')}.toml").read_text(encoding="utf-8"))
    if name.endswith("_with_reaction"):
        data["model"]["forces"].append(REACTION)
    return resolve(data, overrides={path.replace("__", "."): value for path, value in overrides.items()})


@cache
def reference(name: str) -> dict[str, Any]:
    found: dict[str, Any] = json.loads(FILES[name].read_text(encoding="utf-8"))
    for state in found["states"]:
        state.setdefault("bodies", [state])  # the heavy top's stands alone
    return found


def at_reference_times(name: str) -> dict[str, Any]:
    return {"times": [0.0, *(state["t"] for state in reference(name)["states"])]}


@cache
def simulated(name: str, step: float, projection: tuple[str, str] = ("local", "mass")) -> Any:
    position, velocity = projection
    dataset = lienumba.run(
        scenario(
            name,
            integrator__step=step,
            output=at_reference_times(name),
            projection__position=position,
            projection__velocity=velocity,
        ),
        workers=1,
    )
    assert int(dataset["status"][0]) == 0
    return dataset.isel(run=0)


def errors(dataset: Any, name: str) -> np.ndarray:
    """The largest differences of r, R, v, omega over all reference times and bodies."""
    found = []
    for part, variable in PARTS.items():
        expected = np.array([[body[part] for body in state["bodies"]] for state in reference(name)["states"]])
        found.append(np.abs(dataset[variable].values[1:] - expected).max())
    return np.array(found)


def largest(dataset: Any, variable: str) -> float:
    return float(dataset[variable].max())


@pytest.mark.parametrize(
    ("name", "step", "limit"),
    [("satellite", 5e-3, 1e-11), ("satellite_with_reaction", 5e-3, 1e-11), ("heavy_top", 2e-5, 1e-9)],
)
def test_meets_the_reference(name: str, step: float, limit: float) -> None:
    assert limit <= reference(name)["accept_abs"]
    dataset = simulated(name, step)
    assert errors(dataset, name).max() < limit
    energies = [state["energy"] for state in reference(name)["states"]]
    scale = np.abs(energies).max()
    np.testing.assert_allclose(dataset["energy"].values[1:], energies, rtol=0, atol=limit * scale)


@pytest.mark.parametrize("projection", PROJECTIONS, ids="+".join)
@pytest.mark.parametrize(
    ("name", "steps"),
    [
        ("satellite", (0.1, 0.05, 0.025)),
        ("satellite_with_reaction", (0.1, 0.05, 0.025)),
        ("heavy_top", (2e-4, 1e-4, 5e-5)),
    ],
)
def test_has_order_four_on_the_way_there(name: str, steps: tuple[float, ...], projection: tuple[str, str]) -> None:
    found = [errors(simulated(name, step, projection), name) for step in steps]
    for coarse, fine in pairwise(found):
        assert np.log2(coarse / fine) == pytest.approx(np.full(4, 4.0), abs=0.2)


@pytest.mark.parametrize("velocity", ["mass", "identity"])
@pytest.mark.parametrize(
    ("step", "tolerance", "end"), [(1e-2, 1e-10, 10.0), (1e-3, 1e-11, 10.0), (1e-5, 1e-14, 1.0), (0.5, 1e-11, 10.0)]
)
def test_projections_need_three_iterations_at_most(velocity: str, step: float, tolerance: float, end: float) -> None:
    """The steps and tolerances of Figs. 18, 20 and 22-25, and one much larger step."""
    dataset = lienumba.run(
        scenario(
            "satellite",
            integrator__step=step,
            integrator__end_time=end,
            output__every=max(step, 0.1),
            projection__tolerance=tolerance,
            projection__velocity=velocity,
        ),
        workers=1,
    ).isel(run=0)
    for kind in ("position", "velocity"):
        assert 1 <= largest(dataset, f"{kind}_iterations") <= 3
        assert largest(dataset, f"{kind}_violation") <= tolerance


def test_a_violation_is_left_without_projection() -> None:
    """Of the order of the error itself: the projection has something to do."""
    dataset = simulated("satellite", 0.1, ("none", "none"))
    assert largest(dataset, "position_violation") > 1e-9
    assert largest(dataset, "velocity_violation") > 1e-10
    assert largest(dataset, "position_iterations") == 0


def test_the_slider_lies_where_it_should() -> None:
    dataset = simulated("satellite", 5e-3)
    rod, slider = (dataset.sel(body=name) for name in ("slider_rod", "slider"))
    axis = rod["rotation"].sel(body_axis="z").values
    along = ((slider["position"] - rod["position"]).values * axis).sum(1)
    expected = [state["slider_displacement"] for state in reference("satellite")["states"]]
    assert along[1:] == pytest.approx(expected, abs=1e-11)


def test_driver_effort_is_what_changes_the_angular_momentum() -> None:
    """About the fixed point, in the global frame: dL/dt = effort + the actuators as eq. (44) has them."""
    every = 0.02
    x = lienumba.run(scenario("satellite", output__every=every), workers=1).isel(run=0)
    r, R, v, w = (x[name].values for name in PARTS.values())
    masses, J = np.array([1800.0, 80.0, 60.0, 30.0]), np.array([
        [1800, 1800, 900], [15.1125, 15.1125, 0.225], [11.3, 11.3, 0.1], [0.35, 0.35, 0.8937],
    ])  # fmt: skip
    L = (masses[:, None] * np.cross(r, v) + np.einsum("tbij,bj,tbj->tbi", R, J, w)).sum(1)
    growth = (L[:-4] - 8 * L[1:-3] + 8 * L[3:-1] - L[4:]) / (12 * every)
    torques = np.array([-L_SJ, L_SJ - L_RJ, L_RJ, np.zeros(3)])
    actuators = np.einsum("tbij,bj->ti", R, torques) + np.cross(r[:, 3], R[:, 3] @ F_PJ)
    effort = x["driver_effort"]
    assert list(effort["effort"].values) == ["spin.x", "spin.y", "spin.z"]
    np.testing.assert_allclose(effort.values[2:-2], growth - actuators[2:-2], rtol=0, atol=2e-7)
    assert np.abs(effort.values).max() > 5.0
    assert largest(abs(x), "energy_residual") < 1e-10


class TestMonteCarlo:
    """satellite_monte_carlo.toml: real actuators, bodies placed relative to each other, numbers that vary."""

    @pytest.fixture(scope="class")
    @staticmethod
    def sweep() -> Any:
        return lienumba.run(resolve(MONTE_CARLO), workers=1)

    def test_its_nominal_run_meets_the_reference_with_reaction(self) -> None:
        """Actuators between the bodies are, on the joints, the paper's torques with the reaction that it leaves out."""
        name = "satellite_with_reaction"
        nominal = resolve(
            MONTE_CARLO,
            overrides={"integrator.step": 5e-3, "output": at_reference_times(name)},
        )
        assert errors(lienumba.run(nominal, runs=[-1], workers=1).isel(run=0), name).max() < 1e-11

    def test_every_run_is_good(self, sweep: Any) -> None:
        assert sweep.sizes["run"] == 200
        assert (sweep["status"] == 0).all()
        assert largest(sweep, "max_position_violation") < 1e-11
        assert largest(sweep, "max_velocity_violation") < 1e-11
        assert largest(sweep, "max_energy_drift") < 1e-9
        for kind in ("position", "velocity"):
            assert largest(sweep, f"{kind}_iterations") <= 3

    def test_every_run_starts_in_rigid_rotation(self, sweep: Any) -> None:
        start = sweep.isel(time=0)
        spin = np.array([sweep[f"drivers.spin.value[{i}]"].values for i in range(3)]).T[:, None]
        turning = np.einsum("rbij,rbj->rbi", start["rotation"].values, start["angular_velocity"].values)
        np.testing.assert_allclose(turning, np.broadcast_to(spin, turning.shape), rtol=0, atol=1e-15)
        speeds = np.cross(spin, start["position"].values)
        np.testing.assert_allclose(start["velocity"].values, speeds, rtol=0, atol=1e-15)

    def test_every_run_starts_where_its_numbers_put_it(self, sweep: Any) -> None:
        start = sweep.isel(time=0)
        r, R = start["position"].values, start["rotation"].values
        elbow = np.einsum("rji,rjk->rik", R[:, 1], R[:, 2])
        angle = np.arctan2(elbow[:, 0, 2], elbow[:, 2, 2])
        np.testing.assert_allclose(angle, sweep["joints.elbow.angle"].values, rtol=0, atol=1e-14)
        along = ((r[:, 3] - r[:, 2]) * R[:, 2, :, 2]).sum(1)
        np.testing.assert_allclose(along, sweep["joints.slide.displacement"].values, rtol=0, atol=1e-14)
        np.testing.assert_allclose(R[:, 3], R[:, 2], rtol=0, atol=1e-14)
        place = r[:, 1] + R[:, 1] @ [0.0, 0.0, -0.75]
        for i in range(2):
            np.testing.assert_allclose(place[:, i], sweep[f"joints.shoulder.points[0][{i}]"].values, atol=1e-14)

    @pytest.mark.parametrize("path", sorted(VARIED))
    def test_every_varied_number_reaches_the_mechanism(self, path: str) -> None:
        """All the others held at their nominal values."""
        still = {"distribution": "normal", "std": 0.0}
        held = {other: own if other == path else still for other, own in VARIED.items()}
        overrides = {"sweep.vary": held, "sweep.runs": 2, "integrator.end_time": 1.0, "output": {"times": [0.0, 1.0]}}
        dataset = lienumba.run(resolve(MONTE_CARLO, overrides=overrides), workers=1)
        first, second = (np.concatenate([dataset[v].values[i, -1].ravel() for v in PARTS.values()]) for i in range(2))
        assert float(dataset[path][0]) != float(dataset[path][1])
        assert np.abs(first - second).max() > 1e-7
