"""Numbers of whole runs by functions of one's own, against what the stored courses say."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

import lienumba
from lienumba import ScenarioError

TEXT = '''"""Numbers of courses."""
import numpy as np


def path(x):
    """The length of the way."""
    return np.linalg.norm(np.diff(x, axis=0), axis=1).sum()


def slowest(t, speed_v, *, power=1.0):
    return float(np.abs(speed_v).min() ** power + 0 * t[-1])


def last(t):
    return t[-1]


def seen(position, rotation):
    assert position.shape[1:] == (1, 3) and rotation.shape[1:] == (1, 3, 3)
    return position[-1, 0, 0]


def fails(t):
    return t[99]


def many(t):
    return t


def lost(nowhere):
    return 0.0


def all_of(*courses):
    return 0.0
'''
DATA: dict[str, Any] = {
    "parameters": {"w": "2*pi", "start": 1.0},
    "model": {
        "gravity": [0, 0, 0],
        "bodies": [
            {"name": "bob", "mass": 1.0, "inertia": [1, 1, 1], "position": ["start", 0, 0], "rotation": [1, 0, 0, 0]}
        ],
        "forces": [{"name": "pull", "type": "force", "body": "bob", "value": ["-w**2*x.x", 0, 0]}],
    },
    "quantities": [
        {"name": "x", "type": "point", "body": "bob"},
        {"name": "speed", "type": "distance", "bodies": ["ground", "bob"], "points": [[-9, 0, 0], [0, 0, 0]]},
    ],
    "integrator": {"step": 0.01, "end_time": 1.0},
    "output": {"every": 0.1, "variables": ["x", "position"]},
    "sweep": {"runs": 12, "seed": 3, "vary": {"parameters.start": {"distribution": "uniform", "low": 0.5, "high": 2}}},
}


def asking(folder: Path, *functions: str, **keys: Any) -> dict[str, Any]:
    file = folder / "reducers.py"
    file.write_text(TEXT.replace("speed_v", "speed_speed"), encoding="utf-8")
    return DATA | {"measures": [{"name": x, "function": f"{file}:{x}", "units": "m"} for x in functions]} | keys


def test_functions_see_courses_by_name(tmp_path: Path) -> None:
    ds = lienumba.run(asking(tmp_path, "path", "slowest", "last", "seen"))
    x = ds["x"].values
    np.testing.assert_array_equal(ds["path"], np.linalg.norm(np.diff(x, axis=1), axis=2).sum(axis=1))
    np.testing.assert_allclose(ds["slowest"], 0.0, atol=1e-9)  # it starts from rest
    np.testing.assert_array_equal(ds["last"], 1.0)
    np.testing.assert_array_equal(ds["seen"], ds["position"][:, -1, 0, 0])
    assert ds["path"].attrs["units"] == "m"
    assert ds["path"].attrs["measure"].endswith("reducers.py:path")


def test_nothing_need_be_stored_and_nothing_is_decided(tmp_path: Path) -> None:
    """In summaries, by names in requirements, in files that are resumed, in parts; a run that stops has fewer times."""
    stored = lienumba.run(asking(tmp_path, "path"))
    wanted = [{"name": "short", "value": "path", "below": 6.0, "probability": 0.5}]
    lean = {"every": 0.1, "mode": "summary"}
    ds = lienumba.run(asking(tmp_path, "path", output=lean, requirements=wanted))
    np.testing.assert_array_equal(ds["path"], stored["path"])
    np.testing.assert_array_equal(ds["requirement_met"][:, 0], ds["path"] < 6.0)
    plain = lienumba.run(DATA)
    assert plain.attrs["scenario_sha256"] == stored.attrs["scenario_sha256"]
    parts = [tmp_path / f"part{n}.nc" for n in (1, 2)]
    for n, part in enumerate(parts, 1):
        lienumba.run(asking(tmp_path, "path", output=lean), part=f"{n}/2", output=part)
    lienumba.merge(parts, tmp_path / "all.nc", allow_code=True)
    with xr.open_dataset(tmp_path / "all.nc") as whole:
        np.testing.assert_array_equal(whole["path"], stored["path"])
        with pytest.raises(ScenarioError, match=r"brings Python code, which a replay runs: reducers\.py"):
            lienumba.replay(whole, 3)
        again = lienumba.replay(whole, 3, allow_code=True)
    np.testing.assert_array_equal(again["path"], stored["path"][3:4])
    stops = [{"name": "over", "when": "x.x < 0", "action": "stop"}]
    early = lienumba.run(asking(tmp_path, "last", events=stops))
    np.testing.assert_array_equal(early["last"], 0.2)  # of a quarter of a period


def test_a_function_may_be_handed_over() -> None:
    def reach(x: Any) -> float:
        return float(x[:, 0].max())

    system = lienumba.System("spring").body("bob", mass=1, inertia=[1, 1, 1], position=[0.5, 0, 0], velocity=[1, 0, 0])
    system.quantity("x", "point", body="bob").measure("reach", function=reach).integrator(step=0.1, end_time=1)
    assert float(lienumba.run(system)["reach"][0]) == pytest.approx(1.5)


WRONG = {
    "fails": "reducers.py cannot be run: line 24, `return t[99]`: IndexError: index 99 is out of bounds for axis 0 "
    "with size 11; correct it",
    "many": 'returns "array(',
    "lost": 'asks for "nowhere", of which there is no course; known',
    "all_of": "has the argument *courses, but it is called by names; write one for each course, such as (t, tip)",
    "gone": "reducers.py has no function gone; known",
}


@pytest.mark.parametrize(("function", "sentence"), WRONG.items())
def test_what_is_wrong_with_a_function_is_said(tmp_path: Path, function: str, sentence: str) -> None:
    with pytest.raises(ScenarioError) as caught:
        lienumba.run(asking(tmp_path, function))
    assert str(caught.value).startswith(f'measures.{function}.function = "')
    assert sentence in str(caught.value)


def test_a_value_or_a_function(tmp_path: Path) -> None:
    asking(tmp_path)
    for keys in ({}, {"value": "max(x.x)", "function": f"{tmp_path}/reducers.py:path"}):
        rule = "needs a value, a formula with reducers, or a function" if not keys else "has value and function"
        with pytest.raises(ScenarioError, match=f"measures.far: {rule}; write one"):
            lienumba.run(asking(tmp_path, measures=[{"name": "far", **keys}]))
