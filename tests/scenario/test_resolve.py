"""The resolved scenario: defaults written out, round trips, the hash, overrides, warnings."""

import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lienumba.mechanics.system.output_variables import OUTPUT_VARIABLES
from lienumba.scenario.base import toml
from lienumba.store import layout
from tests.facade import ScenarioError, resolve
from tests.rigs.scenario_example import EXAMPLE, example


def test_defaults_are_written_out_and_read_back() -> None:
    data = example(position=None, angular_velocity=None)
    del data["output"], data["sweep"], data["title"], data["model"]["gravity"], data["integrator"]["method"]
    scenario = resolve(data)
    written = tomllib.loads(scenario.to_toml())
    assert written["model"]["gravity"] == [0.0, 0.0, -9.81]
    assert written["integrator"] == {
        "method": "rk4", "step": 1e-3, "end_time": 0.1, "group": "R3xSO3", "coordinates": "lie",
    }  # fmt: skip
    assert written["projection"] == {
        "position": "local", "velocity": "mass", "tolerance": 1e-11, "max_iterations": 10, "chord": False
    }  # fmt: skip
    assert written["output"] == {
        "every": 0.001, "variables": [name for name in OUTPUT_VARIABLES if name != "multiplier"], "also": [],
        "joint_coordinates": False, "precision": "float64", "mode": "full", "summary": {},
        "at_events": [], "max_changes": 16,
    }  # fmt: skip
    assert written["sweep"] == {
        "runs": 1, "seed": 0, "sampler": "random", "nominal": False, "vary": {}, "correlate": [], "proposal": {},
    }  # fmt: skip
    again = resolve(written)
    assert again.to_toml() == scenario.to_toml()
    assert again.sha256() == scenario.sha256()


def test_a_resolved_scenario_may_be_resolved_again() -> None:
    scenario = resolve(example())
    assert resolve(scenario).to_toml() == scenario.to_toml()


@pytest.mark.parametrize(
    ("path", "value", "same"),
    [
        ("title", "another", True),
        ("sweep.runs", 100, True),
        ("output.every", 0.02, True),
        ("bodies.top.position", [0.0, 1.0, 0.0], True),
        ("bodies.top.inertia[0]", 0.3, False),
        ("integrator.step", 5e-4, False),
        ("projection.velocity", "identity", False),
        ("projection.position", "embedded", False),
        ("projection.chord", True, False),
        ("sweep.seed", 2, False),
        ("sweep.vary.bodies.top.mass.std", 0.2, False),
    ],
)
def test_the_hash_tells_what_determines_a_run(path: str, value: Any, same: bool) -> None:
    changed = resolve(example(), overrides={path: value})
    assert (changed.sha256() == resolve(example()).sha256()) is same


def test_the_hash_is_stable() -> None:
    """A new value here means that files of older versions cannot be resumed: say so in the changelog."""
    assert resolve(example()).sha256() == "572f24923b83e276c06b6287b3bb5d2da289876328cdd626183e842c69313f19"


def test_varied_paths_get_their_canonical_form() -> None:
    data = example()
    data["sweep"]["vary"] = {"model.bodies.top.mass": {"distribution": "normal", "std": 0.1}}
    scenario = resolve(data)
    assert list(scenario.data.sweep.vary) == ["bodies.top.mass"]
    assert scenario.nominal() == {"bodies.top.mass": 15.0}
    assert scenario.sha256() == resolve(example()).sha256()


def test_times_and_steps() -> None:
    scenario = resolve(example())
    assert scenario.steps == 100
    assert scenario.times == [0.0, 0.01, 0.02, 0.03, 0.04, 0.05, 0.06, 0.07, 0.08, 0.09, 0.1]
    assert scenario.output_steps == list(range(0, 101, 10))
    listed = example()
    listed["output"] = {"times": [0, 0.057, 0.1]}
    assert resolve(listed).output_steps == [0, 57, 100]


def test_overrides_are_toml_or_bare_words() -> None:
    scenario = resolve(
        example(),
        overrides={
            "integrator.step": "5e-4",
            "integrator.method": "euler",
            "model.gravity": "[0, 0, -1.62]",
            "bodies.top.angular_velocity[1]": "151",
            "projection.velocity": "none",
            "bodies.top.rotation": "{ axis = [0, 0, 1], angle = 0.5 }",
            "title": '"On the moon"',
            "sweep.runs": 5,
        },
        seed=7,
    )
    data = scenario.data
    assert (data.integrator.step, data.integrator.method) == (5e-4, "euler")
    assert data.model.gravity == [0.0, 0.0, -1.62]
    assert data.model.bodies[0].angular_velocity == [0.0, 151.0, -4.61538]
    assert (data.projection.velocity, data.title) == ("none", "On the moon")
    assert (data.sweep.seed, data.sweep.runs) == (7, 5)


def test_overrides_leave_their_source_alone() -> None:
    data = example()
    resolve(data, overrides={"bodies.top.position[0]": 0.0, "integrator.step": 5e-4})
    assert data == EXAMPLE


