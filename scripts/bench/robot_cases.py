"""Robots against MuJoCo and Pinocchio, and chains in the coordinates of their joints: what is timed, and the tables.

Everything counts core time: what the processor spent on all threads, of ours in the steps; what a run costs beside them
stands by itself. Nothing is stored on the way, but for the states that MuJoCo's rollout always writes.
"""

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from bench import robot_rivals, robots
from bench.cases import Case
from bench.checks import CLOSE, Check
from bench.clock import Spent
from lienumba.errors import ScenarioError

if TYPE_CHECKING:
    from rich.console import Console

THREADS = 2
RUNS = 1000
WORK = 1_000_000  # steps times runs times bodies of one sample of ours; a tenth of it for MuJoCo
EVALUATIONS = 20  # of aba, at each of so many starts
LENGTH = 0.25  # m, of a link of a chain
CHAIN_RUNS = 64
PROJECTED = {"integrator.coordinates": "lie", "projection": {"position": "local", "velocity": "mass"}}
BY_JOINTS = {"integrator.coordinates": "joint"}
WAYS = {"lie": PROJECTED, "joint": BY_JOINTS}
RIVALS = ("mujoco", "batch", "pinocchio")
WORDS = {"lie": "bodies, both projections", "joint": "coordinates of joints"}


def ways() -> list[str]:
    """The ways of integrating a robot that this version has."""
    found = []
    for way, settings in WAYS.items():
        try:
            robots.scenario("ur5", settings)
        except ScenarioError:
            continue
        found.append(way)
    return found


