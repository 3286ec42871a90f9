"""lienumba: constrained rigid multibody systems on Lie groups, thousands of runs at a time."""

from typing import TYPE_CHECKING

from lienumba.errors import ScenarioError as ScenarioError

if TYPE_CHECKING:
    from lienumba import analysis as analysis
    from lienumba.compiler.foreign.batched import batched as batched
    from lienumba.compiler.foreign.jitted import jit as jit
    from lienumba.compiler.foreign.libraries import foreign as foreign
    from lienumba.engine.budget.budget import budget as budget
    from lienumba.engine.calibration.fit import Fit as Fit
    from lienumba.engine.disk.merge import merge as merge
    from lienumba.engine.kernels.kernels import Kernels as Kernels
    from lienumba.engine.linear.equilibrium import equilibrium as equilibrium
    from lienumba.engine.linear.linearise import linearise as linearise
    from lienumba.engine.linear.modes import modes as modes
    from lienumba.engine.prepared import Prepared as Prepared
    from lienumba.engine.prepared import prepare as prepare
    from lienumba.engine.rare.rare import rare as rare
    from lienumba.engine.rare.worst import worst as worst
    from lienumba.engine.replay import replay as replay
    from lienumba.engine.runner import run as run
    from lienumba.present.html.page import report as report
    from lienumba.scenario.system import System as System

__version__ = "0.2.0"
__all__ = [
    "Fit",
    "Kernels",
    "Prepared",
    "ScenarioError",
    "System",
    "__version__",
    "analysis",
    "batched",
    "budget",
    "equilibrium",
    "foreign",
    "jit",
    "linearise",
    "merge",
    "modes",
    "prepare",
    "rare",
    "replay",
    "report",
    "run",
    "worst",
]

_MODULES = {  # of what is heavy, which is imported when it is first asked for
    "Fit": "lienumba.engine.calibration.fit",
    "Kernels": "lienumba.engine.kernels.kernels",
    "Prepared": "lienumba.engine.prepared",
    "System": "lienumba.scenario.system",
    "batched": "lienumba.compiler.foreign.batched",
    "budget": "lienumba.engine.budget.budget",
    "equilibrium": "lienumba.engine.linear.equilibrium",
    "foreign": "lienumba.compiler.foreign.libraries",
    "jit": "lienumba.compiler.foreign.jitted",
    "linearise": "lienumba.engine.linear.linearise",
    "merge": "lienumba.engine.disk.merge",
    "modes": "lienumba.engine.linear.modes",
    "prepare": "lienumba.engine.prepared",
    "rare": "lienumba.engine.rare.rare",
    "replay": "lienumba.engine.replay",
    "report": "lienumba.present.html.page",
    "run": "lienumba.engine.runner",
    "worst": "lienumba.engine.rare.worst",
}


def __getattr__(name: str) -> object:
    from importlib import import_module

    if name == "analysis":
        return import_module("lienumba.analysis")
    if name not in _MODULES:
        raise AttributeError(f"module 'lienumba' has no attribute {name!r}")
    return getattr(import_module(_MODULES[name]), name)


def __dir__() -> list[str]:
    return __all__
