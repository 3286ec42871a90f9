"""What large mechanisms cost: operations per body, counted, never timed. `-s` prints the tables."""

from dataclasses import replace
from time import perf_counter

import numpy as np
import pytest

from lienumba.batch.execute import execute, tasks
from lienumba.batch.integrate import Batch
from lienumba.compiler.emit import Kernel
from lienumba.groups import so3
from lienumba.integrators.tracing.machine import compile_program
from lienumba.integrators.tracing.program import Method, build
from lienumba.integrators.tracing.row_selection import UNIQUE, initial_selection
from lienumba.integrators.tracing.template import split
from lienumba.integrators.tracing.tracer import Tracer
from lienumba.mechanics.mechanism.model import JointStart, Pose, Start
from lienumba.mechanics.start import assembly
from lienumba.mechanics.system import dynamics
from lienumba.mechanics.system.rank import nominal, rank_of
from tests.facade import GROUND, Body, Joint, Model
from tests.rigs import mechanisms
from tests.rigs.linkages import bennett, door, planar_four_bar, triple, unit_body

RK4 = Method("rk4", "local", "mass")
GRAVITY = (0.0, 0.0, -9.81)
SKEW = ((0.0, 1.0, 0.0), (0.0, 0.6, 0.8))


def operations(kernels):
    return {name: kernel.counts()["operations"] for name, kernel in kernels.items()}


def acceleration_map(model, choice=UNIQUE):
    """Operations from a state to the accelerations and multipliers."""
    template, values = split(model)
    tracer = Tracer(template, RK4, choice, fixed=True)
    graph, symbols = tracer.graph()
    posture, mask = tracer.now(graph, symbols)
    expected = tracer.expected(tracer.augmented_rows(graph), 0.0, graph.input("clock", 1))
    solution = dynamics.accelerations(symbols, tracer.structure, posture.now, mask, expected)
    return Kernel("map", (*solution.x, *solution.mu), len(values)).counts()["operations"]


def assembled(model, start):
    done = assembly.assemble(model, start, 1)
    assert done.good.all()
    return nominal(done.model), done.instant(0)


def revolute_chain(k):
    """Links along x that turn about axes askew to each other, in turns."""
    bodies = tuple(unit_body(f"b{i}") for i in range(k))
    ends = [(i - 1 if i else GROUND, i) for i in range(k)]
    joints = tuple(Joint(f"j{i}", "revolute", e) for i, e in enumerate(ends))
    poses = tuple(Pose(position=(i + 0.5, 0.0, 0.0), rotation=so3.IDENTITY) for i in range(k))
    says = tuple(JointStart(at=(float(i), 0.0, 0.0), axis=(SKEW[i % 2],)) for i in range(k))
    return assembled(Model(GRAVITY, bodies, joints), Start(poses, says))


def spherical_chain(k):
    return mechanisms.model(k, mechanisms.chain(k)), None


def star(arms):
    """A hub that nothing holds, and arms hinged on its rim."""
    angle = 2.0 * np.pi * np.arange(arms) / arms + 0.1
    out = np.stack([np.cos(angle), np.sin(angle), np.zeros(arms)], axis=1)
    axes = np.stack([-np.sin(angle), np.cos(angle), np.zeros(arms)], axis=1)
    joints = tuple(Joint(f"j{i}", "revolute", (0, i + 1)) for i in range(arms))
    says = tuple(JointStart(at=triple(0.5 * p), axis=(triple(z),)) for p, z in zip(out, axes, strict=True))
    places = [np.zeros(3), *out]
    poses = tuple(Pose(position=triple(p), rotation=so3.IDENTITY) for p in places)
    bodies = tuple(unit_body(f"b{i}") for i in range(arms + 1))
    return assembled(Model(GRAVITY, bodies, joints), Start(poses, says))


def four_bars(loops):
    """Upright bars side by side on the ground, others across their ends: plane, with three rows to spare per loop."""
    feet, heads = (
        [(GROUND, i) for i in range(loops + 1)],
        [(i + j, loops + 1 + i) for i in range(loops) for j in (0, 1)],
    )
    places = [(float(i), 0.0, 0.5) for i in range(loops + 1)] + [(i + 0.5, 0.0, 1.0) for i in range(loops)]
    points = [(float(i), 0.0, 0.0) for i in range(loops + 1)]
    points += [(float(i + j), 0.0, 1.0) for i in range(loops) for j in (0, 1)]
    joints = tuple(Joint(f"j{n}", "revolute", ends) for n, ends in enumerate(feet + heads))
    says = tuple(JointStart(at=p, axis=((0.0, 1.0, 0.0),)) for p in points)
    bodies = tuple(unit_body(f"b{i}") for i in range(2 * loops + 1))
    poses = tuple(Pose(position=p, rotation=so3.IDENTITY) for p in places)
    return assembled(Model(GRAVITY, bodies, joints), Start(poses, says))


def ladder(loops):
    """Two chains of spherical joints, tied by rods."""
    return mechanisms.model(2 * loops, mechanisms.ladder(loops)), None


