"""Rotors of joints: motions, reactions and energies are those of minimal coordinates, where a rotor is one number."""

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest

import lienumba
from tests.oracles.trees.dense import Motion, kinetic, motion, simulate
from tests.oracles.trees.trees import TIMES, Link, Random, Tree, compare, reactions, run, scenario

SIZES = {"screw": 0.9}
KINDS = ("revolute", "prismatic", "screw")


def limb(word: str, names: list[tuple[str, str]], draw: Random) -> list[Link]:
    """Bodies on bodies by joints of one coordinate in turns, which name their base first or last."""
    links = []
    for n, (name, base) in enumerate(names):
        kind = KINDS[(n + len(word)) % 3]
        ends = (base, name) if draw.draw.random() < 0.5 else (name, base)
        joint = draw.joint(f"j{name}", kind, ends)
        rotor = float(10.0 ** draw.draw.uniform(-3.0, 1.0))
        links.append(Link(name, draw.body(), joint, base, SIZES.get(kind, 0.0), rotor=rotor))
    return links


def tree(word: str) -> tuple[Tree, Random]:
    draw = Random("rotors", word)
    names = [("a", "ground"), ("b", "a"), ("c", "b"), ("d", "a")]
    links = limb(word, names, draw)
    if word == "floating":
        links[0] = Link("a", draw.body(), draw.joint("ja", "spherical", ("ground", "a")))
    return Tree(links), draw


@cache
def moving(word: str) -> tuple[Tree, list[Motion]]:
    """The tree, and its motion by minimal coordinates."""
    here, draw = tree(word)
    return here, simulate(here.mechanism, *draw.start(here), TIMES)


@pytest.mark.parametrize("word", ["x", "floating"])
def test_a_random_tree_moves_as_in_minimal_coordinates(word: str) -> None:
    here, history = moving(word)
    ds = run(scenario(here, history[0]))
    compare(here, ds, history)
    reactions(here, ds, history)
    without = replace(here, links=[replace(link, rotor=0.0) for link in here.links])
    q, qd = tree(word)[1].start(here)
    assert np.abs(simulate(without.mechanism, q, qd, (0.0, TIMES[-1]))[-1].r - history[-1].r).max() > 1e-3


@pytest.mark.parametrize(
    "settings",
    [
        {"integrator.group": "SE3"},
        {"integrator.coordinates": "quaternion"},
        {"integrator.coordinates": "joint"},
        {"projection.position": "embedded"},
        {"projection.velocity": "identity"},
        {"projection.chord": True},
        {"projection.position": "none", "projection.velocity": "none"},
        {"integrator.method": "dp54", "integrator.step": None, "integrator.tolerance": 1e-11},
    ],
    ids=lambda settings: "-".join(str(x) for x in settings.values()),
)
def test_every_chart_and_projection_has_the_same_motion(settings: dict[str, Any]) -> None:
    here, history = moving("x")
    data = scenario(here, history[0])
    for path, value in settings.items():
        section, key = path.split(".")
        data.setdefault(section, {})[key] = value
        if value is None:
            del data[section][key]
    ds = lienumba.run(data, workers=1).isel(run=0)
    assert int(ds["status"]) == 0
    for time, at in enumerate(history):
        np.testing.assert_allclose(ds["position"][time], at.r, atol=1e-8)
        np.testing.assert_allclose(ds["velocity"][time], at.v, atol=1e-7)
    assert float(abs(ds["energy_residual"]).max()) < 1e-7


def test_velocities_that_are_omitted_have_the_least_energy_of_bodies_and_rotors() -> None:
    """The rate of one joint is given: the others of the least a/2 rate^2 and of the bodies together."""
    here, draw = tree("yy")
    q, _ = draw.start(here)
    links = list(here.links)
    known = next(n for n, link in enumerate(links) if link.joint.type == "revolute")
    links[known] = replace(links[known], joint=replace(links[known].joint, says={"rate": 1.3}))
    said = replace(here, links=links)
    m = here.mechanism
    M = 0.5 * np.array([[_energy(m, q, e + f) - _energy(m, q, e - f) for e in np.eye(4)] for f in np.eye(4)])
    others = [n for n in range(4) if n != known]
    best = np.zeros(4)
    best[known] = 1.3
    best[others] = np.linalg.solve(M[np.ix_(others, others)], -M[others, known] * 1.3)
    still = simulate(m, q, np.zeros(4), (0.0,))[0]
    ds = run(scenario(said, still, omit=("velocity", "angular_velocity"), step=1e-2))
    exact = simulate(m, q, best, (0.0,))[0]
    np.testing.assert_allclose(ds["velocity"][0], exact.v, atol=1e-12)
    assert float(ds["kinetic_energy"][0]) == pytest.approx(_energy(m, q, best), rel=1e-12)


def _energy(m: Any, q: np.ndarray, qd: np.ndarray) -> float:
    return kinetic(m, motion(m, 0.0, q, qd))
