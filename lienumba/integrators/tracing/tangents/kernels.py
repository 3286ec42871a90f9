"""Kernels that compute tangents beside values: how what they give changes with each input of a run.

They are those of a step by its stages, of the projections and of what is looked at, each with the tangents of its
outputs (`lienumba.compiler.tangents`). Lanes are inputs: all of them have the values of one run. `shift` rows behind a
value is its tangent, in states, slopes and all that kernels write; those of the parameters follow the parameters, those
of the clock the clock.
"""

from collections.abc import Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from lienumba.compiler import native
from lienumba.compiler.emit import Kernel
from lienumba.compiler.foreign.calls import linked
from lienumba.compiler.memo import Memo
from lienumba.compiler.symbols import Symbol, uncollected
from lienumba.compiler.tangents import tangents
from lienumba.integrators import layout
from lienumba.integrators.layout import COMBINE, ORDER
from lienumba.integrators.methods import METHODS
from lienumba.integrators.methods.charts import JOINT
from lienumba.integrators.sizes import Sizes
from lienumba.integrators.tracing import position_kernels, state_kernels, step_kernels
from lienumba.integrators.tracing.compiled import key_of
from lienumba.integrators.tracing.implicit import kernels as collocation
from lienumba.integrators.tracing.joint.tracer import JointTracer, carry
from lienumba.integrators.tracing.measuring import kernels as measuring
from lienumba.integrators.tracing.method import Method
from lienumba.integrators.tracing.row_selection import RowSelection
from lienumba.integrators.tracing.tangents.jumps import Jumps
from lienumba.integrators.tracing.template import split
from lienumba.integrators.tracing.tracer import BODIES, Tracer
from lienumba.keys.registry import Registry
from lienumba.mechanics.elements import quantities
from lienumba.mechanics.mechanism.model import Model
from lienumba.numerics.number import Number

BEHIND = {"advance": 2, "position": 2, "closure": 2, "velocity": 2}  # outputs that only say whether a step is good
INSTEAD = "dop853"  # whose steps, in parts, take the place of those of a series: both follow the motion
MOVES = (layout.TIME, layout.LENGTH)  # rows of the clock that have tangents


@dataclass(frozen=True)
class TangentMachine:
    """The kernels as machine code.

    kernels: addresses, see `layout.ORDER`; prepares: of the functions that fill the hoisted rows of the parameters;
    nodes: c of all stages; shift: rows from a value to its tangent; slots: parameters, behind which their tangents are;
    parameters: rows of them with all that follows; observed: name -> (first row, rows); engines: which hold the code;
    jumps: where forces jump; instead: whether the steps are those of another method.
    """

    kernels: np.ndarray
    prepares: tuple[int, ...]
    nodes: np.ndarray
    sizes: Sizes
    shift: int
    slots: int
    parameters: int
    work_rows: int
    observed: dict[str, tuple[int, int]]
    engines: tuple[Any, ...]
    jumps: Jumps
    instead: bool


class Asked(NamedTuple):
    """The rows of the parameters that change with an input, and the variables whose tangents are wanted."""

    parameters: frozenset[int]
    variables: frozenset[str]


MACHINES: Memo[TangentMachine] = Memo(16)


def compiled(model: Model, method: Method, selection: RowSelection, fixed: bool, asked: Asked) -> TangentMachine:
    """The kernels of a mechanism and a method (see `program.build`), once in a process."""

    def make() -> TangentMachine:
        return _made(model, method, selection, fixed, asked)

    key = key_of(model, method, selection, fixed)
    return make() if key is None else MACHINES.get((Registry.changes, key, asked), make)


@uncollected()
def _made(model: Model, method: Method, selection: RowSelection, fixed: bool, asked: Asked) -> TangentMachine:
    """Trace and compile the kernels."""
    method = replace(method, chord=False, queued=False, adaptive=False, extended=False, order=0)
    instead = METHODS[method.tableau].series
    if instead:
        method = replace(method, tableau=INSTEAD)
    template, values = split(model)
    tracer = (JointTracer if method.coordinates == JOINT else Tracer)(template, method, selection, fixed)
    plain, observed = _kernels(tracer, asked)
    shift = max(layout.series_row(tracer.sizes), max(_rows(kernel) for kernel in plain.values()))
    rows, work, made = 2 * len(values), 0, dict[str, Future[bytes]]()
    with ThreadPoolExecutor(2) as threads:
        for name, kernel in plain.items():
            own = _with_tangents(tracer, kernel, shift, len(values), asked.parameters).hoisted_from(rows)
            rows += len(own.hoisted)
            made[name] = threads.submit(native.compile_text, linked(own.text()))
            work = max(work, own.work_rows)
    addresses, prepares, engines = np.zeros(COMBINE + len(tracer.tableau.stages), np.int64), [], []
    order = [*ORDER, *(f"combine{s}" for s in range(len(tracer.tableau.stages)))]
    for name, code in made.items():
        engine, found = native.load(code.result(), [name, f"{name}_prepare"])
        addresses[order.index(name)] = found[name]
        prepares.append(found[f"{name}_prepare"])
        engines.append(engine)
    nodes = np.array([float(sum(row, start=0)) for row in tracer.tableau.stages])
    seen, signals = sum(count for _, count in observed.values()), len(quantities.signals(template))
    sizes = tracer.sizes._replace(observed=seen, signals=signals if template.measures else 0)
    tracer.close()
    return TangentMachine(
        addresses, tuple(prepares), nodes, sizes, shift, len(values), max(rows, 1), work, observed, tuple(engines),
        Jumps.of(model, method, selection, fixed), instead,
    )  # fmt: skip


