"""Datasets of studies whose every number is known."""

import numpy as np

from lienumba.store.study_layout import Coordinate, dataset

STEPS = (0.08, 0.04, 0.02, 0.01)
METHODS = ("first", "second")
METHOD = Coordinate("method", "method", METHODS, "1", "integrator.method")
STEP = Coordinate("step", "step", STEPS, "s", "integrator.step")


def study(errors, grid=(METHOD, STEP), steps=STEPS, floor=0.0, status=0, end=0.8):
    """errors (runs, points of each dimension): of positions; the same, tenfold, of velocities."""
    errors = np.asarray(errors, float)
    runs, shape = len(errors), errors.shape
    counts = np.broadcast_to(np.round(end / np.asarray(steps)), shape)
    arrays = {
        "position_error": errors,
        "velocity_error": 10 * errors,
        "reference_position_error": np.broadcast_to(floor, shape),
        "reference_velocity_error": np.broadcast_to(floor, shape),
        "status": np.broadcast_to(status, shape),
        "end_time": np.full(shape, end),
        "steps": counts,
        "rejected_steps": 0 * counts,
        "evaluations": 4 * counts,
        "time_per_run": 1e-6 * counts[0],
        "time_per_run_spread": 1e-7 * counts[0],
    }
    title = {"title": "made up", "scenario_sha256": "ab12"}
    return dataset(arrays, range(runs), grid, {}, {}, title)
