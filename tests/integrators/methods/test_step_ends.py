"""What the ends of a step say, against what is in it."""

import numpy as np
import pytest

from lienumba.integrators.methods.step_ends import Ends, Known, added, matters
from lienumba.mechanics.mechanism.model import LARGEST, SMALLEST

RUNS, WITHIN = 4000, 400


def waves() -> tuple[np.ndarray, Ends]:
    """Oscillations of up to four fifths of a period in a step, or over a line of up to a third: all values in each
    step, and what its ends say."""
    rng = np.random.default_rng(1)
    phase, turn, size, slope = (rng.uniform(*x, (RUNS, 1)) for x in ((0, 6.3), (0.01, 5.0), (0.1, 3), (-3, 3)))
    slope[turn > 2.1] = 0.0
    x = np.linspace(0.0, 1.0, WITHIN)
    values = size * np.sin(phase + turn * x) + slope * x
    rates = tuple((size * turn * np.cos(phase + turn * at) + slope)[:, 0] for at in (0.0, 1.0))
    return values, Ends(values[:, 0], values[:, -1], np.zeros(RUNS), rates)


def test_no_turn_is_missed() -> None:
    values, ends = waves()
    steps = np.diff(values, axis=1)
    goes_one_way = (steps >= 0.0).all(axis=1) | (steps <= 0.0).all(axis=1)
    assert goes_one_way[ends.if_it_turns(1.0, 0.0) == 0.0].all()
    assert (ends.if_it_turns(1.0, 0.0) == 0.0).sum() > 0.3 * goes_one_way.sum()


@pytest.mark.parametrize(("kind", "sign"), [(LARGEST, 1.0), (SMALLEST, -1.0)])
def test_extremes_of_steps_that_are_not_looked_into(kind: str, sign: float) -> None:
    """Are those of all values in them, whatever was known before, and undefined values are looked at."""
    values, ends = waves()
    before = sign * np.maximum(sign * ends.before, np.random.default_rng(2).normal(0.0, 2.0, RUNS))
    known = Known(before, np.zeros(RUNS), np.ones(RUNS), np.zeros(RUNS))
    closed = matters(kind, known, ends, None, None) == 0.0
    found = added(kind, known, ends.after, None, None, np.where(closed, 1.0, 0.0), 0.0, 1.0)
    true = sign * np.maximum(sign * before, (sign * values).max(axis=1))
    np.testing.assert_array_equal(found.value[closed], true[closed])
    np.testing.assert_array_equal(
        found.time[closed],
        np.where(true > before, 1.0, 0.0)[closed] if sign > 0 else np.where(true < before, 1.0, 0.0)[closed],
    )
    np.testing.assert_array_equal(found.value[~closed], before[~closed])
    assert closed.mean() > 0.2
    undefined = Ends(ends.before, np.full(RUNS, np.nan), ends.changed, ends.rates)
    assert (matters(kind, known, undefined, None, None) == 1.0).all()
    unseen = Ends(ends.before, ends.after, ends.changed, (np.full(RUNS, np.nan), ends.rates[1]))
    assert (matters(kind, known, unseen, None, None) == 1.0).all()
