"""[start]: coordinates of joints at the start, by their names."""

import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

import lienumba
from lienumba.scenario.start.prepare import check_initial
from tests.facade import resolve
from tests.rigs import all_joints
from tests.rigs.joint_values import values

Q = {
    "crank": 0.4, "slide": -0.1, "ball": [0.3, -0.2, 0.5], "piston": [9.0, 0.2], "cross": [0.5, -0.7],
    "puck": [0.1, -0.2, -4.0], "nut": 7.0,
}  # fmt: skip
QD = {
    "crank": 1.5, "slide": -0.3, "ball": [1.3, -0.7, 0.9], "piston": [-2.0, 0.4], "cross": [0.8, 1.1],
    "puck": [0.5, 0.3, -1.2], "nut": 0.6,
}  # fmt: skip


def scenario(only: tuple[str, ...] = (), **start: Any) -> dict[str, Any]:
    data = all_joints.scenario("joint", only)
    del data["quantities"]
    for joint in data["model"]["joints"]:
        joint |= {"displacement": 0.1} if joint["name"] == "nut" else {}
    return data | {"start": start}


ARM = ("crank", "slide", "ball")


def flat(given: dict[str, Any]) -> dict[str, float]:
    """By every coordinate."""
    found: dict[str, float] = {}
    for name, x in given.items():
        labels = [label for label in all_joints.COORDINATES if f"{label}.".startswith(f"{name}.")]
        found |= dict(zip(labels, x if isinstance(x, list) else [x], strict=True))
    return found


@pytest.mark.parametrize("by_name", [True, False], ids=["each", "lists"])
def test_a_tree_is_where_its_coordinates_are(by_name: bool) -> None:
    q, qd = (flat(x) if by_name else x for x in (Q, QD))
    found, rates = values(check_initial(resolve(scenario(q=q, qd=qd))))
    assert {x: found[x] for x in flat(Q)} == pytest.approx(flat(Q), abs=1e-13)
    assert {x: rates[x] for x in flat(QD)} == pytest.approx(flat(QD), abs=1e-13)


KEYS = {
    "ball": {"rotation_vector": Q["ball"], "angular_velocity": QD["ball"]},
    "cross": {"first_angle": 0.5, "second_angle": -0.7, "first_rate": 0.8, "second_rate": 1.1},
    "puck": {"x": 0.1, "y": -0.2, "angle": -4.0, "x_rate": 0.5, "y_rate": 0.3, "rate": -1.2},
    "crank": {"angle": 0.4, "rate": 1.5},
}


def test_keys_of_the_joints_say_the_same() -> None:
    only = ("crank", "slide", "ball", "cross", "piston", "puck")
    given = {"slide": -0.1, "piston": Q["piston"]}, {"slide": -0.3, "piston": QD["piston"]}
    data = scenario(only, q=given[0], qd=given[1])
    for joint in data["model"]["joints"]:
        joint |= KEYS.get(joint["name"], {})
    by_keys = check_initial(resolve(data))
    q, qd = ({name: x for name, x in of_all.items() if name in only} for of_all in (Q, QD))
    by_names = check_initial(resolve(scenario(only, q=q, qd=qd)))
    assert by_keys.now.bodies == by_names.now.bodies


def test_it_stands_over_the_keys_of_joints() -> None:
    data = scenario(("crank",), q={"crank": 0.4})
    data["model"]["joints"][0]["angle"] = -1.0
    assert values(check_initial(resolve(data)))[0]["crank"] == pytest.approx(0.4, abs=1e-14)


