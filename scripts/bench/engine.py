"""The engine on the heavy top and on chains: batches to time, and the kernels' own operation counts."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from bench.clock import Spent, Stopwatch
from lienumba.batch.execute import execute, tasks
from lienumba.batch.integrate import Batch, Chunk
from lienumba.compiler import native
from lienumba.compiler.emit import Kernel
from lienumba.compiler.flat import compiled
from lienumba.compiler.lanes import call
from lienumba.compiler.routines.marks import Floats2, Floats3
from lienumba.compiler.rows import W
from lienumba.compiler.symbols import Graph
from lienumba.groups.state import ELEMENT
from lienumba.integrators.tracing.machine import aligned, compile_program
from lienumba.integrators.tracing.method import Method
from lienumba.integrators.tracing.program import Program, build
from lienumba.integrators.tracing.row_selection import UNIQUE
from lienumba.integrators.tracing.template import Slot, split
from lienumba.integrators.tracing.tracer import Tracer
from lienumba.mechanics.mechanism.kinematics import Instant
from lienumba.mechanics.mechanism.model import Body, Joint, JointStart, Model, Pose, Start
from lienumba.mechanics.mechanism.model_numbers import map_numbers
from lienumba.mechanics.start import assembly
from lienumba.mechanics.system import dynamics

# Terze, Mueller, Zlatar (2015), section 7.1; inertia about the mass centre, body frame
MASS, INERTIA, GRAVITY = 15.0, (0.234375, 0.46875, 0.234375), (0.0, 0.0, -9.81)
PIVOT = (0.0, -1.0, 0.0)  # m, body frame
SPIN = (0.0, 150.0, -4.61538)  # rad/s, body frame
END_TIME, STEP, OUTPUTS = 2.0, 1e-4, 200
MASS_CENTRE = (-0.15041682, -0.72416559, -0.67302227)  # m, exact at END_TIME
METHODS = {"none": Method("rk4", "none", "none"), "both": Method("rk4", "local", "mass")}
TOLERANCE, ITERATIONS = 1e-11, 10


@dataclass(frozen=True)
class Tops:
    """Perturbed tops: masses (runs,), spins (runs, 3), states (runs, 18) at t = 0. Run 0 is the paper's."""

    masses: np.ndarray
    spins: np.ndarray
    states: np.ndarray
    model: Model


def tops(runs: int) -> Tops:
    random = np.random.default_rng(2015)
    masses = MASS * (1.0 + 0.01 * random.standard_normal(runs))
    spins = np.array(SPIN) * (1.0 + 0.01 * random.standard_normal((runs, 3)))
    masses[0], spins[0] = MASS, SPIN
    body = Body("top", masses, (*INERTIA, 0.0, 0.0, 0.0))
    joint = Joint("pivot", "spherical", (-1, 0), ((0.0, 0.0, 0.0), PIVOT))
    identity = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)
    pose = Pose((0.0, 1.0, 0.0), identity, None, (spins[:, 0], spins[:, 1], spins[:, 2]))
    done = assembly.assemble(Model(GRAVITY, (body,), (joint,)), Start((pose,), (JointStart(),)), runs)
    return Tops(masses, spins, done.state.reshape(runs, -1), done.model)


def chain(k: int, runs: int) -> tuple[Model, np.ndarray]:
    """k links of 0.25 m on spherical joints, hanging askew; each run with its own masses; states (runs, 18 k)."""
    random = np.random.default_rng(k)
    bodies, joints, poses = [], [], []
    for i in range(k):
        mass = 1.0 + 0.01 * random.standard_normal(runs)
        bodies.append(Body(f"link{i}", mass, (0.0053, 0.0054, 0.0002, 0.0, 0.0, 0.0)))
        above = (0.0, 0.0, 0.0) if i == 0 else (0.0, 0.0, -0.125)
        joints.append(Joint(f"hinge{i}", "spherical", (i - 1, i), (above, (0.0, 0.0, 0.125))))
        c, s = np.cos(0.2 + 0.3 / k * i), np.sin(0.2 + 0.3 / k * i)
        poses.append(Pose(None, (c, 0.0, s, 0.0, 1.0, 0.0, -s, 0.0, c), None, (0.1, 0.2, 0.3)))
    start = Start(tuple(poses), (JointStart(),) * k)
    done = assembly.assemble(Model(GRAVITY, tuple(bodies), tuple(joints)), start, runs)
    return done.model, done.state.reshape(runs, -1)


