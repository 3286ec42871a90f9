"""Short sweeps, samples edited on purpose, and datasets compared bit by bit."""

import copy
from collections.abc import Mapping, Sequence, Set
from typing import Any

import numpy as np
import pytest

import lienumba
from lienumba.scenario.reading.loading import load
from lienumba.scenario.start import design
from tests.rigs import parts
from tests.rigs.places import SCENARIOS
from tests.rigs.scenarios import BENNETT, LOOP, chain, scenario

COUNTS = {"position_iterations", "velocity_iterations"}  # the most since the last output: they belong to an interval


def top(runs: int = 40, end: float = 0.05, **sections: Any) -> dict[str, Any]:
    """The Monte-Carlo heavy top of the gallery, shortened."""
    data = load(SCENARIOS / "heavy_top_monte_carlo.toml")
    data["integrator"]["end_time"] = end
    data["sweep"]["runs"] = runs
    return _with(data, sections)


def links(runs: int = 20, count: int = 5, **sections: Any) -> dict[str, Any]:
    """A chain, long enough that its stage is a function of its own, with varied masses, inertia and rates."""
    data = scenario(chain(count), 1e-3, 0.02, output={"every": 0.005})
    data["sweep"] = {"runs": runs, "seed": 5, "vary": {
        "bodies.link0.mass": {"distribution": "normal", "std": 0.05},
        "bodies.link2.inertia[4]": {"distribution": "uniform", "low": -0.002, "high": 0.002},
        f"bodies.link{count - 1}.angular_velocity[1]": {"distribution": "normal", "std": 0.5},
        "joints.hinge1.points[1][2]": {"distribution": "uniform", "low": 0.19, "high": 0.21},
    }}  # fmt: skip
    return _with(data, sections)


def loop(runs: int = 20, **sections: Any) -> dict[str, Any]:
    """A loop with rods whose ends vary, Heun's method, and a coarse step: several iterations of the projection."""
    data = scenario(LOOP, 0.02, 0.2, method="heun", output={"every": 0.04})
    data["sweep"] = {"runs": runs, "seed": 6, "vary": {
        "joints.tie.points[0][2]": {"distribution": "normal", "std": 0.02},
        "bodies.left.angular_velocity[0]": {"distribution": "normal", "std": 3.0},
        "gravity[0]": {"distribution": "uniform", "low": -1, "high": 1},
    }}  # fmt: skip
    return _with(data, sections)


def linkage(runs: int = 20, **sections: Any) -> dict[str, Any]:
    """Bennett's linkage: the fast ones get to where they need other rows of the redundant ones."""
    data = scenario(BENNETT, 2e-3, 0.16, output={"every": 0.04})
    data["sweep"] = {"runs": runs, "seed": 7, "vary": {
        "joints.hinge1.rate": {"distribution": "uniform", "low": 1, "high": 9},
        "bodies.second.mass": {"distribution": "normal", "std": 0.05},
        "gravity[1]": {"distribution": "uniform", "low": -1, "high": 1},
    }}  # fmt: skip
    return _with(data, sections)


def wheel(runs: int = 20, **sections: Any) -> dict[str, Any]:
    """A body on a pivot whose axle is held by two axes of the ground and one of its own, one more than needed: within a
    quarter of a turn its own gets weak, and the fast ones need the other of the ground. The smallest that exchanges."""
    first, second, axle = np.array([[2, 1, 2], [-2, 2, 1], [-1, -2, 2]]) / 3
    held = [(first, [0, 0, 1]), (axle, [0, 1, 0]), (0.5 * first + 0.866 * second, [0, 0, 1])]
    joints = [{"name": "hub", "type": "spherical", "bodies": ["ground", "wheel"], "points": [[0, 0, 0], [0.1, 0.2, 0]]}]
    joints += [{"name": f"axle{n}", "type": "perpendicular_axes", "bodies": ["ground", "wheel"],
                "axes": [ours.tolist(), its]} for n, (ours, its) in enumerate(held)]  # fmt: skip
    body = {"name": "wheel", "mass": 1.2, "inertia": [0.05, 0.07, 0.04, -0.004, 0.006, 0.001],
            "rotation": {"axis": [1, -1, 1], "angle": np.pi / 3}, "angular_velocity": [0, 0, 5]}  # fmt: skip
    data = scenario({"model": {"bodies": [body], "joints": joints}}, 4e-3, 0.32, output={"every": 0.08})
    data["sweep"] = {"runs": runs, "seed": 8, "vary": {
        "bodies.wheel.angular_velocity[2]": {"distribution": "uniform", "low": 1, "high": 9},
        "bodies.wheel.mass": {"distribution": "normal", "std": 0.05},
        "gravity[1]": {"distribution": "uniform", "low": -1, "high": 1},
    }}  # fmt: skip
    return _with(data, sections)


