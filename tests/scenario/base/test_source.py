"""Laws that are handed over as functions of Python: their text, with all that they use, goes into the scenario."""

import importlib
import math
import sys
import tomllib
from functools import partial
from typing import Any

import numpy as np
import pytest

import lienumba
from lienumba import laws
from lienumba.laws import Vector, clip
from tests.facade import resolve
from tests.laws import functions
from tests.laws.rigs import pendulum, run

GAIN, CENTRE, NAMES = 7, (0.0, 0.5), ["x", "y"]
HOOKED = {"kp": 3}


def alone(joint):
    return joint.effort(-7 * joint.angle + 0.5)


def helper(x):
    """Uses a constant, and is used."""
    return -GAIN * x


def with_helper(joint):
    return joint.effort(helper(joint.angle) + CENTRE[1])


def with_imports(joint):
    """A function and a module of `laws`, and one of Python's, on ordinary numbers."""
    return joint.effort(clip(helper(joint.angle), -1e9, 1e9) + laws.cos(0.0) * math.sqrt(0.25))


def with_a_helper_inside(joint):
    def inner(x):
        return helper(x)

    return joint.effort(inner(joint.angle) + sum(0.25 for _ in NAMES))


def with_annotations(joint: laws.Joint, *, kp: float = 7.0, at: Vector | None = None) -> list[laws.Load]:
    """With defaults, which stay as they are."""
    return [joint.effort(-kp * joint.angle), joint.effort(0.5)]


angle = HOOKED  # which nothing of a name of its own reads


def with_an_attribute_named_like_a_global(joint):
    return joint.effort(helper(joint.angle) + 0.5)


def even(n):
    return 0.5 if n == 0 else odd(n - 1)


def odd(n):
    return even(n - 1)


def with_a_circle(joint):
    return joint.effort(helper(joint.angle) + even(4))


SAME = [
    alone, with_helper, with_imports, with_a_helper_inside, with_annotations, with_an_attribute_named_like_a_global,
    with_a_circle,
]  # fmt: skip


def own(function: Any, **keys: Any) -> dict[str, Any]:
    return {"name": "own", "type": "python", "function": function, "joints": ["hinge"], **keys}


def data(function: Any, **keys: Any) -> dict[str, Any]:
    return pendulum(own(function, **keys), end=0.2)


BUILT_IN = {"name": "own", "type": "actuator", "joint": "hinge", "value": 0.5, "stiffness": 7}


@pytest.mark.parametrize("function", SAME, ids=lambda f: f.__name__)
def test_a_function_of_python_is_written_out_with_all_that_it_uses(function):
    scenario = resolve(data(function))
    (text,) = scenario.data.files.values()
    assert f"def {function.__name__}(" in text
    assert ("def helper" in text) == ("helper" in function.__code__.co_names or "helper" in function.__name__)
    ds = run(data(function))
    np.testing.assert_allclose(ds.position, run(pendulum(BUILT_IN, end=0.2)).position, rtol=0, atol=1e-13)
    again = tomllib.loads(scenario.to_toml())
    assert resolve(again).sha256() == scenario.sha256()
    np.testing.assert_array_equal(run(again).position, ds.position)


@pytest.mark.parametrize("name", [name for name in laws.__all__ if callable(getattr(laws, name))])
def test_what_laws_are_written_with_can_be_imported_by_its_name(name, tmp_path, monkeypatch):
    """Of functions their values, too."""
    (tmp_path / "wheel.py").write_text(
        f"from lienumba.laws import {name}\n\n\ndef f(j):\n    {name}\n    return j.effort(0.5)\n"
    )
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.delitem(sys.modules, "wheel", raising=False)
    (text,) = resolve(data(importlib.import_module("wheel").f)).data.files.values()
    read: dict[str, Any] = {}
    exec(text, read)
    assert read[name] is getattr(laws, name)


def test_what_it_does_not_use_does_not_change_the_hash(monkeypatch):
    before = resolve(data(with_helper)).sha256()
    monkeypatch.setitem(globals(), "NAMES", ["z"])
    assert resolve(data(with_helper)).sha256() == before
    monkeypatch.setitem(globals(), "GAIN", 8)
    assert resolve(data(with_helper)).sha256() != before


def test_a_system_takes_functions_and_writes_them(tmp_path):
    def build() -> lienumba.System:
        system = lienumba.System("arm")
        system.body("rod", mass=1, inertia=[0.1, 0.1, 0.1], rotation={"axis": [0, 1, 0], "angle": 0.5})
        system.joint("hinge", "revolute", ["ground", "rod"], points=[[0, 0, 0], [0, 0, 1]], axes=[[0, 1, 0]] * 2)
        system.joint("flat", "python", ["rod"], function=in_plane)
        system.force("own", type="python", function=functions.pid, joints=["hinge"], states={"integral": 0.1},
                     parameters={"kp": 20, "ki": 5, "kd": 2, "target": 1.0})  # fmt: skip
        system.force("late", type="python", function=functions.motor, joints=["hinge"], states={"torque": 0},
                     parameters={"volts": 2, "lag": 0.1}, every=0.05)  # fmt: skip
        return system.integrator(step=0.01, end_time=0.2)

    file = tmp_path / "arm.toml"
    file.write_text(build().to_toml(), encoding="utf-8")
    direct, read = run(build()), run(file, allow_code=True)
    assert direct.attrs["scenario_sha256"] == read.attrs["scenario_sha256"] == resolve(build()).sha256()
    for name in ("position", "own.integral", "late.torque", "joint_force"):
        np.testing.assert_array_equal(direct[name], read[name], err_msg=name)
    stored = tomllib.loads(direct.attrs["scenario"])
    assert set(stored["files"]) == {"pid.py", "motor.py", "in_plane.py"}
    np.testing.assert_array_equal(run(stored).position, direct.position)


