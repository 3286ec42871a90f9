"""What is wrong in the same way for all types of joints: points, axes, references, keys of other types."""

from pathlib import Path

import pytest

from tests.scenario.checks.refusal import PIVOT, joint, refused_by_both, rig

POINTS = "points = [[0, 0, -0.3], [0, 0, 0]]"
AXES = dict.fromkeys(
    ["revolute", "universal", "cylindrical", "prismatic", "fixed", "planar", "parallel_axes", "perpendicular_axes",
     "screw"], 2,
) | {"point_on_line": 1, "point_in_plane": 1, "spherical": 0, "distance": 0}  # fmt: skip
POINTLESS = ("parallel_axes", "perpendicular_axes")
WITH_AT = [kind for kind in AXES if kind not in (*POINTLESS, "distance")]
TWO_POINTS = "give two points in m, each with 3 numbers in the frame of its own body"
TWO_AXES = "two directions, each with 3 numbers in the frame of its own body"


def of_type(kind: str, *lines: str) -> str:
    return rig(joint(f'type = "{kind}"', *(["pitch = 0.1"] if kind == "screw" else []), *lines))


@pytest.mark.parametrize("kind", [kind for kind in AXES if kind not in POINTLESS])
def test_wrong_points(tmp_path: Path, kind: str) -> None:
    axes = f"axes = {[[0, 1, 0]] * AXES[kind]}" if AXES[kind] else ""
    other = ", or at = [x, y, z] in the global frame at the start" if kind in WITH_AT else ""
    at = "model.joints.extra.points"
    assert refused_by_both(tmp_path, of_type(kind, axes)) == [f"{at} is missing; {TWO_POINTS}{other}"]


@pytest.mark.parametrize("kind", WITH_AT)
def test_points_and_at(tmp_path: Path, kind: str) -> None:
    axes = f"axes = {[[0, 1, 0]] * AXES[kind]}" if AXES[kind] else ""
    assert refused_by_both(tmp_path, of_type(kind, axes, POINTS, "at = [0, 0, 0]")) == [
        "model.joints.extra.at = [0.0, 0.0, 0.0]: the joint has points already; give either points (in the bodies' own "
        "frames) or at (in the global frame at the start)"
    ]


@pytest.mark.parametrize("kind", [kind for kind, axes in AXES.items() if axes])
def test_wrong_axes(tmp_path: Path, kind: str) -> None:
    points = "" if kind in POINTLESS else POINTS
    own = TWO_AXES if AXES[kind] == 2 else "the direction in the frame of the first body, as [[x, y, z]]"
    pair = kind in ("universal", "perpendicular_axes")
    common = "[[x, y, z], [x, y, z]]" if pair else "[x, y, z]"
    axis, zero = ("[[1, 0, 0], [0, 0, 0]]", "axis[1]") if pair else ("[0, 0, 0]", "axis")
    at = "model.joints.extra"
    cases = {
        "axes = [[0, 0, 0], [0, 1, 0]]": f"{at}.axes[0] = [0.0, 0.0, 0.0]: has no direction; give 3 numbers that are "
        "not all 0",
        f"axis = {axis}": f"{at}.{zero} = [0.0, 0.0, 0.0]: has no direction; give 3 numbers that are not all 0",
    }
    if kind != "fixed":
        cases[""] = f"{at}.axes is missing; give {own}, or axis = {common} in the global frame at the start"
    for axes, message in cases.items():
        assert refused_by_both(tmp_path, of_type(kind, points, axes)) == [message]


@pytest.mark.parametrize("kind", ["revolute", "cylindrical", "prismatic", "fixed", "screw"])
def test_wrong_references(tmp_path: Path, kind: str) -> None:
    at = "model.joints.extra.references"
    assert refused_by_both(tmp_path, of_type(kind, POINTS, PIVOT, "references = [[0, 2, 0], [1, 0, 0]]")) == [
        f"{at}[0] = [0.0, 2.0, 0.0]: is parallel to the axis [0.0, 1.0, 0.0]; give a direction across it"
    ]
    assert refused_by_both(tmp_path, of_type(kind, POINTS, PIVOT, "references = [[1, 0, 0], [0, 0, 0]]")) == [
        f"{at}[1] = [0.0, 0.0, 0.0]: has no direction; give 3 numbers that are not all 0"
    ]
