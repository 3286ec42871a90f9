"""Statistics of attitudes: angles, means, covariances of rotation vectors."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import xarray as xr

from lienumba.analysis.statistics.blockwise import COUNT, STORED, Block, Found, RunStatistics, check_numbers
from lienumba.analysis.statistics.covariance import AXIS, OTHER, described, moments, second_axis
from lienumba.errors import ScenarioError
from lienumba.groups import so3
from lienumba.store.layout import RUN, texts
from lienumba.words import show, suggestion

MATRIX = ("axis", "body_axis")
FRAMES = ("body", "global")
ORTHOGONAL = 1e-3  # the largest element of R^T R - I that a rotation may have
UNIQUE = 1e-6  # the least sum of the two smaller singular values of a mean matrix that has one nearest rotation
AT_ONCE = 2**16  # rotations


def rotation_error(R: xr.DataArray, reference: xr.DataArray | np.ndarray) -> xr.DataArray:
    """The angle between rotations and a reference: the length of log(reference^T R).

    Parameters
    ----------
    R : xarray.DataArray
        Rotations, body to global, with the dimensions axis and body_axis.
    reference : xarray.DataArray, xarray.Dataset or 3x3 array
        The same, with the labels of `R` along the other dimensions that it has, such as `R.sel(run=-1)`; what
        `mean_rotation` gave; or one matrix.

    Returns
    -------
    xarray.DataArray
        The angle in rad, from 0 to pi, as exact beside these as elsewhere.
    """
    _check_matrices(R)
    reference = _matching(R, _one_or_labelled("reference", reference))
    _check(reference)
    dims = [str(name) for name in R.dims if name not in MATRIX]
    along = max(dims, key=lambda name: (name in STORED, R.sizes[name])) if dims else ""
    parts = []
    for here in _pieces(R.sizes[along], R.size // 9) if dims else [slice(0, 1)]:
        A, B = (x.isel({along: here}).compute() if along in x.dims else x for x in (R, reference))
        _check(A)
        parts.append(_angle(A, B))
    error = xr.concat(parts, along, coords="minimal", compat="override", join="override") if along else parts[0]
    error.attrs = texts("rad", "angle to the reference rotation")
    return error


def _angle(R: xr.DataArray, reference: xr.DataArray) -> xr.DataArray:
    A, B = (x.transpose(..., *MATRIX) for x in xr.broadcast(R, reference))
    u = so3.log(so3.multiply(so3.transpose(_nine(B.values)), _nine(A.values)))
    return A.isel(axis=0, body_axis=0, drop=True).copy(data=so3.dot(u, u) ** 0.5).rename("rotation_error")


def mean_rotation(R: xr.DataArray, dim: str = RUN[0]) -> xr.Dataset:
    """The mean of rotations over `dim`, at each other label: the rotation nearest to the mean of their matrices.

    It is that of `scipy.spatial.transform.Rotation.mean`.

    Parameters
    ----------
    R : xarray.DataArray
        Rotations, body to global, with the dimensions axis and body_axis.
    dim : str
        The dimension of the runs. The nominal run is left out if there are others.

    Returns
    -------
    xarray.Dataset
        `mean` (..., axis, body_axis), like `R`, over the `count` of the `runs` that have a value there; `spread`, the
        root of the mean squared angle to it, and `radius`, the largest one, in rad. NaN without a run, and where
        several rotations are equally near, as of two that are half a turn apart.
    """
    _check_matrices(R)
    runs = RunStatistics(R, dim, *MATRIX)

    def work(block: Block) -> Found:
        parts = [_mean(R, finite) for _, R, finite in _portions(runs, block)]
        return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}

    what = R.attrs.get("long_name", "rotation matrix")
    named: dict[str, Any] = {
        "mean": (MATRIX, dict(R.attrs) | texts("1", f"mean over {dim}: {what}")),
        "spread": ((), texts("rad", "root of the mean squared angle to the mean")),
        "radius": ((), texts("rad", "largest angle to the mean")),
        "count": ((), COUNT),
    }
    return runs.labelled(runs.gather(work), named)


def _mean(R: so3.Matrix3, finite: np.ndarray) -> Found:
    """Project the mean matrix U S V^T onto U diag(1, 1, +-1) V^T, the nearest rotation."""
    count = finite.sum(axis=1)
    known = np.maximum(count, 1)
    total = np.stack([np.where(finite, x, 0.0).sum(axis=1) for x in R], axis=-1).reshape(-1, 3, 3)
    U, sizes, V = np.linalg.svd(total / known[:, None, None])
    sign = np.linalg.det(U @ V)
    U[..., -1] *= sign[:, None]
    unique = sizes[:, 1] + sign * sizes[:, 2] > UNIQUE
    mean = np.where(unique[:, None, None], U @ V, np.nan)
    u = so3.log(so3.multiply(so3.transpose(tuple(x[:, None] for x in _nine(mean))), R))
    square = np.where(finite, so3.dot(u, u), 0.0)
    none = np.where(unique, 0.0, np.nan)
    return {
        "mean": mean,
        "spread": (square.sum(axis=1) / known) ** 0.5 + none,
        "radius": square.max(axis=1) ** 0.5 + none,
        "count": count,
    }


def rotation_covariance(
    R: xr.DataArray, mean: xr.DataArray | xr.Dataset | np.ndarray | None = None, dim: str = RUN[0], frame: str = "body"
) -> xr.Dataset:
    """The covariance of the rotation vectors from a mean to the runs, at each other label.

    Parameters
    ----------
    R : xarray.DataArray
        Rotations, body to global, with the dimensions axis and body_axis.
    mean : xarray.Dataset, xarray.DataArray or 3x3 array, optional
        What `mean_rotation` gave of `R`, which is the default, or rotations of your own to count deviations from.
    dim : str
        The dimension of the runs. The nominal run is left out if there are others.
    frame : str
        The axes of the vectors, "body": log(mean^T R), or "global": log(R mean^T).

    Returns
    -------
    xarray.Dataset
        `covariance` (..., axis, axis_2) in rad^2, by n - 1 about the mean vector, over the `count` of the `runs` that
        have a value there, NaN of fewer than two.
    """
    if frame not in FRAMES:
        raise ScenarioError(f"frame = {show(frame)}: is not known; {suggestion(str(frame), FRAMES)}")
    _check_matrices(R)
    runs = RunStatistics(R, dim, *MATRIX, new=(AXIS + OTHER,))
    M = _at_labels(runs, _one_or_labelled("mean", mean_rotation(R, dim) if mean is None else mean))

    def work(block: Block) -> Found:
        parts = []
        for first, A, finite in _portions(runs, block):
            B = so3.transpose(tuple(x[:, None] for x in _nine(M[first : first + len(finite)])))
            u = so3.log(so3.multiply(B, A) if frame == "body" else so3.multiply(A, B))
            parts.append(moments(np.where(finite[..., None], np.stack(u, axis=-1), np.nan)))
        return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}

    what = "log(mean^T R)" if frame == "body" else "log(R mean^T)"
    named = described("rad2", f"covariance of the rotation vectors {what}", frame)
    return runs.labelled(runs.gather(work), named, second_axis(R))


def _portions(runs: RunStatistics, block: Block) -> Iterator[tuple[int, so3.Matrix3, np.ndarray]]:
    """The rotations of some labels at a time: the number of the first, nine numbers (labels, runs), I where they are
    not known, and which are."""
    for here in _pieces(len(block.values), block.values.size // 9):
        first = block.first + here.start

        def place(index: tuple[int, ...], first: int = first) -> str:
            label = runs.place(first + int(index[0]))
            return f"{runs.dim} {block.runs[index[1]]}" + (f", {label}" if label else "")

        yield first, *_rotations(block.values[here], place)


def _pieces(labels: int, rotations: int) -> Iterator[slice]:
    """So many labels in pieces of about AT_ONCE rotations, one at least."""
    step = max(1, AT_ONCE * labels // max(rotations, 1))
    for first in range(0, max(labels, 1), step):
        yield slice(first, first + step)


def _nine(R: np.ndarray) -> so3.Matrix3:
    """Matrices (..., 3, 3) as nine numbers (...)."""
    return tuple(np.ascontiguousarray(np.moveaxis(R.reshape(*R.shape[:-2], 9), -1, 0)))


def _rotations(R: np.ndarray, place: Callable[[tuple[int, ...]], str]) -> tuple[so3.Matrix3, np.ndarray]:
    """Matrices (..., 3, 3) as nine numbers (...), and which are there, I standing for the others. Refuse those that are
    no rotations; place(index) says where."""
    nine = _nine(R)
    finite = np.isfinite(sum(nine))
    nine = tuple(np.where(finite, x, one) for x, one in zip(nine, so3.IDENTITY, strict=True))
    x, y, z = (nine[k::3] for k in range(3))  # columns
    off = [abs(so3.dot(a, b)) for a, b in ((x, y), (y, z), (z, x))] + [abs(so3.dot(a, a) - 1.0) for a in (x, y, z)]
    deviation = np.maximum.reduce(off)
    mirrored = so3.dot(so3.cross(x, y), z) < 0.0
    if (bad := (deviation > ORTHOGONAL) | mirrored).any():
        index = np.unravel_index(np.flatnonzero(bad)[0], bad.shape)
        what = f"R^T R is {deviation[index]:.2g} off the identity" if deviation[index] > ORTHOGONAL else "it mirrors"
        where = f" at {text}" if (text := place(index)) else ""
        raise ScenarioError(f"the matrix{where} is no rotation, since {what}; give rotation matrices, such as those of "
                            'ds["rotation"]')  # fmt: skip
    return nine, finite


def _check(R: xr.DataArray) -> None:
    """Refuse what are no rotations."""
    R = R.transpose(..., *MATRIX)
    _rotations(R.values, lambda index: ", ".join(f"{x} {R[x].values[k]}" for x, k in zip(R.dims, index, strict=False)))


def _one_or_labelled(name: str, given: object) -> Any:
    """A variable of rotations: that of a mean, one that was given, or of one 3x3 matrix."""
    if isinstance(given, xr.Dataset) and "mean" in given:
        return given["mean"]
    if isinstance(given, xr.DataArray | xr.Dataset):
        return given
    try:
        matrix = np.asarray(given, dtype=float)
    except (TypeError, ValueError):
        raise ScenarioError(f"{name} = {show(given)}: has no numbers; give a 3x3 matrix, or a variable") from None
    if matrix.shape != (3, 3):
        raise ScenarioError(f"{name}: has the shape {matrix.shape}; give a 3x3 matrix, or a variable")
    return xr.DataArray(matrix, dims=MATRIX, name=name)


def _at_labels(runs: RunStatistics, mean: xr.DataArray) -> np.ndarray:
    """A mean at every label (labels, 3, 3)."""
    _check_matrices(mean)
    if runs.dim in mean.dims:
        raise ScenarioError(f"mean: has the dimension {runs.dim}; give one rotation for all runs")
    coordinates = {name: runs.x[name] for name in runs.dims if name in runs.x.coords}
    labels = xr.DataArray(np.zeros(runs.sizes), coordinates, runs.dims, runs.x.name)
    mean = _matching(labels, mean)
    _check(mean)
    whole: np.ndarray = xr.broadcast(mean, labels)[0].transpose(*runs.dims, *MATRIX).values
    return whole.reshape(-1, 3, 3) if whole.size else whole.reshape(0, 3, 3)


def _matching(x: xr.DataArray, other: xr.DataArray) -> xr.DataArray:
    """The other, without coordinates that are no labels; its labels must be those of x."""
    _check_matrices(other)
    for name in set(x.dims) & set(other.dims):
        both = name in x.coords and name in other.coords
        if x.sizes[name] != other.sizes[name] or (both and not np.array_equal(x[name], other[name])):
            of = other.name or "the reference"
            raise ScenarioError(f"{of}: has other labels of {name} than {x.name or 'R'}; select those that both have")
    return other.drop_vars([name for name in other.coords if name not in other.dims])


def _check_matrices(R: xr.DataArray) -> None:
    check_numbers(R, *MATRIX)
    if any(R.sizes[name] != 3 for name in MATRIX):
        raise ScenarioError(f"{R.name or 'R'}: has not 3 entries along axis and body_axis; give whole matrices")
