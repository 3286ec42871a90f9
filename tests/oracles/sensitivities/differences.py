"""Derivatives of runs as lienumba gives them, and as differences of its runs and of formulas give them."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import mpmath
import numpy as np

import lienumba

PLACES = (-3, -2, -1, 1, 2, 3)  # of a difference of sixth order, in steps,
WEIGHTS = np.array([-1, 9, -45, 45, -9, 1]) / 60  # and its weights
STEP = 1e-3  # of an input, relative to it or to 1
Data = dict[str, Any]


def derivatives(data: Data, of: Sequence[str], at: Mapping[str, float], **options: Any) -> Any:
    """One run with its inputs at these numbers, and its derivatives by them."""
    columns = {path: [float(x)] for path, x in at.items()}
    asked = {"of": list(of), "by": list(at)}
    keys = {"sweep": {"sampler": "table", "table": {"columns": columns}}, "sensitivities": asked}
    return lienumba.run(data | keys, workers=1, progress=False, **options).isel(run=0)


def differences(data: Data, of: Sequence[str], at: Mapping[str, float], step: float = STEP) -> dict[str, np.ndarray]:
    """The same derivatives as differences of the results of runs; the last axis is that of the inputs."""
    steps = [step * (abs(x) or 1.0) for x in at.values()]
    rows = [{**at, path: at[path] + n * h} for path, h in zip(at, steps, strict=True) for n in PLACES]
    columns = {path: [float(row[path]) for row in rows] for path in at}
    sweep = {"sampler": "table", "table": {"columns": columns}}
    ds = lienumba.run(data | {"sweep": sweep}, workers=1, progress=False)
    assert (ds.status == 0).all()
    found = {}
    for name in of:
        values = ds[name].values.reshape(len(at), len(PLACES), *ds[name].shape[1:])
        found[name] = np.moveaxis(np.einsum("k,ik...->i...", WEIGHTS, values), 0, -1) / np.array(steps)
    return found


def of_formula(f: Callable[..., Any], *at: float) -> list[float]:
    """The derivatives of a formula in mpmath by each of its arguments."""
    with mpmath.workdps(40):
        return [
            float(mpmath.diff(f, tuple(map(mpmath.mpf, at)), tuple(int(k == n) for k in range(len(at)))))
            for n in range(len(at))
        ]


def apart(found: Any, expected: Any) -> float:
    """The largest difference relative to the largest number."""
    found, expected = np.asarray(found), np.asarray(expected)
    return float(np.abs(found - expected).max() / np.abs(expected).max())
