"""What was run, with what, when and where, and how it can be repeated."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from lienumba.analysis.labels import unit_label
from lienumba.present.html.chart import Section, section
from lienumba.present.html.header import scenario_of
from lienumba.present.html.markup import Markup, element, folded, number, sentence, table
from lienumba.present.info import describe_dataset
from lienumba.scenario.base.toml import Tables
from lienumba.store.linear_layout import is_modes
from lienumba.words import plural, show

if TYPE_CHECKING:
    from lienumba.engine.checks.recompute import Recomputed

ENGINE = 'the engine "numba"'
MOST_REASONS = 5
CHECK_LEGEND = (
    "Each row has the variable whose difference is largest beside its tolerance. Relative differences are to the "
    "largest value of the same unit in the run, of the variable itself where it has none; torques are also measured by "
    "forces at an arm of 1 m. The tolerance is 1e-9, or more where the motion amplifies roundoff: ten times the "
    "difference of two runs whose starts differ by roundoff. The start, the choice of redundant rows, formulas of time "
    "and what is computed from stored states are common to both engines."
)


def provenance(ds: xr.Dataset, name: str, check: int) -> Section:
    """The section, with what `lienumba info` says; name: of the file of the dataset; check: how many runs the page
    recomputes."""
    told = element("pre", describe_dataset(ds))
    repeat = _repeat(ds, name, check)
    return section("origin", "What was run", told, *_inputs(ds, scenario_of(ds)), *repeat, *_scenario(ds))


def recomputed(found: Sequence[Recomputed] | str) -> Section:
    """The runs that another engine has recomputed, with their differences, or why it has none."""
    title = "Recomputed by another engine"
    if isinstance(found, str):
        reasons = found.split("\n")
        more = [f"{len(reasons) - MOST_REASONS} more"] if len(reasons) > MOST_REASONS else []
        why = element("ul", *(element("li", sentence(text)) for text in [*reasons[:MOST_REASONS], *more]))
        return section("recomputed", title, element("p", sentence(f"{ENGINE} does not recompute this dataset")), why)
    differing, open_ = sum(x.differs for x in found), sum(not x.comparable for x in found)
    counts = f"{len(found) - differing - open_} agree, {differing} differ, {open_} without a verdict"
    whole = f"{plural(len(found), 'run', 'runs')} recomputed by {ENGINE} from start to end: {counts}"
    rows = [
        (str(x.run), x.verdict, x.worst.name, "" if np.isnan(x.worst.time) else f"{x.worst.time:g} s",
         f"{number(x.worst.size, 2)} {unit_label(x.worst.units)}", number(x.worst.relative, 2), number(x.tolerance, 2),
         str(x.variables))
        for x in found
    ]  # fmt: skip
    headings = ("run", "verdict", "variable", "time", "difference", "relative", "tolerance", "variables compared")
    legend = element("p", CHECK_LEGEND, class_="quiet")
    return section("recomputed", title, element("p", sentence(whole)), table(headings, rows, 3), legend)


def doubts(found: Sequence[Recomputed] | str) -> list[str]:
    """A sentence where runs differ from those of the other engine."""
    labels = [] if isinstance(found, str) else [str(x.run) for x in found if x.differs]
    return (
        [f"{ENGINE} gives other numbers for run {', '.join(labels)}; the section of recomputed runs has what differs"]
        if labels
        else []
    )


def _inputs(ds: xr.Dataset, data: Tables) -> Iterator[Markup]:
    """What a sweep varies."""
    vary = data.get("sweep", {}).get("vary", {})
    if not vary:
        return
    rows = []
    for path, entry in vary.items():
        kind = entry.get("distribution", entry.get("scipy", "column" if "column" in entry else "formula"))
        rest = {key: x for key, x in entry.items() if key not in ("distribution", "scipy") and x is not False}
        unit = unit_label(str(ds[path].attrs.get("units", ""))) if path in ds.coords else ""
        rows.append((path, str(kind), ", ".join(f"{key} = {show(x)}" for key, x in rest.items()), unit))
    yield folded(
        f"The {plural(len(vary), 'varied number', 'varied numbers')}",
        table(("path", "distribution", "", "unit"), rows, 4),
    )


def _repeat(ds: xr.Dataset, name: str, check: int) -> Iterator[Markup]:
    commands = [f"lienumba run scenario.toml -o {name}    # the scenario below"]
    if is_modes(ds):
        turning = [f"--rotation {_row(ds.attrs['rotation'])} "] if np.any(ds.attrs.get("rotation", 0.0)) else []
        times = f"--at {_row(ds['time'].values)} "
        commands = [f"lienumba modes scenario.toml {times}{''.join(turning)}-o {name}    # the scenario below"]
        commands.append(f"lienumba animate {name} --mode {int(ds['mode'].values[0])}    # one mode as a film")
    elif "time_per_run" not in ds:
        commands.append(f"lienumba replay {name} --run {int(ds['run'].values[0])}    # one run, with its whole course")
    checked = f" --check {check}" if check else ""
    commands.append(f"lienumba report {name}{checked}    # this page")
    yield element("h3", "To repeat it")
    yield element("pre", "\n".join(commands))


def _row(numbers: Iterable[float]) -> str:
    return ",".join(f"{float(x):g}" for x in numbers)


def _scenario(ds: xr.Dataset) -> Iterator[Markup]:
    text = str(ds.attrs.get("scenario", ""))
    if text:
        yield folded("The whole scenario, every default written out", element("pre", text, id="scenario-toml"))
