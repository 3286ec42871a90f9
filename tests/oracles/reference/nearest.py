"""The projection of positions as the paper prints it, (21) and (22), by a solver that knows nothing of ours."""

from typing import Any

import numpy as np
from scipy.optimize import root

from tests.oracles.reference import naive


def nearest(joints: Any, r: np.ndarray, R: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """min |r' - r|^2 + |R' - R|_F^2 subject to Phi = 0, R' R'^T = I, on twelve numbers per body.

    Newton on the Lagrange conditions. The constraints are quadratic, so that central differences are exact.
    """
    k, lower = len(r), np.tril_indices(3)
    hat = np.concatenate([r.ravel(), R.ravel()])

    def split(y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return y[: 3 * k].reshape(k, 3), y[3 * k :].reshape(k, 3, 3)

    def g(y: np.ndarray) -> np.ndarray:
        r, R = split(y)
        return np.concatenate([naive.residual(joints, r, R), *((Ri @ Ri.T - np.eye(3))[lower] for Ri in R)])

    def jacobian(y: np.ndarray) -> np.ndarray:
        return np.array([g(y + e) - g(y - e) for e in np.eye(len(y))]).T / 2

    def conditions(z: np.ndarray) -> np.ndarray:
        y, mu = z[: len(hat)], z[len(hat) :]
        return np.concatenate([2 * (y - hat) + jacobian(y).T @ mu, g(y)])

    solution = root(conditions, np.concatenate([hat, np.zeros(len(g(hat)))]), tol=1e-13)
    assert np.abs(conditions(solution.x)).max() < 1e-12
    return split(solution.x[: len(hat)])
