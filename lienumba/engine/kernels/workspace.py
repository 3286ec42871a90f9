"""The head of a workspace, which the functions of `lienumba.kernels` read."""

from collections.abc import Mapping

import numpy as np

from lienumba import kernels as f
from lienumba.compiler.flat import Flat
from lienumba.compiler.rows import ROW, W
from lienumba.integrators import layout
from lienumba.integrators.tracing.evaluating.kernels import Evaluating
from lienumba.integrators.tracing.machine import Machine
from lienumba.scenario.schema.scenario import Projection


def write(
    workspace: np.ndarray, machine: Machine, evaluating: Evaluating, projection: Projection,
    routines: Mapping[str, Flat], prepares: np.ndarray,
) -> None:  # fmt: skip
    """Write what is known of the mechanism, and the arguments of routines; prepares: addresses of functions that fill
    hoisted rows, which have to stay where they are."""
    regions, buffer = layout.workspace(machine.sizes), workspace[f.HEAD :].ctypes.data
    at = layout.Workspace(*(buffer + ROW * row for row in regions))
    block = (0, 0, 0.0, 0.0, 0.0)  # is written at each call
    step = routines["step"].packed(
        block, machine.kernels, machine.nodes, machine.sizes, at, projection.max_iterations, projection.tolerance
    )
    evaluate = routines["evaluate"].packed(0, 0, 0, 0, at.clock, at.work, 0.0)
    head = workspace.view(np.int64)
    for place, numbers in ((f.STEP, step[0]), (f.EVALUATE, evaluate[0])):
        head[place : place + len(numbers)] = numbers
    prepare, _ = routines["prepare"].packed(0, prepares, at.work)
    head[f.PREPARE : f.PREPARE + len(prepare)] = prepare
    workspace[f.STEP_FLOATS : f.STEP_FLOATS + len(step[1])] = step[1]
    rows, addresses = evaluating.rows, evaluating.addresses
    facts = {
        f.SEAL: f.KNOWN, f.STATE_ROWS: layout.state_rows(machine.sizes), f.PARAMETER_ROWS: evaluating.parameters,
        f.RHS_ROWS: rows["rhs"], f.EQUATION_ROWS: rows["equations"], f.OBSERVED_ROWS: rows.get("observe", 0),
        f.STEPS: routines["step"].address, f.EVALUATES: routines["evaluate"].address,
        f.PREPARES: routines["prepare"].address, f.RHS: addresses["rhs"], f.EQUATIONS: addresses["equations"],
        f.OBSERVE: addresses.get("observe", 0), f.CODES: f.HEAD + W * (regions.lanes + layout.STATUS),
    }  # fmt: skip
    for place, fact in facts.items():
        head[place] = fact