def _kernels(tracer: Tracer, asked: Asked) -> tuple[dict[str, Kernel], dict[str, tuple[int, int]]]:
    """All that tangents go through, without what only decides whether a step is good."""
    template, method = tracer.template, tracer.method
    kernels = _implicit(tracer) if tracer.tableau.implicit else step_kernels.stages(tracer)
    levels = tracer.levels()
    if "position" in levels and method.position != "none":
        kernels |= position_kernels.position(tracer)[0]
        if position_kernels.closes(tracer):
            kernels["closure"] = position_kernels.closure(tracer)
            kernels |= {"carry": carry(tracer)} if isinstance(tracer, JointTracer) else {}
    if levels and method.velocity != "none":
        kernels["velocity"] = state_kernels.velocity(tracer)
    if any(force.code is not None and force.code.every is not None for force in template.forces):
        kernels["sample"] = state_kernels.sample(tracer)
    observe, observed = _observe(tracer, asked.variables)
    kernels |= {"observe": observe} if observed else {}
    if template.events or tracer.augmented.switches:
        kernels["events"] = state_kernels.events(tracer)
    if tracer.augmented.switches:
        kernels |= {"border": state_kernels.border(tracer), "kick": state_kernels.kick(tracer)}
    if template.measures:
        kernels["measure"] = measuring.measure(tracer)
    return kernels, observed


def _implicit(tracer: Tracer) -> dict[str, Kernel]:
    """A step by collocation: Newton's method, its iterations by a known matrix, by which tangents are found, and the
    end."""
    tracer.sizes = tracer.sizes._replace(iterate=collocation.rows_of(tracer))
    kernels = {name: x for name, x in collocation.kernels(tracer, False).items() if isinstance(x, Kernel)}
    tracer.sizes = tracer.sizes._replace(series=layout.implicit_rows(tracer.sizes))
    return {name: kernels[name] for name in ("newton", "simplified", "step")}


def _observe(tracer: Tracer, wanted: frozenset[str]) -> tuple[Kernel, dict[str, tuple[int, int]]]:
    """Of what is stored beside the state these variables, and bodies where the state does not have them."""
    graph, model = tracer.graph()
    posture, mask = tracer.now(graph, model)
    observed: dict[str, tuple[int, int]] = {}
    outputs: list[Number] = []
    for name, rows in state_kernels.named(tracer, graph, model, posture, mask).items():
        if name in wanted or name == BODIES:
            observed[name] = (len(outputs), len(rows))
            outputs += rows
    return tracer.kernel("observe", outputs), observed


def _places(kernel: Kernel) -> Sequence[int]:
    return range(len(kernel.outputs)) if kernel.rows is None else kernel.rows


def _rows(kernel: Kernel) -> int:
    """The rows that a kernel reads and writes, but for parameters."""
    read = (node.args[1] for node in kernel.order if node.op == "input" and node.args[0] != "parameters")
    return 1 + max([0, *_places(kernel), *read])


def _with_tangents(tracer: Tracer, kernel: Kernel, shift: int, slots: int, active: frozenset[int]) -> Kernel:
    """A kernel that also computes the tangents of its outputs. Newton's method has none: only its matrix is wanted,
    which is good enough as it is."""
    if kernel.name == "newton":
        return kernel
    matrix = layout.factors_row(tracer.sizes) if kernel.name == "simplified" else None
    seeds: dict[Symbol, Number] = {}
    for node in kernel.order:
        if node.op == "input":
            graph, (array, row) = node.graph, node.args
            if array == "parameters":
                if row in active:
                    seeds[node] = graph.input(array, slots + row)
            elif array == "clock":
                if row in MOVES:
                    seeds[node] = graph.input(array, layout.CLOCK + row)
            elif array == "extra" and matrix is not None and row >= matrix:
                continue
            elif not (array == "state" and _decides(tracer, row)):
                seeds[node] = graph.input(array, shift + row)
    smooth = len(kernel.outputs) - (1 if kernel.name.startswith("combine") else BEHIND.get(kernel.name, 0))
    outputs = kernel.outputs[:smooth]
    rows = [*_places(kernel), *(shift + row for row in _places(kernel)[:smooth])]
    return tracer.kernel(kernel.name, (*kernel.outputs, *tangents(outputs, seeds)), rows)


def _decides(tracer: Tracer, row: int) -> bool:
    """Whether a row of a state says which constraints hold: those change at once, or not at all."""
    behind = row - tracer.element * tracer.elements
    augmented = tracer.augmented
    return augmented.first_mask <= behind < augmented.rows - augmented.memory
