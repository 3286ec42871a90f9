"""The figure of a dataset: of runs, how their variables spread; of a study, see `study.py`, of modes `modes.py`."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import xarray as xr

from lienumba.analysis.outcomes import counts
from lienumba.analysis.panels.quantiles import PanelSeries
from lienumba.analysis.panels.run_windows import nominal_run
from lienumba.analysis.panels.select_panels import (
    Panel,
    SelectedPanels,
    default_panels,
    good_runs,
    named_panels,
)
from lienumba.analysis.weights import as_drawn
from lienumba.errors import ScenarioError
from lienumba.figures import canvas
from lienumba.figures.dark import darken
from lienumba.figures.panels import draw, explain
from lienumba.store.files import reading
from lienumba.store.linear_layout import MODES, is_modes
from lienumba.store.names import STATUS, one_of
from lienumba.store.study_layout import is_study
from lienumba.store.targets import claimed
from lienumba.words import listed, plural, show

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def figure(
    dataset: str | os.PathLike[str] | xr.Dataset,
    names: str | Sequence[str] = (),
    *,
    against: str | Sequence[str] = (),
    convergence: bool = False,
    requirement: str | None = None,
    sensitivity: bool = False,
    dark: bool = False,
) -> Figure:
    """The figure of a dataset; a notebook shows it.

    Parameters
    ----------
    dataset : xarray.Dataset or path
        What `lienumba.run` or `lienumba.modes` returned, or its file.
    names : str or sequence of str
        What to draw, such as `tip`, `position.top.z`, `bodies.top.mass` or `status`; what says most if omitted.
    against : str or sequence of str
        Inputs, such as `bodies.top.mass`: outputs are drawn over them, a point for each run.
    convergence : bool
        Whether to draw how the means of outputs settle over the runs, with their 95 % intervals.
    requirement : str, optional
        The name of a requirement: the inputs that set apart the runs that fail it are drawn.
    sensitivity : bool
        Whether to draw what outputs depend on: Sobol' indices of inputs, or Morris' elementary effects.
    dark : bool
        Whether it is for a dark page.

    Returns
    -------
    matplotlib.figure.Figure
        One panel for each name.
    """
    wanted = [names] if isinstance(names, str) else names
    with reading(dataset, (MODES,)) as (ds, _):
        inputs = [against] if isinstance(against, str) else against
        drawn = _chosen(ds, wanted, inputs, convergence, requirement, sensitivity)
    if dark:
        darken(drawn)
    return drawn


def save(drawn: Callable[[], Figure], target: Path) -> None:
    """Write a figure as PNG, SVG or PDF; drawn: makes it, as soon as the file is ours."""
    with claimed(target, "figure", canvas.STILLS) as output:
        canvas.save(drawn(), output)


def _chosen(
    ds: xr.Dataset,
    names: Sequence[str],
    against: Sequence[str],
    convergence: bool,
    requirement: str | None,
    sensitivity: bool,
) -> Figure:
    """The figure that is asked for; a ScenarioError for several at once."""
    kinds = {"against": against, "convergence": convergence, "requirement": requirement, "sensitivity": sensitivity}
    asked = [name for name, x in kinds.items() if x]
    if len(asked) > 1 or (requirement and names):
        both = listed([*asked, *(["names"] if requirement and names else [])])
        raise ScenarioError(f"{both} are asked for together, but each has a figure of its own; give one of them")
    if is_modes(ds):
        if asked or names:
            given = show(names[0]) if names else asked[0]
            rule = "a dataset of modes has one figure, of eigenvalues and frequencies"
            raise ScenarioError(f"{given}: {rule}; leave it out, or draw what is in it in Python")
        from lienumba.figures.modes import modes_figure

        return modes_figure(ds)
    if asked and is_study(ds):
        raise ScenarioError(f"{asked[0]}: a study has no sampled runs of one setting; give a dataset of a sweep")
    if requirement:
        from lienumba.figures.requirements import requirement_figure

        return requirement_figure(ds, requirement)
    if sensitivity:
        from lienumba.figures.sensitivity import sensitivity_figure

        return sensitivity_figure(ds, names)
    ds = _as_varied(ds)
    if asked:
        from lienumba.figures import outputs

        return outputs.scatter(ds, names, against) if against else outputs.convergence(ds, names)
    return _figure(ds, names)


def _as_varied(ds: xr.Dataset) -> xr.Dataset:
    """Runs that show how the inputs vary; a title that says so where others have been left out."""
    kept = as_drawn(ds)
    titles = [str(ds.attrs.get("title", "")), str(kept.attrs.get("weights", ""))]
    return kept.assign_attrs(title=": ".join(filter(None, titles)))


def _figure(ds: xr.Dataset, names: Sequence[str]) -> Figure:
    if not is_study(ds):
        return _of_runs(ds, named_panels(ds, names) if names else default_panels(ds))
    from lienumba.figures.study import study_figure

    drawable = [str(x) for x in ds.variables if set(ds[x].dims) - {x}]
    return study_figure(ds, [one_of(name, drawable, "the dataset", "variable", "it has none") for name in names])


def _of_runs(ds: xr.Dataset, choice: SelectedPanels) -> Figure:
    if not ds.sizes["run"]:
        raise ScenarioError("the dataset has no run; select at least one")
    if not good_runs(ds).any() and any(_is_of_good_runs(panel) for panel in choice.panels):
        raise ScenarioError('no run of the dataset succeeded; draw how they ended, "status", or an input')
    columns = _columns(len(choice.panels))
    drawn, axes = canvas.tiles(len(choice.panels), columns)
    shown = [draw(ax, ds, panel) for ax, panel in zip(axes, choice.panels, strict=True)]
    series = [one for one in shown if one is not None]
    nominal = any(nominal_run(ds, panel) is not None for panel in choice.panels)
    explain(drawn, [panel for panel in choice.panels if panel.over_time], series, nominal, choice.left_out)
    canvas.entitle(drawn, str(ds.attrs.get("title", "")), _count(ds, choice.panels, series))
    return drawn


def _columns(panels: int) -> int:
    return panels if panels <= 3 else 2 if panels == 4 else 3 if panels <= 9 else 4


def _is_of_good_runs(panel: Panel) -> bool:
    """Whether failed runs are no part of a panel."""
    return panel.name != STATUS and not panel.sampled


def _count(ds: xr.Dataset, panels: Sequence[Panel], series: Sequence[PanelSeries]) -> str:
    """Of how many runs it is, and what became of those that did not reach the end."""
    ran = counts(ds)
    read = min((x.runs for x in series), default=len(ds["run"]))
    which = plural(ran.runs, "run", "runs") + ran.beside
    if ran.nominal and not ran.nominal.good:
        which += ", which failed"
    some = f"courses of {read:,}" if read < good_runs(ds).sum() else ""
    inputs = any(panel.sampled for panel in panels)
    remark = " and shown among the inputs only" if inputs else " and not shown"
    hidden = any(_is_of_good_runs(panel) for panel in panels)
    failed = ran.failed + (remark if ran.failed and hidden else "")
    stopped = f"{ran.stopped:,} stopped by events" if ran.stopped else ""
    return "; ".join(filter(None, [which, some, failed, stopped]))