def test_paths_formulas_and_what_is_written_out() -> None:
    data = scenario((*ARM, "piston"), q={"crank": "2*lift", "ball": [0.1, "lift", 0.3], "slide": 0.1})
    data |= {"parameters": {"lift": 0.2}}
    overrides = {"start.q.piston.angle": 0.7, "start.q.ball[2]": -0.3, "start.qd.crank": 2.0}
    resolved = resolve(data, overrides=overrides)
    q, qd = values(check_initial(resolved))
    assert [q[x] for x in ("crank", "ball.ry", "ball.rz", "piston.angle")] == pytest.approx([0.4, 0.2, -0.3, 0.7])
    assert qd["crank"] == pytest.approx(2.0)
    written = tomllib.loads(resolved.to_toml())
    assert written["start"]["q"] == {
        "crank": "2*lift", "ball": [0.1, "lift", -0.3], "slide": 0.1, "piston.angle": 0.7
    }  # fmt: skip
    assert resolve(written).sha256() == resolved.sha256()
    other = resolve(data, overrides=overrides | {"start.qd.crank": 2.5})
    assert other.sha256() != resolved.sha256()


def test_extended_coordinate_by_coordinate(tmp_path: Path) -> None:
    base = scenario((*ARM, "piston"), q={"crank": 0.1})
    (tmp_path / "base.toml").write_text(resolve(base).to_toml())
    (tmp_path / "more.toml").write_text('extends = "base.toml"\n[start]\nq.slide = 0.05\nq.piston.angle = 1.0\n')
    found = resolve(tmp_path / "more.toml").data.model.start
    assert found is not None
    assert found.q == {"crank": 0.1, "slide": 0.05, "piston.angle": 1.0}


def test_a_sweep_varies_them() -> None:
    data = scenario((*ARM, "nut"), q={"crank": 0.4, "slide": 0.1, "ball": [0.1, 0.2, 0.3], "nut": 0.2}, qd={"nut": 0.5})
    vary = {path: {"distribution": "normal", "std": 0.1} for path in
            ("start.q.crank", "start.q.ball[1]", "start.q.slide", "start.qd.nut")}  # fmt: skip
    data |= {"sweep": {"runs": 3, "vary": vary}, "output": {"times": [0.0], "joint_coordinates": True}}
    data["integrator"]["end_time"] = 0.01
    ds = lienumba.run(data)
    assert [ds[path].attrs["units"] for path in vary] == ["rad", "rad", "m", "rad s-1"]
    for path, label, name in zip(vary, ("crank", "ball.ry", "slide", "nut"), ("q", "q", "q", "qd"), strict=True):
        np.testing.assert_allclose(ds[path].values, ds[name].sel(coordinate=label).values[:, 0], rtol=0, atol=1e-13)
    prepared = lienumba.prepare(data)
    assert prepared.run({"start.q.nut": 0.02}).q.sel(coordinate="nut").values[0, 0] == (pytest.approx(0.02, abs=1e-13))


STORED = (*ARM, "nut")


def here(given: dict[str, Any]) -> dict[str, Any]:
    return {name: x for name, x in given.items() if name in STORED}