def paced(runs: int = 20, **sections: Any) -> dict[str, Any]:
    """The heavy top, with steps that a tolerance chooses and an event that some runs see."""
    data = top(runs, 0.02)
    del data["integrator"]["step"]
    data["integrator"] |= {"tolerance": 1e-8, "method": "tsit54"}
    data["events"] = [{"name": "tilted", "when": "tip.z < -0.0005", "action": "stop"}]
    data["quantities"] = [{"name": "tip", "type": "point", "body": "top"}]
    return _with(data, sections)


def bounces(runs: int = 20, **sections: Any) -> dict[str, Any]:
    """A body that falls on a point of its own, rebounds, slides and sticks, each run at its own times."""
    body = parts.body("b", 2.0, [0.3, 0.6, 0.4], position=[0, 0, 0.3], velocity=[1, 0.2, 0])
    contact = parts.foot("c", "b", restitution=0.5, friction=0.3)
    vary = {
        "bodies.b.velocity[2]": {"distribution": "uniform", "low": -1, "high": 1},
        "contacts.c.friction": {"distribution": "uniform", "low": 0, "high": 0.6},
    }
    data = {
        "model": {"gravity": [0, 0, -9.81], "bodies": [body], "contacts": [contact]},
        "integrator": {"end_time": 0.6, "tolerance": 1e-6},
        "output": {"every": 0.1},
        "sweep": {"runs": runs, "seed": 9, "vary": vary},
    }
    return _with(data, sections)


def two_rods(**sections: Any) -> dict[str, Any]:
    """A body on a sphere and two rods to ground, whose ends there never meet, until a sample is edited."""
    data = top(**sections)
    del data["model"]["bodies"][0]["angular_velocity"]
    data["model"]["joints"] += [
        {"name": name, "type": "distance", "bodies": ["ground", "top"], "points": [[1, y, 0.5], [0.3, 0, 0.2]]}
        for name, y in (("near", -0.6), ("far", -0.7))
    ]
    data["sweep"]["vary"] = {"joints.near.points[0][1]": {"distribution": "uniform", "low": -0.62, "high": -0.58}}
    return data


def a_rod(**sections: Any) -> dict[str, Any]:
    """The body may turn, so that its rod, of varied length, fits."""
    data = two_rods(**sections)
    del data["model"]["bodies"][0]["rotation"]
    del data["model"]["joints"][2]
    data["model"]["joints"][1]["length"] = 1.77
    data["sweep"]["vary"] = {"joints.near.length": {"distribution": "uniform", "low": 1.76, "high": 1.78}}
    return data


SWEEPS = {"top": top, "links": links, "loop": loop, "wheel": wheel}


def _with(data: dict[str, Any], sections: Mapping[str, Any]) -> dict[str, Any]:
    data = copy.deepcopy(data)
    for name, keys in sections.items():
        data[name] = keys if name == "output" else {**data.get(name, {}), **keys}
    return data


def run(data: dict[str, Any], **options: Any) -> Any:
    return lienumba.run(data, **{"workers": 1, **options})


def edit_samples(monkeypatch: pytest.MonkeyPatch, edits: Mapping[int, Mapping[str, float]]) -> None:
    """From now on these samples, by label and path, are what is written here."""
    original = design.design_table

    def edited(vary: Any, nominal: Any, labels: Sequence[int], *more: Any, **options: Any) -> dict[str, np.ndarray]:
        drawn = original(vary, nominal, labels, *more, **options)
        samples = {path: np.array(values) for path, values in drawn.items()}
        for label, values in edits.items():
            for path, value in values.items():
                if label in labels:
                    samples[path][list(labels).index(label)] = value
        return samples

    monkeypatch.setattr(design, "design_table", edited)


def assert_same(a: Any, b: Any, *, without: Set[str] = frozenset(), only_common: bool = False) -> None:
    """The same coordinates and the same bits in every variable (in the common ones)."""
    if not only_common:
        assert set(a.variables) == set(b.variables)
    names = (set(a.variables) & set(b.variables)) - without
    assert {"run", "time"} <= names
    different = [name for name in sorted(names) if bits(a[name]) != bits(b[name])]
    assert not different, f"these variables differ: {', '.join(different)}"


def bits(array: Any) -> tuple[tuple[int, ...], bytes]:
    values = np.asarray(array.values)
    return values.shape, (values.astype(str) if values.dtype == object else values).tobytes()  # texts of a file
