"""A run of a dataset again, alone: the same bits, from nothing but the dataset."""

import copy
import tomllib
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import lienumba
from lienumba import ScenarioError
from lienumba.batch import statuses
from lienumba.engine.replay import Replay, again
from lienumba.engine.simulate import Progress
from lienumba.present.cite import cite_dataset
from lienumba.sweep.samplers import sampler_of
from tests.batch.test_last_states import PACES, one_iteration, paced
from tests.integrators.drivers.test_events import LOW, pendulum
from tests.rigs.sweeps import COUNTS, assert_same, edit_samples, linkage, loop, run, top


def silent(event: Progress) -> None:
    pass


def replayed(ds: Any, label: int, every: float | None = None) -> Replay:
    return again(ds, "out.nc", label, every, True, silent)


def failing() -> dict[str, Any]:
    """Where the projection needs one iteration more, early or late."""
    data = loop(projection={"max_iterations": 1, "tolerance": 1e-9})
    data["sweep"]["vary"]["bodies.left.angular_velocity[0]"] = {"distribution": "normal", "std": 1.0}
    return data


def stopping(**integrator: Any) -> dict[str, Any]:
    data = pendulum(LOW | {"when": "tip.z < -depth", "action": "stop"}, **integrator)
    data |= {"parameters": {"depth": 0.5}, "output": {"times": [0.0, 0.2]}}
    vary = {"parameters.depth": {"distribution": "uniform", "low": 0.2, "high": 0.9}}
    return data | {"sweep": {"runs": 11, "vary": vary}}


def vectors() -> dict[str, Any]:
    """Inputs of several numbers, and one that follows from another."""
    data = top(runs=9)
    data["sweep"] |= {"sampler": "sobol", "nominal": True, "vary": {
        "gravity": {"distribution": "direction", "angle": 0.3},
        "bodies.top.inertia": {"distribution": "inertia", "std": 0.05},
        "bodies.top.mass": {"distribution": "triangular", "low": 14, "high": 16},
        "bodies.top.angular_velocity[1]": {"expression": "2250/bodies.top.mass"},
    }}  # fmt: skip
    return data


SUMMARY = {"every": 0.04, "mode": "summary", "summary": {"position": ["max", "rms"], "energy": ["time_of_max"]},
           "full_runs": "3:5"}  # fmt: skip
CASES: dict[str, tuple[dict[str, Any], tuple[int, ...], str]] = {
    "steps": (top(runs=11), (10, -1), "at 6 common times"),
    "joint coordinates": (loop(output={"every": 0.04, "joint_coordinates": True}), (1,), "at 6 common times"),
    "their summaries": (
        loop(output=SUMMARY | {"joint_coordinates": True, "summary": {"q": ["max"]}}),
        (1,),
        "in all that it keeps of a run",
    ),
    "tolerance": (paced(loop(), PACES[2]), (0, 19), "at 6 common times"),
    "free lanes": (paced(loop(), PACES[1]), (7,), "at 6 common times"),
    "other rows": (linkage(), (2, 17), "at 5 common times"),
    "vectors": (vectors(), (4, -1), "at 6 common times"),
    "failed": (failing(), (0, 5), "at 6 common times"),
    "stopped": (stopping(tolerance=1e-9), (5,), "at 2 common times"),
    "stopped within a step": (stopping(step=0.0125, method="dop853"), (3,), "at 2 common times"),
    "summary": (loop(output=SUMMARY), (0, -1), "in all that it keeps of a run"),
    "full run": (loop(output=SUMMARY), (3,), "at 6 common times"),
}


@pytest.mark.parametrize("name", CASES)
def test_the_same_bits(name: str) -> None:
    data, labels, known = CASES[name]
    ds = run(copy.deepcopy(data), runs=[-1, *range(data["sweep"]["runs"])])
    for label in labels:
        done = replayed(ds, label)
        assert done.sentence == f"the same bits as run {label} of out.nc {known}"
        assert done.same
        assert done.dataset["run"].values.tolist() == [label]
        assert done.dataset.attrs["scenario_sha256"] == ds.attrs["scenario_sha256"]
        assert {"position", "energy_residual"} <= {*done.dataset.data_vars}
        for fate in ("status", "end_time", "steps", "last_position"):
            np.testing.assert_array_equal(done.dataset[fate], ds[fate].sel(run=[label]))


def test_it_is_what_a_run_with_more_output_gives() -> None:
    """And may be replayed itself."""
    data = top(runs=11)
    done = replayed(run(data), 7).dataset
    assert_same(done, run({**data, "output": {"every": 1e-3}}, runs=[7]))
    assert_same(replayed(done, 7).dataset, done)


def test_every_and_the_times_of_the_file() -> None:
    """Those of the file are there in any case."""
    ds = run(top(runs=3, output={"times": [0.003, 0.05]}))
    assert replayed(ds, 1, every=0.02).dataset["time"].values.tolist() == [0.0, 0.003, 0.02, 0.04, 0.05]
    with pytest.raises(ScenarioError, match=r"^every = 0\.0015: is not a whole number of steps of integrator\.step = "):
        replayed(ds, 1, every=0.0015)


