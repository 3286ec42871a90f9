"""The derivatives of the runs of a chunk: what they went through is noted, and followed once more with tangents."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from lienumba.batch.integrate import Batch
from lienumba.batch.tangents.changes import MISSING
from lienumba.batch.tangents.follow import EVENT, SIGNAL, Crossing, Follower, Found, Look, Trodden
from lienumba.batch.tangents.marcher import Marcher, Start
from lienumba.batch.tangents.parts import in_parts
from lienumba.compiler.rows import W
from lienumba.engine.sensitivities.noting import Noted, noted
from lienumba.engine.sensitivities.seeds import starts_of
from lienumba.integrators.drivers.trail import HEAD, STEPS
from lienumba.integrators.tracing.machine import aligned
from lienumba.integrators.tracing.tangents.jumps import JUMP, NOTHING, Jumps, Where
from lienumba.integrators.tracing.tangents.kernels import Asked, compiled
from lienumba.mechanics.elements.quantities import kept
from lienumba.mechanics.mechanism.model import NONE, Model
from lienumba.scenario.resolve import Scenario
from lienumba.scenario.start.prepare import Nominal

TOGETHER = 1e-6  # of a step: what turns within it turns at once


@dataclass(frozen=True)
class Tangents:
    """Derivatives of runs by inputs: records (runs, outputs + 1, rows, inputs), the last one of where runs ended;
    event_times (runs, events, inputs), event_rates (runs, events), signals (runs, kept, inputs); flags (runs,);
    observed: what of records is where, as in `Outline`."""

    records: np.ndarray
    event_times: np.ndarray
    event_rates: np.ndarray
    signals: np.ndarray
    flags: np.ndarray
    observed: dict[str, tuple[int, int]]


def differentiate(
    resolved: Scenario, labels: Sequence[int], samples: Mapping[str, np.ndarray], by: Sequence[str], nominal: Nominal,
    variables: frozenset[str], wanted: np.ndarray, fixed: bool = True,
) -> Tangents:  # fmt: skip
    """The derivatives of these runs by these inputs; samples (runs,): of all that varies, and of the inputs; variables:
    of which some are wanted; wanted (runs,): which runs have some, NaN else."""
    starts = starts_of(resolved, labels, samples, by, nominal, fixed)
    model, batch = starts.prepared.model, starts.batch
    asked = Asked(starts.active, variables)
    machine = compiled(model, starts.method, starts.selection, fixed, asked)
    marcher, found = Marcher(machine, batch.iterations, batch.tolerance), []
    good, states = starts.good & wanted, bool(machine.instead or machine.jumps.comparisons or kept(model))
    for first in range(0, len(labels), W):
        group = [run for run in range(first, min(first + W, len(labels))) if good[run]]
        ways = iter(noted(batch.part(np.array(group, int)), [starts.starts[run].jumps for run in group], states))
        for run in range(first, min(first + W, len(labels))):
            here = good[run]
            found.append(_of_run(batch, next(ways), model, starts.starts[run], marcher, len(by)) if here else None)
    events, records = len(model.events), len(kept(model))
    shapes = (len(batch.outputs) + 1, marcher.record_rows), (events,), (records,)
    records_, times, signals = (np.full((*shape, len(by)), np.nan) for shape in shapes)
    none = Found(records_, times, signals, np.full(events, np.nan), MISSING)
    every = [none if x is None else x for x in found]
    return Tangents(
        np.stack([x.records for x in every]), np.stack([x.times for x in every]), np.stack([x.rates for x in every]),
        np.stack([x.signals for x in every]), np.array([x.flags for x in every], np.int64), machine.observed,
    )  # fmt: skip


def _of_run(batch: Batch, way: Noted, model: Model, start: Start, marcher: Marcher, inputs: int) -> Found:
    """Of one run of a batch, by packs of inputs."""
    trodden, looks, signals = _trodden(batch, way, model, start, marcher.machine.jumps)
    if marcher.machine.instead:
        trodden = in_parts(trodden, marcher, marcher.begin(start, slice(0, 0)))
    found, events = [], len(model.events)
    outputs = batch.outputs if batch.h is None else np.rint(batch.outputs / batch.h) * batch.h  # as drivers have them
    for first in range(0, max(inputs, 1), W):
        pack = slice(first, first + W)
        own = Found(
            aligned(len(batch.outputs) + 1, marcher.record_rows, W), np.full((events, W), np.nan),
            np.full((len(signals), W), np.nan), np.full(events, np.nan),
        )  # fmt: skip
        own.records[:] = np.nan
        moving = np.zeros((len(start.jumps), W))
        moving[:, : start.jump_tangents[:, pack].shape[1]] = start.jump_tangents[:, pack]
        run = trodden._replace(jump_tangents=moving)
        follower = Follower(marcher, marcher.begin(start, pack), outputs, list(looks), run, own, signals)
        found.append(follower.follow())

    def joined(parts: list[np.ndarray]) -> np.ndarray:
        return np.concatenate(parts, axis=-1)[..., :inputs]

    records, times, values = (joined([getattr(x, name) for x in found]) for name in ("records", "times", "signals"))
    flags = int(np.bitwise_or.reduce([x.flags for x in found]))
    return Found(records, times, values, found[0].rates, flags)


def _trodden(
    batch: Batch, way: Noted, model: Model, start: Start, jumps: Jumps
) -> tuple[Trodden, list[Look], list[int]]:
    """What a run goes through, and what is looked at on the way."""
    looks = [Look(float(t), EVENT, n) for n, t in enumerate(way.event_times) if t == t]
    records, names = kept(model), [event.name for event in model.events]
    for n, x in enumerate(records):
        value, t = (float(x) for x in way.kept[n, :2])
        if (x.condition == NONE or x.event) and x.value != NONE and np.isfinite(t):
            event = names.index(x.event) if x.event else NONE
            looks.append(Look(t, SIGNAL, n, value, event))
    asked = [max(x.value, 0) for x in records]
    looks.sort()
    crossings = _crossings(jumps, start, way.entries)
    return Trodden(way.entries, start.jumps, start.jump_tangents, batch.plan, crossings), looks, asked


def _crossings(jumps: Jumps, start: Start, entries: np.ndarray) -> dict[int, list[Crossing]]:
    """The steps in which forces bend or jump as the state changes."""
    if not jumps.comparisons or not len(entries):
        return {}
    after = entries[:, HEAD : HEAD + len(start.state)]
    before = np.concatenate([start.state[None], after[:-1]])
    steps = np.flatnonzero(entries[:, 0] == STEPS)
    begin, end = (
        jumps.holding(x[steps], start.parameters, t[steps])
        for x, t in ((before, entries[:, 1]), (after, entries[:, 2]))
    )
    found: dict[int, list[Crossing]] = {}
    for column in np.flatnonzero((begin != end).any(axis=0)):
        k = int(steps[column])
        ends = Where(before[k], start.parameters, entries[k, 1]), Where(after[k], start.parameters, entries[k, 2])
        turned = {int(n): jumps.place(int(n), *ends) for n in np.flatnonzero(begin[:, column] != end[:, column])}
        places = sorted({round(part / TOGETHER) for part, what in turned.values() if what != NOTHING})
        for place in places:
            together = {n: x for n, x in turned.items() if abs(x[0] / TOGETHER - place) <= 1.0}
            leaps = any(what == JUMP for _, what in together.values())
            part = min(part for part, _ in together.values())
            found.setdefault(k, []).append(Crossing(jumps, tuple(together), part, leaps))
    return found
