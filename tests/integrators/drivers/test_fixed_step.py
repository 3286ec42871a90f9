"""Steps of one length: lanes that fail beside lanes that go on."""

import numpy as np

import lienumba
from lienumba.batch import statuses


def test_a_run_that_fails_stops_at_its_last_good_state() -> None:
    """Of a mass under a force that ends as a logarithm, in each run at another time; Euler's sums."""
    body = {"name": "mass", "mass": 2.0, "inertia": [1.0] * 3, "position": [0, 0, 0], "rotation": [1, 0, 0, 0]}
    h, steps = 2.0**-6, 32
    data = {
        "parameters": {"late": 1.0},
        "model": {
            "gravity": [0, 0, 0],
            "bodies": [body],
            "forces": [{"type": "force", "body": "mass", "value": ["log(late - t)", 0, 0]}],
        },
        "integrator": {"method": "euler", "step": h, "end_time": steps * h},
        "output": {"mode": "summary", "every": steps * h},
        "sweep": {"runs": 20, "vary": {"parameters.late": {"distribution": "uniform", "low": 0.1, "high": 1.0}}},
    }
    ds = lienumba.run(data, workers=1)
    late = ds["parameters.late"].values
    good = np.minimum(np.ceil(late / h), steps)  # F is asked for at the start of each step
    assert (ds.end_time.values == good * h).all()
    assert (ds.status.values == np.where(good < steps, statuses.NON_FINITE, statuses.SUCCESS)).all()
    assert 3 < (good < steps).sum() < 17
    for speed, end, n in zip(ds.last_velocity.values[:, 0, 0], late, good, strict=True):
        np.testing.assert_allclose(speed, h / 2.0 * np.log(end - h * np.arange(n)).sum(), rtol=1e-12)