def step_flops(program: Program) -> int:
    """Floating-point operations of one step and run, whether the step is one kernel or many."""
    flops = {name: kernel.counts()["flops"] for name, kernel in program.kernels.items()}
    if "step" in flops:
        return flops["step"]
    combines = [name for name in flops if name.startswith("combine")]
    of_bodies = flops["advance"] + sum(flops[name] for name in combines)
    return flops["first"] + len(combines) * flops["stage"] + program.sizes.elements * of_bodies


def batch(model: Model, machine: Any, states: np.ndarray, h: float, steps: int, outputs: np.ndarray) -> Batch:
    codes = np.zeros(len(states), np.int8)
    return Batch(machine, split(model)[1], states, codes, h * steps, h, h * outputs, TOLERANCE, ITERATIONS)


def top_batch(sample: Tops, projection: str, h: float = STEP, steps: int = 20000, outputs: int = OUTPUTS) -> Batch:
    """`projection`: "none" or "both" (position local, velocity mass); stored at `outputs` evenly spaced steps."""
    program = build(sample.model, METHODS[projection])
    stored = np.arange(1, outputs + 1) * (steps // outputs)
    return batch(sample.model, compile_program(program), sample.states, h, steps, stored)


def _chunks(work: Batch, workers: int) -> Iterator[Chunk]:
    return execute(tasks(work, workers, lambda chunk: chunk), workers, lambda done: None)


def integrate(work: Batch, workers: int) -> np.ndarray:
    """States (runs, outputs, 18 k) at the stored steps; NaN where a run failed."""
    runs, rows = work.states.shape
    found = np.empty((runs, len(work.outputs), rows))
    for chunk in _chunks(work, workers):
        by_run = chunk.records[:, :, :rows].transpose(0, 3, 1, 2).reshape(-1, *found.shape[1:])
        found[chunk.runs] = by_run[: len(chunk.codes)]
    return found


def spend(work: Batch, workers: int) -> Spent:
    """On the integration alone: threads, kernels and records, no dataset."""
    watch = Stopwatch()
    for chunk in _chunks(work, workers):
        if np.any(chunk.codes):
            raise RuntimeError(f"runs of the benchmark failed with the codes {np.unique(chunk.codes)}")
    return watch.spent()


# ------------------------------------------------------------ the acceleration map alone
def _evaluate(kernel: int, states: Floats3, parameters: Floats2, out: Floats3, work: Floats2, rounds: int) -> None:
    for _ in range(rounds):
        for block in range(states.shape[0]):
            x, y = states[block].ctypes.data, out[block].ctypes.data
            call(kernel, x, parameters.ctypes.data, 0, 0, y, work.ctypes.data)


class AccelerationMap:
    """v', w' and the multipliers of one mechanism, as a kernel of its own, on a few blocks that stay in the cache.

    All blocks have the parameters of the first.
    """

    def __init__(self, model: Model, states: np.ndarray, blocks: int = 4) -> None:
        template, values = split(model)
        graph, k = Graph(), len(model.bodies)
        numbers = map_numbers(template, lambda x, _: graph.input("parameters", x.row) if isinstance(x, Slot) else x)
        bodies = tuple(graph.inputs("state", ELEMENT, ELEMENT * i) for i in range(k))
        tracer = Tracer(template, METHODS["none"], UNIQUE, fixed=True)
        solution = dynamics.accelerations(numbers, tracer.structure, Instant(bodies), axes=tracer.axes)
        kernel = Kernel("map", (*solution.x, *solution.mu), len(values))
        self.counts = kernel.counts()
        self.runs = blocks * W
        self.engine, addresses = native.load(native.compile_text(kernel.text()), ["map", "map_prepare"])
        self.address = addresses["map"]
        self.states = aligned(blocks, ELEMENT * k, W)
        self.states[:] = states[: blocks * W].reshape(blocks, W, -1).transpose(0, 2, 1)
        self.parameters = aligned(len(values) + len(kernel.hoisted), W)
        for row, value in enumerate(values):
            self.parameters[row] = np.broadcast_to(value, len(states))[:W]
        self.out = aligned(blocks, len(kernel.outputs), W)
        self.work = aligned(max(kernel.work_rows, 1), W)
        prepare = aligned(1, ELEMENT * k, W)
        self._evaluate = compiled(_evaluate)
        self._evaluate(addresses["map_prepare"], prepare, self.parameters, self.out, self.work, 1)
        self.spend(1)

    def spend(self, rounds: int) -> Spent:
        watch = Stopwatch()
        self._evaluate(self.address, self.states, self.parameters, self.out, self.work, rounds)
        return watch.spent()
