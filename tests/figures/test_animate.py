"""Animations: what is drawn is where the bodies are, and the files play."""

import re
import subprocess
import sys
from dataclasses import replace
from itertools import pairwise
from math import ceil

import numpy as np
import pytest
from typer.testing import CliRunner

import lienumba
from lienumba.groups import so3
from lienumba.scenario.reading.loading import load
from lienumba.scene import box, scene
from lienumba.scene.solids import equivalent
from lienumba.store.outputs import write
from tests.facade import app
from tests.rigs.changing import changing
from tests.rigs.places import SCENARIOS
from tests.rigs.studies import VARIED, top

pytest.importorskip("matplotlib")
from lienumba.figures import movies
from lienumba.figures.picture import Picture
from lienumba.figures.playing import film, played
from lienumba.figures.shapes import Shapes, clipped, hiding, normals


@pytest.fixture(scope="module")
def ds():
    integrator = {"method": "rk4", "step": 1e-3, "end_time": 0.2}
    data = top(integrator=integrator, output={"every": 0.01}, sweep=VARIED | {"runs": 3, "nominal": True}, title="top")
    return lienumba.run(data)


@pytest.fixture(scope="module")
def path(ds, tmp_path_factory):
    target = tmp_path_factory.mktemp("animate") / "top.nc"
    write(ds, target)
    return target


def made(*arguments):
    result = CliRunner().invoke(app, ["animate", *map(str, arguments)])
    assert result.exit_code == 0, result.output
    return result


def test_between_stored_times_bodies_turn_about_one_axis(ds):
    [run] = scene(ds, runs=[1]).runs
    axis, rate = np.array([0.6, 0.0, 0.8]), 3.0
    turned = [np.array(so3.exp(tuple(rate * t * axis))).reshape(1, 3, 3) for t in run.times]
    line = run.times[:, None, None] * np.array([[1.0, -2.0, 0.5]])
    run = replace(run, positions=line, rotations=np.array(turned))
    times = np.array([0.0, 0.003, 0.1, 0.1234, 0.2, 0.5])
    found = played(run, times)
    for t, r, R in zip(np.minimum(times, 0.2), found.positions, found.rotations, strict=True):
        np.testing.assert_allclose(r, [[t, -2.0 * t, 0.5 * t]], atol=1e-15)
        np.testing.assert_allclose(R[0], np.array(so3.exp(tuple(rate * t * axis))).reshape(3, 3), atol=1e-14)
    still = replace(run, times=run.times[:1], positions=run.positions[:1], rotations=run.rotations[:1])
    assert (played(still, times).positions == run.positions[0]).all()


@pytest.mark.parametrize(
    ("end", "asked", "seconds"), [(2.0, None, 4.0), (5.0, None, 5.0), (99.0, None, 8.0), (5.0, 2, 2.0)]
)
def test_how_long_it_takes_to_watch(ds, end, asked, seconds):
    [run] = scene(ds, runs=[1]).runs
    found = film([replace(run, times=np.linspace(0.0, end, len(run.times)))], 20, asked)
    assert len(found.times) == 20 * seconds + 1
    assert (found.times[0], found.times[-1]) == (0.0, end)
    assert found.speed == pytest.approx(end / seconds)


def test_the_faces_look_outwards_and_move_with_the_body(ds):
    [run] = scene(ds, runs=[1]).runs
    shapes = Shapes(run, 1.0)
    corners = shapes.at(7)
    solid = corners[: len(shapes.parts[0].faces)]
    outward = (normals(solid) * (solid.mean(axis=1) - run.positions[7, 0])).sum(axis=1)
    assert outward.min() > 0.0
    own = (solid - run.positions[7, 0]) @ run.rotations[7, 0]  # back in the frame of the body
    np.testing.assert_allclose(own, Shapes(run, 1.0).parts[0].vertices[np.array(shapes.parts[0].faces)], atol=1e-14)
    bar = corners[len(solid) :].reshape(-1, 3)  # to the pivot
    assert np.linalg.norm(bar, axis=1).min() < 0.02
    low, high = box([run])
    every = np.concatenate([shapes.at(frame)[: len(solid)].reshape(-1, 3) for frame in range(len(run.times))])
    assert (low <= every.min(axis=0)).all()
    assert (every.max(axis=0) <= high).all()


def test_polygons_are_cut_at_a_box():
    low, high = np.array([-1.0, -3.0, -1.0]), np.array([2.0, 1.0, 1.0])
    floor = np.array([[-5.0, -5.0, 0.0], [5.0, -5.0, 0.0], [5.0, 5.0, 0.0], [-5.0, 5.0, 0.0]])
    inside, across, outside = clipped(np.stack([0.1 * floor, floor, floor + [0.0, 0.0, 4.0]]), low, high)
    assert (inside == 0.1 * floor).all()
    x, y, _ = across.T
    assert 0.5 * abs(x @ np.roll(y, 1) - y @ np.roll(x, 1)) == pytest.approx(12.0)  # 3 m by 4 m
    assert len(outside) == 0


