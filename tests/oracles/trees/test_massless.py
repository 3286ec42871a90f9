"""Bodies without mass, in the coordinates of the joints: motions and reactions are those of minimal coordinates."""

from typing import Any

import numpy as np

import lienumba
from tests.oracles.trees.dense import Body, simulate
from tests.oracles.trees.trees import TIMES, Link, Random, Tree, compare, reactions, run, scenario
from tests.rigs import parts

NOTHING = Body(0.0, np.zeros((3, 3)))


def shoulders(word: str) -> tuple[Tree, Random]:
    """A base; on it an arm behind two massless bodies, a forearm behind one, and a slide behind one with a rotor."""
    draw = Random("massless", word)
    base = "spherical" if word == "floating" else "revolute"
    links = [Link("base", draw.body(), draw.joint("j0", base, ("ground", "base")))]
    for name, kind, on in (
        ("s1", "revolute", "base"), ("s2", "revolute", "s1"), ("arm", "revolute", "s2"),
        ("e1", "revolute", "arm"), ("forearm", "revolute", "e1"),
        ("carriage", "prismatic", "base"), ("bob", "revolute", "carriage"),
    ):  # fmt: skip
        body = draw.body() if name in ("arm", "forearm", "bob") else NOTHING
        ends = (on, name) if draw.draw.random() < 0.5 else (name, on)
        rotor = 0.3 if name in ("carriage", "e1") and word != "floating" else 0.0
        links.append(Link(name, body, draw.joint(f"j{name}", kind, ends), on, rotor=rotor))
    return Tree(links), draw


def test_motions_and_reactions_are_those_of_minimal_coordinates() -> None:
    tree, draw = shoulders("floating")
    q, qd = draw.start(tree)
    history = simulate(tree.mechanism, q, qd, TIMES)
    data = scenario(tree, history[0], step=5e-4)
    data["integrator"]["coordinates"] = "joint"
    ds = run(data)
    compare(tree, ds, history)
    reactions(tree, ds, history)


ROD = 0.7


def linkage(massless: bool) -> dict[str, Any]:
    """A crank and a rocker in a plane; between their ends a massless coupler, or the joint "distance"."""
    crank = parts.body("crank", 1.0, [0.01, 0.02, 0.02], position=[0, 0.15, 0])
    rocker = parts.body("rocker", 2.0, [0.01, 0.05, 0.05], position=[0.7, 0.25, 0])
    one = parts.hinge("one", "crank", axis=parts.Z, rate=5.0)
    two = parts.hinge("two", "rocker", [0.7, 0, 0], parts.Z)
    ends = [[0, 0.3, 0], [0.7, 0.5, 0]]
    bodies, joints = [crank, rocker], [one, two]
    if massless:
        bodies.append({"name": "coupler", "mass": 0.0, "position": [0.35, 0.4, 0]})
        joints.append(parts.hinge("a", "coupler", ends[0], parts.Z, to="crank"))
        joints.append(parts.joint("b", "spherical", "rocker", "coupler", at=ends[1]))
    else:
        joints.append(parts.joint("tie", "distance", "rocker", "crank", points=[[0, 0.15, 0], [0, 0.25, 0]]))
    return {"gravity": [0, -9.81, 0], "bodies": bodies, "joints": joints}


def test_a_massless_coupler_of_a_loop_is_a_rod() -> None:
    integrator = {"method": "dop853", "step": 2e-3, "end_time": 0.5}
    rod = lienumba.run({"model": linkage(massless=False), "integrator": integrator})
    coupler = lienumba.run({"model": linkage(massless=True), "integrator": {**integrator, "coordinates": "joint"}})
    assert (coupler["status"] == 0).all()
    np.testing.assert_allclose(coupler["position"][:, :, :2], rod["position"], atol=1e-9)
    np.testing.assert_allclose(coupler["kinetic_energy"], rod["kinetic_energy"], atol=1e-9)


def test_a_massless_body_at_the_end_turns_by_its_rotor_alone() -> None:
    """It is welded to a pendulum, or turns on it under a steady torque, with nothing but a/2 rate^2."""
    bob = parts.body("bob", 1.0, [0.02, 0.03, 0.02], position=[0.4, 0, 0])
    tip = {"name": "tip", "mass": 0.0, "position": [0.8, 0, 0]}
    hinge = parts.hinge("hinge", "bob")
    end = {"name": "end", "bodies": ["bob", "tip"], "at": [0.8, 0, 0], "axis": [0, 1, 0]}
    push = {"type": "actuator", "joint": "end", "value": 0.3}
    integrator = {"method": "dop853", "step": 2e-3, "end_time": 0.4, "coordinates": "joint"}

    def moved(joint: dict[str, Any], forces: list[dict[str, Any]]) -> Any:
        model = {"bodies": [bob, tip], "joints": [hinge, end | joint], "forces": forces}
        ds = lienumba.run({"model": model, "integrator": integrator, "quantities": [seen][: len(forces)]})
        assert (ds["status"] == 0).all()
        return ds

    seen = {"name": "seen", "type": "joint", "joint": "end"}
    welded, turning = moved({"type": "fixed"}, []), moved({"type": "revolute", "armature": 0.05}, [push])
    alone = lienumba.run({"model": {"bodies": [bob], "joints": [hinge]}, "integrator": integrator})
    np.testing.assert_allclose(welded["position"][:, :, :1], alone["position"], atol=1e-12)
    relative = turning["seen.rate"]
    np.testing.assert_allclose(relative[0], 0.3 / 0.05 * turning["time"], atol=1e-11)


def test_runs_of_a_sweep_with_massless_bodies_have_their_own_bits() -> None:
    tree, draw = shoulders("a")
    history = simulate(tree.mechanism, *draw.start(tree), TIMES[:1])
    data = scenario(tree, history[0], step=2e-3)
    data["integrator"] |= {"coordinates": "joint", "method": "dp54", "tolerance": 1e-8}
    del data["integrator"]["step"]
    vary = {"bodies.arm.mass": {"distribution": "uniform", "low": 1.0, "high": 2.0}}
    many, few = (lienumba.run(data | {"sweep": {"runs": n, "vary": vary}}) for n in (9, 2))
    assert (many["status"] == 0).all()
    np.testing.assert_array_equal(many["position"][:2], few["position"])
    assert float(abs(many["energy_residual"]).max()) < 1e-5
