"""The header of the page: the title, how it went in a sentence, and the size of it all."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import xarray as xr

from lienumba.analysis.outcomes import Counts, counts
from lienumba.analysis.studies.study_rows import headline
from lienumba.analysis.summary import Summary, summarise
from lienumba.batch.statuses import GOOD
from lienumba.present.html import verdict
from lienumba.present.html.markup import Markup, element, join, number, sentence
from lienumba.scenario.base.toml import Tables
from lienumba.scenario.resolve import written_tables
from lienumba.store.layout import warnings_in
from lienumba.store.linear_layout import is_modes
from lienumba.store.study_layout import grid_of, is_study
from lienumba.words import listed, plural


def header(ds: xr.Dataset, told: Markup | None = None, doubts: Sequence[str] = ()) -> Markup:
    """Title, verdict, and what the runs are of; told: the verdict, where it is not one of runs or of a study; doubts:
    warnings beside those of the dataset."""
    failed = int((~ds["status"].isin(GOOD)).sum())
    title = element("h1", str(ds.attrs.get("title", "")) or "Untitled")
    if told is None:
        told = _study_verdict(ds, failed) if is_study(ds) else _verdict(ds)
    warned = [*warnings_in(ds), *doubts]
    ran = element("p", told, class_="verdict failed" if failed or warned else "verdict")
    warnings = [element("p", sentence(f"warning: {text}")) for text in warned]
    return join([title, *verdict.headline(ds), ran, *warnings, element("p", " · ".join(_size(ds)), class_="quiet")])


def scenario_of(ds: xr.Dataset) -> Tables:
    """The scenario that a dataset brings, as tables; none of its code runs."""
    return written_tables(ds, "the dataset")


def _verdict(ds: xr.Dataset) -> Markup:
    """How the runs ended, and how well they are computed."""
    found, ran, model = summarise(ds), counts(ds), scenario_of(ds).get("model", {})
    end, ended = f"t = {found.final_time:g} s", "; ".join(_early(ran))
    if not ended:
        runs = f"All {ran.runs:,} runs" if ran.runs > 1 else "The run"
        how = f"{runs}{ran.beside} reached {end}"
    else:
        how = f"{ran.good:,} of {plural(ran.runs, 'run is', 'runs are')} good"
    kept = list(_quality(found, bool(model.get("joints") or model.get("drivers"))))
    rest = (f": {ended}" if ended else "") + ". " + (f"{' and '.join(kept)}." if kept else "")
    return join([element("strong", how), rest])


def _early(ran: Counts) -> Iterator[str]:
    """How many runs did not reach the end, and why; how the nominal one ended, if any did not."""
    if ran.failed:
        yield ran.failed
    if ran.stopped:
        yield f"{plural(ran.stopped, 'was', 'were')} ended by an event"
    if ran.nominal and ran.early:
        how = "is good" if ran.nominal.good else f"failed ({ran.nominal.status.replace('_', ' ')})"
        yield f"the nominal run {how}"


def _quality(found: Summary, held: bool) -> Iterator[str]:
    """How well joints, where something is held, and the energy are computed."""
    joints = found.max_position_violation if held else None
    if joints is not None:
        yield f"The joints held to {number(joints, 1)} m"
    if found.max_relative_energy_drift is not None:
        start = "The energy held" if joints is None else "the energy"
        yield f"{start} to {number(found.max_relative_energy_drift, 1)} of what was exchanged"


def _study_verdict(ds: xr.Dataset, failed: int) -> Markup:
    of = ds["status"].size
    return join([element("strong", headline(ds)), f", {failed:,} of {of:,} failed." if failed else ", none failed."])


def _size(ds: xr.Dataset) -> Iterator[str]:
    """The size of the mechanism and of the sweep, and how it was integrated."""
    data = scenario_of(ds)
    model, integrator = data.get("model", {}), data.get("integrator", {})
    for key, one, many in (
        ("bodies", "body", "bodies"), ("joints", "joint", "joints"),
        ("drivers", "driver", "drivers"), ("forces", "force", "forces"),
    ):  # fmt: skip
        if model.get(key):
            yield plural(len(model[key]), one, many)
    if is_study(ds):
        yield f"a grid over {listed(grid_of(ds))}"
    elif not is_modes(ds):
        yield method(integrator)
    inputs = sum(x.attrs.get("role") == "input" for x in ds.coords.values())
    if inputs:
        yield plural(inputs, "varied number", "varied numbers")


def method(integrator: Tables) -> str:
    """How steps are made."""
    name = str(integrator.get("method", "unknown method"))
    if "tolerance" in integrator:
        tolerance = integrator["tolerance"]
        return f"{name}, tolerance {tolerance['relative'] if isinstance(tolerance, dict) else tolerance:g}"
    return f"{name}, step {integrator['step']:g} s" if "step" in integrator else name
