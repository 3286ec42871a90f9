"""Covariances over runs, and the ellipsoids that hold a part of them."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from lienumba.analysis.statistics.blockwise import (
    COUNT,
    Block,
    Found,
    RunStatistics,
    check_free,
    check_numbers,
    check_probability,
    power,
)
from lienumba.errors import ScenarioError
from lienumba.store.layout import RUN, texts

AXIS = "axis"
OTHER = "_2"  # behind the name of the second dimension of a covariance
FLAT = 1e-12  # of the largest variance: what is less is none
ROUNDING = 1e-9  # of the largest element of a matrix: by so much it may miss being a covariance
PRINCIPAL = "principal"


def covariance(x: xr.DataArray, dim: str = RUN[0]) -> xr.Dataset:
    """The covariance of a vector over `dim` at each other label, such as that of positions.

    For the covariance in a plane, select two axes first.

    Parameters
    ----------
    x : xarray.DataArray
        The vectors, with `dim` and one dimension of two or three axes, such as `ds.position`.
    dim : str
        The dimension of the runs. The nominal run is left out if there are others.

    Returns
    -------
    xarray.Dataset
        `covariance` (..., axis, axis_2) by n - 1, in the square of the unit of `x`, over the `count` of the `runs` that
        have a value there; NaN of fewer than two.
    """
    runs = RunStatistics(x, dim, AXIS, new=(AXIS + OTHER,))
    named = described(
        power(str(x.attrs.get("units", "1")), 2),
        f"covariance over {dim}: {x.attrs.get('long_name', x.name)}",
        x.attrs.get("frame"),
    )

    def work(block: Block) -> Found:
        return moments(block.values)

    return runs.labelled(runs.gather(work), named, second_axis(x))


def moments(vectors: np.ndarray) -> Found:
    """The covariance of vectors (labels, runs, size), and how many there are; NaN is none."""
    finite = np.isfinite(vectors).all(axis=-1)
    count = finite.sum(axis=1)
    mean = np.where(finite[..., None], vectors, 0.0).sum(axis=1) / np.maximum(count, 1)[:, None]
    rest = np.where(finite[..., None], vectors - mean[:, None], 0.0)
    found = np.swapaxes(rest, 1, 2) @ rest / np.where(count > 1, count - 1, np.nan)[:, None, None]
    return {"covariance": found, "count": count}


def described(units: str, long_name: str, frame: str | None) -> dict[str, Any]:
    """What `moments` found, for `RunStatistics.labelled`."""
    attributes = texts(units, long_name) | ({} if frame is None else {"frame": frame})
    return {"covariance": ((AXIS, AXIS + OTHER), attributes), "count": ((), COUNT)}


def second_axis(x: xr.DataArray) -> dict[str, Any]:
    """The labels of the second dimension of a covariance."""
    return {AXIS + OTHER: (AXIS + OTHER, x[AXIS].values, texts("1", "second axis of the covariance"))}


def ellipsoid(cov: xr.Dataset | xr.DataArray, probability: float = 0.997) -> xr.Dataset:
    """The ellipsoid about the mean that holds a part of normal vectors; the ellipse in a plane.

    Parameters
    ----------
    cov : xarray.Dataset or xarray.DataArray
        What `covariance` or `rotation_covariance` gave; or a variable, taken for exact, 2x2 or 3x3 along a dimension
        and the one called like it with "_2" behind.
    probability : float
        The part that it holds, between 0 and 1.

    Returns
    -------
    xarray.Dataset
        `semi_axis` (..., principal), the longest first; `direction` (..., axis, principal), right-handed unit vectors;
        `volume`, or `area`; `freedom`, in how many directions the vectors vary: chi-squared with so many degrees of
        freedom has this `probability`, and across a plane or line in which they all are the semi-axis is 0. `count`, if
        known: of no more runs than there are axes it is NaN, with freedom 0, since so few always lie in a plane; of few
        it holds less than asked for.
    """
    from scipy.special import chdtri, gamma

    check_probability("probability", probability)
    C, count = _counted(cov)
    first, second = _pair(C)
    check_free(C, PRINCIPAL)
    C = C.transpose(..., first, second)
    variances, directions = _principal(C)
    size = C.sizes[first]
    if count is not None:
        enough = (count.broadcast_like(C.isel({first: 0, second: 0})) > size).transpose(*C.dims[:-2]).values
        variances = np.where(enough[..., None], variances, np.nan)
        directions = np.where(enough[..., None, None], directions, np.nan)
    freedom = (variances > FLAT * variances[..., :1]).sum(axis=-1)
    kept = np.where(np.arange(size) < freedom[..., None], variances, 0.0 * variances)
    semi = (chdtri(np.maximum(freedom, 1), 1.0 - probability)[..., None] * kept) ** 0.5
    ball = np.pi ** (0.5 * size) / gamma(0.5 * size + 1.0)
    units = power(str(C.attrs.get("units", "1")), 0.5)
    labels, whole = C.dims[:-2], "volume" if size == 3 else "area"
    frame = {"frame": C.attrs["frame"]} if "frame" in C.attrs else {}
    share = f"{100.0 * probability:g} %"
    data = {
        "semi_axis": ((*labels, PRINCIPAL), semi, texts(units, f"semi-axes of the ellipsoid that holds {share}")),
        "direction": ((*labels, first, PRINCIPAL), directions, texts("1", "directions of the semi-axes") | frame),
        whole: (labels, ball * semi.prod(axis=-1), texts(power(units, size), f"{whole} of the ellipsoid")),
        "freedom": (labels, freedom, texts("1", "directions in which the vectors vary")),
    }
    if count is not None:
        data["count"] = (count.dims, count.values, COUNT)
    coordinates = {name: x for name, x in C.coords.items() if second not in x.dims}
    numbers = {PRINCIPAL: (PRINCIPAL, np.arange(1, size + 1), texts("1", "number of the semi-axis"))}
    return xr.Dataset(data, {**coordinates, **numbers}, {"probability": probability})


def _counted(cov: xr.DataArray | xr.Dataset) -> tuple[Any, xr.DataArray | None]:
    """A covariance, and of how many runs it is, if that is known."""
    if isinstance(cov, xr.Dataset) and {"covariance", "count"} <= set(cov):
        return cov["covariance"], cov["count"]
    return cov, None


def _pair(cov: xr.DataArray) -> tuple[str, str]:
    """The two dimensions of a covariance."""
    check_numbers(cov)
    for name in map(str, cov.dims):
        if name + OTHER in cov.dims and cov.sizes[name] == cov.sizes[name + OTHER] in (2, 3):
            return name, name + OTHER
    raise ScenarioError(
        f"{cov.name or 'cov'}: is no covariance, which has 2 or 3 entries along a dimension such as axis and along one "
        "called axis_2; give what covariance or rotation_covariance returns"
    )


def _principal(cov: xr.DataArray) -> tuple[np.ndarray, np.ndarray]:
    """Variances (..., size), the largest first and none below 0, and their directions (..., size, size) in columns."""
    C = cov.values
    finite = np.isfinite(C).all(axis=(-2, -1))[..., None]
    C = np.where(finite[..., None], C, np.eye(C.shape[-1]))
    variances, directions = (x[..., ::-1] for x in np.linalg.eigh(C))
    largest = abs(C).max(axis=(-2, -1))
    skew = abs(C - np.swapaxes(C, -1, -2)).max(axis=(-2, -1)) > ROUNDING * largest
    bad = skew | (variances[..., -1] < -ROUNDING * largest)
    if bad.any():
        index = np.unravel_index(np.flatnonzero(bad)[0], bad.shape)
        label = ", ".join(f"{name} {cov[name].values[k]}" for name, k in zip(cov.dims, index, strict=False))
        what = "is not symmetric" if skew[index] else f"has the variance {variances[index][-1]:.3g} in one direction"
        raise ScenarioError(
            f"{cov.name or 'cov'}: the matrix{f' at {label}' if label else ''} {what}, so it is no covariance; give a "
            "symmetric matrix without negative eigenvalues"
        )
    longest = np.take_along_axis(directions, abs(directions).argmax(axis=-2, keepdims=True), axis=-2)
    directions = np.where(longest < 0.0, -directions, directions)
    turned = np.linalg.det(directions) < 0.0
    directions[..., -1] = np.where(turned[..., None], -directions[..., -1], directions[..., -1])
    return np.where(finite, np.maximum(variances, 0.0), np.nan), np.where(finite[..., None], directions, np.nan)
