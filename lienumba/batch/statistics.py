"""What is kept of a variable of a run where its course is not: over the stored times that the run reached, and where an
event ended it."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np


@dataclass(frozen=True)
class Course:
    """A variable (blocks, times, ..., W) at the stored times (times,), NaN behind the end of a run.

    at_end (blocks, ..., W): where an event ended a run before the last of these times; end_times (blocks, W): when (s),
    NaN of other runs; None where there are only those."""

    values: np.ndarray
    times: np.ndarray
    at_end: np.ndarray | None = None
    end_times: np.ndarray | None = None

    @property
    def ends(self) -> np.ndarray:
        """end_times for arrays (blocks, ..., W)."""
        assert self.end_times is not None
        blocks, *shape, width = self.values[:, 0].shape
        return self.end_times.reshape(blocks, *[1] * len(shape), width)

    @property
    def last(self) -> tuple[np.ndarray, np.ndarray]:
        """At the last stored time at which it is known (blocks, ..., W), and that time (s); NaN where there is none."""
        known = ~np.isnan(self.values)
        index = self.values.shape[1] - 1 - np.argmax(known[:, ::-1], axis=1)
        value = np.take_along_axis(self.values, index[:, None], axis=1)[:, 0]
        return value, np.where(known.any(axis=1), self.times[index], np.nan)

    @property
    def largest(self) -> np.ndarray:
        """The largest absolute value (blocks, ..., W)."""
        return self._of(np.abs).extreme(np.fmax)

    def part(self, n: int) -> "Course":
        """One component of vectors."""
        return replace(self, values=self.values[:, :, n], at_end=None if self.at_end is None else self.at_end[:, n])

    def squared(self) -> "Course":
        with np.errstate(over="ignore"):
            return self._of(np.square)

    def extreme(self, pick: np.ufunc) -> np.ndarray:
        """What fmax or fmin picks (blocks, ..., W)."""
        found: np.ndarray = pick.reduce(self.values, axis=1)
        if self.at_end is not None:
            found = np.where(np.isnan(self.ends), found, pick(found, self.at_end))
        return found

    def _of(self, function: np.ufunc) -> "Course":
        return replace(
            self, values=function(self.values), at_end=None if self.at_end is None else function(self.at_end)
        )


LEAST_EXCHANGE = 1e-3  # of the largest kinetic energy: what spins freely exchanges none
ROUNDOFF = 1e-9  # of the potential energy: the least scale, for what rests and has no kinetic energy


def energy_scale(kinetic: Course, potential: Course) -> np.ndarray:
    """With which an energy residual compares (J) (blocks, W): the range of the kinetic energy."""
    largest = kinetic.extreme(np.fmax)
    least = np.fmax(LEAST_EXCHANGE * largest, ROUNDOFF * np.fmax.reduce(abs(potential.values[:, [0, -1]]), axis=1))
    scale: np.ndarray = np.fmax(largest - kinetic.extreme(np.fmin), least)
    return scale


Statistic = Callable[[Course], np.ndarray]


def _max(course: Course) -> np.ndarray:
    return course.extreme(np.fmax)


def _min(course: Course) -> np.ndarray:
    return course.extreme(np.fmin)


def _final(course: Course) -> np.ndarray:
    last: np.ndarray = course.values[:, -1]
    return last if course.at_end is None else np.where(np.isnan(course.ends), last, course.at_end)


def _time_of_max(course: Course) -> np.ndarray:
    x = course.values
    known = ~np.isnan(x)
    first = np.argmax(np.where(known, x, -np.inf), axis=1)
    found = np.where(known.any(axis=1), course.times[first], np.nan)
    if course.at_end is None:
        return found
    later = ~np.isnan(course.ends + course.at_end) & ~(np.fmax.reduce(x, axis=1) >= course.at_end)
    return np.where(later, course.ends, found)


def _mean(course: Course) -> np.ndarray:
    """The integral over the time by the trapezoidal rule, divided by the time."""
    x = course.values
    known = ~np.isnan(x)
    both = known[:, 1:] & known[:, :-1]
    lengths = np.diff(course.times).reshape(-1, *[1] * (x.ndim - 2))
    with np.errstate(over="ignore", invalid="ignore"):
        area = np.add.reduce(np.where(both, 0.5 * lengths * (x[:, 1:] + x[:, :-1]), 0.0), axis=1)
        length = np.add.reduce(np.where(both, lengths, 0.0), axis=1)
        if course.at_end is not None:
            last, since = course.last
            rest, both_ends = course.ends - since, course.at_end + last
            more = (rest > 0.0) & ~np.isnan(both_ends)
            area = np.where(more, area + 0.5 * rest * both_ends, area)
            length = np.where(more, length + rest, length)
        return np.where(length > 0.0, area / np.where(length > 0.0, length, 1.0), _max(course))


def _rms(course: Course) -> np.ndarray:
    return np.sqrt(_mean(course.squared()))


# Of a course (blocks, ..., W). A run that failed has NaN behind its last good time, of which only `final` takes notice.
STATISTICS: dict[str, Statistic] = {
    "max": _max, "min": _min, "mean": _mean, "rms": _rms, "final": _final, "time_of_max": _time_of_max,
}  # fmt: skip
MEANINGS = {
    "max": "largest", "min": "smallest", "mean": "mean over the time", "rms": "root mean square over the time",
    "final": "at the last stored time", "time_of_max": "time of the largest",
}  # fmt: skip
