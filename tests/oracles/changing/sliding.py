"""A body that slides and turns on three feet on a level floor, with Coulomb's friction: each foot slides or sticks, and
changes are events of SciPy's DOP853. Equilibrium shares the weight among three feet. Nothing is taken from lienumba."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp

Array = np.ndarray
Event = Callable[[float, Array], float]
REST = 1e-9  # m/s, rad/s: what is slower has come to rest


@dataclass(frozen=True)
class Tripod:
    """mass (kg), inertia about the vertical, a principal axis (kg m2), height of the mass centre (m), feet beside it
    (3, 2) (m), friction."""

    mass: float
    inertia: float
    height: float
    feet: Array
    friction: float
    g: float = 9.81

    def arms(self, y: Array) -> Array:
        c, s = np.cos(y[2]), np.sin(y[2])
        return np.asarray(self.feet @ np.array([[c, s], [-s, c]]))

    def speeds(self, y: Array) -> Array:
        """Of the feet (3, 2)."""
        p = self.arms(y)
        return np.stack([y[3] - y[5] * p[:, 1], y[4] + y[5] * p[:, 0]], axis=1)

    def forces(self, y: Array, stuck: int | None) -> tuple[Array, Array]:
        """Accelerations (x, y, turn), and forces on the feet (3, 3): equilibrium of the moments about both level axes,
        friction of what slides, no acceleration of what sticks."""
        p, v = self.arms(y), self.speeds(y)
        A, b = np.zeros((12, 12)), np.zeros(12)  # of ax, ay, turn, and Fx, Fy, N of each foot
        A[0, 0] = A[1, 1] = self.mass
        A[2, 2], b[3] = self.inertia, self.mass * self.g
        for i in range(3):
            x, at, n = 3 + 3 * i, 6 + 2 * i, 5 + 3 * i
            A[0, x] = A[1, x + 1] = -1.0
            A[2, x], A[2, x + 1] = p[i, 1], -p[i, 0]
            A[3, n] = 1.0
            A[4, n], A[4, x + 1] = p[i, 1], self.height
            A[5, n], A[5, x] = p[i, 0], self.height
            if i == stuck:
                A[at, 0], A[at, 2], b[at] = 1.0, -p[i, 1], y[5] ** 2 * p[i, 0]
                A[at + 1, 1], A[at + 1, 2], b[at + 1] = 1.0, p[i, 0], y[5] ** 2 * p[i, 1]
            else:
                A[at : at + 2, x : x + 2] = np.eye(2)
                A[at : at + 2, n] = self.friction * v[i] / np.linalg.norm(v[i])
        solved = np.linalg.solve(A, b)
        return solved[:3], solved[3:].reshape(3, 3)

    def come_to_rest(self, v: tuple[float, float], w: float) -> tuple[float, int, float, Array]:
        """From the origin with these velocities: when which foot sticks, when all rests, where that is (x, y, turn)."""
        t, y, foot = self._slide(0.0, np.array([0.0, 0.0, 0.0, *v, w]))
        p, sticks = self.arms(y)[foot], t
        y[3:5] = y[5] * np.array([p[1], -p[0]])
        if self._reserve(y, foot) < 0.0:
            raise ArithmeticError("a foot that comes to rest slides on")
        t, y = self._turn(t, y, foot)
        return sticks, foot, t, y[:3]

    def _slide(self, t: float, y: Array) -> tuple[float, Array, int]:
        """On all feet, until one has come to rest; which one."""
        return self._go_on(t, y, None, [lambda t, y, i=i: REST - np.hypot(*self.speeds(y)[i]) for i in range(3)])  # type: ignore[misc]

    def _turn(self, t: float, y: Array, foot: int) -> tuple[float, Array]:
        """About a foot that sticks, until all rests."""
        return self._go_on(t, y, foot, [lambda t, y: REST - abs(float(y[5]))])[:2]

    def _go_on(self, t: float, y: Array, stuck: int | None, events: list[Event]) -> tuple[float, Array, int]:
        """Until one of the events comes from below to 0; which one."""
        events = [*events, lambda t, y: -self._reserve(y, stuck)]
        for event in events:
            event.terminal, event.direction = True, 1  # type: ignore[attr-defined]

        def slope(t: float, y: Array) -> Array:
            return np.concatenate([y[3:], self.forces(y, stuck)[0]])

        run = solve_ivp(slope, (t, 100.0), y, method="DOP853", rtol=1e-12, atol=1e-14, events=events)
        found = next(n for n, times in enumerate(run.t_events) if len(times))
        if found == len(events) - 1:
            raise ArithmeticError("a foot lifts off, or slides again")
        return float(run.t[-1]), run.y[:, -1], found

    def _reserve(self, y: Array, stuck: int | None) -> float:
        """The least weight on a foot, or, if less, the friction that what sticks might have besides (N)."""
        F = self.forces(y, stuck)[1]
        least = float(F[:, 2].min())
        return least if stuck is None else min(least, float(self.friction * F[stuck, 2] - np.hypot(*F[stuck, :2])))
