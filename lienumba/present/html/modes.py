"""The sections of a dataset of modes: the shapes in motion, frequencies and damping, eigenvalues, frequency fans."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import xarray as xr

from lienumba.analysis.labels import unit_label
from lienumba.analysis.mode_rows import mode_rows, sampled, swept, unstable
from lienumba.analysis.mode_runs import as_runs
from lienumba.errors import ScenarioError
from lienumba.present.html import chart, motion, sensitivity
from lienumba.present.html.chart import Chart, Json, Section, section
from lienumba.present.html.header import scenario_of
from lienumba.present.html.markup import Markup, element, join, sentence, text_table
from lienumba.scene import Scene, mode_scene
from lienumba.store.linear_layout import has_shapes
from lienumba.words import plural

MOST_SHAPES = 24  # that can be chosen
MOST_FANS = 4  # swept numbers
MOST_POINTS = 6000  # of a chart
MOST_NAMED = 10  # modes in a legend


def headline(ds: xr.Dataset) -> Markup:
    """How many modes there are, and whether all is stable."""
    ds = sampled(ds)
    count = f"{plural(ds.sizes['mode'], 'mode', 'modes')} of {plural(ds.sizes['run'], 'run', 'runs')}"
    grow = {float(time): unstable(ds.sel(time=time)) for time in ds["time"].values}
    told = [f"{n:,} unstable at t = {time:g} s" for time, n in grow.items() if n]
    return join([element("strong", count), f": {'; '.join(told)}." if told else ", in none of which a mode grows."])


def sections(ds: xr.Dataset, name: str, extra: Json) -> Iterator[Section]:
    """extra: what scripts need, by the name of the script; name: of the file of the dataset."""
    found = _seen(ds, name)
    if not isinstance(found, str):
        extra["motion"] = motion.data(found, scenario_of(ds)["model"].get("gravity", ()))
    yield motion.section_of(found)
    for n, (rows, time) in enumerate(zip(mode_rows(ds), ds["time"].values, strict=True)):
        own = ds.sel(time=time)
        notes = [element("p", sentence(note), class_="quiet") for note in rows.notes]
        charts = [_plane(own), *(_fan(own, path) for path in swept(ds, MOST_FANS))]
        key = f"modes-{n}" if n else "modes"
        yield section(key, f"Modes at t = {time:g} s", text_table(rows.table), *notes, charts=charts)
    runs = as_runs(ds)
    yield from sensitivity.sections(runs, sensitivity.columns(runs))


def _seen(ds: xr.Dataset, name: str) -> Scene | str:
    """The shapes that are shown, or the sentence that says why there are none."""
    if not has_shapes(ds):
        return "this dataset has no shapes of modes: find them with shapes=True"
    try:
        return mode_scene(ds, modes=range(1, MOST_SHAPES + 1))
    except ScenarioError as error:
        return f"{name}: {error}"


def _plane(own: xr.Dataset) -> Chart:
    """The eigenvalues of all runs."""
    layout: Json = {
        "xaxis": chart.axis("real part (1/s)"), "yaxis": chart.axis("imaginary part (rad/s)"), "hovermode": "closest",
        "showlegend": own.sizes["mode"] <= MOST_NAMED, "height": 340,
        "shapes": [{"type": "line", "x0": 0, "x1": 0, "y0": 0, "y1": 1, "yref": "paper",
                    "line": {"color": chart.QUIET, "width": 1}}],
    }  # fmt: skip
    hover = "run %{customdata}: %{x:.4~g} ± %{y:.4~g} i"
    kept = _kept(own)
    traces = [
        _points(own["growth"], own["angular_frequency"].sel(mode=mode), kept, hover, n)
        for n, mode in enumerate(own["mode"].values)
    ]
    return Chart("Eigenvalues", traces, layout, note=_note(own, kept, "right of the line a mode grows"))


def _fan(own: xr.Dataset, path: str) -> Chart:
    """Frequencies over a swept number."""
    unit = unit_label(str(own[path].attrs.get("units", "")))
    across, upwards = f"{path} ({unit})" if unit else path, "frequency (Hz)"
    layout: Json = {
        "xaxis": chart.axis(across), "yaxis": chart.axis(upwards, rangemode="tozero"),
        "hovermode": "closest", "showlegend": own.sizes["mode"] <= MOST_NAMED, "height": 340,
    }  # fmt: skip
    hover, kept = "run %{customdata}: %{y:.5~g} Hz", _kept(own)
    kept = kept[np.argsort(own[path].values[kept], kind="stable")]
    alone = sum(x.attrs.get("role") == "input" for x in own.coords.values()) == 1
    traces = [
        _points(own[path], own["frequency"].sel(mode=mode), kept, hover, n) | ({"mode": "lines"} if alone else {})
        for n, mode in enumerate(own["mode"].values)
    ]
    return Chart(f"Frequencies over {path}", traces, layout, "Hz", _note(own, kept, ""))


def _points(x: xr.DataArray, y: xr.DataArray, kept: np.ndarray, hover: str, n: int) -> Json:
    """A mode, in the colour of its number."""
    mode = int(y["mode"])
    across = x.sel(mode=mode) if "mode" in x.dims else x
    return {
        "type": "scatter", "mode": "markers", "name": f"mode {mode}", "hovertemplate": hover,
        "x": chart.packed(across.values[kept].astype(float)), "y": chart.packed(y.values[kept].astype(float)),
        "customdata": chart.packed(y["run"].values[kept].astype(float)),
        "marker": {"color": chart.color(n), "size": 5}, "line": {"color": chart.color(n), "width": 1.8},
    }  # fmt: skip


def _kept(own: xr.Dataset) -> np.ndarray:
    """The runs (indices) that are drawn, evenly over the sweep."""
    runs = own.sizes["run"]
    most = max(MOST_POINTS // own.sizes["mode"], 50)
    return np.unique(np.linspace(0, runs - 1, min(runs, most)).round().astype(int))


def _note(own: xr.Dataset, kept: np.ndarray, note: str) -> str:
    drawn = f"{len(kept):,} of {own.sizes['run']:,} runs are drawn" if len(kept) < own.sizes["run"] else ""
    return "; ".join(filter(None, [note, drawn]))
