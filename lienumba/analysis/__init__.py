"""What a dataset says: summaries, sensitivities, observed orders, work against precision, statistics, figures."""

from lienumba.analysis.covariance import covariance as covariance
from lienumba.analysis.covariance import ellipsoid as ellipsoid
from lienumba.analysis.intervals import mean_interval as mean_interval
from lienumba.analysis.intervals import quantile_interval as quantile_interval
from lienumba.analysis.orders import orders as orders
from lienumba.analysis.rotations import mean_rotation as mean_rotation
from lienumba.analysis.rotations import rotation_covariance as rotation_covariance
from lienumba.analysis.rotations import rotation_error as rotation_error
from lienumba.analysis.sensitivity import sensitivity as sensitivity
from lienumba.analysis.study import work_precision as work_precision

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
    "work_precision",
]
