"""The tables of docs/accuracy.md."""

from collections.abc import Callable
from functools import partial

from precision import long_time, slopes, tolerances, work
from precision.cases import ROOT

DOCUMENT = ROOT / "docs" / "accuracy.md"
TABLES: dict[str, Callable[[], str]] = {
    f"{title}, {name}": partial(table, name)
    for title, table, cases in (
        ("orders", slopes.table, slopes.CASES),
        ("steps", work.steps_table, work.CASES),
        ("times", work.times_table, work.CASES),
        ("adaptive", work.adaptive_table, work.CASES),
        ("tolerances", tolerances.table, tolerances.CASES),
        ("long", long_time.table, long_time.CASES),
    )
    for name in cases
}