@pytest.mark.parametrize(
    ("make", "short", "long"),
    [(revolute_chain, 8, 20), (spherical_chain, 10, 25), (star, 5, 15), (ladder, 3, 7), (four_bars, 3, 7)],
)
def test_the_accelerations_cost_as_much_per_body_however_many_there_are(make, short, long):
    per_body = {}
    for size in (short, long):
        start = perf_counter()
        model, now = make(size)
        choice = initial_selection(model, rank_of(model, now).exchangeable, now) if make is four_bars else UNIQUE
        count = acceleration_map(model, choice)
        per_body[size] = count / len(model.bodies)
        print(f"\n{make.__name__} {size}: {count} operations, {per_body[size]:.0f} per body, "
              f"{perf_counter() - start:.1f} s", end="")  # fmt: skip
    assert per_body[long] < 1.6 * per_body[short]


def test_fifty_revolutes_are_250_rows():
    model, now = revolute_chain(50)
    found = rank_of(model, now)
    assert (found.rows, found.rank, found.shared) == (250, 250, ())


def test_the_heavy_top_costs_what_it_did():
    top = Body("top", 15.0, (0.234375, 0.46875, 0.234375, 0.0, 0.0, 0.0))
    pivot = Joint("pivot", "spherical", (GROUND, 0), ((0.0, 0.0, 0.0), (0.0, -1.0, 0.0)))
    counts = operations(build(Model(GRAVITY, (top,), (pivot,)), RK4).kernels)
    print(f"\nheavy top: {counts}", end="")
    assert set(counts) == {"step", "position", "velocity", "observe"}
    for name, most in {"step": 848, "position": 184, "velocity": 138, "observe": 143}.items():
        assert counts[name] <= most, f"{name}: {counts[name]} operations"


# ---------------------------------------------------------------- rows that say the same
REDUNDANT = {"door": door, "planar four-bar": planar_four_bar, "Bennett": bennett}


def without_redundance(name, model):
    """The same motions with as many rows as the rank: one hinge less, or the last joint only a point on its axis."""
    last = model.joints[-1]
    instead = () if name == "door" else (replace(last, type="point_on_line"),)
    return replace(model, joints=(*model.joints[:-1], *instead))


def programs(name):
    """By hand; with the rows in use compiled in; and with rows that each run exchanges."""
    model, now = assembled(*REDUNDANT[name]())
    by_hand = without_redundance(name, model)
    found, less = rank_of(model, now), rank_of(by_hand, now)
    assert less.rank == less.rows == found.rank < found.rows
    choice = initial_selection(model, found.exchangeable, now)
    return build(by_hand, RK4), build(model, RK4, choice, True), build(model, RK4, choice, False)


def of_a_step(program):
    """Operations of a step with one iteration of each projection, and those of an observation."""
    counts, k = operations(program.kernels), program.sizes.elements
    if "step" not in counts:
        per_body = sum(counts[name] for name in ("combine1", "combine2", "combine3", "advance"))
        counts["step"] = counts["first"] + 3 * counts["stage"] + k * per_body + counts.get("finish", 0)
    return counts["step"] + counts["position"] + counts["velocity"], counts["observe"]


@pytest.mark.parametrize("name", REDUNDANT)
def test_redundant_rows_cost_little(name):
    """Reactions that are not unique make an observation dear: it finds the smallest. A step knows nothing of that."""
    by_hand, fixed, exchanging = map(of_a_step, programs(name))
    print(f"\n{name}: step {by_hand[0]} by hand, {fixed[0]} with fixed rows, {exchanging[0]} with exchanged rows; "
          f"observation {by_hand[1]}, {fixed[1]}, {exchanging[1]}", end="")  # fmt: skip
    assert fixed[0] < 2.5 * by_hand[0]
    assert sum(fixed) < 2.5 * sum(by_hand)


def timed(model, now, choice, program, machine, runs=64, steps=200):
    """A function that takes `steps` steps with all runs on one core and returns its time (ns per step and run)."""
    bodies = np.tile(np.ravel(now.bodies), (runs, 1))
    held = program.augmented.start(now.angles, choice, runs)
    states, codes = np.concatenate([bodies, held], axis=1), np.zeros(runs, np.int8)
    ends = np.array([0, 1e-3 * steps])
    batch = Batch(machine, split(model)[1], states, codes, 1e-3 * steps, 1e-3, ends, 1e-11, 10)

    def run():
        start = perf_counter()
        chunks = list(execute(tasks(batch, 1, lambda chunk: chunk), 1, lambda done: None))
        assert not any(chunk.codes.any() for chunk in chunks)
        return 1e9 * (perf_counter() - start) / (runs * steps)

    return run


def test_twenty_five_revolutes_compile_and_run():
    """Prints times, asserts none; the machine code may be there already."""
    model, now = revolute_chain(25)
    start = perf_counter()
    program = build(model, RK4)
    traced = perf_counter()
    machine = compile_program(program)
    compiled = perf_counter()
    run = timed(model, now, UNIQUE, program, machine, 8, 100)
    print(f"\n25 revolutes: traced in {traced - start:.1f} s, compiled in {compiled - traced:.1f} s, "
          f"{run():.0f} ns per step and run; {operations(program.kernels)}", end="")  # fmt: skip
