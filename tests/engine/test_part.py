"""Parts of a sweep, each a dataset of its own, and the whole that is made of them."""

import re
import warnings
from pathlib import Path
from typing import Any

import netCDF4
import numpy as np
import pytest
from typer.testing import CliRunner

import lienumba
from lienumba import ScenarioError
from lienumba.engine.part import SweepPart
from lienumba.store import provenance
from tests.facade import app
from tests.rigs.places import SCENARIOS
from tests.rigs.sweeps import top

SUMMARY = {"mode": "summary", "full_runs": "3,17", "every": 0.01, "summary": {"position": ["max", "final"]}}
STUDY = {"reference": {"method": "dop853", "step": 5e-4}, "grid": [{"integrator.step": [1e-3, 2.5e-3]}]}
OWN = {"history"}  # attributes that say how a file came about


def content(path: Path) -> dict[str, Any]:
    """All that a file holds, as it holds it."""
    with netCDF4.Dataset(path) as file:
        file.set_auto_maskandscale(False)
        found: dict[str, Any] = {name: file.getncattr(name) for name in file.ncattrs() if name not in OWN}
        found["dimensions"] = {name: len(x) for name, x in file.dimensions.items()}
        for name, x in file.variables.items():
            attributes = {key: np.asarray(x.getncattr(key)).tolist() for key in x.ncattrs()}
            values = x[:].tolist() if x.dtype is str else x[:].tobytes()
            found[f"variable {name}"] = (str(x.dtype), x.dimensions, x.chunking(), x.filters(), str(attributes), values)
    return found


