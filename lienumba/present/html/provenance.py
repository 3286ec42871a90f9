"""What was run, with what, when and where, and how it can be repeated."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np
import xarray as xr

from lienumba.analysis.labels import unit_label
from lienumba.present.html.chart import Section, section
from lienumba.present.html.header import scenario_of
from lienumba.present.html.markup import Markup, element, folded, table
from lienumba.present.info import describe_dataset
from lienumba.scenario.base.toml import Tables
from lienumba.store.linear_layout import is_modes
from lienumba.words import plural, show


def provenance(ds: xr.Dataset, name: str) -> Section:
    """The section, with what `lienumba info` says; name: of the file of the dataset."""
    told = element("pre", describe_dataset(ds))
    return section("origin", "What was run", told, *_inputs(ds, scenario_of(ds)), *_repeat(ds, name), *_scenario(ds))


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


def _repeat(ds: xr.Dataset, name: str) -> Iterator[Markup]:
    commands = [f"lienumba run scenario.toml -o {name}    # the scenario below"]
    if is_modes(ds):
        turning = [f"--rotation {_row(ds.attrs['rotation'])} "] if np.any(ds.attrs.get("rotation", 0.0)) else []
        times = f"--at {_row(ds['time'].values)} "
        commands = [f"lienumba modes scenario.toml {times}{''.join(turning)}-o {name}    # the scenario below"]
        commands.append(f"lienumba animate {name} --mode {int(ds['mode'].values[0])}    # one mode as a film")
    elif "time_per_run" not in ds:
        commands.append(f"lienumba replay {name} --run {int(ds['run'].values[0])}    # one run, with its whole course")
    commands.append(f"lienumba report {name}    # this page")
    yield element("h3", "To repeat it")
    yield element("pre", "\n".join(commands))


def _row(numbers: Iterable[float]) -> str:
    return ",".join(f"{float(x):g}" for x in numbers)


def _scenario(ds: xr.Dataset) -> Iterator[Markup]:
    text = str(ds.attrs.get("scenario", ""))
    if text:
        yield folded("The whole scenario, every default written out", element("pre", text, id="scenario-toml"))
