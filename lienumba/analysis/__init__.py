"""What a dataset says: summaries, sensitivities, observed orders, work against precision, statistics, figures."""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from lienumba.analysis.by_run import run_table as run_table
    from lienumba.analysis.changed import changes as changes
    from lienumba.analysis.comparison import compare as compare
    from lienumba.analysis.folder_index import index as index
    from lienumba.analysis.requirements.separation import separation as separation
    from lienumba.analysis.requirements.verdict import verdicts as verdicts
    from lienumba.analysis.sensitivities.sensitivity import sensitivity as sensitivity
    from lienumba.analysis.statistics.covariance import covariance as covariance
    from lienumba.analysis.statistics.covariance import ellipsoid as ellipsoid
    from lienumba.analysis.statistics.intervals import mean_interval as mean_interval
    from lienumba.analysis.statistics.intervals import proportion_interval as proportion_interval
    from lienumba.analysis.statistics.intervals import quantile_interval as quantile_interval
    from lienumba.analysis.statistics.rotations import mean_rotation as mean_rotation
    from lienumba.analysis.statistics.rotations import rotation_covariance as rotation_covariance
    from lienumba.analysis.statistics.rotations import rotation_error as rotation_error
    from lienumba.analysis.studies.orders import orders as orders
    from lienumba.analysis.studies.study import work_precision as work_precision
    from lienumba.analysis.summary import summarise as summarise
    from lienumba.analysis.weights import as_drawn as as_drawn

_MODULES = {  # of what needs xarray, which is imported when it is first asked for
    "as_drawn": "lienumba.analysis.weights",
    "changes": "lienumba.analysis.changed",
    "compare": "lienumba.analysis.comparison",
    "covariance": "lienumba.analysis.statistics.covariance",
    "ellipsoid": "lienumba.analysis.statistics.covariance",
    "index": "lienumba.analysis.folder_index",
    "mean_interval": "lienumba.analysis.statistics.intervals",
    "mean_rotation": "lienumba.analysis.statistics.rotations",
    "orders": "lienumba.analysis.studies.orders",
    "proportion_interval": "lienumba.analysis.statistics.intervals",
    "quantile_interval": "lienumba.analysis.statistics.intervals",
    "rotation_covariance": "lienumba.analysis.statistics.rotations",
    "rotation_error": "lienumba.analysis.statistics.rotations",
    "run_table": "lienumba.analysis.by_run",
    "separation": "lienumba.analysis.requirements.separation",
    "sensitivity": "lienumba.analysis.sensitivities.sensitivity",
    "summarise": "lienumba.analysis.summary",
    "verdicts": "lienumba.analysis.requirements.verdict",
    "work_precision": "lienumba.analysis.studies.study",
}
__all__ = [
    "as_drawn",
    "changes",
    "compare",
    "covariance",
    "ellipsoid",
    "index",
    "mean_interval",
    "mean_rotation",
    "orders",
    "proportion_interval",
    "quantile_interval",
    "rotation_covariance",
    "rotation_error",
    "run_table",
    "sensitivity",
    "separation",
    "summarise",
    "verdicts",
    "work_precision",
]


def __getattr__(name: str) -> object:
    if name not in _MODULES:
        raise AttributeError(f"module 'lienumba.analysis' has no attribute {name!r}")
    return getattr(import_module(_MODULES[name]), name)


def __dir__() -> list[str]:
    return __all__