def test_a_picture_travels_with_a_body_over_the_ground():
    data = load(SCENARIOS / "thruster.toml")
    data["model"]["bodies"][0] |= {"velocity": [60.0, 5.0, 0.0]}
    data["model"]["ground_shapes"] = [{"type": "box", "size": [900.0, 900.0, 0.1]}]
    data["sweep"] = {"runs": 1}
    shown = scene(lienumba.run(data))
    picture = Picture(shown, film(shown.runs, 20, 4.0))
    for frame in (0, 31, 80):
        picture.show(frame)
        limits = np.array([picture.axes.get_xlim(), picture.axes.get_ylim(), picture.axes.get_zlim()])
        corners = picture.shapes[0].at(frame)[np.array(picture.shapes[0].body) == 0]
        assert (limits[:, 0] <= corners).all()
        assert (corners <= limits[:, 1]).all()
        assert np.ptp(corners.reshape(-1, 3), axis=0).max() >= 0.15 * np.ptp(limits, axis=1).max()


def test_what_encloses_another_body_hides_it(ds):
    [run] = scene(ds, runs=[1]).runs
    large, small = equivalent(1.0, (1.0, 1.0, 1.0, 0, 0, 0)), equivalent(1.0, (0.01, 0.01, 0.01, 0, 0, 0))
    for apart, expected in ((0.1, {0}), (5.0, set())):
        places = np.array([[[0.0, 0.0, 0.0], [apart, 0.0, 0.0]]])
        two = replace(run, mechanism=replace(run.mechanism, solids=(large, small)), positions=places)
        assert hiding(replace(two, rotations=np.tile(np.eye(3), (1, 2, 1, 1)))) == expected


def test_a_picture_shows_paths_joints_and_time(ds):
    seen = scene(ds, runs=[-1, 2])
    picture = Picture(seen, film(seen.runs, 10, 1.0), "title")
    picture.show(5)
    assert [text.get_text() for text in picture.figure.texts] == ["title", "t = 0.10 s  (0.2 × real time)"]
    assert [text.get_text() for text in picture.figure.legends[0].get_texts()] == ["nominal run", "run 2"]
    for run, paths in zip(seen.runs, picture.paths, strict=True):
        (path,) = paths.values()
        drawn = np.array(path.get_data_3d()).T
        np.testing.assert_allclose(drawn[:-1], run.positions[:11, 0])
    ground = picture.marks[1][0].get_data_3d()
    np.testing.assert_allclose(np.array(ground), 0.0)
    assert picture.axes.get_xlabel() == "x (m)"
    lengths = [np.diff(getattr(picture.axes, f"get_{axis}lim")())[0] for axis in "xyz"]
    np.testing.assert_allclose(picture.axes._box_aspect / picture.axes._box_aspect[0], np.array(lengths) / lengths[0])


def test_a_gif_plays(tmp_path, path):
    from PIL import Image

    target = tmp_path / "top.gif"
    result = made(path, "-o", target, "--duration", "1", "--fps", "15", "--run", "-1")
    assert result.stdout == f"written to {target}: nominal run\n"
    assert result.stderr == "drawing 16 frames\n"
    with Image.open(target) as movie:
        assert (movie.n_frames, movie.size, movie.info["loop"]) == (16, (640, 480), 0)
        shown, pixels = [], []
        for frame in range(movie.n_frames):
            movie.seek(frame)
            shown.append(movie.info["duration"])
            pixels.append(np.asarray(movie.convert("RGB"), int))
    assert set(shown) == {60, 70}
    assert sum(shown) == 10 * ceil(1600 / 15)
    changed = [(abs(b - a).max(axis=-1) > 40).sum() for a, b in pairwise(pixels)]
    assert min(changed) > 300
    assert (pixels[8][100:400, 100:500] < 200).any()
    assert target.stat().st_size < 400_000


def test_an_mp4_plays_in_browsers(tmp_path, path):
    pytest.importorskip("imageio_ffmpeg")
    target = tmp_path / "top.mp4"
    made(path, "-o", target, "--duration", "0.5", "--fps", "10", "--worst", "position", "-q")
    read = [movies.ffmpeg(), "-i", str(target), "-f", "rawvideo", "-pix_fmt", "rgb24", "-"]
    decoded = subprocess.run(read, capture_output=True, check=True)
    told = decoded.stderr.decode()
    assert re.search(r"Video: h264 .*yuv420p.*, 1280x960.* 10 fps", told), told
    pixels = np.frombuffer(decoded.stdout, np.uint8).reshape(-1, 960, 1280, 3).astype(int)
    assert len(pixels) == 6
    assert min((abs(b - a).max(axis=-1) > 40).sum() for a, b in pairwise(pixels)) > 1000
    assert target.read_bytes().index(b"moov") < target.read_bytes().index(b"mdat")  # plays while it is loaded
    assert [item.name for item in tmp_path.iterdir()] == ["top.mp4"]