def assert_same_content(a: Path, b: Path) -> None:
    one, other = content(a), content(b)
    assert [key for key in one | other if one.get(key) != other.get(key)] == []


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A sweep as a whole, and in three parts; another one; a summary of it; a study."""
    folder = tmp_path_factory.mktemp("parts")
    lienumba.run(top(), output=folder / "whole.nc").close()
    for k in (1, 2, 3):
        lienumba.run(top(), part=(k, 3), output=folder / f"part{k}.nc").close()
    lienumba.run(top(end=0.06), runs=[39], output=folder / "longer.nc").close()
    lienumba.run({**top(runs=2), "study": STUDY}, output=folder / "study.nc").close()
    return folder


def merged(*arguments: object) -> Any:
    return CliRunner().invoke(app, ["merge", *map(str, arguments)])


def refused(*arguments: object) -> str:
    result = merged(*arguments)
    assert result.exit_code == 2, result.output
    [line] = result.stderr.splitlines()
    return line.removeprefix("error: ")


@pytest.mark.parametrize("of", [1, 3, 7, 40])
def test_parts_are_even_and_make_the_whole(of: int) -> None:
    parts = [SweepPart(k + 1, of).share(range(-1, 39)) for k in range(of)]
    assert [label for part in parts for label in part] == list(range(-1, 39))
    assert {len(part) for part in parts} <= {40 // of, -(-40 // of)}


@pytest.mark.parametrize("part", ["1/1", "1/5", "5/5"])
def test_the_first_and_the_last_part_exist(part: str) -> None:
    number, of = map(int, part.split("/"))
    assert SweepPart.parse(part) == SweepPart.parse((number, of)) == SweepPart(number, of)
    for wrong in (f"0/{of}", f"{of + 1}/{of}", "1/0"):
        with pytest.raises(ScenarioError, match=f"part {wrong}: does not exist"):
            SweepPart.parse(wrong)


def test_as_many_parts_as_runs() -> None:
    assert SweepPart(5, 5).share(range(5)) == range(4, 5)
    with pytest.raises(ScenarioError, match="there are more parts than runs, of which there are 5"):
        SweepPart(6, 6).share(range(5))


def test_parts_become_the_whole(folder: Path, tmp_path: Path) -> None:
    result = merged(folder / "part[1-3].nc", "-o", tmp_path / "all.nc", "-q")
    assert (result.exit_code, result.output) == (0, "")
    assert_same_content(tmp_path / "all.nc", folder / "whole.nc")


def test_parts_of_a_summary_and_the_nominal_run(tmp_path: Path) -> None:
    data, labels = top(output=SUMMARY), [-1, *range(12), *range(15, 40)]
    lienumba.run(data, runs=labels, output=tmp_path / "whole.nc").close()
    files = [tmp_path / f"part{k}.nc" for k in (3, 1, 2)]
    for k, file in zip((3, 1, 2), files, strict=True):
        lienumba.run(data, runs=labels, part=f"{k}/3", output=file).close()
    with pytest.warns(UserWarning, match="3 runs are missing of 40: 12:15; "):
        lienumba.merge(files, tmp_path / "all.nc").close()
    assert_same_content(tmp_path / "all.nc", tmp_path / "whole.nc")


def test_a_gap_is_told_and_filled(folder: Path, tmp_path: Path) -> None:
    target = tmp_path / "all.nc"
    result = merged(folder / "part1.nc", folder / "part3.nc", "-o", target)
    assert result.exit_code == 0, result.output
    assert "warning: 13 runs are missing of 40: 13:26; run them with --resume, or " in result.stderr
    with lienumba.run(top(), output=target, resume=True) as dataset:
        assert dataset["run"].values.tolist() == list(range(40))
    assert_same_content(target, folder / "whole.nc")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        lienumba.merge([target], tmp_path / "alone.nc").close()
    assert_same_content(tmp_path / "alone.nc", folder / "whole.nc")


def test_more_files_than_are_open_at_a_time(folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("lienumba.store.finished.OPEN", 1)
    files = [tmp_path / f"{k}.nc" for k in range(3)]
    for k, file in enumerate(files):  # every third run, so that files take turns
        lienumba.run(top(), runs=range(k, 40, 3), output=file).close()
    lienumba.merge(files, tmp_path / "all.nc").close()
    assert_same_content(tmp_path / "all.nc", folder / "whole.nc")


def test_what_does_not_belong_together_is_refused(folder: Path, tmp_path: Path) -> None:
    one, two, whole, target = folder / "part1.nc", folder / "part2.nc", folder / "whole.nc", tmp_path / "all.nc"
    assert refused(one, folder / "longer.nc", "-o", target) == (
        f"{folder / 'longer.nc'}: is of another scenario than {one}, integrator.end_time = 0.06 there and 0.05 here; "
        "merge datasets of one sweep"
    )
    assert refused(two, whole, "-o", target) == f"{two} and {whole} both have the runs 13:26; leave one of them out"
    assert refused(one, one, "-o", target) == f"{one}: is named twice; name each dataset once"
    assert refused(one, two, "-o", two, "--overwrite") == (
        f"output = {two}: is one of the datasets to be merged; choose another name"
    )
    assert refused(folder / "study.nc", "-o", target) == (
        f"{folder / 'study.nc'}: is a study, which is never in parts; give datasets of sweeps"
    )
    assert refused(folder / "q*.nc", "-o", target) == f"{folder / 'q*.nc'}: matches no file; check the pattern"
    assert not list(tmp_path.iterdir())
    with pytest.raises(ScenarioError, match="no dataset is named; give those that are to be merged"):
        lienumba.merge([], target)


def test_code_is_run_only_if_it_is_allowed(tmp_path: Path) -> None:
    lienumba.run(SCENARIOS / "arm_sampled.toml", output=tmp_path / "arm.nc").close()
    message = refused(tmp_path / "arm.nc", "-o", tmp_path / "all.nc")
    assert message.startswith(f"{tmp_path / 'arm.nc'}: brings Python code, which merging runs: ")
    assert merged(tmp_path / "arm.nc", "-o", tmp_path / "all.nc", "--allow-code", "-q").exit_code == 0
    assert_same_content(tmp_path / "all.nc", tmp_path / "arm.nc")


def test_other_versions_are_refused(folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    older = tmp_path / "older.nc"
    monkeypatch.setattr(lienumba, "__version__", "0.0.9")
    provenance.versions.cache_clear()
    lienumba.run(top(), runs=[39], output=older).close()
    monkeypatch.undo()
    provenance.versions.cache_clear()
    assert refused(folder / "part1.nc", older, "-o", tmp_path / "all.nc").startswith(
        f"{older}: was made by lienumba 0.0.9, but {folder / 'part1.nc'} by {lienumba.__version__}, "
    )
    assert refused(older, "-o", tmp_path / "all.nc") == (
        f"{older}: was made by lienumba 0.0.9, but this is {lienumba.__version__}; merge with that version"
    )


def compressed(content: bytes) -> list[int]:
    """Where compressed chunks may begin, from the largest gap on: where much data lies."""
    places = [found.start() for found in re.finditer(b"\x78\x01", content)]
    return sorted(places, key=lambda place: place - min([*(x for x in places if x > place), len(content)]))


def test_damaged_files_are_refused(folder: Path, tmp_path: Path) -> None:
    whole, bad, target = (folder / "part1.nc").read_bytes(), tmp_path / "bad.nc", tmp_path / "all.nc"
    bad.write_bytes(whole[: len(whole) // 2])
    assert f"{bad} cannot be opened as netCDF" in refused(bad, "-o", target)
    for place in compressed(whole):  # a byte that makes the file itself unreadable is no damage to its data
        bad.write_bytes(whole[:place] + bytes(2) + whole[place + 2 :])
        message = refused(bad, folder / "part2.nc", "-o", target)
        if "cannot be opened" not in message:
            break
    assert message.startswith(f"{bad}: is damaged, ")
    assert message.endswith("; make this file again")
    assert not target.exists()


@pytest.mark.parametrize(
    ("part", "message"),
    [
        ("0/5", "part 0/5: does not exist; parts count from 1/5 to 5/5"),
        ("6/5", "part 6/5: does not exist; parts count from 1/5 to 5/5"),
        ("41/41", "part 41/41: there are more parts than runs, of which there are 40; give 40 parts at most"),
        ("third", "part third: does not say which part of how many; give it such as 3/20"),
    ],
)
def test_parts_that_are_none(part: str, message: str, tmp_path: Path) -> None:
    scenario = str(SCENARIOS / "heavy_top_monte_carlo.toml")
    options = ["--set", "sweep.runs=40", "--part", part, "-o", str(tmp_path / "out.nc")]
    result = CliRunner().invoke(app, ["run", scenario, *options])
    assert (result.exit_code, result.stderr) == (2, f"error: {message}\n")
    assert not list(tmp_path.iterdir())


def test_parts_have_files_of_their_own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    scenario = str(SCENARIOS / "heavy_top_monte_carlo.toml")
    options = ["-q", "--set", "sweep.runs=40", "--set", "integrator.end_time=0.02", "--part", "2/3"]
    assert CliRunner().invoke(app, ["run", scenario, *options]).exit_code == 0
    assert [path.name for path in tmp_path.iterdir()] == ["heavy_top_monte_carlo.part2of3.nc"]


@pytest.mark.parametrize(
    ("more", "message"),
    [
        ({"study": STUDY}, "part 1/2: a study has none, "),
        (
            {"sweep": {"stop": {"variable": "end_time", "width": 1.0, "every": 10}}},
            "part 1/2: a sweep that ends by sweep.stop has ",
        ),
    ],
)
def test_sweeps_without_parts(more: dict[str, Any], message: str) -> None:
    data = top()
    for key, section in more.items():
        data[key] = {**data.get(key, {}), **section}
    with pytest.raises(ScenarioError) as refused:
        lienumba.run(data, part="1/2")
    assert message in str(refused.value)
