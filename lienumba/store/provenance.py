"""What a dataset says of its origin: enough to make it again."""

from __future__ import annotations

import os
import platform
import sys
from collections.abc import Mapping
from datetime import UTC, datetime
from functools import cache
from importlib.metadata import version
from types import MappingProxyType

from lienumba.compiler import native

PACKAGES = ("numba", "llvmlite", "numpy", "scipy", "xarray", "netCDF4")
PAPER = (
    "Z. Terze, A. Mueller, D. Zlatar, Lie-group integration method for constrained multibody systems"
    " in state space, Multibody System Dynamics 34 (2015)"
)


def attributes(title: str, scenario_toml: str, sha256: str, seed: int, command: str) -> dict[str, str | int | float]:
    """Global attributes; `scenario_toml`: the resolved scenario; `sha256`: of what determines a run."""
    from lienumba import __version__

    now = datetime.now(UTC).isoformat(timespec="seconds")
    return {
        "Conventions": "CF-1.8",
        "title": title,
        "history": f"{now} {command}",
        "source": f"lienumba {__version__}",
        "seed": seed if seed < 2**63 else str(seed),  # netCDF has no larger integer
        "references": PAPER,
        "scenario_sha256": sha256,
        **{f"{name}_version": number for name, number in versions().items()},
        "cpu": native.cpu_name(),
        "scenario": scenario_toml,  # the last, because it is long
    }


@cache
def versions() -> Mapping[str, str]:
    """Of lienumba, of Python and of the packages that it uses, by their names in small letters."""
    from lienumba import __version__

    own = {"lienumba": __version__, "python": platform.python_version()}
    return MappingProxyType(own | {name.lower(): version(name) for name in PACKAGES})


def command() -> str:
    """What was called."""
    name = os.path.basename(sys.argv[0]) if sys.argv and sys.argv[0] else "python"
    return " ".join(["lienumba" if name == "__main__.py" else name, *sys.argv[1:]])
