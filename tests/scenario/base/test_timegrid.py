"""Times are exact decimals on the grid of the step."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lienumba.scenario.base import timegrid


def test_times_are_the_decimals_one_would_type() -> None:
    times = timegrid.stored_times(2.0, 0.01)
    assert times == [float(f"{k // 100}.{k % 100:02d}") for k in range(201)]
    assert times[57] == 0.57


@given(st.integers(1, 10**6), st.integers(-9, 0), st.integers(1, 5000))
def test_times_are_nearest_to_their_decimals(mantissa: int, exponent: int, number: int) -> None:
    every = float(f"{mantissa}e{exponent}")
    end = float(f"{mantissa * number}e{exponent}")
    assert timegrid.count(end, every) == number
    assert timegrid.stored_times(end, every)[-1] == end


@pytest.mark.parametrize(
    ("duration", "step", "number"),
    [(1.0, 0.1, 10), (0.3, 0.1, 3), (1.0, 1 / 3, 3), (1.0, 0.3, None), (0.0, 0.1, 0), (1e-12, 0.1, None)],
)
def test_count(duration: float, step: float, number: int | None) -> None:
    assert timegrid.count(duration, step) == number


@given(st.integers(1, 10**9), st.sampled_from([1e-3, 1e-4, 0.02, 0.25]))
def test_default_interval_divides_the_run(steps: int, step: float) -> None:
    end = steps * step
    if timegrid.count(end, step) != steps:
        return
    every = timegrid.default_interval(end, [step])
    intervals = timegrid.count(end, every)
    assert intervals is not None
    assert intervals <= timegrid.MOST_INTERVALS
    assert timegrid.count(every, step) is not None


@given(st.integers(1, 10**5), st.integers(1, 10**5), st.integers(1, 10**6))
def test_the_proposed_step_fits(a: int, b: int, c: int) -> None:
    durations, step = [a / 1000, b / 1000], c / 10**6
    proposed = float(f"{timegrid.nearest_divisor(durations, step):.12g}")
    assert all(timegrid.count(duration, proposed) for duration in durations)


@given(st.integers(1, 10**6), st.integers(1, 10**6))
def test_the_proposed_duration_fits(a: int, b: int) -> None:
    duration, step = a / 1000, b / 10**6
    assert timegrid.count(float(f"{timegrid.nearest_multiple(duration, step):.12g}"), step)


@pytest.mark.parametrize("k", range(1, 60))
@pytest.mark.parametrize("parts", [3, 7, 10])
def test_no_stored_time_lies_behind_the_end(k: int, parts: int) -> None:
    """Numbers from scripts do not divide to the last bit; what is stored behind the end was NaN."""
    end = 0.3 * math.sqrt(k)
    times = timegrid.stored_times(end, end / parts)
    assert len(times) == parts + 1
    assert times[-1] <= end
    assert times[-1] == pytest.approx(end, rel=1e-9)
