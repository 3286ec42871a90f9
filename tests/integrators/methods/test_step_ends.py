"""What the ends of a step say, against what is in it."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from lienumba.integrators.methods.step_ends import ALIKE, Ends, Known, Past, added, matters
from lienumba.mechanics.mechanism.model import COUNT, LARGEST, LAST, SMALLEST

RUNS, WITHIN = 4000, 400
UNKNOWN = Past((np.zeros(RUNS), np.zeros(RUNS)), (np.ones(RUNS), np.zeros(RUNS), np.zeros(RUNS)))


def waves() -> tuple[np.ndarray, Ends]:
    """Oscillations of up to four fifths of a period in a step, or over a line of up to a third: all values in each
    step, and what its ends say."""
    rng = np.random.default_rng(1)
    phase, turn, size, slope = (rng.uniform(*x, (RUNS, 1)) for x in ((0, 6.3), (0.01, 5.0), (0.1, 3), (-3, 3)))
    slope[turn > 2.1] = 0.0
    x = np.linspace(0.0, 1.0, WITHIN)
    values = size * np.sin(phase + turn * x) + slope * x
    rates = tuple((size * turn * np.cos(phase + turn * at) + slope)[:, 0] for at in (0.0, 1.0))
    return values, Ends(values[:, 0], values[:, -1], UNKNOWN, rates)


def steady_waves() -> tuple[np.ndarray, Ends]:
    """Of up to a third of a period, over any line, where nothing is known but what was at the ends of three steps that
    are about as long."""
    rng = np.random.default_rng(3)
    phase, turn, size, slope = (rng.uniform(*x, (RUNS, 1)) for x in ((0, 6.3), (0.01, 2.1), (0.1, 3), (-4, 4)))
    last, first = (rng.uniform(1.0 / ALIKE, ALIKE, RUNS) for _ in range(2))
    first = np.clip(first, last / ALIKE, last * ALIKE)

    def at(x: np.ndarray) -> np.ndarray:
        return size * np.sin(phase + turn * x) + slope * turn * x

    values = at(np.linspace(0.0, 1.0, WITHIN))
    before, earlier = (at(-x[:, None])[:, 0] for x in (last, last + first))
    past = Past((values[:, 0] - before, before - earlier), (np.ones(RUNS), last, first))
    return values, Ends(values[:, 0], values[:, -1], past, smooth=True)


@pytest.mark.parametrize("waves", [waves, steady_waves])
def test_no_turn_is_missed(waves: Callable[[], tuple[np.ndarray, Ends]]) -> None:
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
    known = Known(before, np.zeros(RUNS), np.ones(RUNS), np.zeros(RUNS), np.zeros(RUNS))
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
    undefined = Ends(ends.before, np.full(RUNS, np.nan), ends.past, ends.rates)
    assert (matters(kind, known, undefined, None, None) == 1.0).all()
    unseen = Ends(ends.before, ends.after, ends.past, (np.full(RUNS, np.nan), ends.rates[1]))
    assert (matters(kind, known, unseen, None, None) == 1.0).all()


def test_what_has_kinks_or_no_past_is_looked_into() -> None:
    """Also where steps have become twice as long, and where a signal has turned back."""
    _, ends = steady_waves()
    turns = ends.if_it_turns(1.0, 0.0)
    assert 0.2 < (turns == 0.0).mean() < 0.8
    assert replace(ends, smooth=False).if_it_turns(1.0, 0.0) == 1.0
    for other in (
        replace(ends, past=replace(ends.past, lengths=(2.0 * ends.past.lengths[0], *ends.past.lengths[1:]))),
        replace(ends, past=replace(ends.past, lengths=UNKNOWN.lengths)),
        replace(ends, past=replace(ends.past, changes=(-ends.past.changes[0], ends.past.changes[1]))),
        replace(ends, after=np.full(RUNS, np.nan)),
    ):
        assert (other.if_it_turns(1.0, 0.0)[turns == 0.0] == 1.0).all()


def noise(scale: float) -> Ends:
    """What is left of a signal that was 4 at most, at rest: signs and rates are those of rounding."""
    rng = np.random.default_rng(5)
    before, after, begin, end = scale * rng.standard_normal((4, RUNS))
    return Ends(before, after, UNKNOWN, (begin, end), size=np.full(RUNS, 4.0))


@pytest.mark.parametrize("kind", [LARGEST, SMALLEST, COUNT, LAST])
@pytest.mark.parametrize("held", [0.0, 1e-16])
def test_what_is_left_by_rounding_is_not_looked_into(kind: str, held: float) -> None:
    """Where a condition held it goes on, and where it did not it does not begin; a bend that is rounding bends nothing.
    What is above that by as much as counts is looked into."""
    known = Known(np.full(RUNS, 1e-3), np.ones(RUNS), np.full(RUNS, held), np.zeros(RUNS), np.full(RUNS, 4.0))
    low = known._replace(value=np.full(RUNS, -1e-3)) if kind == SMALLEST else known
    faint = noise(1e-16)
    value = faint if kind in (LARGEST, SMALLEST) else None
    assert (matters(kind, low, value, faint, None, [faint], [faint]) == 0.0).all()
    assert (faint.if_it_crosses(1.0, 0.0) == 0.0).all()
    seen = noise(1e-10 if held == 0.0 else 1e-7)
    assert (matters(kind, low, None if value is None else seen, seen, None) == 1.0).mean() > 0.3
    assert (seen.if_it_crosses(1.0, 0.0) == 1.0).mean() > 0.3


def test_an_extreme_that_is_higher_by_rounding_is_not_looked_for() -> None:
    faint = noise(1e-16)
    known = Known(np.zeros(RUNS), np.zeros(RUNS), np.ones(RUNS), np.zeros(RUNS), np.zeros(RUNS))
    assert (matters(LARGEST, known, faint, None, None) == 0.0).all()
    assert (matters(LARGEST, known, replace(faint, size=0.0), None, None) == 1.0).mean() > 0.3
