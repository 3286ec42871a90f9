"""What a dataset says: summaries, observed orders, work against precision, figures."""

from lienumba.analysis.orders import orders as orders
from lienumba.analysis.study import work_precision as work_precision

__all__ = ["orders", "work_precision"]
