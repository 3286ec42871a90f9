"""One dataset with all kinds of numbers: every command that is asked for one knows all names, and says the same of
those that nothing has."""

import functools
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from typer.testing import CliRunner

import lienumba
from lienumba import ScenarioError, analysis
from lienumba.analysis.panels.select_panels import named_panels
from lienumba.engine.rare.limit import Limit
from lienumba.engine.requirements import judged_of
from lienumba.engine.results import Results
from lienumba.engine.select_run import worst
from lienumba.engine.stopping import stopping_of
from lienumba.figures.outputs import convergence, scatter
from lienumba.scenario.start.prepare import check_initial
from lienumba.store.layout import MARGIN, MET
from lienumba.store.names import INPUT, OVER_TIME, known, match
from tests.facade import app, resolve
from tests.rigs.everything import BRIEF, EVERYTHING, SOON, STOP

RUNNER = CliRunner()
# What a user may ask for, one of each kind, and some that are several numbers.
NAMES = [
    "peak", "swings far", "stays slow", "in time", "requirement_margin.in time", "requirement_met.stays slow",
    "event_time.fast", "event_count.fast", "event_speed.fast.z", "change_time.0", "changes", "energy_lost", "steps",
    "end_time", "max_energy_drift", "last_position.ball.x", "last_position.ball", "last_mode.floor", "swing.angle_max",
    "swing.angle_final", "swing.angle_time_of_max", "speed_max.z", "speed_max", "swing.angle", "speed.z", "q.hinge",
    "position.ball.z", "energy", "joint_force.hinge.x", "mode.floor", "parameters.push", "bodies.ball.velocity[2]",
]  # fmt: skip
UNKNOWN = {
    "peaks": 'the nearest known name is "peak"',
    "stay slow": 'the nearest known name is "stays slow"',
    "event_time.fats": 'the nearest known name is "event_time.fast"',
    "multiplyer": "",
    "zzzzzz": "measures such as",
}


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """The same runs with all courses, and with those of two."""
    folder = tmp_path_factory.mktemp("names")
    found = {"full": folder / "full.nc", "brief": folder / "brief.nc"}
    lienumba.run(EVERYTHING, output=found["full"]).close()
    lienumba.run(EVERYTHING, overrides=BRIEF, output=found["brief"]).close()
    return found


@functools.cache
def results_of_everything() -> Results:
    resolved = resolve(EVERYTHING)
    return Results(resolved, check_initial(resolved))


@pytest.fixture(scope="module", params=["full", "brief"])
def ds(request: pytest.FixtureRequest, files: dict[str, Path]) -> xr.Dataset:
    return xr.load_dataset(files[request.param])


def compared(ds: xr.Dataset, name: str) -> Sequence[object]:
    return analysis.compare(ds, ds, name)["output"].values.tolist()


ASKED: dict[str, Callable[[xr.Dataset, str], object]] = {
    "analyse": lambda ds, name: [*analysis.sensitivity(ds, name)["output"].values],
    "compare": compared,
    "table": lambda ds, name: [*analysis.run_table(ds, name).columns],
    "plot": lambda ds, name: named_panels(ds, [name]).panels,
    "--worst": worst,
}
ALIKE = {"in time": "event_time.fast", "stays slow": "last_velocity.ball.x"}  # outputs are called by their own names


@pytest.mark.parametrize("name", NAMES)
def test_every_command_knows_every_name(ds: xr.Dataset, name: str) -> None:
    """What does not differ from run to run depends on no input, and says so by its name."""
    for command, asked in ASKED.items():
        said = ""
        try:
            assert asked(ds, name), command
        except ScenarioError as error:
            said = str(error)
        assert not said or (command == "analyse" and ALIKE.get(name, name) in said), said


def test_figures_of_outputs_know_the_same_names(ds: xr.Dataset) -> None:
    names = ["in time", "requirement_margin.stays slow", "bodies.ball.velocity[2]", "speed_max.z"]
    for found in (scatter(ds, names, ["parameters.push"]), convergence(ds, names)):
        labels = " ".join(ax.get_ylabel() for ax in found.axes)
        assert all(ALIKE.get(name, name) in labels.replace("\n", " ") for name in names), labels


def test_figures_of_what_no_run_has_a_value_of_say_so(ds: xr.Dataset) -> None:
    ds = ds.assign(status=xr.full_like(ds.status, 1))
    why = "see with lienumba info why runs failed"
    with pytest.raises(ScenarioError, match=f"^peak: no good run has a value, so there are no points; {why}$"):
        scatter(ds, ["peak"], ["parameters.push"])
    with pytest.raises(ScenarioError, match=f"^peak: has a value in 0 runs, and a mean takes at least 2; {why}$"):
        convergence(ds, ["peak"])


