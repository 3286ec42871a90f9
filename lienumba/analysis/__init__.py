"""What a dataset says: summaries, sensitivities, observed orders, work against precision, figures."""

from lienumba.analysis.orders import orders as orders
from lienumba.analysis.sensitivity import sensitivity as sensitivity
from lienumba.analysis.study import work_precision as work_precision

__all__ = ["orders", "sensitivity", "work_precision"]
