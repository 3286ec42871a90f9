"""Functions of C in laws: the bits of the same laws for Numba, run by run; refused before runs begin."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import lienumba
from lienumba.compiler.foreign.libraries import LibraryFunction
from tests.facade import ScenarioError, resolve
from tests.laws.rigs import pendulum, run
from tests.laws.test_jitted import arm, swinging
from tests.rigs.libraries import built

LAWS = """
import ctypes
import lienumba

library = ctypes.CDLL({path!r})
controller = lienumba.foreign(library.pid, inputs=8, outputs=1, states=1)
limited = lienumba.foreign(library.limited, inputs=3, outputs=1)
counted = lienumba.foreign(library.counted, inputs=1, outputs=1)


def pid(joint, *, kp, ki, kd, target, limit, states, interval):
    torque, integral = controller(
        (joint.angle, joint.rate), kp, ki, kd, target, limit, interval, states=states.integral
    )
    return joint.effort(torque), {{"integral": integral}}


def motor(joint, *, limit):
    return joint.effort(limited(joint.angle, joint.rate, limit))


def impure(joint, *, limit):
    return joint.effort(counted(joint.angle))


def short(joint, *, limit):
    return joint.effort(limited(joint.angle, limit))
"""


@pytest.fixture(scope="module")
def laws(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A file of LAWS beside their library."""
    folder = tmp_path_factory.mktemp("laws")
    file = folder / "laws.py"
    file.write_text(LAWS.format(path=str(built(folder))))
    return file


def calling(data: dict[str, Any], function: str) -> dict[str, Any]:
    data["model"]["forces"][0]["function"] = function
    return data


def test_a_controller_has_the_bits_of_the_jitted_one(laws):
    a, b = run(calling(arm(), f"{laws}:pid")), run(arm())
    assert a.position.values.tobytes() == b.position.values.tobytes()
    assert a["own.integral"].values.tobytes() == b["own.integral"].values.tobytes()


def test_a_run_with_what_is_not_finite_fails_alone_as_that_in_which_the_jitted_one_raises(laws):
    jitted = lienumba.run(swinging(), workers=1)
    assert 0 < (jitted.status.values != 0).sum() < 11
    for workers in (1, 2):
        ds = lienumba.run(calling(swinging(), f"{laws}:motor"), workers=workers)
        np.testing.assert_array_equal(ds.status, jitted.status)
        np.testing.assert_array_equal(ds.position, jitted.position)


@pytest.mark.parametrize(
    ("function", "sampled", "rule"),
    [
        ("impure", True, "counted returns other numbers when it is called again with equal arguments; let its outputs"),
        ("pid", False, "calls pid, which keeps states from call to call, but is not sampled; give every"),
        ("short", True, "limited gets 2 inputs, but has 3; give it 3, or write inputs=2 in lienumba.foreign"),
    ],
)
def test_what_is_refused_is_refused_before_runs_begin(laws, function, sampled, rule):
    data = calling(arm() if function == "pid" else swinging(every=0.02), f"{laws}:{function}")
    if not sampled:
        del data["model"]["forces"][0]["every"]
        data["model"]["forces"][0]["parameters"] |= {"interval": 0.1}
    with pytest.raises(ScenarioError, match=f"model.forces.own: {rule}"):
        lienumba.run(data)


def test_its_library_is_part_of_the_scenario(laws, monkeypatch):
    data = calling(swinging(), f"{laws}:motor")
    sha = resolve(data).sha256()
    monkeypatch.setattr(LibraryFunction, "identity", lambda self: "another")
    assert resolve(data).sha256() != sha


def test_it_may_be_handed_over_in_python(laws):
    names: dict[str, Any] = {}
    exec(compile(laws.read_text(), str(laws), "exec"), names)
    law = {"name": "own", "type": "python", "function": names["motor"], "joints": ["hinge"], "parameters": {"limit": 3}}
    other = law | {"function": f"{laws}:motor"}
    np.testing.assert_array_equal(run(pendulum(law)).position, run(pendulum(other)).position)
