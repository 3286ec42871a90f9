"""The car axis of the Test Set for IVP Solvers in minimal coordinates, by extrapolation in extended precision: its
printed speeds differ from both from the tenth digit on."""

import numpy as np
import numpy.typing as npt
import pytest

import lienumba
from tests.rigs.places import SCENARIOS

Array = npt.NDArray[np.longdouble]
REAL = np.longdouble
MASS, STIFFNESS, GRAVITY, FREE = REAL(5), REAL(10_000), REAL(1), REAL(1) / 2
END, STEPS, ROWS = REAL(3), 400, 9


def axes(t: np.longdouble) -> tuple[Array, Array, np.longdouble, np.longdouble]:
    """Along the axle and across it, and the rate and acceleration of its angle; it is 1 m long."""
    u, rate, acceleration = np.sin(10 * t) / 10, np.cos(10 * t), -10 * np.sin(10 * t)
    c = np.sqrt(1 - u * u)
    return np.array([c, u]), np.array([-u, c]), rate / c, acceleration / c + u * rate**2 / c**3


def rates(t: np.longdouble, y: Array) -> Array:
    """y: how far the left mass is from the axle, the angle of the rod to the right one, and their rates."""
    s, angle, s_rate, turning = y
    along, across, w, w_rate = axes(t)
    rod, normal = np.array([np.cos(angle), np.sin(angle)]), np.array([-np.sin(angle), np.cos(angle)])
    spring = s * across + rod - along
    length = np.sqrt(spring @ spring)
    weight = np.array([REAL(0), -MASS * GRAVITY])
    left = STIFFNESS * (FREE - s) * across + weight
    right = STIFFNESS * (FREE - length) * spring / length + weight
    known = -2 * s_rate * w * along - s * w_rate * along - s * w * w * across
    rest = known - turning**2 * rod
    mixed = MASS * (across @ normal)
    a = across @ (left + right - MASS * (known + rest))
    b = normal @ (right - MASS * rest)
    determinant = 2 * MASS * MASS - mixed**2
    return np.array([s_rate, turning, (a * MASS - mixed * b) / determinant, (2 * MASS * b - mixed * a) / determinant])


def step(t: np.longdouble, y: Array, h: np.longdouble) -> Array:
    """Gragg's method with 2, 4, 6, ... midpoint steps, extrapolated to order 2 ROWS."""
    table: list[list[Array]] = []
    for row in range(ROWS):
        count = 2 * (row + 1)
        small, before, now = h / count, y, y + h / count * rates(t, y)
        for n in range(1, count):
            before, now = now, before + 2 * small * rates(t + n * small, now)
        found = [(before + now + small * rates(t + h, now)) / 2]
        for column in range(1, row + 1):
            ratio = (REAL(count) / (2 * (row + 1 - column))) ** 2
            found.append(found[-1] + (found[-1] - table[-1][column - 1]) / (ratio - 1))
        table.append(found)
    return table[-1][-1]


@pytest.mark.release
def test_extended_precision_agrees_to_thirteen_digits() -> None:
    h, y = END / STEPS, np.array([FREE, REAL(0), REAL(0), REAL(0)])
    for n in range(STEPS):
        y = step(h * n, y, h)
    s, angle, s_rate, turning = y
    along, across, w, _ = axes(END)
    left, left_speed = s * across, s_rate * across - s * w * along
    right = left + np.array([np.cos(angle), np.sin(angle)])
    right_speed = left_speed + turning * np.array([-np.sin(angle), np.cos(angle)])
    ds = lienumba.run(SCENARIOS / "published" / "car_axis.toml").isel(run=0, time=-1)
    for name, exact in {"left": left, "right": right, "left_speed": left_speed, "right_speed": right_speed}.items():
        np.testing.assert_allclose(ds[name].values[:2], exact.astype(float), rtol=0, atol=2e-13)
