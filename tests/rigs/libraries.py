"""A shared library of C functions, built where there is a compiler."""

import shutil
import subprocess
from pathlib import Path

import pytest

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


def built(folder: Path, name: str = "library.so", gain: float = 2.0, source: str = SOURCE) -> Path:
    """The library in a file of this name."""
    compiler = shutil.which("cc")
    if compiler is None:
        pytest.skip("there is no C compiler")
    flags = ["-O2", "-ffp-contract=off", "-shared", "-fPIC", f"-DGAIN={gain}"]
    command = [compiler, "-x", "c", *flags, "-o", str(folder / name), "-"]
    subprocess.run(command, input=source, text=True, check=True)
    return folder / name
