"""What a dataset says: summaries, sensitivities, observed orders, work against precision, statistics, figures."""

from lienumba.analysis.sensitivities.sensitivity import sensitivity as sensitivity
from lienumba.analysis.statistics.covariance import covariance as covariance
from lienumba.analysis.statistics.covariance import ellipsoid as ellipsoid
from lienumba.analysis.statistics.intervals import mean_interval as mean_interval
from lienumba.analysis.statistics.intervals import quantile_interval as quantile_interval
from lienumba.analysis.statistics.rotations import mean_rotation as mean_rotation
from lienumba.analysis.statistics.rotations import rotation_covariance as rotation_covariance
from lienumba.analysis.statistics.rotations import rotation_error as rotation_error
from lienumba.analysis.studies.orders import orders as orders
from lienumba.analysis.studies.study import work_precision as work_precision
from lienumba.analysis.summary import summarise as summarise

__all__ = [
    "covariance",
    "ellipsoid",
    "mean_interval",
    "mean_rotation",
    "orders",
    "quantile_interval",
    "rotation_covariance",
    "rotation_error",
    "sensitivity",
    "summarise",
    "work_precision",
]
