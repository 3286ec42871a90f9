"""Runs by the engine "numba" (`lienumba.reference`): from prepared runs to what is kept of them."""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from functools import partial
from time import thread_time

import numpy as np

from lienumba.batch.execute import CHUNK_BYTES, Task
from lienumba.batch.integrate import Chunk
from lienumba.engine.reference.records import observer, outline_of, records_of
from lienumba.engine.results import Piece, Results
from lienumba.groups.state import ELEMENT
from lienumba.integrators.codes import LARGEST_STAGE, QUARTER
from lienumba.integrators.methods import METHODS
from lienumba.integrators.tracing.augmented_state import counted_angles
from lienumba.integrators.tracing.method import Method as Shape
from lienumba.integrators.tracing.row_selection import RowSelection
from lienumba.mechanics.system.kkt import Structure
from lienumba.reference.compiling import is_kept
from lienumba.reference.integrate import Runs
from lienumba.reference.mechanism import CLOSED, IDENTITY, MASS, NONE, PLACES, Method, Run
from lienumba.reference.step import march
from lienumba.reference.table import Table
from lienumba.scenario.resolve import Scenario
from lienumba.scenario.start.prepare import Prepared
from lienumba.scenario.start.stored_start import start_numbers

TOGETHER = 64  # runs in one task: enough for vector instructions, and few enough that their matrices stay in caches
POSITION_WEIGHTS = {"none": NONE, "local": PLACES}
VELOCITY_WEIGHTS = {"none": NONE, "mass": MASS, "identity": IDENTITY}


def chunks(
    results: Results,
    portions: Iterable[tuple[Prepared, Shape, RowSelection]],
    workers: int,
    begin: Callable[[], None] = lambda: None,
) -> Iterator[Task[Piece]]:
    """The tasks of all portions, each with its method and its rows; begin: called where the first compiles, because no
    cache has it."""
    if not is_kept(march):
        begin()
    for prepared, shape, selection in portions:
        work, total = _Work.of(prepared, shape, selection, results), len(prepared.states)
        size = max(1, min(TOGETHER, -(-total // workers), CHUNK_BYTES // work.bytes_of_run))
        for first in range(0, total, size):
            runs = slice(first, min(first + size, total))
            yield Task(runs.stop - runs.start, len(work.runs.outputs), partial(work.piece, runs))


@dataclass(frozen=True)
class _Work:
    """Prepared runs, ready to be integrated."""

    prepared: Prepared
    shape: Shape
    selection: RowSelection
    results: Results
    runs: Runs

    @staticmethod
    def of(prepared: Prepared, shape: Shape, selection: RowSelection, results: Results) -> "_Work":
        resolved = results.resolved
        counted = [x for x in counted_angles(prepared.model, prepared.nominal.now) if isinstance(x, int)]
        angles = {joint: x for joint, x in prepared.angles.items() if isinstance(joint, int)}
        runs = Runs(
            Table.of(prepared.model, counted), _method(resolved, shape, bool(counted)), prepared.states, angles,
            prepared.codes, resolved.steps or 0, np.unique([0, *resolved.output_steps]),
            selection.dropped,
        )  # fmt: skip
        return _Work(prepared, shape, selection, results, runs)

    @property
    def bytes_of_run(self) -> int:
        """Of the records of a run, about."""
        rows = 2 * ELEMENT * len(self.prepared.model.bodies) + 4 * len(self.runs.table.wanted)
        return 8 * len(self.runs.outputs) * rows

    def piece(self, runs: slice, progress: np.ndarray, stop: np.ndarray) -> Piece:
        """Integrate these runs, and take what is kept of them; see `Task` for progress and stop."""
        started, indices, model = thread_time(), np.arange(runs.start, runs.stop), self.prepared.model
        for end in self.runs.integrate(indices, stop):
            progress[0] = end[0].steps.max() * len(self.runs.outputs) // self.runs.steps
        run, stored = end
        rows = Structure.of(model, self.selection.rows)
        observe = observer(rows, self.shape.reactions)
        records, observed = records_of(model, indices, stored, self.runs.method.h, self.runs.table.angles, observe)
        chunk = self._chunk(runs, records, run, thread_time() - started)
        outline = outline_of(len(model.bodies), len(self.runs.method.b), observed)
        return self.results.piece(chunk, outline, np.array(self.prepared.labels)[runs])

    def _chunk(self, runs: slice, records: np.ndarray, run: Run, seconds: float) -> Chunk:
        """The finished runs, which know neither events nor changes."""
        count, end, rests = runs.stop - runs.start, self.results.resolved.data.integrator.end_time, self.prepared.rests
        states = np.column_stack([run.x[:-ELEMENT].T, run.work])
        times = np.where(run.steps == self.runs.steps, end, run.steps * self.runs.method.h)
        none, zero = np.full((count, 0), np.nan), np.zeros(count)
        return Chunk(
            runs, records, None, np.full((1, count), np.nan), states, run.code.astype(np.int8), times, run.steps,
            np.zeros(count, np.int64), none, none, None, none, np.zeros((count, 0, 5)), zero, zero,
            np.zeros((count, 0, 2)), np.zeros(count, np.int8) if rests is None else rests[runs],
            start_numbers(self.prepared)[runs], seconds,
        )  # fmt: skip


def _method(resolved: Scenario, shape: Shape, counts: bool) -> Method:
    """The method as arrays; counts: whether turns of a joint are counted, so that a step must be short."""
    integrator, projection = resolved.data.integrator, resolved.data.projection
    tableau, terms = METHODS[shape.tableau], shape.terms
    A = np.zeros((len(tableau.b), len(tableau.b)))
    for row, given in zip(A, tableau.A, strict=True):
        row[: len(given)] = [float(a) for a in given]
    assert integrator.step is not None, "adaptive steps are refused"
    return Method(
        A, np.array([float(b) for b in tableau.b]), CLOSED if terms is None else terms, integrator.step,
        POSITION_WEIGHTS[projection.position], VELOCITY_WEIGHTS[projection.velocity], projection.tolerance,
        projection.max_iterations, QUARTER**2 if counts else LARGEST_STAGE,
    )  # fmt: skip
