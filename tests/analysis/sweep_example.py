"""Datasets of sweeps whose outputs are known functions of their inputs."""

import numpy as np
from scipy.stats import qmc

from lienumba.scenario.base import toml
from lienumba.store.layout import RUN, SERIES, VARIABLES, Variable, dataset

TIMES = (0.0, 0.5, 1.0)
VECTOR = (*SERIES, "axis")


def sweep(samples, status=0, labels=None, vary=None, units=None, title="Made up", specs=None, times=TIMES, **arrays):
    """samples, arrays: of each input and variable; arrays that no dataset has otherwise are quantities of the scenario:
    (runs,), (runs, times) or (runs, times, axes). vary: the table of [sweep], or its sampler."""
    runs = len(next(iter(samples.values())))
    labels = np.arange(runs) if labels is None else labels
    shapes = {1: RUN, 2: SERIES, 3: VECTOR}
    own = {name: Variable(shapes[np.ndim(x)], "m", name) for name, x in arrays.items() if np.ndim(x) in shapes}
    own = {name: spec for name, spec in own.items() if name not in VARIABLES}
    table = {"sampler": "random", "runs": runs} | ({"sampler": vary} if isinstance(vary, str) else vary or {})
    table.setdefault("vary", {path: {"distribution": "normal", "std": 1.0} for path in samples})
    arrays = {"status": np.broadcast_to(status, runs).astype(np.int8), **arrays}
    return dataset(
        variables=arrays,
        times=times,
        runs=labels,
        bodies=("arm", "top"),
        joints=(),
        constraints=(),
        events=("far",),
        inputs=samples,
        input_units=dict.fromkeys(samples, "kg") | (units or {}),
        own=own | (specs or {}),
        attributes={"title": title, "scenario": toml.dumps({"sweep": table}), "scenario_sha256": "ab12"},
    )


def saltelli(rows, distributions, seed=0):
    """Samples (runs, d) of ppfs, row by row: A, B, and A with each input from B."""
    d = len(distributions)
    u = qmc.Sobol(2 * d, rng=seed).random(rows)
    A, B = (np.stack([f(x) for f, x in zip(distributions, u.T[k : k + d], strict=True)], axis=1) for k in (0, d))
    mixed = [np.where(np.arange(d) == k, B, A) for k in range(d)]
    return np.stack([A, B, *mixed], axis=1).reshape(-1, d)


def named(x):
    """Columns (runs, d) as the inputs a, b, c ..."""
    return dict(zip("abcdefgh", x.T, strict=False))
