"""What is kept of a variable of a run where its course is not: over the stored times that the run reached."""

from collections.abc import Callable

import numpy as np

Statistic = Callable[[np.ndarray, np.ndarray], np.ndarray]


def _max(x: np.ndarray, times: np.ndarray) -> np.ndarray:
    largest: np.ndarray = np.fmax.reduce(x, axis=1)
    return largest


def _min(x: np.ndarray, times: np.ndarray) -> np.ndarray:
    smallest: np.ndarray = np.fmin.reduce(x, axis=1)
    return smallest


def _final(x: np.ndarray, times: np.ndarray) -> np.ndarray:
    last: np.ndarray = x[:, -1]
    return last


def _time_of_max(x: np.ndarray, times: np.ndarray) -> np.ndarray:
    known = ~np.isnan(x)
    first = np.argmax(np.where(known, x, -np.inf), axis=1)
    return np.where(known.any(axis=1), times[first], np.nan)


def _mean(x: np.ndarray, times: np.ndarray) -> np.ndarray:
    """The integral over the time by the trapezoidal rule, divided by the time."""
    known = ~np.isnan(x)
    both = known[:, 1:] & known[:, :-1]
    lengths = np.diff(times).reshape(-1, *[1] * (x.ndim - 2))
    with np.errstate(over="ignore", invalid="ignore"):
        area = np.add.reduce(np.where(both, 0.5 * lengths * (x[:, 1:] + x[:, :-1]), 0.0), axis=1)
        length = np.add.reduce(np.where(both, lengths, 0.0), axis=1)
        return np.where(length > 0.0, area / np.where(length > 0.0, length, 1.0), _max(x, times))


def _rms(x: np.ndarray, times: np.ndarray) -> np.ndarray:
    with np.errstate(over="ignore"):
        return np.sqrt(_mean(x * x, times))


# Of a variable (blocks, times, ..., W) at times (times,): (blocks, ..., W). A run that failed has NaN behind its last
# good time, of which only `final` takes notice.
STATISTICS: dict[str, Statistic] = {
    "max": _max, "min": _min, "mean": _mean, "rms": _rms, "final": _final, "time_of_max": _time_of_max,
}  # fmt: skip
MEANINGS = {
    "max": "largest", "min": "smallest", "mean": "mean over the time", "rms": "root mean square over the time",
    "final": "at the last stored time", "time_of_max": "time of the largest",
}  # fmt: skip
