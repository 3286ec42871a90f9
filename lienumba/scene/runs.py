"""Which runs of a dataset are looked at in motion: the nominal or a typical one, the worst, one that failed, others."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr

from lienumba.batch.statuses import GOOD, STATUSES, SUCCESS
from lienumba.engine.select_run import check_run, worst
from lienumba.mechanics.elements.quantities import XYZ
from lienumba.mechanics.mechanism.massless import is_massless
from lienumba.mechanics.mechanism.model import Body
from lienumba.scenario.resolve import Scenario
from lienumba.scenario.start.build import geometry
from lienumba.store.layout import FULL, RUN
from lienumba.store.windows import windows
from lienumba.sweep.design import NOMINAL_RUN

POSE = ("position", "rotation")
LAST = ("last_position", "last_rotation")
NOMINAL = "nominal"
NAMES = {status.code: status.name for status in STATUSES}


@dataclass(frozen=True)
class ShownRun:
    """A run that is shown.

    Attributes
    ----------
    run : int
        Its label.
    why : str
        In a few words, why it is shown.
    """

    run: int
    why: str


def shown_runs(
    ds: "xr.Dataset",
    scenario: Scenario,
    where: str,
    count: int,
    *,
    runs: Sequence[int] = (),
    name: str | None = None,
) -> list[ShownRun]:
    """Up to `count` runs: the nominal one, or that with the most usual samples; the worst; the first that failed on the
    way; and others, evenly over the labels. runs: these instead; name: in what the worst is worst, else it is the run
    that departs farthest from the first of these."""
    if runs:
        for run in runs:
            check_run(ds, where, run)
        return [ShownRun(run, _status(ds, run)) for run in runs]
    labels, moved = ds["run"].values, ds["end_time"].values > 0.0
    good = moved & np.isin(ds["status"].values, GOOD)
    first = usual(ds, good)
    found = [first] if first is not None else []
    if name is not None:
        chosen = worst(ds, name)
        found.append(ShownRun(chosen.run, chosen.why))
    elif first is not None and good.sum() > 1:
        label = _farthest(ds, scenario, first.run, good)
        found += [] if label is None else [ShownRun(label, f"farthest from {first.why}")]
    failed = labels[moved & ~good]
    found += [ShownRun(int(label), _status(ds, int(label))) for label in failed[: 1 if good.any() else count]]
    others = labels[good]
    spread = others[np.linspace(0, len(others) - 1, min(count, len(others))).astype(int)] if len(others) else []
    found += [ShownRun(int(label), "") for label in spread]
    unique = {choice.run: choice for choice in reversed(found)}
    kept = [choice for choice in found if unique[choice.run] is choice]
    return kept[:count]


def _status(ds: "xr.Dataset", run: int) -> str:
    """How a run ended, if that is worth a word."""
    if run == NOMINAL_RUN:
        return NOMINAL
    code = int(ds["status"].sel(run=run))
    return "" if code == SUCCESS else f"{NAMES[code]} at {float(ds['end_time'].sel(run=run)):.4g} s".replace("_", " ")


def usual(ds: "xr.Dataset", which: np.ndarray) -> ShownRun | None:
    """The nominal run, or the one whose samples are nearest to the medians, in units of their spread."""
    labels = ds["run"].values
    if not which.any():
        return None
    if NOMINAL_RUN in labels[which]:
        return ShownRun(NOMINAL_RUN, NOMINAL)
    inputs = [x.values[which] for x in ds.coords.values() if x.attrs.get("role") == "input" and x.dims == RUN]
    distance = np.zeros(which.sum())
    for x in inputs:
        low, middle, high = np.quantile(x, [0.25, 0.5, 0.75])
        distance += ((x - middle) / (high - low)) ** 2 if high > low else 0.0
    label = int(labels[which][distance.argmin()])
    return ShownRun(label, "typical" if len(labels) > 1 else "")


def _farthest(ds: "xr.Dataset", scenario: Scenario, run: int, good: np.ndarray) -> int | None:
    """The run whose bodies are, at some time, farthest from where they are in another run: by the mean square distance
    of their mass points, |r - r'|^2 + tr((R - R') J (R - R')^T) / m  with  J = tr(I) / 2 - I."""
    names, dim = _poses(ds)
    if not names or not has_bodies(ds, scenario) or run not in ds[dim].values:
        return None
    second = np.array([_second_moment(body) for body in geometry(scenario, {})[0].bodies])
    r, R = (ds[name].sel({dim: run}).values for name in names)
    labels, largest = [], []
    for window in windows(ds, names, dim):
        dr, dR = window[names[0]].values - r, window[names[1]].values - R
        with np.errstate(over="ignore"):
            squares = (dr**2).sum(axis=-1) + np.einsum("...kij,kjl,...kil->...k", dR, second, dR)
        labels.append(window[dim].values)
        largest.append(np.nan_to_num(squares).reshape(len(dr), -1).max(axis=1))
    runs, distances = np.concatenate(labels), np.concatenate(largest)
    distances[~np.isin(runs, ds["run"].values[good])] = 0.0
    return int(runs[distances.argmax()]) if distances.max() > 0.0 else None


def _poses(ds: "xr.Dataset") -> tuple[tuple[str, ...], str]:
    """The variables that say where bodies are in each run, and the dimension of these runs."""
    for names, dim in ((POSE, "run"), (POSE, FULL), (LAST, "run")):
        if all(name in ds and ds[name].dims[0] == dim for name in names):
            return names, dim
    return (), "run"


def has_bodies(ds: "xr.Dataset", scenario: Scenario) -> bool:
    """Whether a dataset, which may be a selection, has all bodies of its scenario, and all of their axes, in order."""
    if any(dim not in ds.coords or ds[dim].values.tolist() != list(XYZ) for dim in ("axis", "body_axis")):
        return False
    return "body" in ds.dims and ds["body"].values.tolist() == [body.name for body in scenario.data.model.bodies]


def _second_moment(body: Body) -> np.ndarray:
    """J / m of a body in m^2, in its frame; 0 without mass."""
    if is_massless(body):
        return np.zeros((3, 3))
    xx, yy, zz, xy, xz, yz = body.inertia
    inertia = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]], float)
    return (0.5 * np.trace(inertia) * np.eye(3) - inertia) / float(body.mass)