@pytest.mark.parametrize(("name", "start"), [("a.png", b"\x89PNG"), ("a.svg", b"<?xml"), ("a.pdf", b"%PDF")])
def test_stills(tmp_path, path, name, start):
    written = []
    for _ in range(2):
        result = made(path, "-o", tmp_path / name, "--run", "0,1")
        assert result.stdout.endswith(": run 0, run 1\n")
        written.append((tmp_path / name).read_bytes())
    assert written[0].startswith(start)
    assert written[0] == written[1]


def test_what_cannot_be_animated(tmp_path, path, monkeypatch):
    def said(*arguments):
        result = CliRunner().invoke(app, ["animate", str(path), *arguments])
        assert result.exit_code == 2, result.output
        assert list(tmp_path.iterdir()) == []
        return result.stderr.splitlines()[-1]

    monkeypatch.chdir(tmp_path)
    assert said("-o", "a.avi") == (
        "error: output = a.avi: is no animation or picture; give a name that ends in .gif, .mp4, .png, .svg or .pdf"
    )
    assert said("-o", "no/a.gif") == (
        "error: output = no/a.gif: its folder no does not exist; create it or choose another"
    )
    assert said("--run", "7").startswith(f"error: {path}: has no run 7, but 4 with labels from -1 to 2; ")
    assert said("--run", "x").startswith('error: --run x: "x" is not a run; ')
    assert said("--run", "0:9") == "error: --run 0:9: names more runs than can be told apart; give at most 7"
    assert said("--run", "1", "--worst", "position") == (
        "error: --run N names runs, and --worst NAME chooses one; give one of them"
    )
    assert said("--fps", "70") == "error: --fps 70: is not between 1 and 50 frames per second; give a number such as 20"
    assert said("--duration", "900") == (
        "error: --duration 900: is not between 0.05 and 150 s, which is what 3,000 frames at 20 per second take; give "
        "a number such as 8"
    )
    for wrong in ("-1", "nan", "inf"):
        assert f"--duration {wrong}: is not between" in said("--duration", wrong)
    monkeypatch.setattr(movies.shutil, "which", lambda name: None)
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    assert said("-o", "a.mp4") == (
        "error: an MP4 needs ffmpeg, which is missing; in the clone of lienumba, pip install "
        '".[animate]", or write a GIF'
    )


def test_an_ffmpeg_that_fails_is_quoted(tmp_path, path, monkeypatch):
    fake = tmp_path / "ffmpeg"
    fake.write_text("#!/bin/sh\necho 'Unknown encoder libx264' >&2\nexit 1\n")
    fake.chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path), prepend=":")
    result = CliRunner().invoke(app, ["animate", str(path), "-q", "--duration", "0.2", "-o", str(tmp_path / "a.mp4")])
    assert result.exit_code == 2
    assert result.stderr == (
        f"error: ffmpeg ({fake}) could not write an MP4 (Unknown encoder libx264); in the clone of lienumba, "
        'pip install ".[animate]"\n'
    )
    assert [item.name for item in tmp_path.iterdir()] == ["ffmpeg"]


def test_what_is_locked_open_or_hit_is_marked_and_named():
    seen = scene(changing(), runs=[1])
    picture = Picture(seen, film(seen.runs, 50, 4.0))
    assert [text.get_text() for text in picture.figure.legends[-1].get_texts()][:2] == ["locked", "open"]
    locked, opened, *_, hit = (artist for artist, _ in picture.marks[2:])
    times = picture.film.times
    picture.show(int(times.searchsorted(0.08)))
    assert np.isnan(locked.get_data_3d()).all()
    np.testing.assert_allclose(np.nanmax(opened.get_data_3d(), axis=1), [1.0, 0.0, 0.15])
    assert np.isnan(hit.get_data_3d()).all()
    picture.show(int(times.searchsorted(seen.runs[0].switching.hits[0][0])))
    assert np.nanmax(locked.get_data_3d()) == pytest.approx(0.0, abs=1e-12)
    np.testing.assert_allclose(np.nanmax(hit.get_data_3d(), axis=1), [1.0, 0.0, 0.1], atol=0.02)
    assert picture.clock.get_text().endswith("floor: impact")
