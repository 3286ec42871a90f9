"""A small dataset with made-up numbers, as the engine would hand them over."""

import numpy as np

from lienumba.store.layout import VARIABLES, dataset

TIMES = [float(f"{k / 100:.2f}") for k in range(101)]
INPUTS = ("bodies.top.mass", "bodies.top.angular_velocity[1]", "joints.pivot.points[1][0]", "gravity[2]")


def arrays(runs: int, times: int, bodies: int, joints: int, constraints: int, seed: int = 0) -> dict[str, np.ndarray]:
    sizes = {"run": runs, "time": times, "body": bodies, "joint": joints, "constraint": constraints}
    rng = np.random.default_rng(seed)
    result = {}
    for name, variable in VARIABLES.items():
        shape = tuple(sizes.get(dim, 3) for dim in variable.dims)
        if variable.dtype == "float64":
            result[name] = rng.standard_normal(shape)
        else:
            result[name] = rng.integers(0, 3, shape).astype(variable.dtype)
    result["status"][:] = 0
    return result


def example(runs=4, times=TIMES, bodies=("top",), joints=("pivot",), seed=0, scenario="", **replaced):
    """Three constraint equations per joint; `replaced` are arrays to put in."""
    constraints = [f"{joint}[{k}]" for joint in joints for k in range(3)]
    variables = arrays(runs, len(times), len(bodies), len(joints), len(constraints), seed) | replaced
    return dataset(
        variables=variables,
        times=times,
        runs=range(runs),
        bodies=bodies,
        joints=joints,
        constraints=constraints,
        inputs={path: np.linspace(1.0, 2.0, runs) + k for k, path in enumerate(INPUTS)},
        input_units=dict(zip(INPUTS, ["kg", "rad s-1", "m", "m s-2"], strict=True)),
        attributes={"Conventions": "CF-1.11", "title": "Kreisel µ", "scenario": scenario, "seed": 2015},
    )
