"""The multiply-add peak of one core, with the engine's own vector type."""

from typing import Any

from bench.clock import Spent, Stopwatch
from lienumba.compiler.flat import compiled
from lienumba.compiler.lanes import fma, splat, store
from lienumba.compiler.routines.marks import inlined
from lienumba.compiler.rows import W
from lienumba.integrators.tracing.machine import aligned

PER_TURN = 8  # multiply-adds of each chain in one turn of the loop


@inlined
def _advance(x: Any, a: Any, b: Any) -> Any:
    """Four independent chains, one multiply-add each."""
    return fma(x[0], a, b), fma(x[1], a, b), fma(x[2], a, b), fma(x[3], a, b)


def _four(out: int, turns: int) -> None:
    a, b = splat(0.999), splat(0.001)
    p = (splat(0.1), splat(0.2), splat(0.3), splat(0.4))
    for _ in range(turns):
        for _ in range(PER_TURN):
            p = _advance(p, a, b)
    store(out, 0, (p[0] + p[1]) + (p[2] + p[3]))


def _six(out: int, turns: int) -> None:
    a, b = splat(0.999), splat(0.001)
    p = (splat(0.1), splat(0.2), splat(0.3), splat(0.4))
    q, r = splat(0.5), splat(0.6)
    for _ in range(turns):
        for _ in range(PER_TURN):
            p, q, r = _advance(p, a, b), fma(q, a, b), fma(r, a, b)
    store(out, 0, ((p[0] + p[1]) + (p[2] + p[3])) + (q + r))


def _eight(out: int, turns: int) -> None:
    a, b = splat(0.999), splat(0.001)
    p = (splat(0.1), splat(0.2), splat(0.3), splat(0.4))
    q = (splat(0.5), splat(0.6), splat(0.7), splat(0.8))
    for _ in range(turns):
        for _ in range(PER_TURN):
            p, q = _advance(p, a, b), _advance(q, a, b)
    store(out, 0, ((p[0] + p[1]) + (p[2] + p[3])) + ((q[0] + q[1]) + (q[2] + q[3])))


def _sixteen(out: int, turns: int) -> None:
    a, b = splat(0.999), splat(0.001)
    p = (splat(0.1), splat(0.2), splat(0.3), splat(0.4))
    q = (splat(0.5), splat(0.6), splat(0.7), splat(0.8))
    r = (splat(0.15), splat(0.25), splat(0.35), splat(0.45))
    s = (splat(0.55), splat(0.65), splat(0.75), splat(0.85))
    for _ in range(turns):
        for _ in range(PER_TURN):
            p, q, r, s = _advance(p, a, b), _advance(q, a, b), _advance(r, a, b), _advance(s, a, b)
    total = ((p[0] + p[1]) + (p[2] + p[3])) + ((q[0] + q[1]) + (q[2] + q[3]))
    store(out, 0, total + ((r[0] + r[1]) + (r[2] + r[3])) + ((s[0] + s[1]) + (s[2] + s[3])))


CHAINS = {4: _four, 6: _six, 8: _eight, 16: _sixteen}  # more chains hide the latency, until the registers run out


def of_a_flop(turns: int) -> Spent:
    """The least over the numbers of chains, s; a multiply-add counts as two."""
    out, found = aligned(1, W), []
    for chains, routine in CHAINS.items():
        spin = compiled(routine)
        spin(out.ctypes.data, 1)
        watch = Stopwatch()
        spin(out.ctypes.data, turns)
        flops = 2 * W * PER_TURN * chains * turns
        found.append(Spent(*(seconds / flops for seconds in watch.spent())))
    return min(found, key=lambda spent: spent.core)
