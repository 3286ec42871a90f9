"""What was run, with what, when and where, and how it can be repeated."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Sequence

import numpy as np
import xarray as xr

from lienumba.analysis.labels import unit_label
from lienumba.analysis.outcomes import counts
from lienumba.present.html.chart import Section, section
from lienumba.present.html.header import method, scenario_of
from lienumba.present.html.markup import Markup, element, facts, folded, table
from lienumba.scenario.base.toml import Tables
from lienumba.store.linear_layout import is_modes
from lienumba.store.study_layout import grid_of, is_study
from lienumba.words import plural, show

MOST_NAMES = 12
VERSIONS = ("python", "numba", "llvmlite", "numpy", "scipy", "xarray", "netcdf4")


def provenance(ds: xr.Dataset, name: str) -> Section:
    """The section; name: of the file of the dataset."""
    data = scenario_of(ds)
    parts = [facts(_facts(ds, data)), *_inputs(ds, data), *_repeat(ds, name), *_scenario(ds)]
    return section("origin", "What was run", *parts)


def _facts(ds: xr.Dataset, data: Tables) -> Iterator[tuple[str, str]]:
    attributes, model, sweep = ds.attrs, data.get("model", {}), data.get("sweep", {})
    date, _, command = str(attributes.get("history", "")).partition("\n")[0].partition(" ")
    for kind, key in (("bodies", "mass"), ("joints", "type"), ("drivers", "type"), ("forces", "type")):
        yield kind, _names(model.get(kind, []), key if kind != "bodies" else "")
    paths = grid_of(ds).values()
    yield "grid", _grid(data)
    yield "method", _method(data, paths)
    yield "simulated time", f"{data['integrator']['end_time']:g} s" if "end_time" in data.get("integrator", {}) else ""
    projection = data.get("projection", {})
    yield "projection", ", ".join(f"{key} {projection[key]}" for key in ("position", "velocity") if key in projection)
    yield "runs", _runs(ds) + (f", sampler {sweep['sampler']}" if "sampler" in sweep else "")
    yield "seed", str(attributes.get("seed", ""))
    yield "date", date.replace("T", " ")
    yield "command", command
    yield "source", str(attributes.get("source", ""))
    versions = ((key, attributes.get(f"{key}_version")) for key in VERSIONS)
    yield "with", ", ".join(f"{key} {version}" for key, version in versions if version)
    yield "processor", str(attributes.get("cpu", ""))
    yield "scenario sha256", str(attributes.get("scenario_sha256", ""))


def _runs(ds: xr.Dataset) -> str:
    """How many there are."""
    if is_study(ds):
        return f"{ds.sizes['run']:,} at each point of the grid"
    if is_modes(ds):
        return f"{ds.sizes['run']:,}"
    ran = counts(ds)
    return f"{ran.runs:,}{ran.beside}"


def _grid(data: Tables) -> str:
    """What a study sets, one grid after the other."""
    blocks = data.get("study", {}).get("grid", [])
    return "; ".join(
        ", ".join(f"{path} = {' | '.join(map(show, values))}" for path, values in block.items()) for block in blocks
    )


def _method(data: Tables, paths: Collection[str]) -> str:
    """The method and the length of its steps, but for what is set at these paths of a study."""
    set_by_grid = {path.split(".")[1] for path in paths if path.startswith("integrator.")}
    if "method" in set_by_grid:
        return ""
    return method({key: x for key, x in data.get("integrator", {}).items() if key not in set_by_grid})


def _names(items: Sequence[Tables], key: str) -> str:
    """The first of these, each with its kind."""
    shown = [_name(item, key) for item in items[:MOST_NAMES]]
    return ", ".join(shown) + (f" and {len(items) - MOST_NAMES} more" if len(items) > MOST_NAMES else "")


def _name(item: Tables, key: str) -> str:
    own, kind = str(item.get("name", "")), str(item.get(key, ""))
    return f"{own} ({kind})" if own and kind else own or kind


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
