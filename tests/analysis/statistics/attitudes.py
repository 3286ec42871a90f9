"""Rotations of runs, by SciPy."""

import numpy as np
import xarray as xr
from scipy.spatial.transform import Rotation

AXES = ["x", "y", "z"]


def attitudes(matrices, dims=("run",), **labels):
    """A variable of rotation matrices (..., 3, 3)."""
    matrices = np.asarray(matrices)
    coordinates = {name: np.arange(size) for name, size in zip(dims, matrices.shape, strict=False)} | labels
    return xr.DataArray(
        matrices,
        {**coordinates, "axis": AXES, "body_axis": AXES},
        (*dims, "axis", "body_axis"),
        "rotation",
        {"units": "1", "long_name": "rotation matrix", "frame": "body to global"},
    )


def spread(rng, runs, deviation):
    """Matrices (runs, 3, 3) about a rotation."""
    return (Rotation.random(rng=rng) * Rotation.from_rotvec(deviation * rng.normal(size=(runs, 3)))).as_matrix()


def about_z(*angles):
    return Rotation.from_rotvec([[0.0, 0.0, angle] for angle in angles]).as_matrix()


def angle(A, B):
    return (Rotation.from_matrix(A).inv() * Rotation.from_matrix(B)).magnitude()
