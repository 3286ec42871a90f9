"""Which sections the report of a dataset has."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any

from lienumba.report.chart import Section
from lienumba.report.markup import Markup
from lienumba.store.study_layout import is_study

if TYPE_CHECKING:
    import xarray as xr


def sections_of(ds: xr.Dataset, name: str, allow_code: bool) -> tuple[Markup, list[Section], dict[str, Any]]:
    """The head of the page, its sections, and what its scripts need beside the charts, by the name of the script."""
    from lienumba.report.head import head
    from lienumba.report.origin import origin

    extra: dict[str, Any] = {}
    found = [*(_of_study(ds) if is_study(ds) else _of_runs(ds, name, allow_code, extra.__setitem__))]
    return head(ds), [*found, origin(ds, name)], extra


def _of_study(ds: xr.Dataset) -> Iterator[Section]:
    from lienumba.report import study

    yield from study.sections(ds)


def _of_runs(ds: xr.Dataset, name: str, allow_code: bool, keep: Callable[[str, Any], None]) -> Iterator[Section]:
    from lienumba.report.head import scenario_of
    from lienumba.report import courses, motion, sensitivity, spreads, summary
    from lienumba.scene import Scene

    seen = motion.seen(ds, name, allow_code)
    if isinstance(seen, Scene):
        keep("motion", motion.data(seen, scenario_of(ds)["model"].get("gravity", ())))
    yield motion.section_of(seen)
    yield summary.summary(ds, name)
    yield from courses.sections(ds, motion.marked(seen))
    known = sensitivity.columns(ds)
    section, numbers = sensitivity.sensitivity(ds, known)
    if section is not None:
        yield section
    if numbers:
        keep("sensitivity", numbers)
    if ds.sizes["run"] > 1:
        yield from spreads.sections(known)