@pytest.fixture(scope="module")
def dataset(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("start") / "out.nc"
    data = scenario(STORED, q=here(Q), qd=here(QD)) | {"output": {"every": 0.01, "joint_coordinates": True}}
    data["integrator"]["end_time"] = 0.05
    lienumba.run(data).to_netcdf(path)
    return path


def test_from_a_dataset(dataset: Path) -> None:
    """At a time of it; what is given stands over it."""
    with xr.open_dataset(dataset) as ds:
        expected, rates = (dict(zip(ds.coordinate.values, ds[x].values[0, 3], strict=True)) for x in ("q", "qd"))
    data = scenario(STORED, file=str(dataset), run=0, time=0.03, q={"ball": [0.0, 0.1, 0.0]}, qd={"crank": 0.25})
    data["model"]["joints"][-1]["displacement"] += (expected["nut"] - Q["nut"]) * 0.3 / (2 * np.pi)
    resolved = resolve(data)
    q, qd = values(check_initial(resolved))
    expected |= {"ball.rx": 0.0, "ball.ry": 0.1, "ball.rz": 0.0}
    assert q == pytest.approx(expected, abs=1e-12)
    assert qd == pytest.approx(rates | {"crank": 0.25}, abs=1e-11)
    assert "file" not in tomllib.loads(resolved.to_toml())["start"]


SENTENCES = {
    "unknown": ({"q": {"crnk": 1.0}}, 'start.q.crnk: is not a coordinate of the mechanism; the nearest .* "crank"'),
    "like none": ({"q": {"zz": 1.0}}, r'start.q.zz: is not a coordinate .*known here are (?!.*("\w[^"]*").*\1)'),
    "of several": ({"q": {"piston": 1.0}}, "start.q.piston = 1.0: the joint has 2 coordinates; give a list of 2"),
    "too few": ({"q": {"ball": [1.0, 2.0]}}, "start.q.ball = .*has 2 entries, but the joint has 3 coordinates"),
    "a list of one": ({"qd": {"crank": [1.0, 2.0]}}, "start.qd.crank = .*has 2 entries.*1 coordinate; give a number"),
    "twice": (
        {"q": {"cross": [1.0, 2.0], "cross.first_angle": 1.0}},
        'start.q.cross: gives "cross.first_angle", too, which stands beside it; leave one',
    ),
    "no number": ({"q": {"crank": "high"}}, 'start.q.crank = "high": '),
    "no key": ({"Q": {}}, 'start.Q is not a known key; .*"q"'),
    "time alone": ({"time": 1.0}, "start.time = 1.0: has no meaning without a file"),
    "no file": ({"file": "none.nc"}, "none.nc does not exist"),
}


@pytest.mark.parametrize("case", SENTENCES)
def test_sentences(case: str) -> None:
    start, said = SENTENCES[case]
    with pytest.raises(lienumba.ScenarioError, match=said):
        resolve(scenario(**start))


@pytest.mark.parametrize(
    ("keys", "said"),
    [
        ({"time": 0.0312}, "start.time = 0.0312: is not stored; the nearest stored time is 0.03"),
        ({"run": 4}, "start.run = 4: .* has no such run"),
    ],
)
def test_sentences_about_a_dataset(dataset: Path, keys: dict[str, Any], said: str) -> None:
    with pytest.raises(lienumba.ScenarioError, match=said):
        resolve(scenario(file=str(dataset), **keys))


def test_what_varies_needs_a_number_in_start() -> None:
    vary = {"start.q.crank": {"distribution": "normal", "std": 0.1}}
    remedy = r"start\.q\.crank does not exist; give crank a number there, in start\.q, which is what it has without"
    with pytest.raises(lienumba.ScenarioError, match=remedy):
        resolve(scenario(("crank",)) | {"sweep": {"runs": 2, "vary": vary}})


def test_what_contradicts_a_driver_or_a_pose() -> None:
    with pytest.raises(lienumba.ScenarioError, match=r"prescribes the angle 0 at t = 0, but start.q.wheel = 1.0"):
        check_initial(resolve(scenario(("puck", "wheel"), q={"wheel": 1.0})))
    data = scenario(("crank",), q={"crank": 1.0})
    data["model"]["bodies"][0]["rotation"] = [1.0, 0.0, 0.0, 0.0]
    with pytest.raises(lienumba.ScenarioError, match=r"start.q.crank: contradicts what else is given"):
        check_initial(resolve(data))


def test_without_references_nothing_says_where_zero_is() -> None:
    data = scenario(("piston", "cross"), q={"cross": [0.1, 0.2]})
    del next(x for x in data["model"]["joints"] if x["name"] == "cross")["references"]
    with pytest.raises(lienumba.ScenarioError, match=r"joints.cross: its angle is prescribed .* from where it counts"):
        check_initial(resolve(data))


def test_without_references_pins_are_at_zero_at_the_start() -> None:
    data = scenario(("piston", "cross"), q={"piston": [0.1, 0.2]})
    del next(x for x in data["model"]["joints"] if x["name"] == "cross")["references"]
    q, _ = values(check_initial(resolve(data)))
    assert [q["cross.first_angle"], q["cross.second_angle"]] == [0.0, 0.0]
