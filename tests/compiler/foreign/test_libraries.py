"""Functions of shared libraries: called for each lane, known by their file, loaded again by later processes."""

import ctypes
import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import lienumba
from lienumba.compiler.emit import Kernel
from lienumba.compiler.symbols import Graph
from lienumba.errors import BadValueError
from tests.compiler.evaluation import assert_same_bits, call
from tests.rigs.libraries import built
from tests.rigs.places import ROOT

CHILD = """
import ctypes, sys
import numpy as np
import lienumba
from lienumba.compiler import native
native.emit = lambda *given: sys.exit("it is compiled again")
limited = lienumba.foreign(ctypes.CDLL(sys.argv[1]).limited, inputs=3, outputs=1)
print(limited(np.linspace(0.0, 1.0, 9), 0.3, 0.7).tobytes().hex())
"""


@pytest.fixture(scope="module")
def path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return built(tmp_path_factory.mktemp("library"), gain=2.5)  # as no other test has it


def limited(path: Path):
    return lienumba.foreign(ctypes.CDLL(str(path)).limited, inputs=3, outputs=1)


def test_each_lane_is_called_with_its_states_and_fails_alone(path):
    """Not finite, or not called, since one of its arguments is NaN."""
    pid = lienumba.foreign(ctypes.CDLL(str(path)).pid, inputs=8, outputs=1, states=1)
    graph = Graph()
    x, y, state, limit = graph.inputs("state", 4)
    torque, following = pid((x, y, 2.0, 0.5, 0.25), 0.3, 4.0, 0.125, states=state)
    kernel = Kernel("main", (torque, following, limited(path)(x, y, limit)), 0)
    given = np.random.default_rng(1).normal(size=(4, 8))
    given[3] = 1.0
    given[1, 3], given[0, 5], given[0, 6], given[3, 7] = np.nan, np.inf, -np.inf, np.nan
    found = call(kernel, state=given)
    assert np.isnan(found[:2]).all(axis=0).tolist() == [lane == 3 for lane in range(8)]
    error = 0.3 - given[0]
    wanted = 2.0 * error + 0.5 * given[2] - 0.25 * given[1]
    assert_same_bits(found[0], np.clip(wanted, -4.0, 4.0))
    assert_same_bits(found[1], np.where(abs(wanted) > 4.0, given[2], given[2] + 0.125 * error) + 0.0 * given[1])
    assert (
        np.isnan(found[2]).tolist()
        == (np.isnan(given[[1, 3]]).any(axis=0) | np.isinf(given[0]) | (given[0] > 1)).tolist()
    )


def test_later_processes_find_its_object_code_wherever_the_library_lies(path):
    here = limited(path)(np.linspace(0.0, 1.0, 9), 0.3, 0.7)
    assert np.isnan(here).any()
    command = [sys.executable, "-c", CHILD, str(path)]
    done = subprocess.run(command, cwd=ROOT, env=os.environ, capture_output=True, text=True)
    assert done.stdout.strip() == here.tobytes().hex(), done.stderr


def test_what_is_no_function_of_a_library_is_refused(path):
    library = ctypes.CDLL(str(path))
    for function in (abs, ctypes.CFUNCTYPE(None)(abs)):
        with pytest.raises(
            BadValueError, match=r"lienumba\.foreign.*; load the library with ctypes\.CDLL\(path\), and"
        ):
            lienumba.foreign(function, inputs=1, outputs=1)
    with pytest.raises(BadValueError, match=r"inputs = -1 must be a whole number from 0 on; count its numbers"):
        lienumba.foreign(library.pid, inputs=-1, outputs=1)
    with pytest.raises(BadValueError, match="a function without outputs and states changes nothing"):
        lienumba.foreign(library.pid, inputs=1, outputs=0)


def test_the_file_counts_not_where_it_lies(path, tmp_path):
    shutil.copy(path, tmp_path / "same.so")
    other = built(tmp_path, "other.so", gain=3.0)
    assert limited(tmp_path / "same.so").identity() == limited(path).identity() != limited(other).identity()
    built(tmp_path, "other.so", gain=4.0)
    with pytest.raises(
        BadValueError, match=r"other\.so has changed since this process loaded it, .*; start a new proc"
    ):
        limited(other)
