"""lienumba: constrained rigid multibody systems on Lie groups, thousands of runs at a time."""

from typing import TYPE_CHECKING, Any

from lienumba.errors import ScenarioError as ScenarioError

if TYPE_CHECKING:
    from lienumba.engine.disk.merge import merge as merge
    from lienumba.engine.replay import replay as replay
    from lienumba.engine.runner import run as run
    from lienumba.present.html.page import report as report
    from lienumba.scenario.system import System as System

__version__ = "0.1.0"
__all__ = ["ScenarioError", "System", "__version__", "merge", "replay", "report", "run"]


def __getattr__(name: str) -> Any:
    """Import the heavy half of the package when it is first asked for."""
    if name == "run":
        from lienumba.engine.runner import run

        return run
    if name == "merge":
        from lienumba.engine.disk.merge import merge

        return merge
    if name == "replay":
        from lienumba.engine.replay import replay

        return replay
    if name == "report":
        from lienumba.present.html.page import report

        return report
    if name == "analysis":
        from importlib import import_module

        return import_module("lienumba.analysis")
    if name == "System":
        from lienumba.scenario.system import System

        return System
    raise AttributeError(f"module 'lienumba' has no attribute {name!r}")
