"""The same bits for every CPU that the kernels and the driver are compiled for, and for any number of lanes."""

import json
import os
import subprocess
import sys
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

SCRIPT = Path(__file__).with_name("cpu_sweep.py")
FIXED = ("top", "links", "loop", "wheel", "rotations")
FEW = ("links", "rotations")
EVERY = ("paced", *FIXED)  # the driver of free lanes takes longest to compile
WIDE = ("avx512f", "avx512vl", "avx512dq", "avx512bw")
NEEDS = {  # what code for these names may contain
    "znver4": WIDE,
    "skylake-avx512": WIDE,
    "haswell": ("avx2", "fma", "bmi2"),
}
TARGETS = ("NUMBA_CPU_NAME", "NUMBA_CPU_FEATURES", "NPY_DISABLE_CPU_FEATURES", "OPENBLAS_CORETYPE", "GLIBC_TUNABLES")


@cache
def sweeps(*names: str, **environment: str) -> dict[str, Any]:
    """CPU and hashes of these short sweeps in a process with these variables."""
    others = {key: value for key, value in os.environ.items() if key not in TARGETS}
    done = subprocess.run(
        [sys.executable, SCRIPT, *names], env=others | environment, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr[-3000:]
    result: dict[str, Any] = json.loads(done.stdout)
    return result


def check(target: dict[str, Any]) -> None:
    """The same bits as on the host, and the same eigenvalues but for rounding."""
    host = sweeps("modes", *EVERY)
    assert target["hashes"] == {name: host["hashes"][name] for name in target["hashes"]}
    for name, values in target["modes"].items():
        scale = np.nanmax(np.abs(host["modes"][name]))
        np.testing.assert_allclose(values, host["modes"][name], rtol=1e-10, atol=1e-12 * scale)


def require(name: str) -> None:
    from llvmlite import binding

    features = binding.get_host_cpu_features()
    missing = [feature for feature in NEEDS[name] if not features.get(feature)]
    if missing:
        pytest.skip(f"this machine cannot execute code for {name}: it has no {', '.join(missing)}")


@pytest.mark.release
@pytest.mark.parametrize("name", ["znver4", "skylake-avx512"])
def test_the_same_bits_as_the_host(name: str) -> None:
    from llvmlite import binding

    require(name)
    target = sweeps(*FEW, NUMBA_CPU_NAME=name)
    assert target["cpu"][0] == name
    assert (target["cpu"][1] == "") == (name != binding.get_host_cpu_name())  # the host's own has its features
    check(target)


@pytest.mark.release
def test_the_hosts_own_name_gives_the_same_bits() -> None:
    from llvmlite import binding

    name = binding.get_host_cpu_name()
    target = sweeps(*FEW, NUMBA_CPU_NAME=name)
    assert target["cpu"][0] == name
    check(target)


@pytest.mark.release
def test_the_driver_too_without_any_feature_of_the_host() -> None:
    require("haswell")
    target = sweeps("loop", "wheel", NUMBA_CPU_NAME="haswell", NUMBA_CPU_FEATURES="")
    assert target["cpu"] == ["haswell", ""]
    check(target)


@pytest.mark.release
def test_an_old_cpu_throughout() -> None:
    """NumPy, which samples and assembles, its BLAS and the C library keep to their baselines too. Without `fma` code
    takes ten times as long to optimise: none is."""
    from numpy._core import _multiarray_umath as core

    beyond = [name for name in core.__cpu_dispatch__ if core.__cpu_features__.get(name)]
    old = {
        "NUMBA_CPU_NAME": "generic",
        "NUMBA_CPU_FEATURES": "",
        "NPY_DISABLE_CPU_FEATURES": " ".join(beyond),
        "OPENBLAS_CORETYPE": "Prescott",
        "GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX512F,-AVX2,-FMA,-FMA4",
    }
    target = sweeps("paced", "top", "rotations", "modes", LEVEL="0", **old)
    assert target["cpu"] == ["generic", ""]
    check(target)


def with_lanes(lanes: str, cache: Path, *names: str) -> None:
    """The same bits with rows of so many lanes. The cache knows of one number."""
    assert sweeps(*names, LANES=lanes, LIENUMBA_CACHE_DIR=str(cache))["hashes"] == sweeps(*names)["hashes"]


def test_rows_of_another_number_of_lanes(tmp_path: Path) -> None:
    with_lanes("4", tmp_path, "loop")


@pytest.mark.release
@pytest.mark.parametrize("lanes", ["4", "16", "32"])
def test_rows_of_any_number_of_lanes(lanes: str, tmp_path: Path) -> None:
    with_lanes(lanes, tmp_path, "bounces", *FIXED)


def test_hashes_notice_a_change() -> None:
    found = sweeps(*EVERY)["hashes"]
    assert set(found) == set(EVERY)
    for name in ("position", "joint_force", "energy"):
        assert len({found[sweep][name] for sweep in EVERY[:-1]}) == 5
