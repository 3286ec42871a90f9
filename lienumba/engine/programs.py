"""From prepared runs to the program that integrates them, and to its batch."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from lienumba.batch.actions import at_events, plan
from lienumba.batch.integrate import Batch, Pace
from lienumba.engine.fields import changes_told
from lienumba.groups.state import ELEMENT
from lienumba.integrators.methods import METHODS, step_control
from lienumba.integrators.methods.charts import JOINT
from lienumba.integrators.tracing import program as tracing
from lienumba.integrators.tracing.augmented_state import AugmentedState
from lienumba.integrators.tracing.compiled import Compiled, compiled
from lienumba.integrators.tracing.joint import states as joint_states
from lienumba.integrators.tracing.machine import Machine
from lienumba.integrators.tracing.program import Method, Outline, Program
from lienumba.integrators.tracing.row_selection import RowSelection, initial_selection
from lienumba.integrators.tracing.template import split
from lienumba.mechanics.mechanism.kinematics import Instant
from lienumba.mechanics.mechanism.model import Model
from lienumba.mechanics.system.discontinuities import discontinuities
from lienumba.mechanics.system.kkt import Structure
from lienumba.mechanics.system.output_variables import OUTPUT_VARIABLES
from lienumba.mechanics.system.switches import permanent, switches_of
from lienumba.mechanics.tree.spanning import closing_rows
from lienumba.scenario.checks.integrator import order_of, relative_of
from lienumba.scenario.resolve import Scenario
from lienumba.scenario.schema.output import Output
from lienumba.scenario.schema.scenario import Absolute, Integrator, Tolerance
from lienumba.scenario.start.prepare import Prepared
from lienumba.scenario.start.stored_start import start_numbers

# Where no first step is given: so much of the run, and no body turns further than this (rad); it is soon corrected.
FIRST_PART, FIRST_TURN = 1e-3, 0.01


def by_joints(resolved: Scenario) -> bool:
    """Whether the coordinates of the joints are integrated."""
    return resolved.data.integrator.coordinates == JOINT


def selection_of(resolved: Scenario, prepared: Prepared) -> RowSelection:
    """Which of the redundant rows of constraints the program uses."""
    nominal = prepared.nominal
    exchangeable, lasting = nominal.lasting.exchangeable, permanent(nominal.model)
    if by_joints(resolved):
        closing = closing_rows(lasting)
        exchangeable = tuple(row for row in exchangeable if row in closing)
    selection = initial_selection(lasting, exchangeable, nominal.typical)
    return replace(selection, singular=nominal.singular)


def method_of(resolved: Scenario, model: Model) -> Method:
    """What beside the mechanism shapes the kernels of a scenario."""
    data = resolved.data
    integrator, projection, adaptive = data.integrator, data.projection, data.integrator.step is None
    method = METHODS[integrator.method]
    changes = bool(model.events or switches_of(model))
    queued = adaptive or changes or method.series or method.implicit
    return Method(
        tableau=integrator.method, position=projection.position, velocity=projection.velocity,
        dexpinv=integrator.dexpinv, chord=projection.chord, group=integrator.group, coordinates=integrator.coordinates,
        baumgarte=projection.baumgarte, queued=queued, adaptive=adaptive,
        reactions=_stores_reactions(data.output), joint_coordinates=data.output.joint_coordinates,
        order=order_of(integrator) or 0, rho=integrator.rho_infinity,
        extended=(queued or bool(resolved.parameters.measures)) and not method.series,
    )  # fmt: skip


def _stores_reactions(output: Output) -> bool:
    """Whether a variable of them is stored, or a component of it."""
    asked = {*output.variables, *(name.partition(".")[0] for name in (*output.summary, *output.at_events))}
    return any(variable.reaction and name in asked for name, variable in OUTPUT_VARIABLES.items())


def program_of(resolved: Scenario, prepared: Prepared, fixed: bool) -> Program:
    """The program of these runs; fixed: see `program.build`."""
    return tracing.build(prepared.model, method_of(resolved, prepared.model), selection_of(resolved, prepared), fixed)


def compiled_of(
    resolved: Scenario, prepared: Prepared, fixed: bool, begin: Callable[[], None] = lambda: None
) -> Compiled:
    """The program of these runs, and that as machine code; begin: see `compiled.compiled`."""
    return compiled(prepared.model, method_of(resolved, prepared.model), selection_of(resolved, prepared), fixed, begin)


def compile_early(
    resolved: Scenario, prepared: Prepared, fixed: bool, begin: Callable[[], None] = lambda: None
) -> None:
    """Compile the program of these runs before they are timed, if it is what integrates them."""
    if resolved.data.integrator.engine is None:
        compiled_of(resolved, prepared, fixed, begin)


def batch_of(resolved: Scenario, prepared: Prepared, program: Outline, machine: Machine) -> Batch:
    """The runs, ready to be executed."""
    data = resolved.data
    augmented = _augmented(resolved, prepared, program.augmented)
    if by_joints(resolved):
        states = [joint_states.start(prepared.model, program.law_states, len(prepared.states)), augmented]
    else:
        laws = program.law_states.start(prepared.model, len(prepared.states))
        states = [prepared.states, laws, augmented]
    return Batch(
        machine=machine,
        parameters=split(prepared.model)[1],
        states=np.concatenate(states, axis=1),
        codes=prepared.codes,
        end=data.integrator.end_time,
        h=data.integrator.step,
        outputs=np.unique([0.0, *resolved.times]),  # the start too: energies count from it
        tolerance=data.projection.tolerance,
        iterations=data.projection.max_iterations,
        discontinuities=tuple(discontinuities(prepared.model, data.integrator.end_time)),
        pace=_pace(data.integrator, prepared),
        plan=plan(prepared.model, program.held),
        changes=changes_told(prepared.model, data.output.max_changes),
        at_events=bool(data.output.at_events),
        kept_at_events=at_events(prepared.model) if prepared.model.measures else (),
        bodies=len(prepared.model.bodies),
        placed=prepared.states if by_joints(resolved) else None,
        rests=prepared.rests,
        starts=None if prepared.rests is None else start_numbers(prepared),
    )


def _pace(integrator: Integrator, prepared: Prepared) -> Pace | None:
    """How a tolerance chooses steps. If it is not given, the first one turns no body by more than a small angle."""
    tolerance = integrator.tolerance
    if tolerance is None:
        return None
    relative = relative_of(tolerance)
    absolute = tolerance.absolute.model_dump(exclude_none=True) if isinstance(tolerance, Tolerance) else {}
    kinds = Absolute.model_fields
    longest = integrator.max_step or integrator.end_time
    first = integrator.first_step
    if first is None:
        w = prepared.states.reshape(len(prepared.states), -1, ELEMENT)[:, :, 15:18]
        fastest = np.sqrt(w[..., 0] * w[..., 0] + w[..., 1] * w[..., 1] + w[..., 2] * w[..., 2]).max(axis=1)
        first = FIRST_PART * integrator.end_time
        first = np.minimum(first, FIRST_TURN / np.maximum(fastest, FIRST_TURN / first))
    return Pace(
        step_control.Tolerance(relative, **{kind: absolute.get(kind, relative) for kind in kinds}),
        np.minimum(first, longest), longest, integrator.min_step or 0.0,
    )  # fmt: skip


def _augmented(resolved: Scenario, prepared: Prepared, state: AugmentedState) -> np.ndarray:
    """What every run has beside its bodies and law states at the start (runs, rows)."""
    selection, runs = selection_of(resolved, prepared), len(prepared.states)
    if not prepared.nominal.singular:
        return state.start(prepared.angles, selection, runs)
    structure = Structure.of(prepared.model, (), selection.dropped)
    mask = [0.0 if row in selection.dropped else 1.0 for row in range(structure.rows)]
    bodies = tuple(tuple(body.T) for body in prepared.states.reshape(runs, -1, 18).transpose(1, 0, 2))
    now = Instant(bodies, 0.0, prepared.angles)
    from lienumba.mechanics.system.singular import limiting_accelerations

    with np.errstate(all="ignore"):
        last, rates = limiting_accelerations(prepared.model, structure, now, mask)
        if by_joints(resolved):
            last = joint_states.rate_changes(prepared.model, now, last)
            rates = [np.zeros(runs) for _ in last]
    return state.start(prepared.angles, selection, runs, [np.nan_to_num(a) for a in (*last, *rates)])