def robot_cases(names: list[str], runs: int = RUNS, work: int = WORK) -> tuple[list[Case], list[Check]]:
    """Each robot in every way, without and with rotors, and its rivals; and whether all go the same way."""
    cases, checks = [], []
    for name in names:
        robot = robots.Robot(name, runs)
        bodies = len(robot.tree.links)
        steps = max(10, work // (runs * bodies))
        few = max(5, steps // 10)
        for way in ways():
            for rotors, own in (("", robot), ("_rotors", robot.with_rotors())):
                engine = robots.Engine(own, WAYS[way])
                label = f"{name}, {WORDS[way]}{', rotors' if rotors else ''}"
                run = partial(engine.spend, steps, THREADS)
                key, parts = f"robot_{name}_{way}{rotors}", bodies * engine.stages
                beside = partial(getattr, engine, "beside")
                flops = engine.flops() if way == "joint" else 0.0
                cases.append(Case(key, label, THREADS, runs * steps, run, flops, parts, beside))
                checks += _check(label, own, engine)
        rivals, same = _rivals(name, robot, few)
        cases, checks = [*cases, *rivals], [*checks, *same]
    return cases, checks


def _rivals(name: str, robot: robots.Robot, steps: int) -> tuple[list[Case], list[Check]]:
    found, checks = [], []
    try:
        mujoco = robot_rivals.Mujoco(robot.tree, robots.STEP, THREADS)
        run = timed_by(mujoco.run, robot, steps)
        label = f"{name}, MuJoCo {mujoco.version} rollout, RK4"
        found.append(Case(f"robot_{name}_mujoco", label, THREADS, len(robot.q) * steps, run))
        ends, same = mujoco.run(robot.q, robot.v, 10)[:2], mujoco.run_batch(robot.q, robot.v, 10)[:2]
        error = max(float(np.abs(x - y).max()) for x, y in zip(ends, same, strict=True))
        checks.append(Check(f"{name}: MuJoCo's batch after 10 ms against its rollout", error, 0.0))
        run = timed_by(mujoco.run_batch, robot, steps)
        label = f"{name}, MuJoCo {mujoco.version} batch, own masses, RK4"
        found.append(Case(f"robot_{name}_batch", label, THREADS, len(robot.q) * steps, run))
    except ImportError:
        pass
    try:
        aba = robot_rivals.Pinocchio(robot.tree)
        run = partial(aba.spend, robot.q[:EVALUATIONS], robot.v[:EVALUATIONS], EVALUATIONS)
        label = f"{name}, Pinocchio {aba.version}, aba from Python, one evaluation"
        found.append(Case(f"robot_{name}_pinocchio", label, 1, EVALUATIONS**2, run))
    except ImportError:
        pass
    return found, checks


def timed_by(run: Callable[..., tuple[Any, Any, Spent]], robot: robots.Robot, steps: int) -> Callable[[], Spent]:
    """What a rival spends on so many steps of all runs."""
    return lambda: run(robot.q, robot.v, steps)[2]


def _check(label: str, robot: robots.Robot, engine: robots.Engine) -> list[Check]:
    """Against MuJoCo, where it is installed, after 10 ms; both err by h^4."""
    try:
        mujoco = robot_rivals.Mujoco(robot.tree, robots.STEP, THREADS)
    except ImportError:
        return []
    ends = robot.tree.states(*mujoco.run(robot.q, robot.v, 10)[:2])
    error = float(np.abs(engine.run(10, 1)[0] - ends).max())
    return [Check(f"{label}: state after 10 ms against MuJoCo", error, 1e3 * CLOSE)]


# ------------------------------------------------------------ chains
def chain(k: int, kind: str) -> dict[str, Any]:
    """k links from the ground along x, "revolute" about y and z in turn, or "spherical"; at rest."""
    bodies, joints = [], []
    for i in range(k):
        body = {"name": f"link{i}", "mass": 1.0 + 0.01 * (i % 7), "inertia": [0.0002, 0.0053, 0.0054]}
        place = {"position": [(i + 0.5) * LENGTH, 0.0, 0.0], "rotation": [1, 0, 0, 0]}
        bodies.append({**body, **place, "velocity": [0.0, 0.0, 0.0], "angular_velocity": [0.0, 0.0, 0.0]})
        ends = {"bodies": [f"link{i - 1}" if i else "ground", f"link{i}"]}
        points = {"points": [[0.5 * LENGTH if i else 0.0, 0.0, 0.0], [-0.5 * LENGTH, 0.0, 0.0]]}
        axis = [[0, 1, 0], [0, 0, 1]][i % 2]
        axes = {"axes": [axis, axis], "references": [[1, 0, 0], [1, 0, 0]]} if kind == "revolute" else {}
        joints.append({"name": f"joint{i}", "type": kind, **ends, **points, **axes})
    model = {"gravity": [0.0, 0.0, -9.81], "bodies": bodies, "joints": joints}
    return {"model": model, "integrator": {"method": "rk4", "step": robots.STEP, "end_time": 1.0}}


def chain_cases(lengths: list[int], work: int = WORK) -> list[Case]:
    """In the coordinates of the joints, if there are such; their unit of work is a stage of one body."""
    if "joint" not in ways():
        return []
    cases = []
    for kind, word in (("revolute", "hinges"), ("spherical", "balls")):
        for k in lengths:
            engine = robots.Engine(robots.Robot(chain(k, kind), CHAIN_RUNS), BY_JOINTS)
            steps = max(10, work // (CHAIN_RUNS * k))
            units = steps * CHAIN_RUNS * k * engine.stages
            cases.append(Case(f"joints_{word}_{k}", f"chain of {k} {word}", 1, units, partial(engine.spend, steps)))
    return cases


# ------------------------------------------------------------ numbers
def ratios(cases: list[Case], ratio: Callable[[str, str], float]) -> dict[str, float]:
    """Of robots to their rivals, of rotors to none, of chains to that of four; ratio(slow, fast): within rounds."""
    keys, found = {case.key for case in cases}, {}
    for key in sorted(keys):
        if key.startswith("robot_") and not key.endswith(RIVALS):
            for rival in (f"robot_{key.split('_')[1]}_{other}" for other in ("mujoco", "batch")):
                if rival in keys and not key.endswith("_rotors"):
                    found[f"{rival}/{key}"] = ratio(rival, key)
            if (rotors := f"{key}_rotors") in keys:
                found[f"{rotors}/{key}"] = ratio(rotors, key)
        if key.startswith("joints_") and (four := f"{key.rpartition('_')[0]}_4") in keys:
            found[f"{key}/{four}"] = ratio(key, four)
    return found


def show(found: dict[str, Any], console: "Console") -> None:
    from rich.table import Table

    rows, ratios = found["rows"], found["ratios"]
    table = Table(title="Robots, RK4, h = 1e-3, two threads: ns of core time per step and run, medians")
    faster = "faster than MuJoCo's rollout by", "than its batch by"
    for name in ("", "ns", "of peak", "per body and stage", *faster, "with rotors", "beside steps, µs per run"):
        table.add_column(name, no_wrap=not name, justify="right" if name else "left")
    for key, row in rows.items():
        if not key.startswith("robot_") or key.endswith("_rotors"):
            continue
        rivals = [ratios.get(f"robot_{key.split('_')[1]}_{other}/{key}") for other in ("mujoco", "batch")]
        rotors, of_peak = ratios.get(f"{key}_rotors/{key}"), ratios.get(f"peak_fraction_{key}")
        each = f"{row['ns'] / row['parts']:.1f}" if row["parts"] else ""
        more = (*(f"{x:.1f}" if x else "" for x in rivals), f"{rotors:.2f}" if rotors else "")
        beside = f"{row['beside_us']:,.0f}" if row["beside_us"] else ""
        share = f"{of_peak:.0%}" if of_peak else ""
        table.add_row(row["label"], f"{row['ns']:,.0f}", share, each, *more, beside)
    console.print(table)
    chains = [key for key in rows if key.startswith("joints_")]
    if chains:
        table = Table(title="Chains in the coordinates of their joints, RK4, one thread")
        for name in ("", "ns per body and stage", "to chain of 4"):
            table.add_column(name, justify="right" if name else "left")
        for key in chains:
            ratio = ratios.get(f"{key}/{key.rpartition('_')[0]}_4")
            table.add_row(rows[key]["label"], f"{rows[key]['ns']:.1f}", f"{ratio:.2f}" if ratio else "")
        console.print(table)
