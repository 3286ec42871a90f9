"""`lienumba.prepare`: the same bits as `lienumba.run` of the scenario with these numbers, and nothing made again."""

from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
import pandas as pd
import pytest
import xarray as xr

import lienumba
from lienumba.batch.statuses import NOT_ASSEMBLED, SUCCESS
from lienumba.integrators.tracing import program
from tests.facade import ScenarioError, resolve
from tests.rigs.places import SCENARIOS

TOP = {"integrator.end_time": 0.1, "output.every": 0.05}


def prepared(name: str, **overrides: Any) -> Any:
    return lienumba.prepare(SCENARIOS / f"{name}.toml", overrides=overrides)


def assert_same(a: xr.Dataset, b: xr.Dataset) -> None:
    xr.testing.assert_identical(a.drop_attrs(deep=False), b.drop_attrs(deep=False))
    for name in a.variables:
        assert a[name].values.tobytes() == b[name].values.tobytes(), name
        assert {k: str(x) for k, x in a[name].encoding.items()} == {k: str(x) for k, x in b[name].encoding.items()}
    assert {k: x for k, x in a.attrs.items() if k != "history"} == {k: x for k, x in b.attrs.items() if k != "history"}
    assert list(a.attrs) == list(b.attrs)


CASES = {  # redundant rows, a law in Python, one that is sampled, a table, a tolerance with events, formulas, a gear
    "heavy_top": ({"gravity[0]": 0.1}, 0.1),
    "door_on_two_hinges": ({}, 0.1),
    "arm_pd": ({}, 0.1),
    "arm_sampled": ({}, 0.1),
    "thruster": ({}, 0.5),
    "satellite_pointing": ({}, 2.0),
    "slider_crank": ({}, 0.1),
    "rolling_disc": ({}, 0.1),
    "screw_press": ({}, 0.05),
}


@pytest.mark.parametrize("name", CASES)
def test_the_same_bits_and_attributes_as_a_run_with_these_numbers(name: str) -> None:
    scenario = SCENARIOS / f"{name}.toml"
    given, end = CASES[name]
    settings = {"integrator.end_time": end, "sweep.runs": min(3, resolve(scenario).data.sweep.runs)}
    first = resolve(scenario).data.model.bodies[0]
    varied = resolve(scenario).data.sweep.vary
    known = resolve(scenario).parameters.numbers
    numbers = dict(given) | {f"parameters.{name}": 1.1 * x for name, x in known.items()}
    numbers[f"bodies.{first.name}.mass"] = first.mass * 1.1
    numbers = {path: x for path, x in numbers.items() if path not in varied}
    assert numbers
    ready = lienumba.prepare(scenario, overrides=settings)
    assert_same(ready.run(numbers), lienumba.run(scenario, overrides=settings | numbers))
    assert_same(ready.run(), lienumba.run(scenario, overrides=settings))


def test_nothing_is_traced_again(monkeypatch: pytest.MonkeyPatch) -> None:
    ready = prepared("heavy_top", **TOP)
    monkeypatch.setattr(program, "build", None)
    masses = [13.0, 14.0, 1.0]
    found = [ready.run({"bodies.top.mass": mass}) for mass in masses]
    ends = {ds.position.values[0, -1].tobytes() for ds in found}
    assert len(ends) == 3


def test_an_exact_zero_has_its_own_program_and_the_bits_of_a_run() -> None:
    ready = prepared("heavy_top", **TOP)
    for x in (0.25, 0.0, 1.0, -0.0, np.float64(0.5)):
        numbers = {"gravity[0]": x}
        assert_same(ready.run(numbers), lienumba.run(SCENARIOS / "heavy_top.toml", overrides=TOP | numbers))


@pytest.mark.parametrize(
    "kind", [dict, pd.DataFrame, lambda x: pd.DataFrame(x).to_records(index=False)], ids=["dict", "frame", "structured"]
)
def test_samples_are_runs_of_a_table(kind: Any) -> None:
    columns = {"bodies.top.mass": np.array([14.0, 15.0, 1.0]), "gravity[0]": np.array([0.0, 0.1, 1.0])}
    sweep = {"sampler": "table", "table": {"columns": {path: x.tolist() for path, x in columns.items()}}}
    ready = prepared("heavy_top", **TOP)
    given = lienumba.System.from_toml(SCENARIOS / "heavy_top.toml").to_dict() | {"sweep": sweep}
    assert_same(ready.run(samples=kind(columns)), lienumba.run(given, overrides=TOP))
    numbers = {"bodies.top.inertia[0]": 0.25}
    both = ready.run(numbers, samples=kind(columns), runs=[2, 0])
    assert_same(both, lienumba.run(given, overrides=TOP | numbers, runs=[2, 0]))


