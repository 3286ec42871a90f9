"""Mechanisms in MJCF (models/), each of which asks something else of an importer, against MuJoCo.

Accelerations at random states; where loops close, the rigid limit of MuJoCo's own matrices. The comparison is that of
scripts/import_check, which knows bodies by where they are.
"""

import re
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import lienumba
from lienumba.importing import from_file
from tests.facade import ScenarioError, resolve
from tests.importing.robots import mjcf
from tests.rigs.places import scripts_on_path

pytest.importorskip("mujoco")
MODELS = sorted((Path(__file__).parent / "models").glob("*.xml"))
CLOSE = 1e-11  # relative to the largest acceleration of the state
COUNT = 20  # states of each
LOST = {  # what a model asks for in vain
    "slides_and_balls": ["the stiffness of ball joints is left out"],
}
MOVED = ["several_joints_of_a_body", "four_bar_in_space", "actuators"]  # also for a while
by_name = pytest.mark.parametrize("path", MODELS, ids=[path.stem for path in MODELS])


@cache
def bench() -> Any:
    """The modules of the script."""
    with scripts_on_path():
        from bench.importing import compare
    return compare


@cache
def imported(path: Path) -> Any:
    from lienumba.importing import from_file

    return from_file(path)


@cache
def pair(path: Path) -> Any:
    from lienumba.importing.reading import read

    return bench().Pair(read(path).model, imported(path))


@by_name
def test_accelerations_are_those_of_mujoco(path: Path) -> None:
    both = pair(path)
    states = both.reference.random_states(COUNT)
    seen, bodies = both.seen(states)
    assert seen.fits.all()
    assert both.error(states, both.reference.accelerations(states), seen, bodies) < CLOSE


@by_name
def test_nothing_else_is_lost(path: Path) -> None:
    assert pair(path).lost == LOST.get(path.stem, [])


@by_name
def test_what_is_written_is_read_again(path: Path, tmp_path: Path) -> None:
    """All numbers to the bit, but those of meshes, which go through files."""
    file = tmp_path / "scenario.toml"
    imported(path).write(file)
    read, made = (resolve(x).data.model_dump() for x in (file, imported(path).to_dict()))
    for data in (read, made):
        for shape in (x for body in data["model"]["bodies"] for x in body["shapes"] or []):
            shape.pop("file", None), shape.pop("data", None)
        for law in (x for kind in ("joints", "forces") for x in data["model"][kind] if "function" in x):
            law["function"] = law["function"].rpartition(":")[2]
    for name, text in made.pop("files", {}).items():
        assert (tmp_path / f"scenario_{name}").read_text(encoding="utf-8") == text
    read.pop("files", None)
    assert read == made


@pytest.mark.parametrize("name", MOVED)
def test_motions_are_those_of_mujoco(name: str) -> None:
    both = pair(next(path for path in MODELS if path.stem == name))
    states = both.reference.random_states(2)
    _, bodies = both.seen(states)
    moved, theirs = both.motion(states, bodies, 1e-3, lasting=0.3)
    assert moved < max(theirs, 1e-9)


def test_what_was_written_runs_to_the_same_bits(tmp_path: Path) -> None:
    path = next(path for path in MODELS if path.stem == "gears")
    file = tmp_path / "scenario.toml"
    imported(path).write(file)
    short = {"integrator.end_time": 0.02}
    ours, again = lienumba.run(imported(path), overrides=short), lienumba.run(file, overrides=short)
    assert np.array_equal(ours.position, again.position)


def test_strict_refuses_what_is_lost() -> None:
    for path in MODELS:
        if LOST.get(path.stem):
            with pytest.raises(ScenarioError):
                from_file(path, strict=True)


def test_how_far_coordinates_in_loops_start_from_the_given_start(tmp_path: Path) -> None:
    """Two hinges tied such that their angles are the same, given 0.2 and 0 rad apart."""
    body = '<body name="{0}" pos="{1} 0 0"><joint name="{0}" axis="0 0 1"/><geom size="0.1"/></body>'
    tie = '<equality><joint joint1="a" joint2="b"/></equality>'
    bodies = body.format("a", 0) + body.format("b", 1)
    file = mjcf(tmp_path, f"<worldbody>{bodies}</worldbody>{tie}")
    moved = {}
    for note in from_file(file, qpos=[0.2, 0.0]).notes:
        if found := re.fullmatch(r"starts by (\S+) rad away from the given start, so that its loop closes", note.what):
            moved |= dict.fromkeys(note.places, float(found[1]))
    assert 0.2 + moved.get('joint "a"', 0.0) == pytest.approx(moved.get('joint "b"', 0.0), abs=1e-3)
    assert not [x for x in from_file(file, qpos=[0.2, 0.2]).notes if "starts by" in x.what]
