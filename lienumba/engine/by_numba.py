"""Runs by the engine "numba" (`lienumba.reference`): from prepared runs to what is kept of them."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from time import thread_time
from typing import Any

import numpy as np

from lienumba.batch.execute import CHUNK_BYTES, Task
from lienumba.batch.integrate import Chunk
from lienumba.engine.programs import selection_of, method_of
from lienumba.engine.results import Piece, Results
from lienumba.groups.state import ELEMENT
from lienumba.integrators.codes import LARGEST_STAGE, QUARTER
from lienumba.integrators.layout import PROJECTIONS
from lienumba.integrators.methods import METHODS
from lienumba.integrators.sizes import Sizes
from lienumba.integrators.tracing.augmented_state import AugmentedState, counted_angles
from lienumba.integrators.tracing.law_states import LawStates
from lienumba.integrators.tracing.observed import said
from lienumba.integrators.tracing.program import Outline
from lienumba.mechanics.elements import quantities
from lienumba.mechanics.mechanism.kinematics import Instant
from lienumba.mechanics.mechanism.model import Model
from lienumba.mechanics.mechanism.model_numbers import map_numbers
from lienumba.mechanics.mechanism.tables import RunNumbers
from lienumba.mechanics.system.kkt import Structure
from lienumba.mechanics.system.output_variables import OUTPUT_VARIABLES, Observation
from lienumba.reference.integrate import Runs
from lienumba.reference.mechanism import CLOSED, IDENTITY, MASS, NONE, PLACES, Method, Records, Run, W
from lienumba.reference.table import Table
from lienumba.scenario.resolve import Scenario
from lienumba.scenario.start.prepare import Prepared

BLOCKS = 8  # of W runs in one task: enough that what is stored costs little beside the steps
WEIGHTS = {"none": NONE, "mass": MASS, "identity": IDENTITY}


def chunks(
    resolved: Scenario,
    portions: Iterable[Prepared],
    workers: int,
    results: Results | None = None,
    begin: Callable[[], None] = lambda: None,
) -> Iterator[Task[Piece]]:
    """The tasks of all portions; begin: called before the first, which compiles what no cache has."""
    begin()
    for prepared in portions:
        results = results or Results(resolved, prepared.nominal)
        work, total = Work.of(resolved, prepared, results), len(prepared.states)
        size = W * min(BLOCKS, max(1, -(-total // (W * workers))), max(1, CHUNK_BYTES // work.bytes_of_block))
        for first in range(0, total, size):
            runs = slice(first, min(first + size, total))
            yield Task(runs.stop - runs.start, len(work.runs.outputs), partial(work.piece, runs))


@dataclass(frozen=True)
class Work:
    """Prepared runs, ready to be integrated; structure: of all rows."""

    resolved: Scenario
    prepared: Prepared
    results: Results
    runs: Runs
    structure: Structure

    @staticmethod
    def of(resolved: Scenario, prepared: Prepared, results: Results) -> "Work":
        model, integrator, projection = prepared.model, resolved.data.integrator, resolved.data.projection
        shaped, selection = method_of(resolved, model), selection_of(resolved, prepared)
        tableau, h = METHODS[shaped.tableau], integrator.step
        assert h is not None, "checked before"
        counted = [x for x in counted_angles(model, prepared.nominal.now) if isinstance(x, int)]
        A = np.zeros((len(tableau.b), len(tableau.b)))
        for row, given in zip(A, tableau.A, strict=True):
            row[: len(given)] = [float(a) for a in given]
        method = Method(
            A, np.array([float(b) for b in tableau.b]), CLOSED if shaped.terms is None else shaped.terms, h,
            NONE if projection.position == "none" else PLACES, WEIGHTS[projection.velocity], projection.tolerance,
            projection.max_iterations, QUARTER**2 if counted else LARGEST_STAGE,
        )  # fmt: skip
        outputs = np.unique([0, *resolved.output_steps])
        angles = {joint: x for joint, x in prepared.angles.items() if isinstance(joint, int)}
        runs = Runs(
            Table.of(model, counted), method, prepared.states, angles, prepared.codes, resolved.steps or 0, outputs,
            selection.dropped,
        )  # fmt: skip
        return Work(resolved, prepared, results, runs, Structure.of(model, selection.rows))

    @property
    def bytes_of_block(self) -> int:
        """Of the records of W runs, about."""
        rows = 2 * ELEMENT * len(self.prepared.model.bodies) + 4 * len(self.runs.table.wanted)
        return 8 * W * len(self.runs.outputs) * rows

    def piece(self, runs: slice, progress: np.ndarray, stop: np.ndarray) -> Piece:
        """Integrate these runs, and take what is kept of them."""
        started, indices = thread_time(), []
        ends: list[tuple[Run, Records]] = []
        for first in range(runs.start, runs.stop, W):
            indices.append(np.minimum(np.arange(first, first + W), runs.stop - 1))
            for end in self.runs.integrate(indices[-1], stop):
                last = end
                done = (len(ends) + last[0].steps.max() / self.runs.steps) * W / (runs.stop - runs.start)
                progress[0] = int(min(done, 1.0) * len(self.runs.outputs))
            ends.append(last)
        records, observed = self._recorded(np.array(indices), [x for _, x in ends])
        chunk = self._chunk(runs, records, [x for x, _ in ends], thread_time() - started)
        return self.results.piece(chunk, self._outline(observed), np.array(self.prepared.labels)[runs])

    def _recorded(
        self, indices: np.ndarray, stored: Sequence[Records]
    ) -> tuple[np.ndarray, dict[str, tuple[int, int]]]:
        """Records (blocks, outputs, rows, W) as `lienumba.batch.records` reads them, and where each variable is."""
        model, k, shape = self.prepared.model, len(self.prepared.model.bodies), (len(stored), len(self.runs.outputs), W)
        every = {
            name: np.moveaxis(np.array([getattr(x, name) for x in stored]), -2, 0)
            for name in ("states", "near", "accelerations", "multipliers", "iterations")
        }  # each: rows, blocks, outputs, W
        states, work = every["states"][: ELEMENT * k], np.array([x.work for x in stored])[None]
        times = np.broadcast_to((self.runs.outputs * self.runs.method.h)[:, None], shape)
        runs = np.broadcast_to(indices[:, None], shape).reshape(-1)
        flat = {name: list(x.reshape(len(x), -1)) for name, x in every.items()}
        bodies = tuple(tuple(flat["states"][ELEMENT * i : ELEMENT * (i + 1)]) for i in range(k))
        angles = {joint: flat["near"][n] for joint, n in self.runs.table.angles.items()}
        now, of_runs = Instant(bodies, times.reshape(-1), angles), _of_runs(model, runs)
        with np.errstate(all="ignore"):  # runs that have ended are NaN
            named = self._observed(of_runs, now, flat["accelerations"], flat["multipliers"])
        observed, rows = {}, []
        for name, numbers in named.items():
            observed[name] = (len(rows), len(numbers))
            rows += [np.broadcast_to(np.asarray(x, float), (runs.size,)).reshape(shape) for x in numbers]
        seen = np.where(np.isnan(states[0]), np.nan, np.array(rows).reshape(len(rows), *shape))
        found = np.concatenate([states, work, seen, every["iterations"]])
        return np.ascontiguousarray(np.moveaxis(found, 0, -2)), observed

    def _observed(
        self, model: Model, now: Instant, accelerations: list[Any], multipliers: list[Any]
    ) -> dict[str, list[Any]]:
        """The numbers of every variable that is computed where a state is stored."""
        seen = Observation(model, now, lambda: said(self.structure, model, now, accelerations, multipliers))
        reactions = method_of(self.resolved, model).reactions
        named = {
            name: list(x.rows(seen))
            for name, x in OUTPUT_VARIABLES.items()
            if x.rows is not None and (reactions or not x.reaction)
        }
        return named | dict(quantities.observe(model, now, seen.observed))

    def _outline(self, observed: dict[str, tuple[int, int]]) -> Outline:
        k, rows = len(self.prepared.model.bodies), sum(count for _, count in observed.values())
        sizes = Sizes(k, 1, 1, 0, 0, 12, len(self.runs.method.b), 0, 0, 0, observed=rows)
        augmented = AugmentedState((), True, 0, (), {})
        return Outline(sizes, augmented, LawStates({}), (), observed, False, (), (), ())

    def _chunk(self, runs: slice, records: np.ndarray, ends: Sequence[Run], seconds: float) -> Chunk:
        """The finished runs, as other engines leave them."""
        count, blocks, k = runs.stop - runs.start, len(ends), len(self.prepared.model.bodies)
        codes, steps, work = (np.concatenate([getattr(x, name) for x in ends])[:count] for name in ("code", "steps", "work"))
        states = np.concatenate([x.x.T for x in ends])[:count, : ELEMENT * k]
        h, end = self.runs.method.h, self.resolved.data.integrator.end_time
        none = np.full((count, 0), np.nan)
        rests = np.zeros(count, np.int8) if self.prepared.rests is None else self.prepared.rests[runs]
        return Chunk(
            runs, records, None, np.full((blocks, W), np.nan), np.column_stack([states, work]), codes.astype(np.int8),
            np.where(steps == self.runs.steps, end, steps * h), steps.astype(np.int64), np.zeros(count, np.int64),
            none, none, None, none, np.zeros((count, 0, 5)), np.zeros(count), np.zeros(count), np.zeros((count, 0, 2)),
            rests, seconds,
        )  # fmt: skip


def _of_runs(model: Model, runs: np.ndarray) -> Model:
    """The model with the numbers of these runs (indices)."""

    def part(x: Any) -> Any:
        return x.part(runs) if isinstance(x, RunNumbers) else x

    return map_numbers(model, lambda x, _: x[runs] if np.ndim(x) else x, part)


assert PROJECTIONS == 2, "the iterations of both are behind a record"
