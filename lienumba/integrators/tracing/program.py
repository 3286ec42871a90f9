"""The kernels of one mechanism and one method: what the driver calls.

    step       state -> state, code, margin         one Munthe-Kaas step (clock: t, h), or for large mechanisms
      first, stage     state, u -> slopes, sound, ...    the slopes of one stage
      combine1, ...    slopes of a body -> u, rotation   the argument of a stage
      advance          state, slopes of a body -> state, rotation, square
      finish           state, what the stages report -> what is held beside the bodies
    position   q^, iterate -> iterate               one Gauss-Newton iteration of the position projection
      chord      q^, iterate -> iterate               the same by the elimination of the first
    velocity   state -> state, violation, code      the velocity projection
    observe    state -> what is stored beside the state
    close, end, dense  see `lienumba.integrators.tracing.extension_kernels`
    events     state -> whether the condition of each event holds, 1 or 0
    exchange   state -> S of the rows that may be exchanged (see `lienumba.integrators.tracing.row_selection`)

    sample     state -> state                       the laws of the user's own that are sampled now

A state is 18 rows per body, what is carried (`lienumba.integrators.tracing.law_states`) and what is held
(`lienumba.integrators.tracing.augmented_state`).
Every row is a vector of W runs. A code of 0 is good; see `lienumba.integrators.codes`. Each kernel has a graph of its
own, so that what is observed can never change how a step is computed.
"""

from dataclasses import dataclass
from fractions import Fraction

from lienumba.compiler.emit import Kernel
from lienumba.compiler.symbols import uncollected
from lienumba.integrators.tracing import extension_kernels, position_kernels, state_kernels, step_kernels
from lienumba.integrators.tracing.augmented_state import Held
from lienumba.integrators.tracing.law_states import Carried
from lienumba.integrators.tracing.row_selection import UNIQUE, Choice
from lienumba.integrators.tracing.tracer import Method, Tracer, split
from lienumba.mechanics.mechanism.model import Model
from lienumba.mechanics.system import constraints

__all__ = ["Method", "Program", "build"]


@dataclass
class Program:
    """`elements`: of S, those of the bodies first; `slope`: the coordinates of each in a step; `stages`, `slots`: see
    `Tracer`; `events`: conditions; `parameter_rows`: of the model's numbers, and of what is hoisted; `nodes`: c of all
    stages; `observed`: name -> (first row, rows); `correction`: rows of an iterate of the position projection between
    its state and its violation; `kept`: behind its code; `free`: whether every lane has its own time.
    """

    elements: int
    slope: int
    stages: int
    slots: int
    events: int
    held: Held
    carried: Carried
    parameter_rows: int
    kernels: dict[str, Kernel]
    nodes: list[float]
    observed: dict[str, tuple[int, int]]
    correction: int
    kept: int
    free: bool


@uncollected()
def build(model: Model, method: Method, choice: Choice = UNIQUE, fixed: bool = True) -> Program:
    """Trace every kernel that this mechanism and method need. Of the model, all but the numbers in its slots counts.

    choice: of the rows of C that say the same; fixed: only the rows in use are compiled, which is faster, and a run
    that needs others ends with `codes.EXCHANGED`; else each run exchanges them on its way.
    """
    template, values = split(model)
    tracer = Tracer(template, len(values), method, choice, fixed)
    kernels = step_kernels.step(tracer)
    levels = {constraint.level for constraint in constraints.constraints_of(tracer.graph()[1])}
    kept = 0
    if "position" in levels and method.position != "none":
        projecting, kept = position_kernels.position(tracer)
        kernels |= projecting
    if levels and method.velocity != "none":
        kernels["velocity"] = state_kernels.velocity(tracer)
    if tracer.held.masks:
        kernels["exchange"] = state_kernels.exchange(tracer)
    if any(force.code is not None and force.code.every is not None for force in template.forces):
        kernels["sample"] = state_kernels.sample(tracer)
    kernels["observe"], observed = state_kernels.observe(tracer)
    if method.free:
        kernels |= {"end": extension_kernels.end(tracer), "dense": extension_kernels.dense(tracer)}
    if method.paced:
        kernels["close"] = extension_kernels.close(tracer)
    if template.events:
        kernels["events"] = state_kernels.events(tracer)
    nodes = [float(sum(row, Fraction(0))) for row in tracer.tableau.stages]
    return Program(
        elements=tracer.elements, slope=tracer.chart.size, stages=tracer.stages, slots=tracer.slots,
        events=len(template.events), held=tracer.held, carried=tracer.carried, parameter_rows=tracer.rows,
        kernels=kernels, nodes=nodes, observed=observed, correction=sum(position_kernels.correction_rows(tracer)),
        kept=kept, free=method.free,
    )  # fmt: skip
