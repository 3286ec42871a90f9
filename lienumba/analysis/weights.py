"""Weights of runs that a sampler drew where they tell most: what statistics take, and what is said of them."""

from __future__ import annotations

import numpy as np
import xarray as xr

from lienumba.store.layout import FULL, RUN, WEIGHT
from lienumba.sweep import weighted
from lienumba.sweep.samplers.streams import uniforms
from lienumba.words import plural

SEED = 1951  # of what decides which runs are kept, always the same


def weights_of(ds: xr.Dataset, which: np.ndarray | slice = slice(None)) -> np.ndarray | None:
    """The weights of these of the runs (n,), None if they have none."""
    return ds[WEIGHT].values[which].astype(float) if WEIGHT in ds and ds[WEIGHT].dims == RUN else None


def weights_told(weights: np.ndarray) -> str:
    """What the weights of runs (n,) mean for statistics."""
    tells = weighted.effective(weights) if weights.any() else 0.0
    count = plural(len(weights), "run has a weight", "runs have weights")
    return f"{count}, which statistics respect: of a mean they tell as much as {tells:,.0f} runs without"


def as_drawn(ds: xr.Dataset) -> xr.Dataset:
    """Runs of a sweep with weights that are a sample of the inputs as they vary, for statistics that take no weights.

    Parameters
    ----------
    ds : xarray.Dataset
        What `lienumba.run` returned.

    Returns
    -------
    xarray.Dataset
        The runs that are kept with a probability in proportion to their weights, always the same, without weights; the
        attribute `weights` says how many. A dataset without weights is returned as it is.
    """
    kept = kept_of(ds)
    if kept is None:
        return ds
    which = {"run": kept}
    if FULL in ds.dims:
        which[FULL] = np.isin(ds[FULL].values, ds["run"].values[kept])
    few = ds.isel({dim: np.flatnonzero(x) for dim, x in which.items()}).drop_vars(WEIGHT)
    return few.assign_attrs(weights=note_of(ds, kept))


def kept_of(ds: xr.Dataset, *groups: np.ndarray) -> np.ndarray | None:
    """Which runs (runs,) these are: of those with weights each is kept with a probability of its weight over the
    largest, in each of these groups (runs,) if there are any, by a stream of its own (J. von Neumann, 1951); None if
    there are no weights."""
    weights = weights_of(ds)
    if weights is None or not weights.any():
        return None
    labels = ds["run"].values
    drawn = labels >= 0
    kept = ~drawn
    u = np.ones(len(labels))
    u[drawn] = uniforms("kept by weight", labels[drawn], SEED)
    for group in groups or (drawn,):
        own = group & drawn
        kept[own] = (u * weights[own].max(initial=0.0) < weights)[own]
    return kept


def note_of(ds: xr.Dataset, kept: np.ndarray) -> str:
    """What is to be said of statistics over the runs that are kept."""
    drawn = ds["run"].values >= 0
    return (
        f"what takes no weights is of {int((kept & drawn).sum()):,} of the {int(drawn.sum()):,} weighted runs, kept "
        "with a probability in proportion to their weights"
    )
