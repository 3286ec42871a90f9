"""Robots of the gallery in this engine, in MuJoCo and in Pinocchio, from the same starts with the same steps."""

from collections.abc import Mapping
from copy import copy
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from bench.clock import Spent, Stopwatch
from bench.engine import step_flops
from bench.trees import Tree
from lienumba.batch.execute import execute, tasks
from lienumba.engine import programs
from lienumba.integrators.methods import METHODS
from lienumba.scenario.resolve import Scenario, resolve
from lienumba.scenario.start.prepare import check_initial, prepare

SCENARIOS = Path(__file__).resolve().parents[2] / "scenarios"
Source = str | Mapping[str, Any]

ROBOTS = ("ur5", "iiwa", "solo12", "talos")
STEP = 1e-3
ARMATURE = 0.05  # kg m^2, of the variants with a rotor at every joint
SPREAD = 0.05  # rad, rad/s, m, m/s: of the starts


def scenario(source: Source, overrides: Mapping[str, Any] | None = None, armature: float = 0.0) -> Scenario:
    """A robot of the gallery by its name, or keys and values, without what it stores; armature: of all joints."""
    given = SCENARIOS / f"{source}.toml" if isinstance(source, str) else dict(source)
    joints = [joint.name for joint in resolve(given).data.model.joints if hasattr(joint, "armature")]
    rotors = {f"joints.{joint}.armature": armature for joint in joints if armature}
    return resolve(given, overrides={"output.variables": [], **rotors, **(overrides or {})})


class Robot:
    """A robot of the gallery, or a scenario, as a tree, and `runs` starts: q (runs, nq), v (runs, nv). The first is its
    own, the others scatter about it."""

    def __init__(self, source: Source, runs: int) -> None:
        self.source, self.armature = source, 0.0
        self.nominal = check_initial(scenario(source))
        self.tree = Tree(self.nominal.model)
        start, rates = self.tree.coordinates(self.nominal.assembled.state.reshape(1, -1))
        self.q, self.v = perturbed(self.tree, start[0], rates[0], runs)

    def with_rotors(self, armature: float = ARMATURE) -> "Robot":
        """The same with rotors of this inertia (kg m^2) at all joints."""
        other = copy(self)
        other.tree, other.armature = self.tree.with_rotors(armature), armature
        return other

    def at(self, q: np.ndarray, v: np.ndarray) -> "Robot":
        """The same with these starts."""
        other = copy(self)
        other.q, other.v = q, v
        return other


def perturbed(tree: Tree, q: np.ndarray, v: np.ndarray, runs: int) -> tuple[np.ndarray, np.ndarray]:
    random = np.random.default_rng(2015)
    starts = q + SPREAD * random.standard_normal((runs, tree.nq))
    rates = v + SPREAD * random.standard_normal((runs, tree.nv))
    starts[0], rates[0] = q, v
    return normal(tree, starts), rates


def random_states(tree: Tree, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Anywhere; in single precision, so that they take little room in a file."""
    random = np.random.default_rng(33)
    q, v = random.uniform(-2.0, 2.0, (count, tree.nq)), 2.0 * random.standard_normal((count, tree.nv))
    return q.astype(np.float32), v.astype(np.float32)


def normal(tree: Tree, q: np.ndarray) -> np.ndarray:
    """The same, its quaternions of length 1."""
    q = q.astype(float)
    for link in tree.links:
        if link.kind in ("ball", "free"):
            own = q[:, link.q + (3 if link.kind == "free" else 0) :][:, :4]
            own /= np.linalg.norm(own, axis=1, keepdims=True)
    return q


class Engine:
    """The runs of a robot, ready to go any number of steps, nothing stored on the way."""

    def __init__(self, robot: Robot, overrides: Mapping[str, Any] | None = None) -> None:
        settings = {"integrator.step": STEP, **(overrides or {})}
        self.resolved = scenario(robot.source, settings, robot.armature)
        start = prepare(self.resolved, [0])
        runs = len(robot.q)
        self.prepared = start._replace(
            labels=list(range(runs)), states=robot.tree.states(robot.q, robot.v), codes=np.zeros(runs, np.int8),
            angles={j: np.full(runs, angle[0]) for j, angle in start.angles.items()},
        )  # fmt: skip
        self.program, self.machine = programs.compiled_of(self.resolved, self.prepared, True)
        self.beside = 0.0
        self.stages = len(METHODS[self.resolved.data.integrator.method].b)

    def run(self, steps: int, workers: int, h: float = STEP) -> tuple[np.ndarray, Spent]:
        """States at the end (runs, 18 k), and the time: on the clock of all, of the cores on the steps alone; `beside`
        becomes what a run costs the cores beside them (s)."""
        watch, seconds = Stopwatch(), 0.0
        batch = programs.batch_of(self.resolved, self.prepared, self.program, self.machine)
        batch = replace(batch, h=h, end=steps * h, outputs=np.array([0.0, steps * h]))
        ends = np.empty_like(self.prepared.states)
        for chunk in execute(tasks(batch, workers, lambda chunk: chunk), workers, lambda _: None):
            if np.any(chunk.codes):
                raise RuntimeError(f"runs of {self.resolved.data.title!r} failed: codes {np.unique(chunk.codes)}")
            ends[chunk.runs] = chunk.states[:, : ends.shape[1]]
            seconds += chunk.seconds
        spent = watch.spent()
        self.beside = (spent.core - seconds) / batch.runs
        return ends, Spent(spent.wall, seconds)

    def flops(self) -> int:
        """Of a step and run without its projections."""
        return step_flops(programs.program_of(self.resolved, self.prepared, True))

    def spend(self, steps: int, workers: int = 1) -> Spent:
        return self.run(steps, workers)[1]
