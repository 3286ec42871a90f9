"""What a sweep has stored of the motion of a few runs."""

from collections.abc import Callable

import numpy as np

from lienumba.scenario.resolve import Scenario

TIMES = 9  # that are looked at
STATE = ("position", "rotation", "velocity", "angular_velocity")

Column = Callable[[str, np.ndarray], np.ndarray]  # of a variable, of runs by their labels


def course(resolved: Scenario, column: Column, labels: np.ndarray) -> tuple[list[float], np.ndarray, np.ndarray]:
    """Some times, the end among them, the states of bodies there (times, runs, 18 k), and the largest angular velocity
    (rad/s) that is stored of each run."""
    output, every = resolved.data.output, resolved.times
    if output.mode == "full" and {*STATE} <= {*output.variables}:
        some, whole = np.unique(np.linspace(0, len(every) - 1, TIMES + 1).astype(int)[1:]), column(STATE[-1], labels)
        parts = [column(name, labels)[:, some] for name in STATE]
    else:
        some = np.array([len(every) - 1])
        parts = [column(f"last_{name}", labels)[:, None] for name in STATE]
        whole = parts[-1]
    found = np.concatenate([x.reshape(*x.shape[:3], -1) for x in parts], axis=3)
    states = np.moveaxis(found.reshape(len(labels), len(some), -1), 1, 0)
    return [float(every[n]) for n in some], states, np.abs(whole).reshape(len(labels), -1).max(axis=1)
