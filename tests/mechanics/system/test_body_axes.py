"""Equations in other axes say the same: rows of joints turned to a body, translations along axes of bodies."""

from dataclasses import replace
from itertools import count

import numpy as np
import pytest

from lienumba.groups import so3
from lienumba.integrators.tracing.method import Method
from lienumba.integrators.tracing.program import build
from lienumba.integrators.tracing.row_selection import initial_selection
from lienumba.integrators.tracing.template import split, symbolic
from lienumba.integrators.tracing.tracer import Tracer
from lienumba.mechanics.mechanism import kinematics
from lienumba.mechanics.start import assembly
from lienumba.mechanics.system import axes_choice, constraints, dynamics, kkt, projection
from lienumba.mechanics.system.body_axes import GLOBAL, Axes
from lienumba.mechanics.system.rank import nominal, rank_of
from lienumba.mechanics.system.rotors import rotors_of
from tests.facade import GROUND, JOINTS, Body, Instant, Joint, Model
from tests.mechanics.elements.test_every_joint import every, started
from tests.mechanics.system.test_random_mechanisms import matrix
from tests.rigs.linkages import bennett, door, planar_four_bar
from tests.rigs.mechanisms import dense, vector
from tests.rigs.random_mechanisms import TOPOLOGIES, mechanism

SEEDS = range(12)
RK4 = Method("rk4", "local", "mass")
random_mechanisms = pytest.mark.parametrize(
    ("topology", "seed"), [(topology, seed) for topology in TOPOLOGIES for seed in SEEDS]
)


def any_axes(model, rng):
    """Joints turned to any of their bodies or none, bodies that move along the axes of any body or of none."""
    k = len(model.bodies)
    rows = {}
    for n, c in enumerate(constraints.constraints_of(model)):
        ends = [i for i in c.bodies if i != GROUND]
        if c.indifferent and rng.random() < 0.7:
            rows[n] = int(rng.choice(ends))
    coupled = {i for rotor in rotors_of(model) if not rotor.constant for i in rotor.bodies}
    return Axes(rows, {i: int(rng.integers(k)) for i in range(k) if rng.random() < 0.7 and i not in coupled})


def rotation(x):
    return np.reshape(x[3:12], (3, 3))


def turns(model, now, axes):
    """T and D with C = T C_global D, in NumPy alone."""
    every_row = constraints.rows_of(model)
    T, D = np.eye(every_row[-1].stop if every_row else 0), np.eye(6 * len(model.bodies))
    for n, (c, rows) in enumerate(zip(constraints.constraints_of(model), every_row, strict=True)):
        if n in axes.rows and c.vector:
            own = slice(rows.start, rows.start + c.vector)
            T[own, own] = rotation(now.bodies[axes.rows[n]]).T
    for i, base in axes.moves.items():
        D[6 * i : 6 * i + 3, 6 * i : 6 * i + 3] = rotation(now.bodies[base])
    return T, D


def alike(found, wanted, relative=1e-12):
    found, wanted = np.array(found, float), np.array(wanted, float)
    assert np.abs(found - wanted).max(initial=0.0) <= relative * max(np.abs(wanted).max(initial=0.0), 1e-3)


@every
def test_a_joint_depends_on_no_axes_but_for_its_vector(name):
    """All bodies moved rigidly, ground too: what turns with them is a vector, all else stays."""
    model, now = started(name)
    rng, c = np.random.default_rng(3), constraints.constraints_of(model)[-1]
    assert c.indifferent is not c.own
    moved = [(*vector(rng), *so3.exp(vector(rng)), *x[12:18]) for x in now.bodies]  # off the joint
    here = kinematics.still(Instant(tuple(moved), now.t, now.angles), tuple(range(len(moved))))
    for base in here.motions if c.indifferent else ():
        there = kinematics.seen_from(here, base)
        before, after = np.array(c.law(here), float), np.array(c.law(there), float)
        before[: c.vector] = np.reshape(here[base].R, (3, 3)).T @ before[: c.vector] if c.vector else []
        alike(after, before, 1e-14)


@random_mechanisms
def test_turned_equations_are_the_same_equations(topology, seed):
    model, now = mechanism(topology, seed)
    axes = any_axes(model, np.random.default_rng(seed))
    T, D = turns(model, now, axes)
    C = dense(constraints.jacobian(model, now, axes), (len(T), len(D)))
    alike(C, T @ matrix(model, now) @ D)
    alike(constraints.residual(model, now, axes), T @ constraints.residual(model, now))
    for turned, plain in zip(
        constraints.rate_and_bias(model, now, axes), constraints.rate_and_bias(model, now), strict=True
    ):
        alike(turned, T @ np.array(plain, float))
    for damping in (None, 7.0):
        alike(constraints.required(model, now, damping, axes), T @ constraints.required(model, now, damping))
    x = np.random.default_rng(seed).standard_normal(len(D))
    alike(axes.into(now, x), D.T @ x)
    alike(axes.out_of(now, axes.into(now, x)), x)


