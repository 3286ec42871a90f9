"""Functions of C in laws: the bits of the same laws for Numba, run by run; refused before runs begin."""

import ctypes
import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import lienumba
from lienumba.compiler.foreign.libraries import LibraryFunction
from lienumba.errors import BadValueError
from tests.facade import ScenarioError, resolve
from tests.laws.rigs import pendulum, run
from tests.laws.test_jitted import arm, swinging
from tests.rigs.places import ROOT

SOURCE = """
void pid(const double *u, double *x, double *y)
{
    double error = u[5] - u[0], wanted = u[2] * error + u[3] * x[0] - u[4] * u[1];
    if (wanted > u[6]) y[0] = u[6];
    else if (wanted < -u[6]) y[0] = -u[6];
    else { y[0] = wanted; x[0] += u[7] * error; }
}
void limited(const double *u, double *x, double *y)
{
    y[0] = u[0] > u[2] ? 0.0 / 0.0 : -GAIN * u[0] - u[1];
}
void counted(const double *u, double *x, double *y)
{
    static int calls = 0;
    y[0] = u[0] + ++calls;
}
"""
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
CACHED = """
import sys
import lienumba
from lienumba.compiler import emit, flat, native
from lienumba.compiler.value_types import DOUBLE
from tests.laws.test_jitted import arm
native.LEVEL, flat.PASSES, emit.VALUES = 0, 0, DOUBLE
native.emit = lambda *given: sys.exit("it is compiled again")
data = arm()
data["model"]["forces"][0]["function"] = sys.argv[1]
print(lienumba.run(data, workers=1).position.values.tobytes().hex())
"""


def built(folder: Path, name: str = "laws.so", gain: float = 2.0) -> Path:
    """A shared library of SOURCE."""
    compiler = shutil.which("cc")
    if compiler is None:
        pytest.skip("there is no C compiler")
    flags = ["-O2", "-ffp-contract=off", "-shared", "-fPIC", f"-DGAIN={gain}"]
    command = [compiler, "-x", "c", *flags, "-o", str(folder / name), "-"]
    subprocess.run(command, input=SOURCE, text=True, check=True)
    return folder / name


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


def test_a_controller_has_the_bits_of_the_jitted_one_and_later_processes_compile_nothing(laws):
    """Where the library lies elsewhere in memory."""
    a, b = run(calling(arm(), f"{laws}:pid")), run(arm())
    assert a.position.values.tobytes() == b.position.values.tobytes()
    assert a["own.integral"].values.tobytes() == b["own.integral"].values.tobytes()
    command = [sys.executable, "-c", CACHED, f"{laws}:pid"]
    done = subprocess.run(command, cwd=ROOT, env=os.environ, capture_output=True, text=True)
    assert done.stdout.strip() == a.position.values.tobytes().hex(), done.stderr


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


def test_a_function_is_one_of_a_library_with_whole_sizes(laws):
    library = ctypes.CDLL(str(laws.with_suffix(".so")))
    for function in (abs, ctypes.CFUNCTYPE(None)(abs)):
        with pytest.raises(
            BadValueError, match=r"lienumba\.foreign.*; load the library with ctypes\.CDLL\(path\), and"
        ):
            lienumba.foreign(function, inputs=1, outputs=1)
    with pytest.raises(BadValueError, match=r"inputs = -1 must be a whole number from 0 on; count its numbers"):
        lienumba.foreign(library.pid, inputs=-1, outputs=1)
    with pytest.raises(BadValueError, match="a function without outputs and states changes nothing"):
        lienumba.foreign(library.pid, inputs=1, outputs=0)


def test_another_library_is_another_scenario(laws, tmp_path, monkeypatch):
    """The file counts, not where it lies."""

    def identity(path: Path) -> str:
        return lienumba.foreign(ctypes.CDLL(str(path)).limited, inputs=3, outputs=1).identity()

    first = laws.with_suffix(".so")
    shutil.copy(first, tmp_path / "same.so")
    other = built(tmp_path, "other.so", gain=3.0)
    assert identity(tmp_path / "same.so") == identity(first) != identity(other)
    built(tmp_path, "other.so", gain=4.0)
    with pytest.raises(
        BadValueError, match=r"other\.so has changed since this process loaded it, .*; start a new proc"
    ):
        identity(other)
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
