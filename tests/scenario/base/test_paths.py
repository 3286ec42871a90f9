"""Paths to numbers: parsing, canonical text, getting and setting, units."""

import pytest

from lienumba.scenario.base import paths
from lienumba.scenario.base.paths import PathError, with_values
from tests.facade import resolve
from tests.rigs.scenario_example import example

MODEL = {
    "gravity": [0.0, 0.0, -9.81],
    "bodies": [
        {"name": "a", "mass": 1.0, "rotation": {"axis": [0.0, 0.0, 1.0], "angle": 0.5}},
        {"name": "b", "mass": 2.0, "inertia": [[1.0, 0.0], [0.0, 1.0]]},
    ],
    "joints": [{"name": "j", "type": "spherical", "points": [[0.0, 1.0, 2.0], [3.0, 4.0, 5.0]]}],
}


@pytest.mark.parametrize(
    ("text", "canonical", "value"),
    [
        ("gravity[2]", "gravity[2]", -9.81),
        ("model.gravity[2]", "gravity[2]", -9.81),
        (" bodies.b.mass ", "bodies.b.mass", 2.0),
        ("bodies.a.rotation.angle", "bodies.a.rotation.angle", 0.5),
        ("bodies.b.inertia[1][0]", "bodies.b.inertia[1][0]", 0.0),
        ("joints.j.points[1][2]", "joints.j.points[1][2]", 5.0),
        ('bodies."a".mass', "bodies.a.mass", 1.0),
        ("bodies[1].mass", "bodies.b.mass", 2.0),
        ("model.joints[0].points[1][2]", "joints.j.points[1][2]", 5.0),
    ],
)
def test_get(text: str, canonical: str, value: float) -> None:
    assert paths.canonical(text, MODEL) == canonical
    assert paths.get(MODEL, paths.parse(canonical)) == value


@pytest.mark.parametrize("text", ["", ".", "a..b", "[0]", "a[", "a[x]", "a[-1]", "a.b[1", "a b", "a.[0]"])
def test_not_a_path(text: str) -> None:
    with pytest.raises(PathError, match="is not a path"):
        paths.parse(text)


@pytest.mark.parametrize("text", ["bodies.c.mass", "gravity[3]", "gravity.x", "bodies.a.mass[0]", "joint.j"])
def test_leads_nowhere(text: str) -> None:
    with pytest.raises(PathError):
        paths.get(MODEL, paths.parse(text))


def test_every_numeric_path_leads_to_its_number() -> None:
    found = paths.numeric_paths(MODEL)
    assert len(found) == len(set(found)) == 3 + 5 + 5 + 6
    for path in found:
        assert paths.canonical(path, MODEL) == path
        assert isinstance(paths.get(MODEL, paths.parse(path)), float)


def test_put_replaces_the_value_and_nothing_else() -> None:
    model = {"bodies": [{"name": "a", "mass": 1.0}, {"name": "b", "mass": 2.0}]}
    paths.put(model, paths.parse("bodies.b.mass"), 3.0)
    assert model == {"bodies": [{"name": "a", "mass": 1.0}, {"name": "b", "mass": 3.0}]}


@pytest.mark.parametrize("text", ['sweep.vary."bodies.a.mass".std', "sweep.vary.bodies.a.mass.std"])
def test_a_varied_path_is_one_key_even_without_quotes(text: str) -> None:
    assert paths.parse(text) == ["sweep", "vary", "bodies.a.mass", "std"]


def test_values_take_their_places_in_a_copy() -> None:
    model = resolve(example()).data.model
    changed = with_values(
        model,
        {("bodies", "top", "mass"): 2.0, ("bodies", 0, "position", 1): 3.0, ("bodies", "top", "rotation"): [0, 1]},
    )
    (top,) = changed.bodies
    assert (top.mass, top.position, top.rotation) == (2.0, [0.0, 3.0, 0.0], [0, 1])
    assert (model.bodies[0].mass, model.bodies[0].position) == (15.0, [0.0, 1.0, 0.0])
    assert changed.joints is model.joints
