"""Rare failures and worst cases of runs, where a body's flight makes both known."""

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from scipy import stats
from typer.testing import CliRunner

import lienumba
from lienumba.engine.rare.limit import Limit
from lienumba.engine.select_run import worst as worst_run
from lienumba.scenario.base import toml
from lienumba.store.layout import MARGIN
from tests.facade import ScenarioError, app

MEAN = np.array([1.0, 2.0, 0.5])
STD = np.array([0.1, 0.2, 0.3])
SLOPE = np.array([1.0, 2.0, -1.0])
CORRELATION = 0.6  # of the first two
SPREAD = float(np.sqrt(SLOPE**2 @ STD**2))
PROBABILITY = 1e-5


def flight(far: float, **more: Any) -> dict[str, Any]:
    """A body flies for a second; x is linear in its velocity."""
    system = lienumba.System("A flight")
    system.gravity = [0, 0, 0]
    still = {"position": [0, 0, 0], "rotation": [1, 0, 0, 0], "angular_velocity": [0, 0, 0]}
    system.body("b", mass=1.0, inertia=[1, 1, 1], velocity=MEAN.tolist(), **still)
    system.quantity("p", "point", body="b").quantity("x", "expression", value="p.x + 2*p.y - p.z", units="m")
    for n, std in enumerate(STD):
        system.vary(f"bodies.b.velocity[{n}]", "normal", std=float(std))
    system.integrator(method="rk4", step=0.5, end_time=1.0)
    system.output(every=0.5, mode="summary", summary={"x": ["final"]})
    data = system.to_dict()
    data["sweep"]["runs"] = 10
    data["requirements"] = [{"name": "near", "value": "x_final", "below": far, "probability": 0.99}]
    return data | more


def away(spread: float, probability: float = PROBABILITY) -> float:
    return float(SLOPE @ MEAN + stats.norm.isf(probability) * spread)


@pytest.mark.parametrize("method", ["subset", "importance", "form"])
def test_a_flight_that_ends_too_far(method: str) -> None:
    data = flight(away(SPREAD))
    del data["sweep"]["runs"]  # of sweeps
    found = lienumba.rare(data, method=method, runs=None if method != "subset" else 400)
    assert float(found.probability_low) <= PROBABILITY <= float(found.probability_high)
    assert (found.status == 0).all()
    x = SLOPE @ np.stack([found[f"bodies.b.velocity[{n}]"] for n in range(3)])
    np.testing.assert_allclose(found.requirement_margin[:, 0], away(SPREAD) - x, rtol=0, atol=1e-12)
    assert found.requirement_units == "m"
    if method == "subset":
        return
    np.testing.assert_allclose(found.distance, [stats.norm.isf(PROBABILITY)], rtol=1e-6)
    np.testing.assert_allclose(found.direction[0], SLOPE * STD / SPREAD, atol=1e-6)
    nearest = MEAN + stats.norm.isf(PROBABILITY) * SLOPE * STD**2 / SPREAD
    np.testing.assert_allclose([found[f"design_bodies.b.velocity[{n}]"][0] for n in range(3)], nearest, rtol=1e-6)


def test_correlations_count() -> None:
    matrix = np.eye(3)
    matrix[0, 1] = matrix[1, 0] = CORRELATION
    spread = float(np.sqrt((SLOPE * STD) @ matrix @ (SLOPE * STD)))
    data = flight(away(spread))
    paths = ["bodies.b.velocity[0]", "bodies.b.velocity[1]"]
    data["sweep"]["correlate"] = [{"paths": paths, "matrix": [[1, CORRELATION], [CORRELATION, 1]]}]
    found = lienumba.rare(data, method="form")
    assert float(found.probability) == pytest.approx(PROBABILITY, rel=1e-6)


def measured(far: float) -> dict[str, Any]:
    """The same flight, of which exact derivatives are known."""
    data = flight(far)
    data["requirements"][0]["value"] = "max(x)"
    return data


@pytest.mark.parametrize("workers", [1, 2])
def test_a_design_point_is_found_by_exact_gradients(workers: int) -> None:
    """The limit is a plane: each start takes a gradient, a step, and a gradient at the design point. From the origin
    half of the step is better than the whole one, and is found among five parts."""
    found = lienumba.rare(measured(away(SPREAD)), method="form", workers=workers)
    assert float(found.probability) == pytest.approx(PROBABILITY, rel=1e-9)
    np.testing.assert_allclose(found.direction, [SLOPE * STD / SPREAD], atol=1e-9)
    exact, others = 2 * 10 + 3, 1 + 10 + 7  # nine starts and the opposite of the point; the origin
    assert (found.sizes["run"], found.attrs["runs_with_derivatives"]) == (exact + others, exact)
    assert found.attrs["notes"] == ""


