"""Bodies without mass: what is said of them, and their starts; motions are those of a limit of light bodies."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from lienumba.mechanics.mechanism.massless import with_lent_masses
from lienumba.mechanics.system import constraints, dynamics, kkt, rank
from lienumba.mechanics.tree.spanning import idle, ties_of
from lienumba.scenario.start import prepare
from lienumba.scenario.start.build import build, unphysical
from lienumba.scene.mechanism import mechanism
from lienumba.scene.solids import NOTHING
from tests.facade import Body, Joint, ScenarioError, resolve
from tests.rigs import parts

HEAVY: Any = [1.5, [0.02, 0.05, 0.03]]  # mass, inertia
AXES = {"x": [1, 0, 0], "y": [0, 1, 0], "z": [0, 0, 1], "z again": [0, 0, 1]}


def shoulder(axes: tuple[str, ...] = ("z", "y", "x"), **first: Any) -> dict[str, Any]:
    """An arm, and a forearm; hinges about these axes lead to the arm, with a massless body after each but the last."""
    names = [f"s{n}" for n in range(1, len(axes))]
    bodies: list[dict[str, Any]] = [{"name": x, "mass": 0.0, "position": [0, 0, 1]} for x in names]
    bodies += [parts.body("arm", *HEAVY, position=[0.4, 0, 1]), parts.body("forearm", *HEAVY, position=[0.9, 0.1, 0.9])]
    ends = ["ground", *names, "arm"]
    joints = [parts.hinge(f"j{n}", ends[n + 1], [0, 0, 1], AXES[axis], to=ends[n]) for n, axis in enumerate(axes)]
    elbow = parts.hinge("elbow", "forearm", [0.8, 0, 1], to="arm")
    joints[0] |= first
    return {"bodies": bodies, "joints": [*joints, elbow]}


def scenario(model: dict[str, Any], **integrator: Any) -> dict[str, Any]:
    return {"model": model, "integrator": {"step": 1e-3, "end_time": 0.1, **integrator}}


@pytest.fixture
def by_joints(monkeypatch: pytest.MonkeyPatch) -> None:
    """The check of the integrator passes."""
    monkeypatch.setattr("lienumba.scenario.checks.bodies.JOINT", "lie")


def start(model: dict[str, Any]) -> prepare.Nominal:
    return prepare.check_initial(resolve(scenario(model)))


def told(model: dict[str, Any], **integrator: Any) -> str:
    with pytest.raises(ScenarioError) as error:
        prepare.check_initial(resolve(scenario(model, **integrator)))
    return str(error.value)


# ---------------------------------------------------------------- what is said
def test_other_coordinates_want_a_mass() -> None:
    message = told(shoulder())
    assert 'model.bodies.s1.mass = 0.0: must be above 0 with integrator.coordinates = "lie"; ' in message
    assert 'give the mass in kg, or coordinates = "joint"' in message


def test_a_mass_wants_an_inertia_and_an_inertia_a_mass(by_joints: None) -> None:
    model = shoulder()
    model["bodies"][0] |= {"inertia": [0.1, 0.1, 0.1]}
    del model["bodies"][-1]["inertia"]
    message = told(model)
    assert "model.bodies.s1.inertia = [0.1, 0.1, 0.1]: belongs to no mass, which is 0; leave it out" in message
    assert "model.bodies.forearm.inertia is missing; give the inertia in kg m^2 about the mass centre" in message


def test_zeros_are_no_inertia(by_joints: None) -> None:
    model = shoulder()
    model["bodies"][0] |= {"inertia": [0, 0, 0]}
    assert start(model).model.bodies[0].inertia == (0.0,) * 6


def test_a_negative_mass_is_none() -> None:
    model = shoulder()
    model["bodies"][0]["mass"] = -1.0
    assert "model.bodies.s1.mass = -1.0: must be above 0; give the mass in kg, above 0" in told(model)


def loose(kind: str) -> dict[str, Any]:
    model = shoulder()
    if kind == "a free body":
        model["bodies"].append({"name": "loose", "mass": 0.0, "position": [1, 1, 1]})
    elif kind == "the last of a chain":
        model["bodies"].append({"name": "loose", "mass": 0.0, "position": [1, 0.1, 0.9]})
        model["joints"].append(parts.hinge("tip", "loose", [1, 0.1, 0.9], to="forearm"))
    elif kind == "two hinges about one axis":
        model = shoulder(("z", "z again", "y"))
        model["bodies"][0]["name"] = "loose"
        for joint in model["joints"]:
            joint["bodies"] = ["loose" if x == "s1" else x for x in joint["bodies"]]
    else:
        model = {"bodies": [{"name": "loose", "mass": 0.0, "position": [0, 0, 0]}]}
    return model


@pytest.mark.parametrize("kind", ["a free body", "the last of a chain", "two hinges about one axis", "nothing else"])
def test_a_body_that_moves_no_mass_is_told(by_joints: None, kind: str) -> None:
    message = told(loose(kind))
    assert "model.bodies.loose.mass = 0.0: at the start loose can move while nothing that has a mass does; " in message


def test_in_the_tree_of_the_joints_massless_bodies_carry_something(by_joints: None) -> None:
    """A coupler that closes a loop carries what was tied elsewhere; the last of a branch carries nothing."""
    model = start(shoulder()).model
    assert list(idle(model)) == []
    s2, forearm = 1, 3
    tie = Joint("tie", "spherical", (s2, forearm), ((0.0, 0.0, 0.0), (-0.9, -0.1, 0.1)))
    assert list(idle(replace(model, joints=(*model.joints, tie)))) == []
    last = replace(model, bodies=(*model.bodies, Body("last", 0.0, (0.0,) * 6)))
    hinge = replace(model.joints[-1], bodies=(forearm, 4))
    assert list(idle(replace(last, joints=(*model.joints, hinge)))) == [4]
    assert list(idle(replace(last, joints=(*model.joints, replace(hinge, armature=0.1))))) == []
    assert list(idle(replace(last, joints=(*model.joints, replace(tie, bodies=(0, 4)), hinge)))) == []
    assert [tie.parent for tie in ties_of(last)] == [-1, 0, 1, 2, -1]


def test_a_rotor_is_mass_enough(by_joints: None) -> None:
    model = loose("the last of a chain")
    model["joints"][-1]["armature"] = 0.01
    assert start(model).rank.freedom == 5


def test_a_massless_body_may_be_welded_to_one_with_mass(by_joints: None) -> None:
    model = loose("the last of a chain")
    model["joints"][-1]["type"] = "fixed"
    assert start(model).rank.freedom == 4


# ---------------------------------------------------------------- the start
@pytest.mark.parametrize(
    "first", [{"rate": 2.0}, {"rate": 2.0, "armature": 0.3}, {"armature": 0.1}], ids=["", "rotor", "still"]
)
def test_velocities_are_those_of_least_energy_of_what_has_mass(by_joints: None, first: dict[str, Any]) -> None:
    """Against a dense solution over the motions that the joints allow; the elbow turns in any case."""
    model = shoulder(**first)
    model["joints"][-1] |= {"rate": -1.0}
    nominal = start(model)
    n = 6 * len(nominal.model.bodies)
    C, M = np.zeros((20, n)), np.zeros((n, n))
    for key, x in constraints.jacobian(nominal.model, nominal.now).items():
        C[key] = x
    for (i, j), x in dynamics.mass_matrix(nominal.model, nominal.now).items():
        M[i, j] = M[j, i] = x
    conditions, wanted = C, np.zeros(20)
    for name, turning in (("j0", first.get("rate")), ("elbow", -1.0)):
        joint = next(j for j in nominal.model.joints if j.name == name)
        row = np.zeros(n)
        for sign, side in ((-1.0, 0), (1.0, 1)):
            if joint.bodies[side] >= 0 and joint.frames is not None:
                row[6 * joint.bodies[side] + 3 : 6 * joint.bodies[side] + 6] = sign * np.array(joint.frames[side][2])
        if turning is not None:
            conditions, wanted = np.vstack([conditions, row]), np.append(wanted, turning)
    K = np.block([[M, conditions.T], [conditions, np.zeros((len(conditions),) * 2)]])
    best = np.linalg.lstsq(K, np.concatenate([np.zeros(n), wanted]), rcond=1e-12)[0][:n]
    found = np.array([x for body in nominal.now.bodies for x in body[12:18]])
    np.testing.assert_allclose(found, best, atol=1e-9)
    assert np.abs(found).max() > 0.5


def test_the_start_has_a_rank_and_a_metric(by_joints: None) -> None:
    nominal = start(shoulder())
    assert (nominal.rank.rank, nominal.rank.freedom) == (20, 4)
    assert all(x > 0.0 for x in dynamics.shapes(nominal.model).values())
    assert rank.moving_no_mass(nominal.model, nominal.now) == ()


def test_positions_are_closed_whatever_the_masses(by_joints: None) -> None:
    """Of an arm that is turned: the massless bodies find their rotations."""
    model = shoulder()
    arm = {"position": [0.4 * np.cos(1.1), 0.4 * np.sin(1.1), 1.0], "rotation": {"axis": [0, 0, 1], "angle": 1.1}}
    model["bodies"][2] |= arm
    for joint in model["joints"][:3]:
        axis = joint.pop("axis")
        del joint["at"]
        joint |= {"points": [[0, 0, 1 if joint["name"] == "j0" else 0], [0, 0, 0]], "axes": [axis, axis]}
    model["joints"][2]["points"][1] = [-0.4, 0, 0]
    for x in model["bodies"][:2]:
        del x["position"]
    del model["bodies"][3]["position"]
    model["joints"][3] |= {"points": [[0.4, 0, 0], [-0.1, 0, 0.1]], "axes": [[0, 1, 0]] * 2}
    del model["joints"][3]["at"], model["joints"][3]["axis"]
    nominal = start(model)
    np.testing.assert_allclose(constraints.residual(nominal.model, nominal.now), 0.0, atol=1e-9)


def test_samples_may_not_take_or_give_the_mass(by_joints: None) -> None:
    model = shoulder()
    vary = {"bodies.arm.mass": {"distribution": "normal", "std": 0.1}}
    swept = resolve(scenario(model) | {"sweep": {"runs": 3, "vary": vary}})
    samples = {"bodies.arm.mass": np.array([1.0, 0.0, 2.0])}
    assert unphysical(*build(swept, samples), samples, 3).tolist() == [False, True, False]
    vary = {"bodies.s1.mass": {"distribution": "normal", "std": 0.1}}
    with pytest.raises(ScenarioError, match="varies the mass of a body that has none; give it a mass above 0"):
        resolve(scenario(model) | {"sweep": {"runs": 3, "vary": vary}})


def test_massless_bodies_alone_have_no_mass_centre(by_joints: None) -> None:
    seen = {"name": "p", "type": "momentum", "bodies": ["s1", "s2"], "about": "mass_centre"}
    with pytest.raises(
        ScenarioError, match=r'p\.about = "mass_centre": these bodies have no mass, and so no mass cent'
    ):
        resolve(scenario(shoulder()) | {"quantities": [seen]})


def test_a_massless_body_is_not_drawn_but_its_joints_are(by_joints: None) -> None:
    seen = resolve(scenario(shoulder()))
    positions = np.array([body["position"] for body in shoulder()["bodies"]], float)
    drawn = mechanism(seen, {}, positions, np.tile(np.eye(3), (4, 1, 1)))
    assert drawn.masses == (0.0, 0.0, 1.5, 1.5)
    assert [solid.kind for solid in drawn.solids[:2]] == [NOTHING, NOTHING]
    assert drawn.seen == (2, 3)
    assert {mark.name for mark in drawn.marks} == {joint["name"] for joint in shoulder()["joints"]}


# ---------------------------------------------------------------- the limit
def test_accelerations_of_lighter_and_lighter_bodies_have_a_limit(by_joints: None) -> None:
    """What a formulation without their mass has to give: the equations of motion on what the joints leave free."""
    nominal = start(shoulder(rate=2.0))
    model, now = nominal.model, nominal.now
    n = 6 * len(model.bodies)
    M, C = np.zeros((n, n)), np.zeros((20, n))
    for (i, j), x in dynamics.mass_matrix(model, now).items():
        M[i, j] = M[j, i] = x
    for key, x in constraints.jacobian(model, now).items():
        C[key] = x
    free = np.linalg.svd(C)[2][20:]
    particular = np.linalg.lstsq(C, np.array(constraints.required(model, now)), rcond=None)[0]
    Q = np.array(dynamics.loads(model, now))
    exact = particular + free.T @ np.linalg.solve(free @ M @ free.T, free @ (Q - M @ particular))
    errors = []
    for part in (1e-3, 1e-4):
        light = with_lent_masses(model, part)
        errors.append(np.abs(np.array(dynamics.accelerations(light, kkt.Structure.of(light), now).x) - exact).max())
    assert errors[1] < 0.2 * errors[0] < 0.1
