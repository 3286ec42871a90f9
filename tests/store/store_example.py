"""A small dataset with made-up numbers, as the engine would hand them over."""

import numpy as np

from lienumba.store.layout import VARIABLES, dataset

TIMES = [float(f"{k / 100:.2f}") for k in range(101)]
INPUTS = ("bodies.top.mass", "bodies.top.angular_velocity[1]", "joints.pivot.points[1][0]", "gravity[2]")


def arrays(seed: int = 0, **sizes: int) -> dict[str, np.ndarray]:
    """Every variable; sizes: of its dimensions, 3 by default."""
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


def example(
    runs=4,
    times=TIMES,
    bodies=("top",),
    joints=("pivot",),
    efforts=("motor",),
    events=("far",),
    switches=("latch", "stop"),
    requirements=("stays near", "comes soon"),
    seed=0,
    scenario="",
    shared=(),
    total=None,
    **replaced,
):
    """Three constraint equations per joint, one per effort; `replaced` are arrays to put in; total: see `dataset`."""
    constraints = [*(f"{joint}[{k}]" for joint in joints for k in range(3)), *(f"{name}[0]" for name in efforts)]
    labels = {"body": bodies, "joint": joints, "constraint": constraints, "effort": efforts, "event": events}
    labels |= {"switch": switches, "requirement": requirements}
    sizes = {dim: len(names) for dim, names in labels.items()}
    variables = arrays(seed, run=runs, time=len(times), **sizes) | replaced
    return dataset(
        variables=variables,
        times=times,
        runs=range(runs),
        bodies=bodies,
        joints=joints,
        constraints=constraints,
        efforts=efforts,
        events=events,
        changes=3,
        switches=switches,
        start=["top.position.x", "top.position.y", "top.position.z"],
        requirements=dict.fromkeys(requirements, "m"),
        inputs={path: np.linspace(1.0, 2.0, runs) + k for k, path in enumerate(INPUTS)},
        input_units=dict(zip(INPUTS, ["kg", "rad s-1", "m", "m s-2"], strict=True)),
        shared=shared,
        total=total,
        attributes={"Conventions": "CF-1.8", "title": "Kreisel µ", "scenario": scenario, "seed": 2015},
    )
