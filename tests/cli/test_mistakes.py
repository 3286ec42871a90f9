"""What somebody types wrongly is answered in one sentence, with what is wrong and what to do."""

import shlex
from collections.abc import Iterator
from pathlib import Path

import pytest
from typer.testing import CliRunner

import lienumba
from lienumba.scenario.base.toml import dumps
from tests.facade import app
from tests.rigs.everything import EVERYTHING, STOP

RUNNER = CliRunner()
LINES = {
    # commands and options
    "study all.toml": 'there is no command "study"; a study is a section of a scenario: write [study] there, then '
    "lienumba run FILE.toml",
    "rn all.toml": 'there is no command "rn"; the nearest is run',
    "analyze all.nc": 'there is no command "analyze"; the nearest is analyse',
    "all.toml": 'there is no command "all.toml"; a file stands behind one: lienumba run all.toml',
    "all.nc": 'there is no command "all.nc"; a file stands behind one: lienumba info all.nc',
    "--quiet run all.toml": "there is no option --quiet of all commands; options stand behind the command they belong "
    "to",
    "run": "run: SCENARIO is missing; give the scenario, a TOML file",
    "merge all.nc": "merge: --output is missing; give the dataset to write",
    "run all.toml --sede 3": "run: there is no option --sede; the nearest is --seed",
    "run all.toml --zzzz": "run: there is no option --zzzz; lienumba run --help has all",
    "run all.toml --resume true": 'run: --resume takes no value, but "true" follows; give --resume alone, or leave it '
    "out",
    "run all.toml --resume=true": "run: --resume takes no value; give --resume alone, or leave it out",
    "run all.toml -q false": 'run: -q takes no value, but "false" follows; give -q alone, or leave it out',
    "run all.toml --set": "run: --set has no value; give --set PATH=VALUE",
    "run all.toml --set bodies.rod.mass 12": "run: --set takes PATH=VALUE in one word; give --set bodies.rod.mass=12",
    "run all.toml brief.toml": 'run: the argument "brief.toml" is one too many; it takes SCENARIO, and options by '
    "their names",
    "schema all.toml": 'schema: the argument "all.toml" is one too many; it takes none, and options by their names',
    "run all.toml -j0": 'run: --workers = "0": must be a whole number, at least 1; give it such as --workers 4',
    "run all.toml --workers=two": 'run: --workers = "two": must be a whole number, at least 1; give it such as '
    "--workers 4",
    "analyse all.nc --time soon": 'analyse: --time = "soon": must be a number; give it such as --time 0.5',
    "import all.toml --base glued": 'import: --base = "glued": must be "fixed" or "free"; give it such as --base fixed',
    # files
    "run al.toml": "al.toml does not exist; the nearest file there is all.toml",
    "plot al.nc": "al.nc does not exist; the nearest file there is all.nc",
    "plot nowhere/all.nc": "nowhere/all.nc does not exist; nor does the folder nowhere; check the path",
    "run folder": "folder is a folder; give the path of a TOML file in it",
    "run empty.toml": "empty.toml is empty; write a scenario into it: [model] with bodies, and [integrator]",
    "info empty.nc": "empty.nc is empty; write a scenario into it: [model] with bodies, and [integrator]",
    "run all.nc": "all.nc is a dataset, not a scenario; give a TOML file, or: lienumba info all.nc",
    "validate all.nc": "all.nc is a dataset, not a scenario; give a TOML file, or: lienumba info all.nc",
    "plot all.toml": "all.toml is a scenario, not a dataset; run it first: lienumba run all.toml",
    "analyse empty.nc": "empty.nc cannot be opened as netCDF (NetCDF: Unknown file format); give a whole file that "
    "lienumba run wrote",
    "run all.toml -o folder": "output = folder: is a folder; give the name of a file in it, like folder/out.nc",
    "run all.toml -o runs.csv": "output = runs.csv: is no dataset, but what lienumba table writes; give a name that "
    "ends in .nc",
    "plot all.nc -o fig.bmp": "output = fig.bmp: is no figure; give a name that ends in .png, .svg or .pdf",
    # values and names
    "run all.toml --set bodies.rod.mas=12": 'model.bodies.rod.mas is not a known key; the nearest known name is "mass"',
    "run all.toml --set 'bodies.rod.mass=12 kg'": "--set bodies.rod.mass=12 kg: the value 12 kg is not TOML; give a "
    "number, a list in [] or a text in quotes (bare words need none)",
    "run all.toml --set bodies.ball.velocity[2]=1": "--set bodies.ball.velocity[2]=1: the path bodies.ball.velocity[2] "
    'is varied by sweep.vary."bodies.ball.velocity[2]", whose samples do not follow it; set '
    "sweep.vary.bodies.ball.velocity[2].low, or take it out of sweep.vary",
    "validate all.toml --set 'requirements.in time.value=event_time.fats'": 'requirements.in time.value = '
    '"event_time.fats": is not a number that the dataset has for each run; the nearest known name is "event_time.fast"'
    ", or ask for it in output.summary",
    "validate stop.toml --set sweep.stop.variable=peaks": 'sweep.stop.variable = "peaks": is not a number that the '
    'dataset has for each run; the nearest known name is "peak", or ask for it in output.summary',
    "validate stop.toml --set sweep.stop.variable=swing.angle": 'sweep.stop.variable = "swing.angle": has a value at '
    'each time, not one for each run; give "swing.angle_max", "swing.angle_final" or "swing.angle_time_of_max", or '
    "give a measure of it",
    "plot all.nc swing.angl": 'the dataset has no variable "swing.angl"; the nearest known name is "swing.angle"',
    "plot all.nc --against peak": 'the dataset has no input "peak"; known here are "parameters.push", '
    '"bodies.ball.velocity[2]"',
    "plot all.nc --requirement 'stay slow'": 'the dataset has no requirement "stay slow"; the nearest known name is '
    '"stays slow"',
    "rare all.toml --requirement peak": 'the scenario has no requirement "peak"; known here are "stays slow", "swings '
    'far", "in time"',
    "replay all.nc --worst peaks": '--worst peaks: the dataset has no such variable; the nearest known name is "peak"',
    "replay all.nc --run 99": "all.nc: has no run 99, but 16 with labels from 0 to 15; give one of them",
    "animate all.nc --run x": '--run x: "x" is not a run; give labels such as 3,17 or a range such as 0:500',
    "modes all.toml --runs 0:99999999999999": "run 16 does not exist: the sweep has sweep.runs = 16; give labels from "
    "0 to 15 (-1: the nominal run), or raise sweep.runs",
    "modes all.nc --runs 0:99999999999999": "all.nc: has no run 16, but 16 with labels from 0 to 15; give one of them",
    "run all.toml --set output.mode=summary --set output.full_runs=all": 'output.full_runs = "all": "all" '
    "is not a run; give labels such as 3,17 or a range such as 0:500",
    "rare all.toml --requirement 'in time' --confidence 95": "confidence = 95.0: must be between 0 and 1; give such as "
    "0.95",
}  # fmt: skip


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """Where somebody works."""
    here = tmp_path_factory.mktemp("mistakes")
    (here / "all.toml").write_text(dumps(EVERYTHING))
    stop = STOP | {"variable": "peak"}
    (here / "stop.toml").write_text(dumps(EVERYTHING | {"sweep": EVERYTHING["sweep"] | {"stop": stop}}))
    (here / "empty.toml").touch()
    (here / "empty.nc").touch()
    (here / "folder").mkdir()
    lienumba.run(EVERYTHING, output=here / "all.nc").close()
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(here)
        yield here


@pytest.mark.parametrize(("line", "sentence"), LINES.items(), ids=LINES)
def test_a_mistake_is_answered_in_a_sentence(folder: Path, line: str, sentence: str) -> None:
    before = sorted(folder.rglob("*"))
    done = RUNNER.invoke(app, shlex.split(line))
    assert (done.exit_code, done.stderr) == (2, f"error: {sentence}\n")
    assert done.stdout == ""
    assert sorted(folder.rglob("*")) == before