def test_the_samples_are_those_of_the_file(monkeypatch: pytest.MonkeyPatch) -> None:
    """They are not drawn again; one that fits nothing fails again."""
    with monkeypatch.context() as patch:
        edit_samples(patch, {2: {"bodies.top.mass": -1.0}, 4: {"bodies.top.mass": 17.5}})
        ds = run(top(runs=11))
    bad, odd = replayed(ds, 2), replayed(ds, 4)
    assert bad.same
    assert odd.same
    assert odd.dataset["bodies.top.mass"].item() == 17.5
    assert bad.dataset["status"].item() == statuses.INVALID
    assert bad.dataset["end_time"].item() == 0.0
    for name in ("last_position", "last_rotation", "last_velocity", "last_angular_velocity"):
        assert np.isnan(ds[name].sel(run=2)).all()
        assert np.isfinite(ds[name].drop_sel(run=2)).all()


def test_a_file_that_was_resumed(tmp_path: Path) -> None:
    target = tmp_path / "out.nc"
    run(top(runs=9), output=target).close()
    run(top(runs=20), output=target, resume=True).close()
    for label in (3, 15):
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            assert lienumba.replay(target, label, every=0.01).sizes["time"] == 6


def test_a_difference_is_named() -> None:
    ds = run(top(runs=3)).load()
    ds["velocity"][1, 2, 0, 1] = np.nextafter(ds["velocity"][1, 2, 0, 1], 9.0)
    value = ds["velocity"][1, 2, 0, 1].item()
    done = replayed(ds, 1)
    assert not done.same
    start = f"not the same as run 1 of out.nc: velocity (top, y) at t = 0.02 s is {value!r} there and "
    assert done.sentence.startswith(start)
    assert done.sentence.endswith("; the file was changed since it was written, or this is a fault of lienumba: please "
                                  "report it")  # fmt: skip
    assert replayed(ds, 2).same
    ds.attrs |= {"lienumba_version": "0.0.7"}
    assert replayed(ds, 1).sentence.endswith(f"; a reason may be lienumba 0.0.7 there and {lienumba.__version__} here")
    with pytest.warns(UserWarning, match="the dataset") as told:
        lienumba.replay(ds, 1)
    version, different = (str(warning.message) for warning in told)
    assert version.startswith("the dataset: was written by lienumba 0.0.7, and this is ")
    assert different.startswith("not the same as run 1 of the dataset: velocity (top, y) at t = 0.02 s")


def test_iterations_belong_to_intervals() -> None:
    """They are the one thing that is not compared."""
    ds = run(loop()).load()
    for name in COUNTS:
        ds[name][:] = 99
    assert replayed(ds, 1).same
    ds["steps"][1] = 99
    assert "steps is 99 there and 10 here" in replayed(ds, 1).sentence


def test_a_selection_of_a_dataset() -> None:
    ds = run(loop())
    few = ds[["position", "status"]].isel(run=slice(3, 5), time=[1, 3], body=[1])
    assert replayed(few, 4).sentence.endswith("at 2 common times")


def test_states_that_cannot_be_projected_between_steps() -> None:
    """A run ends where it was stored last, which is later where more is stored."""
    ds = run(one_iteration(np.linspace(0, 0.4, 41).tolist()))
    lost = int(np.flatnonzero(ds["status"] == statuses.NOT_CONVERGED)[0])
    done = replayed(ds, lost)
    assert not done.same
    assert "a state within its steps cannot be projected" in done.sentence
    assert replayed(ds, lost, every=0.01).same


def test_what_cannot_be_replayed() -> None:
    ds = run(top(runs=3))
    for label, said in ((17, "out.nc: has no run 17, but 3 with labels from 0 to 2; give one of them"),
                        ("1", "run = '1': is not a label; give a whole number such as 17")):  # fmt: skip
        with pytest.raises(ScenarioError) as error:
            replayed(ds, label)  # type: ignore[arg-type]
        assert str(error.value) == said
    with pytest.raises(ScenarioError, match=r"^out\.nc: has no runs of lienumba with their scenario; give what "):
        replayed(ds.drop_attrs(), 1)
    study = ds.assign_coords(step=("run", [1.0, 2.0, 3.0], {"role": "grid", "path": "integrator.step"}))
    with pytest.raises(ScenarioError, match=r"^out\.nc: is of a study, .* \(overrides\) and without \[study\]"):
        replayed(study, 1)


def test_what_an_older_version_wrote_is_read() -> None:
    """Its sampler and its rule are gone, but the samples are there, of each row of six those of the first two apart."""
    data = top(runs=12)
    mass = {"distribution": "uniform", "low": 14, "high": 16}
    vary = {"bodies.top.mass": mass, "gravity[2]": {"distribution": "normal", "std": 0.1}}
    ds = lienumba.run(data | {"sweep": {"runs": 12, "seed": 3, "sampler": "saltelli", "vary": vary}})
    text = ds.attrs["scenario"].replace('sampler = "saltelli"', 'sampler = "saltelli_second"')
    ds.attrs["scenario"] = text + '\n[sweep.stop]\nrequirement = "soon"\nevery = 4\n'
    again = lienumba.replay(ds, 7)
    np.testing.assert_array_equal(again.last_position, ds.last_position.sel(run=[7]))
    assert "saltelli2010" not in cite_dataset(ds)
    assert sampler_of(tomllib.loads(ds.attrs["scenario"])["sweep"]).counting(np.arange(12), 2).sum() == 4
