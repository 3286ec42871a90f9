"""The heavy top in plain NumPy: RKMK4, the KKT matrix filled and handed to `np.linalg.solve`.

Every array has a leading axis of runs, so the same lines serve one run at a time (what most people write) and all
runs at once (the best that NumPy can do).
"""

import numpy as np


def hat(u: np.ndarray) -> np.ndarray:
    """(runs, 3) -> (runs, 3, 3) with hat(u) a = u x a."""
    x, y, z = u.T
    zero = np.zeros_like(x)
    return np.array([[zero, -z, y], [z, zero, -x], [-y, x, zero]]).transpose(2, 0, 1)


def exp(u: np.ndarray) -> np.ndarray:
    """Rodrigues' formula, (runs, 3) -> (runs, 3, 3)."""
    angle = np.sqrt(np.sum(u * u, axis=1))
    a = np.sinc(angle / np.pi)
    b = 0.5 * np.sinc(angle / (2.0 * np.pi)) ** 2
    U = hat(u)
    return np.eye(3) + a[:, None, None] * U + b[:, None, None] * (U @ U)


class Top:
    """masses (runs,), inertia (3, 3) about the mass centre, gravity (3,), the pivot in the body's frame (3,)."""

    def __init__(self, masses: np.ndarray, inertia: np.ndarray, gravity: np.ndarray, point: np.ndarray) -> None:
        self.inertia, self.point = inertia, point
        self.hat_point = hat(point[None])[0]
        self.K = np.zeros((len(masses), 9, 9))
        self.K[:, :3, :3] = masses[:, None, None] * np.eye(3)
        self.K[:, 3:6, 3:6] = inertia
        self.K[:, 6:, :3] = self.K[:, :3, 6:] = np.eye(3)
        self.weight = masses[:, None] * gravity

    def slope(self, x: tuple[np.ndarray, ...], u: np.ndarray) -> np.ndarray:
        """dexpinv_{-u}(F(x exp(u))), truncated at order 2; u (runs, 12)."""
        _, R, v, w = moved(x, u)
        self.K[:, 6:, 3:6] = -R @ self.hat_point
        self.K[:, 3:6, 6:] = self.K[:, 6:, 3:6].transpose(0, 2, 1)
        torque = np.cross(w @ self.inertia, w)
        bias = R @ np.cross(w, np.cross(w, self.point))[:, :, None]
        b = np.concatenate([self.weight, torque, -bias[:, :, 0]], axis=1)
        a = np.linalg.solve(self.K, b[:, :, None])[:, :6, 0]
        first = np.cross(u[:, 3:6], w)
        turning = w + 0.5 * first + np.cross(u[:, 3:6], first) / 12.0
        return np.concatenate([v, turning, a], axis=1)

    def step(self, x: tuple[np.ndarray, ...], h: float) -> tuple[np.ndarray, ...]:
        f1 = self.slope(x, np.zeros((len(self.K), 12)))
        f2 = self.slope(x, 0.5 * h * f1)
        f3 = self.slope(x, 0.5 * h * f2)
        f4 = self.slope(x, h * f3)
        return moved(x, h / 6.0 * (f1 + 2.0 * f2 + 2.0 * f3 + f4))

    def integrate(self, states: np.ndarray, h: float, steps: int, every: int) -> np.ndarray:
        """Records (runs, steps // every, 18) from states (runs, 18)."""
        runs = len(states)
        x = (states[:, :3], states[:, 3:12].reshape(runs, 3, 3), states[:, 12:15], states[:, 15:18])
        records = np.empty((runs, steps // every, 18))
        for n in range(1, steps + 1):
            x = self.step(x, h)
            if n % every == 0:
                records[:, n // every - 1] = np.concatenate([x[0], x[1].reshape(runs, 9), x[2], x[3]], axis=1)
        return records


def moved(x: tuple[np.ndarray, ...], u: np.ndarray) -> tuple[np.ndarray, ...]:
    """x exp(u); x: r, R, v, w."""
    r, R, v, w = x
    return r + u[:, 0:3], R @ exp(u[:, 3:6]), v + u[:, 6:9], w + u[:, 9:12]
