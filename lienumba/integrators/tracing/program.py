"""The kernels of one mechanism and one method: what the driver calls.

    step       state -> state, code, margin         one Munthe-Kaas step (clock: t, h), or for large mechanisms
      guess, newton, simplified    see `lienumba.integrators.tracing.implicit`
      first, stage     state, u -> slopes, nonsingular, ...    the slopes of one stage
      combine1, ...    slopes of a body -> u, rotation   the argument of a stage
      advance          state, slopes of a body -> state, rotation, square
      finish           state, what the stages report -> what is augmented
    position   q^, iterate -> iterate               one Gauss-Newton iteration of the position projection
      chord      q^, iterate -> iterate               the same by the elimination of the first
      closure    as position, over the gap of a joint that closes
      carry      state, the state before it closed -> state    rates with which bodies move on as before
    velocity   state -> state, violation, code      the velocity projection
    place      state -> the bodies, where they are no part of it
    read       the bodies -> the state of the moves, likewise
    observe    state -> what is stored beside the state
    close, end, dense  see `lienumba.integrators.tracing.extension_kernels`
    events     state -> the conditions of events and of switched constraints, and to what events set held numbers
    measure    state -> the signals of which something is kept of runs as a whole
      keep       state, what is known of runs -> the same behind a step whose ends say everything
      slopes     as step, with the slopes of all stages, where lanes have no time of their own
      quadrature slopes -> integrals of signals over the step, where `step` does not say them
    border     state -> what a change of modes has to know (see `lienumba.integrators.layout`)
    kick       state, impulses along the switched rows -> state, change of energy, rates
    schur      state -> S of the exchangeable rows of C (see `lienumba.integrators.drivers.row_selection`)
    sample     state -> state                       the laws of the user's own that are sampled now

A state is 18 rows per body, the states of laws (`lienumba.integrators.tracing.law_states`) and what is augmented
(`lienumba.integrators.tracing.augmented_state`). Where everything lies, `lienumba.integrators.layout` says.
Every row is a vector of W runs. A code of 0 is good; see `lienumba.integrators.codes`. Each kernel has a graph of its
own, so that what is observed can never change how a step is computed.
"""

from dataclasses import dataclass, fields
from fractions import Fraction

from lienumba.compiler.emit import Kernel
from lienumba.compiler.loops.composite import Composite
from lienumba.compiler.symbols import uncollected
from lienumba.integrators import layout
from lienumba.integrators.methods.charts import JOINT
from lienumba.integrators.sizes import Sizes
from lienumba.integrators.tracing import (
    extension_kernels,
    position_kernels,
    series_kernels,
    state_kernels,
    step_kernels,
)
from lienumba.integrators.tracing.augmented_state import AugmentedState
from lienumba.integrators.tracing.implicit import alpha_kernels
from lienumba.integrators.tracing.implicit import kernels as collocation
from lienumba.integrators.tracing.joint.tracer import JointTracer, carry, place, read
from lienumba.integrators.tracing.law_states import LawStates
from lienumba.integrators.tracing.measuring import kernels as measuring
from lienumba.integrators.tracing.method import Method
from lienumba.integrators.tracing.row_selection import UNIQUE, RowSelection
from lienumba.integrators.tracing.template import split
from lienumba.integrators.tracing.tracer import Tracer
from lienumba.mechanics.elements import quantities
from lienumba.mechanics.mechanism.model import Model
from lienumba.mechanics.system.switches import Switch

__all__ = ["Method", "Outline", "Program", "build"]

# Kernels of the mechanism, whatever the method: their invariants come first, so that their texts are the same.
ALIKE = ("velocity", "schur", "observe", "position", "chord", "place", "read")


@dataclass(frozen=True)
class Outline:
    """What is known of a program beside its kernels, all of it plain data, which is kept on disk. `nodes`: c of all
    stages; `observed`: name -> (first row, rows); `queued`: whether lanes have their own times; `switches`: see
    `switches_of`; `held`: the rows of a state in which held numbers are; `hoists`: the rows of parameters on which
    hoisted ones depend."""

    sizes: Sizes
    augmented: AugmentedState
    law_states: LawStates
    nodes: tuple[float, ...]
    observed: dict[str, tuple[int, int]]
    queued: bool
    switches: tuple[Switch, ...]
    held: tuple[int, ...]
    hoists: tuple[int, ...]


