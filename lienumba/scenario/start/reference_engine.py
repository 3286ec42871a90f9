"""What a scenario must not have where `integrator.engine = "numba"` integrates it, each in one sentence."""

from collections.abc import Iterator

import numpy as np

from lienumba.errors import NOTHING, Problem
from lienumba.integrators.methods import METHODS
from lienumba.integrators.tracing.augmented_state import counted_angles
from lienumba.mechanics.mechanism.kinematics import Instant
from lienumba.mechanics.mechanism.massless import is_massless
from lienumba.mechanics.mechanism.model import Law, Model, Timed, reads_state
from lienumba.mechanics.system.discontinuities import discontinuities
from lienumba.numerics.operations import is_zero
from lienumba.reference.table import DRIVERS, FORCES, JOINT_ROWS
from lienumba.scenario.schema.scenario import ScenarioData
from lienumba.words import listed

NUMBA = "numba"  # the engine's name


def problems_of_engine(data: ScenarioData, model: Model, now: Instant) -> list[Problem]:
    """All that this engine does not support; now: the nominal start."""
    found = [*_of_method(data), *_of_model(model), *_of_output(data, model, now)]
    return found or [*_of_jumps(model, data.integrator.end_time)]


def _problem(place: str, what: str, remedy: str, value: object = NOTHING) -> Problem:
    rule = f'the engine "{NUMBA}" does not support {what}'
    return Problem(place, rule, f"{remedy}, or leave integrator.engine out", value)


def _of_method(data: ScenarioData) -> Iterator[Problem]:
    integrator, projection, method = data.integrator, data.projection, METHODS[data.integrator.method]
    if integrator.step is None:
        yield _problem("integrator.tolerance", "adaptive steps", "give integrator.step", integrator.tolerance)
    if method.implicit or method.series or method.composed:
        explicit = [name for name, x in METHODS.items() if not (x.implicit or x.series or x.composed)]
        what = "methods that are no explicit tableau in the algebra"
        yield _problem("integrator.method", what, f"take {listed(explicit, 'or')}", integrator.method)
    if integrator.group != "R3xSO3":
        yield _problem("integrator.group", "other groups than the paper's", 'take "R3xSO3"', integrator.group)
    if integrator.coordinates != "lie":
        what = "other coordinates than the paper's"
        yield _problem("integrator.coordinates", what, 'take "lie"', integrator.coordinates)
    if projection.position == "embedded":
        what = "the projection in matrix elements"
        yield _problem("projection.position", what, 'take "local" or "none"', projection.position)
    if projection.chord:
        yield _problem("projection.chord", "chord iterations", "take false", True)
    if projection.baumgarte is not None:
        yield _problem("projection.baumgarte", "Baumgarte damping", "leave it out", projection.baumgarte)


def _of_model(model: Model) -> Iterator[Problem]:
    kinds = {"events": model.events, "limits": model.limits, "contacts": model.contacts, "measures": model.measures}
    for kind in (kind for kind, elements in kinds.items() if elements):
        yield _problem(kind if kind in ("events", "measures") else f"model.{kind}", kind, "leave them out")
    for body in filter(is_massless, model.bodies):
        yield _problem(f"model.bodies.{body.name}.mass", "bodies without mass", "give a mass", 0.0)
    for joint in model.joints:
        place = f"model.joints.{joint.name}"
        if joint.type not in JOINT_ROWS:
            remedy = f"take {listed(JOINT_ROWS, 'or')}"
            yield _problem(f"{place}.type", "joints of this type", remedy, joint.type)
        if joint.switched or not joint.active:
            yield _problem(place, "joints that do not hold all the time", "leave out active and its events")
        if not is_zero(joint.armature):
            yield _problem(f"{place}.armature", "rotors", "leave it out")
    for lock in model.locks:
        yield _problem(f"model.joints.{model.joints[lock.joint].name}", "locks", "leave out locked and its events")
    for driver in model.drivers:
        place = f"model.drivers.{driver.name}"
        if driver.motion not in DRIVERS:
            what = f"a prescribed {driver.motion}"
            yield _problem(place, what, f"prescribe the {listed(DRIVERS, 'or')} of a body")
        yield from _of_numbers(f"{place}.value", driver.value)
    for force in model.forces:
        place = f"model.forces.{force.name}"
        if force.type not in FORCES:
            yield _problem(f"{place}.type", "force laws of this type", f"take {listed(FORCES, 'or')}", force.type)
            continue
        for key, x in force.numbers.items():
            yield from _of_numbers(f"{place}.{key}", x if isinstance(x, tuple) else (x,))


def _of_numbers(place: str, numbers: tuple[Timed, ...]) -> Iterator[Problem]:
    """Formulas that read more than time and parameters."""
    for x in numbers:
        if isinstance(x, Law) and reads_state(x):
            what = f"formulas of the state, and this one reads {listed(x.quantities)}"
            yield _problem(place, what, "write one of t and parameters")


def _of_output(data: ScenarioData, model: Model, now: Instant) -> Iterator[Problem]:
    if data.output.joint_coordinates:
        yield _problem("output.joint_coordinates", "coordinates of joints", "take false", True)
    for which in counted_angles(model, now):
        if not isinstance(which, int):
            name = model.joints[which.joint].name
            what = f"counting the turns of {name}.{which.kind}"
            yield _problem("quantities", what, "leave out the quantity that has it")


def _of_jumps(model: Model, end: float) -> Iterator[Problem]:
    for jumps in discontinuities(model, end):
        times = jumps.times(max(np.size(jumps.a), np.size(jumps.b)))
        inside = times[(times > 0.0) & (times < end)]
        if inside.size:
            what = f"formulas that jump or bend, and one does at t = {inside.min():.6g}"
            yield _problem("model", what, "write smooth ones")
            return
