"""Functions with which code under Numba's `@njit` steps and evaluates a compiled mechanism.

They are the same for all mechanisms: addresses are in the workspace, an argument. So code that calls them may be cached
(`cache=True`), and another process may call it for another mechanism. `lienumba.Kernels` makes their arguments.
"""

import hashlib
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numba import njit, types
from numba.extending import intrinsic

from lienumba.compiler.rows import W

# The head of a workspace: regions of int64, or of float64. In FACTS: what shows that it is one, rows of arrays,
# addresses of routines and of kernels, and in which row the codes of a step are. In the others: arguments of the
# routines of `lienumba.integrators.drivers.single_step`, as `lienumba.compiler.flat` packs them.
REGION = 64
FACTS, STEP, STEP_FLOATS, EVALUATE, EVALUATE_FLOATS, PREPARE, HEAD = range(0, 7 * REGION, REGION)
(
    SEAL, STATE_ROWS, PARAMETER_ROWS, RHS_ROWS, EQUATION_ROWS, OBSERVED_ROWS, STEPS, EVALUATES, PREPARES, RHS,
    EQUATIONS, OBSERVE, CODES,
) = range(13)  # fmt: skip
KNOWN = int.from_bytes(hashlib.sha256(Path(__file__).read_bytes()).digest()[:7])  # of this version of the head
OTHER_SHAPE, OTHER_KIND = -1, -2  # instead of the length of what is no array of that shape, or no such array


class RightHandSide(NamedTuple):
    """What `rhs` fills, for a mechanism of k bodies and m rows of C.

    The last dimension is that of the runs of a block.

    Parameters
    ----------
    rows : ndarray (6 k + m + n, 8)
        All numbers; the others are views of it.
    a : ndarray (6 k, 8)
        Of each body the acceleration of its mass centre (m/s^2, global) and its angular acceleration (rad/s^2, body
        frame).
    multipliers : ndarray (m, 8)
        lambda of every row of C (N, or N m).
    rates : ndarray (n, 8)
        With joint coordinates the accelerations of the n moves, in the order of their rates in a state.
    """

    rows: np.ndarray
    a: np.ndarray
    multipliers: np.ndarray
    rates: np.ndarray


class Equations(NamedTuple):
    """What `equations` fills, for a mechanism of k bodies and m rows of C.

    M a + C^T lambda = Q and C a = xi, with a as in `RightHandSide`. The last dimension is that of the runs of a block.

    Parameters
    ----------
    rows : ndarray (36 k k + 6 k m + 6 k + m, 8)
        All numbers; the others are views of it.
    M : ndarray (6 k, 6 k, 8)
        The mass matrix (kg, kg m^2).
    C : ndarray (m, 6 k, 8)
        The Jacobian of the constraints.
    Q : ndarray (6 k, 8)
        The loads of each body: force (N, global) and torque (N m, body frame), with weight and gyroscopic torque.
    xi : ndarray (m, 8)
        The right-hand side of the accelerations.
    """

    rows: np.ndarray
    M: np.ndarray
    C: np.ndarray
    Q: np.ndarray
    xi: np.ndarray


@intrinsic
def _call(typing: Any, routine: Any, whole: Any, floats: Any) -> Any:
    """Call the routine at an address with the addresses of its packed arguments."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        from llvmlite import ir

        number = ir.IntType(64)
        kind = ir.FunctionType(ir.VoidType(), [number, number])
        builder.call(builder.inttoptr(arguments[0], kind.as_pointer()), arguments[1:])
        return context.get_dummy_value()

    return types.void(types.int64, types.int64, types.int64), code


@intrinsic
def _address(typing: Any, x: Any) -> Any:
    """The address of an array's first number; 0 of what is no contiguous array of float64."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        number = context.get_value_type(types.int64)
        if not _is_contiguous(x):
            return number(0)
        return builder.ptrtoint(context.make_array(x)(context, builder, arguments[0]).data, number)

    return types.int64(x), code


@intrinsic
def _size(typing: Any, x: Any) -> Any:
    """The length of an array of one dimension; OTHER_SHAPE or OTHER_KIND of anything else."""
    return types.int64(x), _length(x, 1)


