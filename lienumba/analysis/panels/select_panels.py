"""What is shown of a dataset: panels of what says most, or of what is asked for by name.

A panel has one or more lines, each one number of every run: over the time, or once. The nine
elements of a rotation say little to people, so `rotation` is shown as the angles of the axes of the body, see
`attitude.py`; an element of it can be asked for, such as `rotation.top.x.z`.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
import xarray as xr

from lienumba.analysis.labels import axis_label, input_label, words
from lienumba.analysis.outcomes import of_sweep
from lienumba.analysis.sensitivities import outputs
from lienumba.analysis.text_table import ROUNDING
from lienumba.batch.statuses import GOOD
from lienumba.mechanics.system.output_variables import MODE, kept_largest
from lienumba.store.layout import FULL, VARIABLES
from lienumba.store.names import INPUT, OVER_TIME, STATUS, Name, by_variable, dims_of, find, known, names_of
from lienumba.words import plural

ROTATIONS = ("rotation", "last_rotation")
ENERGIES = {"energy": "total", "kinetic_energy": "kinetic", "potential_energy": "potential"}
VIOLATIONS = {"position_violation": "position", "velocity_violation": "velocity"}
POSE, MOTION = ("position", "rotation"), ("angular_velocity", "velocity")
EACH = ("body", "joint")  # dimensions whose entries have panels of their own
MOST_LINES = 12  # in one panel
MOST_ASKED = 24  # panels
MOST, TIMED, ALONE = 12, 6, 7  # panels where none is asked for: all, over the time, these without histograms
FEW = 12  # runs: too few for a histogram
RANKED = 10_000  # runs that say on which inputs an output depends


@dataclass(frozen=True)
class PanelLine:
    """One number of every run. place: its index along each dimension of its variable but run and time."""

    variable: str
    label: str
    place: Mapping[str, int] = field(default_factory=dict)


@dataclass(frozen=True)
class Panel:
    """What one diagram shows. label: of the axis of its values, with the unit; dim: along which its runs are;
    over_time: it shows time series, not histograms; angles: of axes of a body, from columns of its rotations;
    logarithmic: its values are; sampled: it is an input, which failed runs have too."""

    title: str
    label: str
    lines: tuple[PanelLine, ...]
    dim: str = "run"
    over_time: bool = True
    angles: bool = False
    logarithmic: bool = False
    sampled: bool = False

    @property
    def steps(self) -> bool:
        """Whether its values jump from one whole number to another."""
        return self.name == MODE.name

    @property
    def name(self) -> str:
        """The first of its variables."""
        return self.lines[0].variable


@dataclass(frozen=True)
class SelectedPanels:
    """The panels that say most, and a sentence on what has been left out, empty if nothing was."""

    panels: tuple[Panel, ...]
    left_out: str = ""


def default_panels(ds: xr.Dataset) -> SelectedPanels:
    """Time series of the scenario's own quantities, of efforts, of the state and the energy; drift; of a sweep
    histograms of its outputs and inputs; how the runs ended, if some failed or there is nothing else."""
    ends, good = [*_panels(ds[STATUS])], good_runs(ds)
    if not good.any():
        inputs = _inputs(ds)
        return SelectedPanels((*ends, *inputs[: MOST - 1]), _left_out([], len(inputs) - MOST + 1))
    ends = ends if good.sum() < of_sweep(ds).sum() else []
    timed = [panel for panel in _over_time(ds) if _moves(ds, panel)]
    checks = [panel for panel in (*_drift(ds), *_violations(ds)) if _moves(ds, panel)] or list(_worst(ds))
    several = not timed or good.sum() > FEW
    results, inputs = (list(_results(ds)), list(_inputs(ds))) if several else ([], [])
    shown = timed[: TIMED if results or inputs else ALONE]
    room = MOST - len(shown) - len(checks) - len(ends)
    results = results[: max(room - len(inputs), room // 2)]
    sampled = inputs[: room - len(results)]
    first = (*shown, *checks, *results) if timed else (*results, *checks)
    panels = (*first, *ends, *sampled) or tuple(_panels(ds[STATUS]))
    return SelectedPanels(panels, _left_out(timed[len(shown) :], len(inputs) - len(sampled)))


def named_panels(ds: xr.Dataset, names: Sequence[str]) -> SelectedPanels:
    """Panels of variables, inputs, `status`, or components such as `position.top` and `position.top.z`."""
    found: list[Panel] = []
    every = known(ds)
    for own in (find(name, every, "variable") for name in names):
        for variable, part in by_variable(own).items():
            found += [_input(ds[variable])] if part[0].kind == INPUT else _panels(ds[variable], part)
    shown = [panel for n, panel in enumerate(found) if panel not in found[:n]]
    return SelectedPanels(tuple(shown[:MOST_ASKED]), _left_out(shown[MOST_ASKED:], 0))


def good_runs(ds: xr.Dataset) -> np.ndarray:
    """The runs that are shown (runs,): the good ones, without the nominal one if there are others."""
    good: np.ndarray = ds[STATUS].isin(GOOD).values
    spread: np.ndarray = good & of_sweep(ds)
    return spread if spread.any() else good


def _left_out(panels: Sequence[Panel], inputs: int) -> str:
    """What else there is."""
    words = [panel.title for panel in panels[:3]]
    more = len(panels) - len(words)
    words += [plural(more, "other diagram", "other diagrams")] if more else []
    words += [plural(inputs, "input", "inputs")] if inputs > 0 else []
    return f"not shown: {', '.join(words)}" if words else ""


def _over_time(ds: xr.Dataset) -> Iterator[Panel]:
    """Of the scenario's own quantities, of efforts, and of the state: bodies from the last on, which is the tip of a
    chain."""
    timed = [*dict.fromkeys(x.variable for x in known(ds).every.values() if x.kind in OVER_TIME)]
    forced = [name for name in ("driver_effort", MODE.name) if name in timed]
    for name in [*(name for name in timed if name not in VARIABLES), *forced]:
        yield from _panels(ds[name])
    last, *others = [*_bodies(ds, timed)][::-1] or [[]]
    yield from last[: len(POSE)]
    yield from _energy(ds)
    yield from [*last[len(POSE) :], *(panel for panels in others for panel in panels)]


def _bodies(ds: xr.Dataset, timed: Sequence[str]) -> Iterator[list[Panel]]:
    """The panels of the state of each body."""
    found = [list(_panels(ds[name])) for name in (*POSE, *MOTION) if name in timed]
    yield from map(list, zip(*filter(None, found), strict=True))  # of a selection of axes there is no attitude


def _energy(ds: xr.Dataset) -> Iterator[Panel]:
    """Total, kinetic and potential energy in one panel."""
    lines = [PanelLine(name, label) for name, label in ENERGIES.items() if name in ds and "time" in ds[name].dims]
    if lines:
        yield Panel("energy", axis_label("energy", "J"), tuple(lines), _dim(ds[lines[0].variable]))


def _drift(ds: xr.Dataset) -> Iterator[Panel]:
    """The energy residual."""
    name = "energy_residual"
    if name in ds and "time" in ds[name].dims:
        yield from _panels(ds[name])


def _violations(ds: xr.Dataset) -> Iterator[Panel]:
    """Those of positions and velocities in one panel."""
    lines = [PanelLine(name, label) for name, label in VIOLATIONS.items() if name in ds and "time" in ds[name].dims]
    if lines:
        words, label = "violation of the constraints", "violation (m, m/s)"
        yield Panel(words, label, tuple(lines), _dim(ds[lines[0].variable]), logarithmic=True)


def _moves(ds: xr.Dataset, panel: Panel) -> bool:
    """Whether anything over the time changes, or is not the same in all runs, as far as the first few tell."""
    good = ds["run"].values[good_runs(ds)]
    first = np.flatnonzero(np.isin(ds[panel.dim].values, good))[:FEW]
    for line in panel.lines:
        few = ds[line.variable].isel({panel.dim: first})
        own = np.nan_to_num(few.isel(dict(line.place)).transpose(panel.dim, "time", ...).values)
        changes = np.ptp(own, axis=(0, 1)).max() if own.size else 0.0
        if changes > ROUNDING * abs(np.nan_to_num(few.values)).max(initial=0.0):
            return True
    return False


def _worst(ds: xr.Dataset) -> Iterator[Panel]:
    """Drift and violations where there is no time series: the largest of each run, if not the same in all."""
    for name in kept_largest():
        if name in ds:
            values = ds[name].values[good_runs(ds)]
            if np.ptp(values) > ROUNDING * values.max():
                yield from _panels(ds[name])


def _results(ds: xr.Dataset) -> Iterator[Panel]:
    """What each run came to, if not all to the same: one number to a panel, at the last time, or once in a run."""
    for output in outputs.read(ds, outputs.default_outputs(ds)[: outputs.MOST], None, good_runs(ds)):
        values = output.values[np.isfinite(output.values)]
        if output.of is not None and len(values) and np.ptp(values) > ROUNDING * output.scale:
            panel = next(_panels(ds[output.of.variable], [output.of]))
            yield replace(panel, title=panel.title + (" at the end" if panel.over_time else ""), over_time=False)


def _inputs(ds: xr.Dataset) -> list[Panel]:
    """The sampled inputs, those first on which the first result depends most."""
    names = [str(name) for name, x in ds.coords.items() if x.attrs.get("role") == "input"]
    strength = dict(zip(names, _strengths(ds, names), strict=True))
    return [_input(ds[name]) for name in sorted(names, key=lambda name: -strength[name])]


def _input(samples: xr.DataArray) -> Panel:
    name = str(samples.name)
    units = str(samples.attrs.get("units", ""))
    return Panel(f"sampled {name}", input_label(name, units), (PanelLine(name, ""),), over_time=False, sampled=True)


def _strengths(ds: xr.Dataset, names: Sequence[str]) -> list[float]:
    """How much the first result depends on each input: absolute rank correlations."""
    from lienumba.analysis.sensitivities.ranks import standard_ranks

    which = np.flatnonzero(good_runs(ds))[:RANKED]
    if not len(which) or not names:
        return [0.0] * len(names)
    few = ds.isel(run=slice(int(which[0]), int(which[-1]) + 1))
    which -= which[0]
    result = next(iter(outputs.read(few, (), None, good_runs(few))))
    which = which[np.isfinite(result.values[which])]
    ranks = standard_ranks(result.values[which])
    found = [abs(float(ranks @ standard_ranks(few[name].values[which]))) for name in names]
    return [x if np.isfinite(x) else 0.0 for x in found]


def _dim(variable: xr.DataArray) -> str:
    return FULL if FULL in variable.dims else "run"


def _panels(variable: xr.DataArray, wanted: Iterable[Name] | None = None) -> Iterator[Panel]:
    """A panel for each body or joint of these names, and for each unit; of a whole rotation its angles."""
    dims = dims_of(variable)
    each = dims.index(next((dim for dim in EACH if dim in dims), "")) if set(EACH) & set(dims) else None
    groups: dict[tuple[int, str], list[Name]] = {}
    for x in names_of(variable) if wanted is None else wanted:
        groups.setdefault((0 if each is None else x.place[each], x.units), []).append(x)
    for (item, _), group in groups.items():
        of = "" if each is None else f" of {variable[dims[each]].values[item]}"
        yield _panel(variable, group, dims, each, of)


def _panel(variable: xr.DataArray, group: list[Name], dims: list[str], each: int | None, of: str) -> Panel:
    name = str(variable.name)
    over_time = "time" in variable.dims
    if name in ROTATIONS and len(group) == 9:
        end = "" if over_time else " at the end"
        lines = [PanelLine(name, axis, {"body": group[0].place[0], "body_axis": n}) for n, axis in enumerate("xyz")]
        return Panel(f"attitude{of}{end}", "", tuple(lines), _dim(variable), over_time, angles=True)
    lines = []
    for x in group:
        index = dict(zip(dims, x.place, strict=True))
        label = "".join(str(variable[dim].values[n]) for dim, n in index.items() if dims.index(dim) != each)
        alone = f", {label}" if len(group) == 1 and label else ""
        lines.append(PanelLine(name, label if len(group) > 1 else "", index))
    frame = ", body frame" if variable.attrs.get("frame") == "body" else ""
    more = f", the first {MOST_LINES} of {len(lines)}" if len(lines) > MOST_LINES else ""
    return Panel(
        f"{words(name)}{of}{alone}{frame}{more}",
        axis_label(name, group[0].units),
        tuple(lines[:MOST_LINES]),
        _dim(variable),
        over_time,
        logarithmic=name in VIOLATIONS,
    )