def in_plane(body):
    return body.position.y


def test_two_files_of_one_name_keep_their_own_text(tmp_path):
    """And a function of one file that is named twice is kept once."""
    for folder, size in (("a", 2), ("b", 3)):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / "law.py").write_text(f"def f(j):\n    return j.effort({size})\n")
    files = [str(tmp_path / folder / "law.py:f") for folder in "aba"]
    forces = [own(file) | {"name": f"own{n}"} for n, file in enumerate(files)]
    scenario = resolve(pendulum(*forces, end=0.1))
    assert sorted(scenario.data.files) == ["law.py", "law_2.py"]
    assert [f.function for f in scenario.data.model.forces] == ["law.py:f", "law_2.py:f", "law.py:f"]
    actuator = {"name": "own", "type": "actuator", "joint": "hinge", "value": 7}
    a, b = run(pendulum(*forces, end=0.1)), run(pendulum(actuator, end=0.1))
    np.testing.assert_allclose(a.position, b.position, rtol=0, atol=1e-13)


# ---------------------------------------------------------------- what is hard to write
ENDLESS, MEASURED, OTHER_NAME = math.inf, np.float64(7.0), helper


def with_infinity(joint):
    return joint.effort(clip(helper(joint.angle) + 0.5, -ENDLESS, ENDLESS))


def with_a_number_of_numpy(joint):
    return joint.effort(-MEASURED * joint.angle + 0.5)


def with_another_name(joint):
    return joint.effort(OTHER_NAME(joint.angle) + 0.5)


def with_a_local_name(joint):
    HOOKED = 0.5
    return joint.effort(helper(joint.angle) + HOOKED)


@pytest.mark.parametrize("function", [with_infinity, with_a_number_of_numpy, with_another_name, with_a_local_name])
def test_it_is_written_out_right(function):
    ds = run(data(function))
    np.testing.assert_allclose(ds.position, run(pendulum(BUILT_IN, end=0.2)).position, rtol=0, atol=1e-13)


def test_a_helper_in_a_module_of_ones_own_is_kept_too(tmp_path, monkeypatch):
    (tmp_path / "lienumba_helpers.py").write_text("def pull(x):\n    return -7 * x\n")
    (tmp_path / "lienumba_law.py").write_text(
        "from lienumba_helpers import pull\n\n\ndef f(joint):\n    return joint.effort(pull(joint.angle) + 0.5)\n"
    )
    with monkeypatch.context() as patch:
        patch.syspath_prepend(tmp_path)
        scenario = resolve(data(importlib.import_module("lienumba_law").f))
    for name in ("lienumba_law", "lienumba_helpers"):
        monkeypatch.delitem(sys.modules, name)
    run(tomllib.loads(scenario.to_toml()))


# ---------------------------------------------------------------- what has no text
PAIR = (helper, 0.5)


def with_a_tuple_of_functions(joint):
    return joint.effort(PAIR[0](joint.angle) + PAIR[1])


def nested(factor):
    def law(joint):
        return joint.effort(factor * joint.angle)

    return law


def with_a_dict(joint):
    return joint.effort(HOOKED["kp"] * joint.angle)


class Controller:
    def law(self, joint):
        return joint.effort(1.0)

    def __call__(self, joint):
        return joint.effort(2.0)


made = {}
exec("def typed(joint):\n    return joint.effort(1.0)\n", made)

NOT_WRITTEN = {
    "lambda": (lambda joint: joint.effort(1.0), "must be a plain function, written with def, but is a lambda"),
    "closure": (nested(3), "law uses factor of the function around it; make it a parameter"),
    "a dict": (with_a_dict, "with_a_dict uses HOOKED, which cannot be written into a file; make it a parameter"),
    "without text": (made["typed"], "the text of typed is not known; write it with def, in a file"),
}


def test_what_cannot_be_written_as_text_is_refused():
    with pytest.raises(lienumba.ScenarioError, match="uses PAIR, which cannot be written into a file; make it a param"):
        run(data(with_a_tuple_of_functions))


@pytest.mark.parametrize("case", NOT_WRITTEN)
def test_what_cannot_be_written_out(case):
    function, sentence = NOT_WRITTEN[case]
    with pytest.raises(lienumba.ScenarioError) as caught:
        resolve(data(function))
    assert str(caught.value).startswith(f"model.forces.own.function: {sentence}")
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    "function",
    [Controller(), partial(alone), Controller().law, print, Controller],
    ids=lambda f: type(f).__name__,
)
def test_what_is_no_plain_function(function):
    """An object that can be called, a method, a partial function, a class."""
    with pytest.raises(lienumba.ScenarioError) as caught:
        resolve(data(function))
    assert str(caught.value).startswith("model.forces.own.function: ")
    assert "\n" not in str(caught.value)