@pytest.mark.parametrize(("name", "remedy"), UNKNOWN.items())
def test_all_say_the_same_of_what_nothing_is_called(ds: xr.Dataset, name: str, remedy: str) -> None:
    said = set()
    for command, asked in ASKED.items():
        with pytest.raises(ScenarioError) as refused:
            asked(ds, name)
        text, _, hint = str(refused.value).partition("; ")
        assert f'"{name}"' in text, command
        assert "\n" not in text + hint, command
        said.add(hint)
    assert len(said) == 1
    assert remedy in said.pop()


def test_names_before_and_after_a_run_are_the_same(ds: xr.Dataset) -> None:
    """But for the units of margins, which requirements have that are found by names."""
    resolved = resolve(EVERYTHING, overrides=BRIEF if "full_run" in ds.dims else {})
    before, after = Results(resolved, check_initial(resolved)).names, known(ds)
    assert set(before.every) == set(after.every)
    for name, x in after.every.items():
        assert before.every[name] == x or x.variable == MARGIN
    assert [*before.requirements] == [*after.requirements]
    assert [before.value_of(x) for x in after.requirements] == ["last_velocity.ball.x", "", "event_time.fast"]


NO_NUMBER = {
    "last_position.ball": "is 3 numbers; give one, such as ",
    "speed_max": "is 3 numbers; give one, such as ",
    "swing.angle": 'has a value at each time, not one for each run; give "swing.angle_max", ',
    "energy": "has a value at each time, not one for each run; ask for it in output.summary, or give a measure of it",
    "parameters.push": "is an input, not what a run comes to; ",
}


@pytest.mark.parametrize("name", NAMES)
def test_the_end_of_a_sweep_knows_every_number_of_a_run(name: str) -> None:
    """And says of the others what they are."""
    resolved = resolve(EVERYTHING | {"sweep": EVERYTHING["sweep"] | {"stop": STOP | {"variable": name}}})
    names = results_of_everything().names
    if any(x.kind in (INPUT, *OVER_TIME) for x in match(name, names)) or name in NO_NUMBER:
        with pytest.raises(ScenarioError) as refused:
            stopping_of(resolved, results_of_everything())
        text = str(refused.value)
        assert text.startswith(f'sweep.stop.variable = "{name}": {NO_NUMBER.get(name, "")}')
    else:
        found = stopping_of(resolved, results_of_everything())
        (own,) = match(name, names)
        assert (found.variable, found.place) == (own.variable, own.place)


@pytest.mark.parametrize(("name", "said"), {**NO_NUMBER, "pek": 'the nearest known name is "peak"'}.items())
def test_requirements_say_what_is_no_number_of_a_run(name: str, said: str) -> None:
    with pytest.raises(ScenarioError) as refused:
        judged_of(resolve(EVERYTHING | {"requirements": [SOON | {"value": name}]}), results_of_everything().names)
    assert str(refused.value).startswith(f'requirements.in time.value = "{name}": ')
    assert said in str(refused.value)


def test_the_worst_run_of_a_requirement_has_the_least_margin(files: dict[str, Path], tmp_path: Path) -> None:
    """By its own name, by that of its margin, and by that of its value; the animation says it, too."""
    ds = xr.load_dataset(files["brief"])
    for n, name in enumerate(["stays slow", "swings far", "in time"]):
        run = int(ds["run"].values[np.argmin(ds[MARGIN].values[:, n])])
        value = known(ds).value_of(name)
        for asked in (name, f"{MARGIN}.{name}", f"{MET}.{name}", *([] if "(" in value else [value])):
            found = worst(ds, asked)
            assert found.run == run
            assert f'"{name}"' in found.sentence
    least = float(ds[MARGIN].values[:, 0].min())
    run = int(np.argmin(ds[MARGIN].values[:, 0]))
    assert (
        worst(ds, "stays slow").sentence == f'run {run} of 16 runs misses "stays slow" by most: by {-least:.6g} m s-1'
    )
    done = RUNNER.invoke(app, ["animate", str(files["full"]), "--worst", "stays slow", "-o", str(tmp_path / "a.png")])
    assert done.stdout.endswith(f'run {run} (misses "stays slow" by most)\n')


def test_what_cannot_be_compared_is_told(files: dict[str, Path]) -> None:
    ds = xr.load_dataset(files["full"])
    for name, said in {
        "swing": 'worst="swing": is of 5 things that cannot be compared; give "swing.angle", ',
        MARGIN: f'worst="{MARGIN}": is of 3 requirements; give one, such as {MARGIN}.stays slow',
        "failed": 'worst="failed": says how a run ended, not how large something is; choose with run=N',
    }.items():
        with pytest.raises(ScenarioError) as refused:
            worst(ds, name)
        assert str(refused.value).startswith(said)


def test_rare_failures_are_of_requirements_by_name() -> None:
    resolved = resolve(EVERYTHING)
    with pytest.raises(ScenarioError) as refused:
        Limit(resolved, "stay slow", 1, lambda event: None, 1)
    assert str(refused.value) == 'the scenario has no requirement "stay slow"; the nearest known name is "stays slow"'
