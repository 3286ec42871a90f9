"""Errors as fractions of what is allowed, and what the controller makes of them, by their formulas."""

from typing import Any

import pytest

from lienumba.integrators.methods import step_control
from lienumba.integrators.methods.step_control import Tolerance

RELATIVE, SIZE = 1e-3, 7.0
TOLERANCE = Tolerance(RELATIVE, position=0.1, rotation=0.2, velocity=0.3, angular_velocity=0.4, state=0.5)
ABSOLUTE = TOLERANCE.numbers[1:5]
ERROR = (3e-4, 0.0, 4e-4)  # of length 5e-4
KINDS = {0: slice(0, 3), 1: slice(3, 6), 2: slice(6, 9), 3: slice(9, 12)}
STATES = {0: slice(0, 3), 2: slice(12, 15), 3: slice(15, 18)}  # rotations have no size


def vector(length: int, place: slice, numbers: tuple[float, ...]) -> tuple[float, ...]:
    found = [0.0] * length
    found[place] = numbers
    return tuple(found)


@pytest.mark.parametrize("kind", KINDS)
def test_the_relative_tolerance_counts_from_the_larger_size_before_and_after(kind: int) -> None:
    small, large = (vector(18, STATES[kind], x) if kind in STATES else (0.0,) * 18 for x in ((1, 2, 2), (2, 3, 6)))
    allowed = ABSOLUTE[kind] + (RELATIVE * SIZE if kind in STATES else 0.0)
    estimates = [vector(12, KINDS[kind], ERROR)]
    for x, y in ((small, large), (large, small)):
        square: Any = step_control.error_square(estimates, x, y, TOLERANCE.numbers)
        assert square == pytest.approx((5e-4 / allowed) ** 2)


def test_of_states_and_of_the_work() -> None:
    state = step_control.state_error_square((2e-3,), -7.0, 4.0, TOLERANCE.numbers)
    assert state == pytest.approx((2e-3 / (0.5 + RELATIVE * 7.0)) ** 2)
    work = step_control.work_error_square((2e-3,), -7.0, 4.0, 50.0, TOLERANCE.numbers)
    assert work == pytest.approx((2e-3 / (0.5 + RELATIVE * (100.0 + 7.0))) ** 2)


def test_two_estimates_are_joined_as_by_hairer() -> None:
    fifth, third = 0.3**2, 0.8**2
    assert step_control.joined((fifth, third)) == pytest.approx((fifth / (fifth + 0.01 * third) ** 0.5) ** 2)


@pytest.mark.parametrize("order", [3, 5, 8])
def test_the_next_step_is_that_of_a_proportional_and_integral_controller(order: int) -> None:
    """Gustafsson's, of an error r behind one of r': 0.9 r^(-0.7/order) r'^(0.4/order); 0.9 r^(-1/order) if refused."""
    first, memory = step_control.factor(0.5**2, 0.0, order)
    assert first == pytest.approx(0.9 * 0.5 ** (-0.7 / order))
    second, _ = step_control.factor(0.8**2, memory, order)
    assert second == pytest.approx(0.9 * 0.8 ** (-0.7 / order) * 0.5 ** (0.4 / order))
    assert step_control.factor(1.5**2, 0.0, order)[0] == pytest.approx(0.9 * 1.5 ** (-1 / order))
    assert [step_control.factor(x, 0.0, order)[0] for x in (1e-30, 1e30)] == [step_control.MOST, step_control.LEAST]
