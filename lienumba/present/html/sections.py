"""Which sections the report of a dataset has."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from typing import TYPE_CHECKING

import xarray as xr

from lienumba.analysis.weights import as_drawn
from lienumba.errors import ResultWarning, ScenarioError
from lienumba.present.html import (
    changes,
    chart,
    histograms,
    modes,
    motion,
    sensitivity,
    study,
    summary,
    time_series,
    verdict,
)
from lienumba.present.html.chart import Json, Section
from lienumba.present.html.header import header, scenario_of
from lienumba.present.html.markup import Markup, element, sentence
from lienumba.present.html.provenance import doubts, provenance, recomputed
from lienumba.store.linear_layout import is_modes
from lienumba.store.study_layout import is_study

if TYPE_CHECKING:
    from lienumba.engine.checks.recompute import Recomputed
    from lienumba.engine.simulate import Tell
    from lienumba.scene import Scene


def sections_of(
    ds: xr.Dataset, name: str, allow_code: bool, tell: Tell, check: int
) -> tuple[Markup, list[Section], Json]:
    """The header of the page, its sections, and what its scripts need beside the charts, by the name of the script;
    check: how many runs another engine recomputes."""
    extra: Json = {}
    if is_modes(ds):
        found = [*modes.sections(ds, name, extra)]
    elif is_study(ds):
        found = [*study.sections(ds)]
    else:
        found = [*_of_runs(ds, motion.seen(ds, name, allow_code, tell), name, extra)]
    told = modes.headline(ds) if is_modes(ds) else None
    checked = _recomputed(ds, name, allow_code, tell, check) if check else ""
    found += [recomputed(checked)] if check else []
    for doubt in doubts(checked):
        warnings.warn(f"{name}: {doubt}", ResultWarning, stacklevel=2)
    return header(ds, told, doubts(checked)), [*found, provenance(ds, name, check)], extra


def _recomputed(ds: xr.Dataset, name: str, allow_code: bool, tell: Tell, check: int) -> list[Recomputed] | str:
    """Runs by another engine, or the sentence that says why there are none."""
    from lienumba.engine.checks.recompute import recompute

    try:
        return recompute(ds, name, check, allow_code, tell)
    except ScenarioError as error:
        return str(error)


def _of_runs(ds: xr.Dataset, seen: Scene | str, name: str, extra: Json) -> Iterator[Section]:
    """seen: the runs that move, or why none does."""
    if not isinstance(seen, str):
        extra["motion"] = motion.data(seen, scenario_of(ds)["model"].get("gravity", ()))
    yield from verdict.sections(ds)
    yield motion.section_of(seen)
    yield summary.summary(ds, name)
    yield from changes.sections(ds, list(summary.changes(ds)))
    ds = as_drawn(ds)
    if "weights" in ds.attrs:
        yield chart.section("weights", "Weights", element("p", sentence(f"below, {ds.attrs['weights']}")))
    yield from time_series.sections(ds, motion.marked(seen))
    columns = sensitivity.columns(ds)
    yield from sensitivity.sections(ds, columns)
    if ds.sizes["run"] > 1:
        yield from histograms.sections(columns)