@dataclass(frozen=True)
class Program(Outline):
    kernels: dict[str, Kernel | Composite]

    def outline(self) -> Outline:
        """Without the kernels, which are large and are not needed beside their machine code."""
        return Outline(**{field.name: getattr(self, field.name) for field in fields(Outline)})


@uncollected()
def build(model: Model, method: Method, selection: RowSelection = UNIQUE, fixed: bool = True) -> Program:
    """Trace every kernel that this mechanism and method need. Of the model, all but the numbers in its slots counts.

    selection: of the rows of C that say the same; fixed: only the rows in use are compiled, which is faster, and a run
    that needs others ends with `codes.RESELECT`; else each run selects them anew on its way.
    """
    template, values = split(model)
    made = JointTracer if method.coordinates == JOINT else Tracer
    tracer = made(template, method, selection, fixed)
    series = 0
    if method.order:
        kernels, series = series_kernels.kernels(tracer)
    else:
        kernels = step_kernels.step(tracer)
    if tracer.tableau.implicit:
        implicit = alpha_kernels if tracer.tableau.carries else collocation
        tracer.sizes = tracer.sizes._replace(iterate=implicit.rows_of(tracer))
        kernels |= implicit.kernels(tracer)
        series = layout.implicit_rows(tracer.sizes)
    levels = tracer.levels()
    chord = 0
    if "position" in levels and method.position != "none":
        projecting, chord = position_kernels.position(tracer)
        kernels |= projecting
        if position_kernels.closes(tracer):
            kernels["closure"] = position_kernels.closure(tracer)
            kernels |= {"carry": carry(tracer)} if isinstance(tracer, JointTracer) else {}
    if levels and method.velocity != "none":
        kernels["velocity"] = state_kernels.velocity(tracer)
    if tracer.augmented.masks:
        kernels["schur"] = state_kernels.schur(tracer)
    if any(force.code is not None and force.code.every is not None for force in template.forces):
        kernels["sample"] = state_kernels.sample(tracer)
    kernels["observe"], observed = state_kernels.observe(tracer)
    if isinstance(tracer, JointTracer):
        kernels |= {"place": place(tracer), "read": read(tracer)}
    if method.extended:
        kernels |= {"end": extension_kernels.end(tracer), "dense": extension_kernels.dense(tracer)}
    if method.adaptive and not method.order and not tracer.tableau.implicit:
        kernels["close"] = extension_kernels.close(tracer)
        kernels |= {"close_along": extension_kernels.close(tracer, along=True)} if tracer.weakens else {}
    if template.events or tracer.augmented.switches:
        kernels["events"] = state_kernels.events(tracer)
        if method.extended and state_kernels.foreseen(tracer, template):
            kernels["watch"] = extension_kernels.watch(tracer)
    if tracer.augmented.switches:
        kernels |= {"border": state_kernels.border(tracer), "kick": state_kernels.kick(tracer)}
    if template.measures:
        tracer.sizes = tracer.sizes._replace(
            signals=len(quantities.signals(template)), kept=len(quantities.kept(template)),
            leaping=sum(quantities.leaps(template, x) for x in quantities.signals(template)),
        )  # fmt: skip
        kernels |= {"measure": measuring.measure(tracer), "keep": measuring.keep(tracer)}
    rows = len(values)
    for name in sorted(kernels, key=[*ALIKE, *kernels].index):
        kernels[name] = kernels[name].hoisted_from(rows)
        rows += len(kernels[name].hoisted)
    hoists = {row for kernel in kernels.values() if isinstance(kernel, Kernel) for row in kernel.hoists}
    tracer.close()
    sizes = tracer.sizes._replace(
        chord=chord, observed=sum(count for _, count in observed.values()), parameters=max(rows, 1), series=series,
    )  # fmt: skip
    return Program(
        sizes, tracer.augmented,
        tracer.law_states, tuple(float(sum(row, Fraction(0))) for row in tracer.tableau.stages), observed,
        method.queued, tracer.augmented.switches, tracer.held(), tuple(sorted(hoists)), kernels,
    )  # fmt: skip
