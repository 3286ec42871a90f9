"""Inputs that are formulas of parameters alone."""

import numpy as np

import lienumba


def test_they_are_read_as_other_inputs_are_and_follow_what_a_sweep_varies() -> None:
    """Drag of size c on a mass of 1 kg leaves exp(-c t) of its speed."""
    system = {
        "model": {
            "bodies": [{"name": "b", "mass": 1, "inertia": [1, 1, 1], "velocity": [1, 0, 0]}],
            "forces": [{"name": "air", "type": "drag", "body": "b", "linear": "inputs.wind"}],
        },
        "parameters": {"k": 2.0},
        "inputs": {"wind": "0.5 + k"},
        "integrator": {"end_time": 0.1, "step": 0.01},
        "sweep": {"runs": 3, "seed": 1, "vary": {"parameters.k": {"distribution": "normal", "std": 0.1}}},
    }
    ds = lienumba.run(system)
    expected = np.exp(-0.1 * (0.5 + ds["parameters.k"].values))
    np.testing.assert_allclose(ds.velocity.values[:, -1, 0, 0], expected, rtol=1e-9)