def test_lognormal_inputs_have_the_design_point_of_their_logarithms() -> None:
    """x = v with log v normal passes its limit where its own number is so large: gradients go through distributions."""
    data, far, scatter = measured(9.0), 4.0, 0.3
    data["requirements"][0]["below"] = far + SLOPE[1:] @ MEAN[1:]
    data["sweep"]["vary"] = {"bodies.b.velocity[0]": {"distribution": "lognormal", "median": 1.0, "sigma": scatter}}
    found = lienumba.rare(data, method="form")
    np.testing.assert_allclose(found.distance, [np.log(far) / scatter], rtol=1e-3)
    assert found.attrs["runs_with_derivatives"] > 0


def test_where_a_gradient_is_missing_the_search_for_the_worst_goes_on(monkeypatch: pytest.MonkeyPatch) -> None:
    def missing(limit: Limit, z: np.ndarray) -> tuple[float, np.ndarray, int]:
        limit.missing += 1
        return float(limit(z[None])[0]), np.full(len(z), np.nan), 1

    monkeypatch.setattr(Limit, "gradient", missing)
    found = lienumba.worst(measured(away(SPREAD)), runs=800)
    at = found.sel(run=int(found.worst))
    corner = MEAN + np.sign(SLOPE) * 3.0 * STD
    np.testing.assert_allclose([at[f"bodies.b.velocity[{n}]"] for n in range(3)], corner, atol=5e-3)
    assert 600 < found.sizes["run"] <= 850


@pytest.mark.parametrize("correlation", [0.0, 0.6, -1.0])
def test_the_worst_is_found_to_rounding_by_exact_gradients(correlation: float) -> None:
    """It is a corner of the box, or of what a correlation leaves of it."""
    data = measured(away(SPREAD))
    paths = [f"bodies.b.velocity[{n}]" for n in range(3)]
    data["sweep"]["correlate"] = [{"paths": paths[:2], "matrix": [[1, correlation], [correlation, 1]]}]
    found = lienumba.worst(data, runs=100)
    edge = stats.norm.isf(0.5 * (1.0 - 0.9973))
    signs = np.array([-1.0, 1.0, -1.0] if correlation == -1.0 else [1.0, 1.0, -1.0])
    at = found.sel(run=int(found.worst))
    np.testing.assert_allclose([at[path] for path in paths], MEAN + signs * edge * STD, rtol=1e-9)
    assert found.sizes["run"] <= 60


def test_where_a_gradient_is_flagged_differences_lead_on() -> None:
    """In the nominal run, from which the search starts, two events come at one time, and inputs would part them."""
    data = measured(away(SPREAD))
    data["parameters"] = {"push": 0.0}
    data["model"]["forces"] = [{"name": "push", "type": "force", "body": "b", "value": ["push", 0, 0]}]
    data["events"] = [
        {"name": axis, "when": f"p.{axis} > {0.6 * mean}", "action": "set", "parameters": {"push": 0.0}, "once": True}
        for axis, mean in zip("xy", MEAN[:2], strict=True)
    ]
    found = lienumba.rare(data, method="form")
    assert float(found.probability) == pytest.approx(PROBABILITY, rel=1e-6)
    exact = found.attrs["runs_with_derivatives"]
    assert found.attrs["notes"] == f"the margin has no exact derivatives at 1 of {exact} points"


def test_without_derivatives_differences_lead_there() -> None:
    """A measure with a condition has none, and a sentence says so."""
    data = measured(away(SPREAD))
    data["requirements"][0]["value"] = "max(x, t > 0.2)"
    found = lienumba.rare(data, method="form")
    assert float(found.probability) == pytest.approx(PROBABILITY, rel=1e-6)
    assert found.attrs["runs_with_derivatives"] == 0
    assert re.fullmatch('the margin has no exact derivatives: "near" is not made of values at .*', found.attrs["notes"])


@pytest.mark.parametrize("search", [lienumba.rare, lienumba.worst], ids=lambda x: x.__name__)
def test_noise_is_refused(search: Any) -> None:
    data = flight(9.0, noise=[{"name": "push", "type": "bias", "std": 0.8}])
    with pytest.raises(ScenarioError, match=r"the margin of a run follows from its inputs alone.*a sweep.* verdict"):
        search(data)


