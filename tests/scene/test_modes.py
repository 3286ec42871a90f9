"""Modes in motion: bodies that hang on a pivot move on arcs about it, a gyroscope's on circles, real modes fade or
grow; and each is as large as is well seen."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

import lienumba
from lienumba.scene import mode_scene
from lienumba.store import files
from tests.facade import ScenarioError

LENGTH = 0.5
SHORT = {"integrator": {"step": 1e-3, "end_time": 0.5}}


def pendulum(height: float = -LENGTH, **of_body: Any) -> dict[str, Any]:
    bob = {"name": "bob", "mass": 1.2, "inertia": [0.02, 0.02, 0.01], "position": [0, 0, height]} | of_body
    pivot = {"name": "pivot", "type": "revolute", "bodies": ["ground", "bob"], "at": [0, 0, 0], "axis": [0, 1, 0]}
    return {"model": {"bodies": [bob], "joints": [pivot]}, **SHORT}


def angles(run: Any) -> np.ndarray:
    return np.arctan2(-run.positions[:, 0, 0], -run.positions[:, 0, 2])


def test_a_pendulum_swings_on_an_arc_about_its_pivot() -> None:
    found = mode_scene(pendulum())
    (run,) = found.runs
    np.testing.assert_allclose(np.linalg.norm(run.positions[:, 0], axis=1), LENGTH, rtol=1e-14)
    share = run.times / run.times[-1]
    np.testing.assert_allclose(angles(run), angles(run)[0] * np.cos(2 * np.pi * share), atol=1e-14)
    period = 2 * np.pi * np.sqrt((0.02 + 1.2 * LENGTH**2) / (1.2 * 9.81 * LENGTH))
    assert run.times[-1] == pytest.approx(period, rel=1e-12)
    assert run.label == f"mode 1: {1 / period:.4g} Hz, damping 0" or run.label.startswith(
        f"mode 1: {1 / period:.4g} Hz"
    )
    (radius,) = (solid.radius for solid in run.mechanism.solids)
    assert 0.01 < abs(angles(run)[0]) * (LENGTH + radius) <= 0.1 * 2 * (LENGTH + radius)
    assert found.cycles


def test_joints_stay_where_they_are_at_any_time() -> None:
    """Where the pivot is on the body is said where the body starts, not where it is now."""
    swung = lienumba.modes(pendulum(angular_velocity=[0, 4, 0]), at=0.4)
    (run,) = mode_scene(swung).runs
    own = [mark.place for mark in run.mechanism.marks if mark.place.body == 0]
    assert abs(run.positions[0, 0] - [0, 0, -LENGTH]).max() > 0.1
    np.testing.assert_allclose(run.at(own), 0.0, atol=1e-12)


def test_no_file_is_opened_twice_at_a_time(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """HDF5 ended the process of a file that was opened again while it was open."""
    lienumba.run(pendulum() | {"output": {"every": 0.1}}, output=tmp_path / "runs.nc", progress=False)
    opened, seen = files._opened, list[xr.Dataset]()

    def watched(path: Path) -> xr.Dataset:
        assert all(dataset._close is None for dataset in seen)
        seen.append(opened(path))
        return seen[-1]

    monkeypatch.setattr(files, "_opened", watched)
    assert mode_scene(tmp_path / "runs.nc").runs
    assert len(seen) == 2


def test_a_precession_moves_on_a_circle_by_its_phase() -> None:
    ball = {"name": "tip", "type": "spherical", "bodies": ["ground", "top"], "points": [[0, 0, 0], [0, 0, -0.3]]}
    body = {"name": "top", "mass": 2.0, "inertia": [0.05, 0.05, 0.03], "rotation": [1, 0, 0, 0],
            "angular_velocity": [0, 0, 120.0]}  # fmt: skip
    found = lienumba.modes({"model": {"bodies": [body], "joints": [ball]}, **SHORT})
    which = int(found["mode"][(found.frequency > 0.0).values[0, 0]][0])
    (run,) = mode_scene(found, modes=which).runs
    away = np.linalg.norm(run.rotations[:, 0, :2, 2], axis=1)
    assert away.min() > 0.01
    np.testing.assert_allclose(away, away[0], rtol=1e-12)
    np.testing.assert_allclose(run.positions[:, 0], 0.3 * run.rotations[:, 0, :, 2], atol=1e-14)


def test_real_modes_fade_and_grow() -> None:
    found = mode_scene(pendulum(LENGTH), modes=range(1, 9))
    growth = np.sqrt(1.2 * 9.81 * LENGTH / (0.02 + 1.2 * LENGTH**2))
    told = [f"mode 1: grows by {growth:.3g} 1/s", f"mode 2: fades by {growth:.3g} 1/s"]
    assert [run.label for run in found.runs] == told
    for run, last in zip(found.runs, (np.exp(4), np.exp(-4)), strict=True):
        turned = np.arctan2(run.rotations[:, 0, 0, 2], run.rotations[:, 0, 0, 0])
        assert turned[-1] / turned[0] == pytest.approx(last, rel=1e-12)


def test_what_there_is_not_is_told() -> None:
    found = lienumba.modes(pendulum())
    with pytest.raises(ScenarioError, match="run 0 has no mode 3 at t = 0 s, but 1 mode, 1; give one of them"):
        mode_scene(found, modes=3)
    with pytest.raises(ScenarioError, match="has no run 4, but 1 run with labels from 0 to 0; give one that has"):
        mode_scene(found, run=4)
    with pytest.raises(ScenarioError, match="has no shapes of modes; find them with shapes=True"):
        mode_scene(lienumba.modes(pendulum(), shapes=False))
