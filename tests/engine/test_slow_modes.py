"""Slow modes beside fast ones: what grows, what drifts, and what is only rounding."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import lienumba
from tests.rigs import parts

G = 9.81
SHORT = {"integrator": {"step": 1e-2, "end_time": 0.1}}
FAST = [1e4, 1e8, 1e10, 1e12]


@pytest.mark.parametrize("fast", FAST)
@pytest.mark.parametrize(("damping", "status"), [(-0.01, 2), (0.01, 0), (0.0, 0)])
def test_a_slow_pair_beside_a_stiff_spring_grows_as_it_does_alone(fast: float, damping: float, status: int) -> None:
    bodies, joints, forces = [], [], []
    for n, (stiffness, own) in enumerate(((1.0, damping), (fast, 0.0))):
        bodies.append(parts.body(f"b{n}", 1, 1, position=[n, 0, 0], rotation=[1, 0, 0, 0]))
        joints.append(parts.hinge(f"j{n}", f"b{n}", [n, 0, 0]))
        forces.append({"type": "torsion_spring", "joint": f"j{n}", "stiffness": stiffness, "damping": own})
    data = {"model": {"gravity": [0, 0, 0], "bodies": bodies, "joints": joints, "forces": forces}, **SHORT}
    modes = lienumba.modes(data)
    assert modes.stable.item() == (status == 0)
    assert modes.grows.values.sum() == (status == 2)
    assert lienumba.equilibrium(data).status.item() == status


@pytest.mark.parametrize("height", [0.5, -0.5])
@pytest.mark.parametrize("damping", [8e3, 8e5])
def test_a_pendulum_in_tar_creeps_but_does_not_drift(height: float, damping: float) -> None:
    """Its eigenvalues, exact roots of 0.28 s^2 + c s - m g z, are apart by up to 1e12."""
    body = parts.body("b", 1, [0.02, 0.03, 0.01], position=[0, 0, height], rotation=[1, 0, 0, 0])
    tar = {"type": "friction", "joint": "j", "viscous": damping}
    data = {"model": {"bodies": [body], "joints": [parts.hinge("j", "b")], "forces": [tar]}, **SHORT}
    slow = G * height / damping
    found, modes = lienumba.equilibrium(data), lienumba.modes(data)
    assert found.status.item() == (2 if height > 0 else 0)
    assert found.growth.item() == pytest.approx(slow, rel=1e-3)
    assert modes.stable.item() == (height < 0)
    assert np.nanmax(modes.growth.values) == pytest.approx(slow, rel=1e-3)


@pytest.mark.parametrize("seed", range(8))
def test_what_nothing_holds_has_six_modes_of_zero_whatever_it_is_made_of(seed: int) -> None:
    """Masses over six, stiffnesses over ten orders of magnitude, with ball joints and springs, turned anyhow."""
    rng, turn = np.random.default_rng(seed), Rotation.random(random_state=seed)
    bodies, joints, forces = [], [], []
    for n in range(3):
        mass, lie = 10.0 ** rng.uniform(-3, 3), np.roll(Rotation.random(random_state=10 * seed + n).as_quat(), 1)
        place = turn.apply([0.5 * n, *(0.1 * rng.normal(size=2))])
        inertia = [mass * x for x in (0.02, 0.03, 0.04)]
        bodies.append(parts.body(f"b{n}", mass, inertia, position=place.tolist(), rotation=lie.tolist()))
    for n in range(2):
        pair = [f"b{n}", f"b{n + 1}"]
        at = turn.apply([0.5 * n + 0.25, 0, 0]).tolist()
        joints.append({"name": f"j{n}", "type": "spherical", "bodies": pair, "at": at})
        stiffness = 10.0 ** rng.uniform(0, 10)
        for _ in range(3):
            points = (0.3 * rng.normal(size=(2, 3))).tolist()
            spring = {"type": "spring_damper", "bodies": pair, "points": points, "free_length": 0.1}
            spring |= {"damping": float(rng.choice([0.0, 1e-3 * np.sqrt(stiffness)]))}
            forces.append({"name": f"f{len(forces)}", "stiffness": stiffness, **spring})
    model = {"gravity": [0, 0, 0], "bodies": bodies, "joints": joints, "forces": forces}
    data = {"model": model, **SHORT}
    assert lienumba.equilibrium(data).status.item() == 0
    modes = lienumba.modes({**data, "start": {"from": "equilibrium"}})
    zero = (modes.growth.values == 0.0) & (modes.angular_frequency.values == 0.0)
    assert zero.sum() == 6
    assert not modes.grows.any()


def test_what_lies_may_roll_and_nothing_else_in_every_run() -> None:
    """Its only freedom has a stiffness of rounding, between weight and what carries it."""
    rods = {"sweep.runs": 400}
    assert (lienumba.equilibrium("scenarios/falling_rod.toml", overrides=rods).status == 0).all()
    lying = lienumba.modes("scenarios/falling_rod.toml", overrides={**rods, "start": {"from": "equilibrium"}})
    assert lying.stable.all()
    assert not np.nan_to_num(np.hypot(lying.growth, lying.angular_frequency)).any()
