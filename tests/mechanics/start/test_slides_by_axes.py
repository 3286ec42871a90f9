"""What slides on a body, and has no references, is turned as that body is, wherever its hinge has turned it."""

from typing import Any

import numpy as np
import pytest

import lienumba
from tests.rigs import parts


@pytest.mark.parametrize("free", [0, 4])
@pytest.mark.parametrize("kind", ["prismatic", "fixed"])
@pytest.mark.parametrize("axis", [[0, 1, 0], [0, 0.6, 0.8], [0.6, 0.8, 0], [0.2, 0.3, 0.93]])
def test_a_slide_is_turned_as_its_base(axis: list[float], kind: str, free: int) -> None:
    """It was turned back about the slide by up to 0.5 rad, as far as that came nearer to where it was drawn."""
    bodies = [parts.body("b", 1.0, [0.02, 0.01, 0.03]), parts.body("c", 0.5, [0.004, 0.006, 0.005])]
    bodies += [parts.body(f"x{n}", 1, 1, position=[n, 0, 9], rotation=[1, 0, 0, 0]) for n in range(free)]
    across = np.cross(axis, [1.0, 0.3, -0.2]).tolist()
    place: Any = {"axis": axis, "references": [across, across], "angle": 0.9, "rate": 0.0}
    hinge = parts.pivot("h", "b", second=[0.2, 0, 0.05], **place)
    on = parts.joint("s", kind, "c", "b", points=[[-0.2, 0, 0], [0, 0, 0]])
    on |= {"axes": [[1, 0, 0]] * 2, "displacement": 0.05, "speed": 0.0} if kind == "prismatic" else {}
    joints = [hinge, on | ({"references": [[0, 1, 0]] * 2} if kind == "fixed" else {})]
    ds = lienumba.run({
        "model": {"bodies": bodies, "joints": joints}, "integrator": {"step": 1e-3, "end_time": 1e-3},
    }, progress=False)  # fmt: skip
    base, slider = (ds["rotation"].sel(body=name).values[0, 0] for name in "bc")
    np.testing.assert_allclose(base.T @ slider, np.eye(3), rtol=0, atol=1e-12)
