"""A stiff arm with joints in lienumba and in Exudyn: what a run costs to an error, both with implicit methods.

Four links in space from a turning post on: the second hinge is free, the third has a stiff spring, the fourth a strong
damper. Exudyn takes them as bodies with joints, which is what its implicit generalised-alpha method is for.
"""

import warnings
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

import lienumba
from bench.clock import Stopwatch

END = 1.0  # s
MASS, INERTIA, LENGTH = 1.0, (0.005, 0.02, 0.02), 0.5
GRAVITY = (0.0, 0.0, -9.81)
AXES = ((0.0, 0.0, 1.0), (0.0, 1.0, 0.0), (0.0, 1.0, 0.0), (1.0, 0.0, 0.0))  # of the hinges, at the start
SPRINGS = (None, None, (1e5, 1e3), (0.0, 1e3))  # N m/rad, N m s/rad
TURNING = 2.0  # rad/s, of the post


@dataclass(frozen=True)
class Way:
    """A method at one setting: run() gives the last body's mass centre at the end, core seconds for each run and
    steps."""

    name: str
    setting: str
    run: Callable[[], tuple[np.ndarray, float, float]] = field(repr=False)


def arm() -> lienumba.System:
    """In lienumba: four bodies along x, hinges between their ends."""
    system = lienumba.System("stiff arm")
    system.gravity = list(GRAVITY)
    for n, axis in enumerate(AXES):
        at = [LENGTH * n, 0.0, 0.0]
        system.body(f"link{n}", mass=MASS, inertia=list(INERTIA), position=[at[0] + 0.5 * LENGTH, 0.0, 0.0])
        rate = TURNING if n == 0 else 0.0
        bodies = ["ground" if n == 0 else f"link{n - 1}", f"link{n}"]
        system.joint(f"hinge{n}", "revolute", bodies, at=at, axis=list(axis), rate=rate)
    for n, spring in enumerate(SPRINGS):
        if spring:
            more = {"stiffness": spring[0], "damping": spring[1]}
            system.force(f"spring{n}", type="torsion_spring", joint=f"hinge{n}", **more)
    return system.output(variables=["position"], every=END)


def lienumba_way(method: str, runs: int, **setting: Any) -> Way:
    """Runs that differ a little in how fast the post turns."""
    system = arm().integrator(method=method, coordinates="joint", end_time=END, **setting)
    system.sweep(runs=runs, nominal=True)
    system.vary("joints.hinge0.rate", "normal", std=0.02)

    def run() -> tuple[np.ndarray, float, float]:
        watch = Stopwatch()
        found = lienumba.run(system, workers=1)
        spent = watch.spent().core
        assert (found.status == 0).all()
        own = found.sel(run=-1)
        return own.position.values[-1, -1], spent / (runs + 1), float(own.steps)

    return Way(method, ", ".join(f"{key} {x:g}" for key, x in setting.items()), run)


def exudyn_way(steps: int) -> Way:
    """Exudyn's implicit generalised-alpha method on the same bodies, with the solver that is fastest here."""

    def run() -> tuple[np.ndarray, float, float]:
        import exudyn
        from exudyn import utilities as exu

        system = exudyn.SystemContainer().AddSystem()
        before, spin = system.CreateGround(), [0.0, 0.0, TURNING]
        for n, axis in enumerate(AXES):
            at = np.array([LENGTH * n, 0.0, 0.0])
            centre = at + [0.5 * LENGTH, 0.0, 0.0]
            body = system.CreateRigidBody(
                inertia=exu.RigidBodyInertia(mass=MASS, inertiaTensor=np.diag(INERTIA)),
                nodeType=exudyn.NodeType.RotationRotationVector, referencePosition=list(centre),
                initialVelocity=list(np.cross(spin, centre)), initialAngularVelocity=spin, gravity=list(GRAVITY),
            )  # fmt: skip
            pair = {"bodyNumbers": [before, body], "position": list(at), "axis": list(axis), "useGlobalFrame": True}
            system.CreateRevoluteJoint(**pair)
            if SPRINGS[n]:
                k, d = SPRINGS[n]
                system.CreateTorsionalSpringDamper(stiffness=k, damping=d, **pair)
            before = body
        system.Assemble()
        settings = exudyn.SimulationSettings()
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", DeprecationWarning)
            settings.timeIntegration.numberOfSteps = steps
            settings.timeIntegration.endTime = END
            settings.timeIntegration.verboseMode = 0
            settings.timeIntegration.generalizedAlpha.spectralRadius = 0.8
            settings.linearSolverType = exudyn.LinearSolverType.EXUdense
            settings.solutionSettings.writeSolutionToFile = False
            settings.displayComputationTime = False
        watch = Stopwatch()
        system.SolveDynamic(settings, solverType=exudyn.DynamicSolverType.GeneralizedAlpha)
        spent = watch.spent().core
        kind = exudyn.OutputVariableType.Position
        return np.array(system.GetObjectOutputBody(before, kind, [0.0, 0.0, 0.0])), spent, float(steps)

    return Way("Exudyn generalised-alpha", f"step {END / steps:g}", run)