def test_the_worst_of_a_box_is_its_corner() -> None:
    found = lienumba.worst(flight(away(SPREAD)), runs=800)
    at = found.sel(run=int(found.worst))
    corner = MEAN + np.sign(SLOPE) * 3.0 * STD
    np.testing.assert_allclose([at[f"bodies.b.velocity[{n}]"] for n in range(3)], corner, atol=2e-3)
    assert at.requirement_margin.item() == found.requirement_margin.min()
    assert worst_run(found, "near").run == int(found.worst) == worst_run(found, f"{MARGIN}.near").run
    assert found.sizes["run"] <= 850


@pytest.mark.parametrize(
    ("correlation", "corner"), [(0.6, (3, 3, -3)), (-0.9, (3, 3, -3)), (1.0, (3, 3, -3)), (-1.0, (-3, 3, -3))]
)
def test_correlated_inputs_stay_within_their_own_bounds(correlation: float, corner: tuple[int, ...]) -> None:
    """One went on to 4.2 of its own standard deviations. Where one follows from the other, both are within them."""
    data = flight(away(SPREAD))
    paths = [f"bodies.b.velocity[{n}]" for n in range(3)]
    matrix = [[1, correlation], [correlation, 1]]
    data["sweep"]["correlate"] = [{"paths": paths[:2], "matrix": matrix}]
    found = lienumba.worst(data, runs=2000)
    scores = (np.stack([found[path] for path in paths]) - MEAN[:, None]) / STD[:, None]
    assert abs(scores).max() < 3.0001
    np.testing.assert_allclose(scores[:, list(found.run).index(found.worst)], corner, atol=2e-2)


REFUSED: list[tuple[dict[str, Any], str]] = [
    ({"requirement": "neer"}, 'the scenario has no requirement "neer"; the nearest known name is "near"'),
    ({"method": "magic"}, 'method = "magic": is not known'),
    ({"runs": 3}, "runs = 3: must be a whole number, at least 40"),
    ({"confidence": 1.5}, "confidence = 1.5: must be between 0 and 1"),
]


@pytest.mark.parametrize(("given", "message"), REFUSED, ids=str)
def test_what_is_wrong_is_told(given: dict[str, Any], message: str) -> None:
    with pytest.raises(ScenarioError) as error:
        lienumba.rare(flight(9.0), **given)
    assert message in str(error.value)


def test_a_scenario_without_requirements_or_inputs() -> None:
    data = flight(9.0)
    del data["requirements"]
    with pytest.raises(ScenarioError, match=r"the scenario has no requirements, so nothing can fail; write one as"):
        lienumba.worst(data)
    data = flight(9.0)
    data["sweep"] = {}
    with pytest.raises(ScenarioError, match=r"sweep\.vary: is empty"):
        lienumba.rare(data)


def test_the_commands(tmp_path: Path) -> None:
    file, out = tmp_path / "flight.toml", tmp_path / "rare.nc"
    file.write_text(toml.dumps(flight(away(SPREAD))), encoding="utf-8")
    done = CliRunner().invoke(app, ["rare", str(file), "--method", "importance", "-o", str(out)])
    assert done.exit_code == 0, done.output
    assert re.search(r'"near": a run does not meet it with a probability of \S+e-0[56], from ', done.output)
    assert "bodies.b.velocity[1]" in done.output
    with xr.open_dataset(out) as ds:
        assert float(ds.probability) == pytest.approx(PROBABILITY, rel=0.1)
    done = CliRunner().invoke(app, ["worst", str(file), "--runs", "300"])
    assert done.exit_code == 0, done.output
    assert "not met by" in done.output or "met by" in done.output
    done = CliRunner().invoke(app, ["rare", str(file), "--requirement", "x"])
    assert done.exit_code == 2


def test_what_never_happens_or_hardly_ever_is_told_as_such(tmp_path: Path) -> None:
    file = tmp_path / "flight.toml"
    data = flight(50.0)
    file.write_text(toml.dumps(data), encoding="utf-8")
    done = CliRunner().invoke(app, ["rare", str(file), "--runs", "400"])
    assert re.search(r"none of the runs that count, of [\d,]+ runs, fails; a failure has a probability of", done.output)
    late = {"name": "near", "value": "first_time(x > 50)", "below": 0.5, "probability": 0.99}
    file.write_text(toml.dumps(data | {"requirements": [late]}), encoding="utf-8")
    done = CliRunner().invoke(app, ["worst", str(file), "--runs", "64"])
    assert "not met by any limit, since what it tells the time of never happens, at" in " ".join(done.output.split())