@intrinsic
def _rows(typing: Any, x: Any) -> Any:
    """The rows of an array (rows, 8); OTHER_SHAPE or OTHER_KIND of anything else."""
    return types.int64(x), _length(x, 2)


def _length(x: Any, dimensions: int) -> Any:
    """The code for the length of the first of so many dimensions, of which a second one is that of 8 runs."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        number = context.get_value_type(types.int64)
        if not _is_contiguous(x) or x.ndim != dimensions:
            return number(OTHER_SHAPE if _is_contiguous(x) else OTHER_KIND)
        shape = context.make_array(x)(context, builder, arguments[0]).shape
        length = builder.extract_value(shape, 0)
        if dimensions == 1:
            return length
        fits = builder.icmp_signed("==", builder.extract_value(shape, 1), number(W))
        return builder.select(fits, length, number(OTHER_SHAPE))

    return code


def _is_contiguous(x: Any) -> bool:
    """Whether a type of Numba's is a contiguous array of float64."""
    return isinstance(x, types.Array) and x.dtype == types.float64 and x.layout == "C"


@intrinsic
def _get(typing: Any, base: Any, place: Any) -> Any:
    """A whole number of the head at an address: views of arrays would be counted references, which cost more."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return builder.load(_pointer(builder, arguments, context.get_value_type(types.int64)))

    return types.int64(types.int64, types.int64), code


@intrinsic
def _put(typing: Any, base: Any, place: Any, value: Any) -> Any:
    """Write a number into the head at an address."""
    kind = types.float64 if isinstance(value, types.Float) else types.int64

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        builder.store(arguments[2], _pointer(builder, arguments, context.get_value_type(kind)))
        return context.get_dummy_value()

    return types.void(types.int64, types.int64, kind), code


def _pointer(builder: Any, arguments: Any, kind: Any) -> Any:
    """To the number at a place behind an address."""
    return builder.gep(builder.inttoptr(arguments[0], kind.as_pointer()), [arguments[1]])


@njit(error_model="numpy", forceinline=True)
def _head(base: int, size: int) -> int:
    """The address of a workspace. Functions pass on addresses only: arrays are counted references, and count at each
    call."""
    if size < HEAD or _get(base, SEAL) != KNOWN:
        raise ValueError(
            "workspace: was not made by this version of lienumba; take Kernels.workspace(), and delete caches of Numba"
        )
    return base


@njit(error_model="numpy", forceinline=True)
def _block(address: int, rows: int, needed: int) -> int:
    """The address of an array of a block."""
    if rows != needed:
        if rows == OTHER_KIND:
            raise ValueError("state, parameters, out: must be contiguous arrays of float64; give such as states[block]")
        raise ValueError(
            "state, parameters, out: must have the dimensions (rows, 8), with the rows of this mechanism; give one "
            "block of its arrays, such as states[block]"
        )
    return address


@njit(error_model="numpy", forceinline=True)
def _evaluate(base: int, state: Any, parameters: Any, t: float, which: int, rows: int, out: Any) -> None:
    """Fill an array that has as many rows as the head of the workspace says at `rows`."""
    _put(base, EVALUATE, _block(_address(state), _rows(state), _get(base, STATE_ROWS)))
    _put(base, EVALUATE + 1, _block(_address(parameters), _rows(parameters), _get(base, PARAMETER_ROWS)))
    _put(base, EVALUATE + 2, _block(_address(out), _rows(out), _get(base, rows)))
    _put(base, EVALUATE + 3, _get(base, which))
    _put(base, EVALUATE_FLOATS, float(t))
    _call(_get(base, EVALUATES), base + 8 * EVALUATE, base + 8 * EVALUATE_FLOATS)


@njit(error_model="numpy", forceinline=True)
def step(workspace: Any, state: Any, parameters: Any, t: float, h: float) -> int:
    """Advance a block of 8 runs by one step, with the projections of the scenario.

    Loops over n with t = n*h give the bits of `lienumba.run`.

    Parameters
    ----------
    workspace : ndarray
        Of `Kernels.workspace`; each thread needs its own.
    state : ndarray (rows, 8)
        The state of each run, which is replaced by that after the step.
    parameters : ndarray (rows, 8)
        The parameters of each run.
    t : float
        The time at which the step begins (s).
    h : float
        Its length (s).

    Returns
    -------
    int
        0, or a number with bit n set where the step of run n of the block has failed. Such a run keeps its state.

    Raises
    ------
    ValueError
        If the workspace or an array is not of this mechanism.
    """
    base, n = _head(_address(workspace), _size(workspace)), np.rint(t / h)
    _put(base, STEP, _block(_address(state), _rows(state), _get(base, STATE_ROWS)))
    _put(base, STEP + 1, _block(_address(parameters), _rows(parameters), _get(base, PARAMETER_ROWS)))
    _put(base, STEP_FLOATS, float(t))
    _put(base, STEP_FLOATS + 1, float(h))
    _put(base, STEP_FLOATS + 2, (n + 1.0) * h if n * h == t else t + h)
    _call(_get(base, STEPS), base + 8 * STEP, base + 8 * STEP_FLOATS)
    codes, some = _get(base, CODES), 0
    for lane in range(W):
        some |= _get(base, codes + lane)  # the bits of a double, which are 0 where the code is
    failed = 0
    if some != 0:
        for lane in range(W):
            failed |= (_get(base, codes + lane) != 0) << lane
    return failed


@njit(error_model="numpy", forceinline=True)
def rhs(workspace: Any, state: Any, parameters: Any, t: float, out: RightHandSide) -> None:
    """Evaluate accelerations and multipliers of a block of 8 runs.

    Parameters
    ----------
    workspace, state, parameters, t
        As of `step`; the state stays as it is.
    out : RightHandSide
        Of `Kernels.right_hand_side`, which is filled.

    Raises
    ------
    ValueError
        If the workspace or an array is not of this mechanism.
    """
    _evaluate(_head(_address(workspace), _size(workspace)), state, parameters, t, RHS, RHS_ROWS, out.rows)


@njit(error_model="numpy", forceinline=True)
def equations(workspace: Any, state: Any, parameters: Any, t: float, out: Equations) -> None:
    """Evaluate M, C, Q and xi of a block of 8 runs.

    Parameters
    ----------
    workspace, state, parameters, t
        As of `step`; the state stays as it is.
    out : Equations
        Of `Kernels.equation_arrays`, which is filled.

    Raises
    ------
    ValueError
        If the workspace or an array is not of this mechanism.
    """
    _evaluate(_head(_address(workspace), _size(workspace)), state, parameters, t, EQUATIONS, EQUATION_ROWS, out.rows)


@njit(error_model="numpy", forceinline=True)
def observe(workspace: Any, state: Any, parameters: Any, t: float, out: Any) -> None:
    """Evaluate the output variables that `Prepared.kernels` was asked for, of a block of 8 runs.

    Parameters
    ----------
    workspace, state, parameters, t
        As of `step`; the state stays as it is.
    out : ndarray (names, 8)
        One row for each name, which is filled.

    Raises
    ------
    ValueError
        If the workspace or an array is not of this mechanism.
    """
    base = _head(_address(workspace), _size(workspace))
    if _get(base, OBSERVE) == 0:
        raise ValueError("observe: was asked for nothing; name variables when you make the kernels")
    _evaluate(base, state, parameters, t, OBSERVE, OBSERVED_ROWS, out)


@njit(error_model="numpy", forceinline=True)
def prepare(workspace: Any, parameters: Any) -> None:
    """Compute what depends on parameters alone; to be called after a row of them has changed.

    Parameters
    ----------
    workspace : ndarray
        As of `step`.
    parameters : ndarray (rows, 8)
        The parameters of a block, whose last rows are filled.

    Raises
    ------
    ValueError
        If the workspace or the array is not of this mechanism.
    """
    base = _head(_address(workspace), _size(workspace))
    _put(base, PREPARE, _block(_address(parameters), _rows(parameters), _get(base, PARAMETER_ROWS)))
    _call(_get(base, PREPARES), base + 8 * PREPARE, 0)