def solvable(topology, seed):
    """With equal bodies and rows far from dependent, so that a comparison to twelve digits means something."""
    for other in count(seed, len(SEEDS)):
        model, now = mechanism(topology, other)
        bodies = tuple(replace(b, mass=2.0, inertia=(0.3, 0.4, 0.5, 0.02, 0.0, -0.01)) for b in model.bodies)
        model = replace(model, bodies=bodies, forces=(), drivers=())
        S = matrix(model, now)
        if np.linalg.cond(S @ S.T) <= 1e4:
            return model, now


@random_mechanisms
def test_accelerations_and_both_projections_are_the_same(topology, seed):
    model, now = solvable(topology, seed)
    structure = kkt.Structure.of(model)
    rng = np.random.default_rng(seed)
    axes, mask = any_axes(model, rng), [1.0] * structure.rows
    plain, turned = (dynamics.accelerations(model, structure, now, mask, axes=each) for each in (GLOBAL, axes))
    T, _ = turns(model, now, axes)
    alike(turned.x, plain.x)
    alike(turned.mu, T @ plain.mu)
    x = (0.05 * rng.standard_normal(6 * len(model.bodies))).tolist()
    plain, turned = (projection.position_correction(model, structure, now, x, mask, each) for each in (GLOBAL, axes))
    alike(turned.x, plain.x)
    mu = (T.T @ turned.mu).tolist()
    first = [s.by for s in (plain, turned)]
    plain = projection.chord_correction(model, first[0], now, x, mu, mask)
    turned = projection.chord_correction(model, first[1], now, x, turned.mu, mask, axes)
    alike(turned.x, plain.x)
    for weight in projection.WEIGHTS.values():
        plain, turned = (
            projection.velocity_correction(model, structure, now, weight, mask, each) for each in (GLOBAL, axes)
        )
        alike(turned.x, plain.x)


def to_ground(kind):
    points, frames = ((0.1, 0.2, 0.3), (0.4, -1.0, 0.2)), (((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)),) * 2
    body = Body("b", 2.0, (0.3, 0.4, 0.5, 0.01, 0.02, 0.03))
    return Model((0.0, 0.0, -9.81), (body,), (Joint("j", kind, (GROUND, 0), points, frames),))


@pytest.mark.parametrize("kind", [name for name, kind in JOINTS.items() if kind.vector])
def test_the_rows_of_points_on_ground_are_constant(kind):
    """In the axes of their body C depends on parameters alone; in global axes it does not."""
    graph, model = symbolic(split(to_ground(kind))[0])
    now = Instant((graph.inputs("state", 18),))

    def varying(axes):
        C = constraints.jacobian(model, now, axes)
        return [key for key, x in C.items() if key[0] < 3 and not getattr(x, "invariant", True)]

    assert not varying(Axes({0: 0}, {0: 0}))
    assert varying(GLOBAL)


def test_a_body_on_a_ball_joint_divides_in_no_stage_and_in_no_projection():
    """C M^-1 C^T and its factors follow from parameters alone, and are computed before the first step."""
    kernels = build(to_ground("spherical"), RK4).kernels
    for name in ("step", "position", "velocity"):
        counts = kernels[name].counts()
        assert counts["divide"] == 0
        assert kernels[name].hoisted
    assert build(to_ground("spherical"), replace(RK4, position="embedded")).kernels["position"].counts()["divide"]


def counted(model, choice, monkeypatch, axes=None):
    """Operations of a step and both projections with the axes that are chosen, or with others."""
    with monkeypatch.context() as patched:
        if axes is not None:
            patched.setattr(axes_choice, "cheapest", lambda *given: axes)
        kernels = build(model, RK4, choice).kernels
    stage = [name for name in ("step", "stage") if name in kernels][-1]
    return sum(kernels[name].counts()["operations"] for name in (stage, "position", "velocity"))


@pytest.mark.parametrize("linkage", [planar_four_bar, bennett, door])
def test_chosen_axes_cost_less_in_loops(linkage, monkeypatch):
    """And turn no vector of which a row is left out: which one that is, was said of global rows."""
    done = assembly.assemble(*linkage(), 1)
    model, now = nominal(done.model), done.instant(0)
    choice = initial_selection(model, rank_of(model, now).exchangeable, now)
    assert choice.rows
    tracer = Tracer(split(model)[0], RK4, choice, fixed=True)
    assert tracer.axes.rows
    for n, (c, rows) in enumerate(zip(constraints.constraints_of(model), constraints.rows_of(model), strict=True)):
        vector_rows = {*range(rows.start, rows.start + c.vector)}
        assert n not in tracer.axes.rows or vector_rows.isdisjoint(choice.dropped)
    assert counted(model, choice, monkeypatch) < 0.95 * counted(model, choice, monkeypatch, GLOBAL)