def test_threads_may_share_it() -> None:
    ready = prepared("heavy_top", **TOP)
    masses = [13.0 + 0.1 * n for n in range(12)]
    alone = [ready.run({"bodies.top.mass": mass}) for mass in masses]
    with ThreadPoolExecutor(4) as pool:
        together = list(pool.map(lambda mass: ready.run({"bodies.top.mass": mass}), masses))
    for a, b in zip(alone, together, strict=True):
        assert_same(a, b)


def test_a_dataset_that_is_changed_changes_no_other() -> None:
    ready = prepared("heavy_top", **TOP)
    first = ready.run()
    first.position.values[:] = 7.0
    first.position.attrs["units"] = "ft"
    first.attrs["title"] = "other"
    first["extra"] = first.time * 2
    assert_same(ready.run(), lienumba.run(SCENARIOS / "heavy_top.toml", overrides=TOP))


def test_a_replay_of_it_is_the_same_run() -> None:
    ds = prepared("heavy_top", **TOP).run({"bodies.top.mass": 14.0})
    assert float(lienumba.replay(ds, 0).position[0, -1, 0, 0]) == float(ds.position[0, -1, 0, 0])


def test_what_cannot_be_assembled_is_data() -> None:
    ready = prepared("heavy_top", **TOP)
    ds = ready.run({"joints.pivot.points[1][2]": 0.1})
    assert ds.status.values.tolist() == [NOT_ASSEMBLED]
    assert np.isnan(ds.position.values).all()
    assert ready.run().status.values.tolist() == [SUCCESS]


MESSAGES = [
    ({"bodies.tap.mass": 1.0}, "bodies.tap.mass"),
    ({"bodies.top.mas": 1.0}, "mass"),
    ({"bodies.top.mass": -1.0}, "must be"),
    ({"bodies.top.mass": float("nan")}, "finite"),
    ({"bodies.top.mass": "2*kp"}, 'bodies.top.mass = "2*kp": must be a number; give a number; what else'),
    ({"bodies.top.mass": True}, "bodies.top.mass = true: must be a number; give a number; what else"),
    ({"integrator.step": 1e-4}, "integrator.step = 0.0001: is no number of the model; give it when you prepare: "),
    ({"parameters.kp": 1.0}, "kp"),
    ({"bodies.top.inertia": [1.0, 2.0]}, "inertia"),
]


@pytest.mark.parametrize(("numbers", "sentence"), MESSAGES)
def test_bad_numbers_are_told(numbers: dict[str, Any], sentence: str) -> None:
    with pytest.raises(ScenarioError) as told:
        prepared("heavy_top", **TOP).run(numbers)
    assert sentence in str(told.value)


SAMPLES = [
    ({"bodies.top.mass": [1.0, float("inf")]}, "samples.bodies.top.mass: row 1 is inf; give finite numbers"),
    ({"bodies.top.mass": [[1.0]]}, "samples.bodies.top.mass: has the shape (1, 1); give one number for each run"),
    ({"bodies.top.mass": ["a"]}, "samples.bodies.top.mass: has what is no number; correct it"),
    ({"bodies.top.mass": [1.0], "gravity[2]": [1.0, 2.0]}, "bodies.top.mass has 1 row and gravity[2] has 2 rows; give"),
    ({}, "samples: has no columns; give a DataFrame"),
    (np.zeros(3), "samples: is a ndarray; give a DataFrame"),
    ({"bodies.tap.mass": [1.0]}, "tap"),
]


@pytest.mark.parametrize(("samples", "sentence"), SAMPLES)
def test_bad_samples_are_told(samples: Any, sentence: str) -> None:
    with pytest.raises(ScenarioError) as told:
        prepared("heavy_top", **TOP).run(samples=samples)
    assert sentence in str(told.value)


def test_a_study_is_not_prepared() -> None:
    with pytest.raises(ScenarioError, match="a study cannot be prepared"):
        prepared("heavy_top_study")


def test_what_is_public_is_shown_and_nothing_else() -> None:
    public = [
        "Fit", "Kernels", "Prepared", "ScenarioError", "System", "__version__", "analysis", "batched", "budget",
        "equilibrium", "foreign", "jit", "linearise", "merge", "modes", "prepare", "rare", "replay", "report",
    ]  # fmt: skip
    assert dir(lienumba) == lienumba.__all__ == [*public, "run", "worst"]
    assert all(hasattr(lienumba, name) for name in public)