def test_problems_of_overrides_and_of_the_scenario_come_together() -> None:
    with pytest.raises(ScenarioError) as caught:
        resolve(example(position=[0, 1]), overrides={"bodies.tpo.inertia": "[1, 1, 1]"})
    first, second = str(caught.value).splitlines()
    assert first.startswith('{"bodies.tpo.inertia": ')
    assert second.startswith("model.bodies.top.position = [0, 1]: has 2 entries")


@pytest.mark.parametrize(
    ("changes", "warning"),
    [
        ({"inertia": [1, 1, 3]}, "triangle inequality"),
        ({"rotation": {"axis": [0, 0, 1], "angle": 90}}, "angles are in rad, not degrees"),
        ({"rotation": {"euler": "ZYX", "angles": [0, 45, 0]}}, "angles are in rad, not degrees"),
        ({"rotation": [2, 0, 0, 0]}, "is scaled to length 1"),
    ],
)
def test_warnings(changes: dict[str, Any], warning: str) -> None:
    (found,) = resolve(example(**changes)).warnings
    assert found.place.startswith("model.bodies.top.")
    assert warning in str(found)


def test_the_papers_satellite_is_accepted_with_a_warning() -> None:
    assert len(resolve(example(inertia=[0.35, 0.35, 0.8937])).warnings) == 1


@pytest.mark.parametrize(
    ("path", "value", "warning"),
    [
        ("output.every", 0.03, "the last stored time is 0.09"),
        ("sweep.vary", {}, "all runs are the same"),
        ("sweep.vary.bodies.top.mass.std", 8.0, "will draw a value of 0 or below and fail"),
    ],
)
def test_warnings_about_the_run(path: str, value: Any, warning: str) -> None:
    (found,) = resolve(example(), overrides={path: value}).warnings
    assert warning in str(found)


def test_arrays_and_tuples_are_welcome_in_dicts() -> None:
    data = example(position=np.array([0.0, 1.0, 0.0]), mass=np.float64(15), rotation=(1, 0, 0, 0))
    data["sweep"]["runs"] = np.int64(3)
    assert resolve(data).sha256() == resolve(example()).sha256()


def test_every_variable_of_the_schema_is_in_the_layout() -> None:
    of_time = {name for name, item in layout.VARIABLES.items() if "time" in item.dims}
    assert of_time == {*OUTPUT_VARIABLES, "mode"}  # which nobody asks for: it is there where something may change


def test_a_byte_order_mark_and_windows_line_ends_do_no_harm(tmp_path: Path) -> None:
    file = tmp_path / "windows.toml"
    file.write_bytes(b"\xef\xbb\xbf" + toml.dumps(EXAMPLE).replace("\n", "\r\n").encode())
    assert resolve(file).sha256() == resolve(example()).sha256()


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"\x89HDF\r\n\x1a\n\xff", "is a dataset, not a scenario"),
        (b"", "is empty"),
        (b"\xff", "is not a text file in UTF-8"),
    ],
)
def test_files_that_are_no_scenario(tmp_path: Path, content: bytes, message: str) -> None:
    file = tmp_path / "file.toml"
    file.write_bytes(content)
    with pytest.raises(ScenarioError, match=message):
        resolve(file)


def test_a_folder_and_a_wrong_type_are_no_scenario(tmp_path: Path) -> None:
    with pytest.raises(ScenarioError, match="is a folder; give the path of a TOML file in it"):
        resolve(tmp_path)
    with pytest.raises(ScenarioError, match="must be the path of a TOML file, a dict or a System"):
        resolve(42)


# ---------------------------------------------------------------------------------- text that TOML reads back
NAMES = st.text(st.characters(codec="utf-8"), max_size=8)
VALUES = st.recursive(
    st.booleans() | st.integers(-(2**63), 2**63 - 1) | st.floats(allow_nan=False) | NAMES,
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(NAMES, inner, max_size=4),
    max_leaves=12,
)


@given(st.dictionaries(NAMES, VALUES, max_size=5))
def test_what_is_written_is_read_back(data: dict[str, Any]) -> None:
    assert tomllib.loads(toml.dumps(data)) == data


@given(st.text(alphabet='\\"\n\r\t \x00\x7fabü', max_size=30))
def test_texts_of_several_lines_stay_what_they_are(text: str) -> None:
    data = {"title": text, "files": {"law.py": f"{text}\n{text}"}}
    assert tomllib.loads(toml.dumps(data)) == data


def test_an_unknown_kind_of_quantity_is_named_before_what_reads_it() -> None:
    data = example()
    data["quantities"] = [{"name": "tip", "type": "pont", "body": data["model"]["bodies"][0]["name"]}]
    data["measures"] = [{"name": "highest", "value": "max(tip.z)"}]
    with pytest.raises(ScenarioError) as caught:
        resolve(data)
    assert [x.place for x in caught.value.problems] == ["quantities.tip.type", "measures.highest.value"]
