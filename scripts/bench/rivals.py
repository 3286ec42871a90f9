"""Other engines on the same top, where they are installed (extra `bench`): MuJoCo's rollout and Exudyn."""

import warnings
from dataclasses import dataclass
from typing import Any

import numpy as np

from bench.clock import Spent, Stopwatch, total
from bench.engine import GRAVITY, INERTIA, MASS, PIVOT, SPIN

CENTRE = tuple(-x for x in PIVOT)  # the mass centre, seen from the pivot, body frame
ABOUT_PIVOT = (INERTIA[0] + MASS, INERTIA[1], INERTIA[2] + MASS)  # kg m2; the arm is 1 m along y


@dataclass(frozen=True)
class Rival:
    """`spend(runs, steps)`: on that many steps; `mass_centre()`: of the nominal run at the end."""

    name: str
    version: str
    threads: int
    runs: int
    steps: int
    spend: Any
    mass_centre: Any


def available(h: float, end_steps: int) -> list[Rival]:
    rivals = []
    for make in (_mujoco, _exudyn):
        try:
            rivals.append(make(h, end_steps))
        except ImportError:
            continue
    return rivals


def _mujoco(h: float, end_steps: int) -> Rival:
    import mujoco
    from mujoco import rollout

    model = mujoco.MjModel.from_xml_string(f"""
        <mujoco>
          <option integrator="RK4" timestep="{h!r}" gravity="{" ".join(map(str, GRAVITY))}">
            <flag constraint="disable" contact="disable"/>
          </option>
          <worldbody><body name="top"><joint type="ball"/>
            <inertial pos="{" ".join(map(str, CENTRE))}" mass="{MASS}" diaginertia="{" ".join(map(str, INERTIA))}"/>
          </body></worldbody>
        </mujoco>""")
    threads = [mujoco.MjData(model) for _ in range(2)]
    size = mujoco.mj_stateSize(model, mujoco.mjtState.mjSTATE_FULLPHYSICS)
    start = np.array([0.0, 1.0, 0.0, 0.0, 0.0, *SPIN])  # time, quaternion, angular velocity (body frame)
    spread = np.zeros(8)
    spread[5:] = 0.01 * np.array(SPIN)

    def run(runs: int, steps: int) -> tuple[Spent, np.ndarray]:
        initial = start + np.random.default_rng(2015).standard_normal((runs, 8)) * spread
        initial[0] = start
        states = np.full((runs, steps, size), 0.0)  # memory that is already there, as in a second call
        watch = Stopwatch()
        rollout.rollout(model, threads, initial, nstep=steps, state=states)
        return watch.spent(), states

    def spend(runs: int, steps: int) -> Spent:
        return run(runs, steps)[0]

    def mass_centre() -> np.ndarray:
        w, x, y, z = run(1, end_steps)[1][0, -1, 1:5]
        return np.array([2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)])  # R (0, 1, 0)

    return Rival("MuJoCo rollout", mujoco.__version__, 2, 64, 500, spend, mass_centre)


def _exudyn(h: float, end_steps: int) -> Rival:
    import exudyn
    from exudyn import utilities as exu

    def solve(steps: int) -> tuple[Spent, np.ndarray]:
        container = exudyn.SystemContainer()
        system = container.AddSystem()
        body = system.CreateRigidBody(  # its explicit solvers refuse joints: Euler's equations about the pivot
            inertia=exu.RigidBodyInertia(mass=MASS, inertiaTensor=np.diag(ABOUT_PIVOT)),
            nodeType=exudyn.NodeType.RotationRotationVector, initialAngularVelocity=list(SPIN), gravity=[0, 0, 0],
        )  # fmt: skip
        for point, sign in ((CENTRE, 1.0), ((0.0, 0.0, 0.0), -1.0)):  # a couple: the weight, and the pivot's support
            marker = system.AddMarker(exu.MarkerBodyRigid(bodyNumber=body, localPosition=list(point)))
            system.AddLoad(exu.LoadForceVector(markerNumber=marker, loadVector=[sign * MASS * g for g in GRAVITY]))
        system.Assemble()
        settings = exudyn.SimulationSettings()
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", DeprecationWarning)  # the names that every version knows
            settings.timeIntegration.numberOfSteps = steps
            settings.timeIntegration.endTime = steps * h
            settings.timeIntegration.verboseMode = 0
            settings.solutionSettings.writeSolutionToFile = False
            settings.displayComputationTime = False
        watch = Stopwatch()
        system.SolveDynamic(settings, solverType=exudyn.DynamicSolverType.RK44)
        spent = watch.spent()
        return spent, np.array(system.GetObjectOutputBody(body, exudyn.OutputVariableType.Position, list(CENTRE)))

    def spend(runs: int, steps: int) -> Spent:
        return total(solve(steps)[0] for _ in range(runs))

    version = str(exudyn.__version__)
    return Rival("Exudyn explicit RK44", version, 1, 1, 10000, spend, lambda: solve(end_steps)[1])
