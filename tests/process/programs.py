"""The command line in a process of its own, which signals reach wherever the tests were started."""

import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from tests.rigs.places import ROOT

PATIENCE = 60.0  # s, for a machine that has other things to do


@contextmanager
def started(*arguments: object, folder: Path) -> Iterator["subprocess.Popen[str]"]:
    """`lienumba` with these arguments, its stderr a pipe; at the end it is gone, and all that it started.

    In the background of a script SIGINT is ignored, and so it would be in what is started there. A signal that is
    caught here has its default action in a new program.
    """
    here = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        process = subprocess.Popen(
            [sys.executable, "-m", "lienumba", *map(str, arguments)], stderr=subprocess.PIPE,
            stdout=subprocess.DEVNULL, text=True, cwd=folder, start_new_session=True,
            env=os.environ | {"PYTHONPATH": str(ROOT)},
        )  # fmt: skip
    finally:
        signal.signal(signal.SIGINT, here)
    with process:
        try:
            yield process
        finally:
            if process.poll() is None:
                os.killpg(process.pid, signal.SIGKILL)


def until(process: "subprocess.Popen[str]", words: str) -> None:
    """Wait for a line that has these words."""
    assert process.stderr is not None
    for line in process.stderr:
        if words in line:
            break
    assert process.poll() is None
