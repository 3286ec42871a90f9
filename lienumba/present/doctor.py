"""Is this machine fit for lienumba? Versions, CPU, cache, and one short run against a known result."""

import platform
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

PACKAGES = ("numba", "llvmlite", "numpy", "scipy", "xarray", "netCDF4", "pydantic", "typer", "rich")
# Mass centre of the paper's heavy top at t = 0.1 s in m, from its solution in elliptic functions.
KNOWN = (0.4212966589254021, 0.894571974345593, -0.14916470056189962)
KNOWN_TOLERANCE = 1e-8  # m; rk4 with the step below errs by about 2e-10

HEAVY_TOP: dict[str, Any] = {
    "title": "Heavy top, self-test",
    "model": {
        "bodies": [
            {
                "name": "top",
                "mass": 15.0,
                "inertia": [0.234375, 0.46875, 0.234375],
                "position": [0.0, 1.0, 0.0],
                "rotation": [1.0, 0.0, 0.0, 0.0],
                "angular_velocity": [0.0, 150.0, -4.61538],
            }
        ],
        "joints": [
            {
                "name": "pivot",
                "type": "spherical",
                "bodies": ["ground", "top"],
                "points": [[0.0, 0.0, 0.0], [0.0, -1.0, 0.0]],
            }
        ],
    },
    "integrator": {"method": "rk4", "step": 1e-4, "end_time": 0.1},
    "output": {"every": 0.1},
}


def environment() -> str:
    """Versions, CPU and cache as lines of text."""
    import llvmlite.binding as llvm

    from lienumba import __version__
    from lienumba.batch.execute import usable_cores
    from lienumba.compiler import cache

    features = llvm.get_host_cpu_features()
    folder = Path(cache.folder())
    files = [item for item in folder.rglob("*") if item.is_file()]
    size = sum(item.stat().st_size for item in files) / 1e6
    rows = {
        "lienumba": f"{__version__}, Python {platform.python_version()} on {platform.platform()}",
        "packages": ", ".join(f"{name} {_version(name)}" for name in PACKAGES),
        "cpu": f"{llvm.get_host_cpu_name()}, {usable_cores()} cores usable",
        "vectors": ", ".join(
            f"{label}: {'yes' if features.get(name) else 'no'}"
            for name, label in (("fma", "fused multiply-add"), ("avx2", "AVX2"), ("avx512f", "AVX-512"))
        ),
        "cache": f"{folder} ({len(files)} files, {size:.1f} MB)",
    }
    return "\n".join(f"{name + ':':<10}{text}" for name, text in rows.items())


def _version(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return "missing"


def self_test() -> tuple[bool, str]:
    """Simulate 0.1 s of the heavy top; whether it agrees with the exact solution, and a sentence."""
    from time import perf_counter

    from lienumba.engine import runner

    start = perf_counter()
    dataset = runner.run(HEAVY_TOP)
    seconds = perf_counter() - start
    position = dataset["position"].values[0, -1, 0]
    error = max(abs(float(value) - right) for value, right in zip(position, KNOWN, strict=True))
    passed = error < KNOWN_TOLERANCE
    verdict = "passed" if passed else f"FAILED, more than {KNOWN_TOLERANCE:g} m; please report this output"
    distance = f"the heavy top is {error:.1e} m from the exact solution at 0.1 s"
    return passed, f"self-test: {distance}: {verdict} ({seconds:.1f} s)"
