"""A prepared scenario as functions for code under Numba's `@njit`: their arguments, and which row is what."""

import ctypes
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from lienumba import kernels as functions
from lienumba.batch.integrate import begin
from lienumba.batch.statuses import SUCCESS
from lienumba.compiler.flat import Flat, kept
from lienumba.compiler.rows import W
from lienumba.engine.kernels import rows, workspace
from lienumba.engine.programs import batch_of, compiled_of, method_of, selection_of
from lienumba.engine.results import Results
from lienumba.errors import ScenarioError
from lienumba.integrators import layout
from lienumba.integrators.tracing.evaluating.kernels import compiled
from lienumba.integrators.tracing.machine import ALIGNMENT, aligned
from lienumba.integrators.tracing.template import leaves, split
from lienumba.kernels import Equations, RightHandSide
from lienumba.mechanics.mechanism.tables import Numbers
from lienumba.scenario.resolve import Scenario
from lienumba.scenario.start.prepare import Nominal, Prepared, prepare

ROUTINES = "lienumba.integrators.drivers.single_step"
Chosen = Callable[..., tuple[Scenario, Sequence[int], Nominal]]  # see `engine.prepared.Prepared`


class Blocks(NamedTuple):
    """Runs as functions take them, 8 to a block: states and parameters (blocks, rows, 8). Behind the last run it is
    repeated."""

    states: np.ndarray
    parameters: np.ndarray


class Kernels:
    """A mechanism as functions that code under `@njit` calls; made by `Prepared.kernels`.

    A block is 8 runs; an array of a block has the dimensions (rows, 8). Bodies have the order of the model.

    Parameters
    ----------
    resolved : Scenario
        What was prepared.
    nominal : Nominal
        Where it starts.
    chosen : callable
        Which gives a scenario with other numbers.
    observe : sequence of str
        See `Prepared.kernels`.

    Attributes
    ----------
    state_rows : int
        Rows of the state of a block.
    observed : tuple of str
        What the rows are that `observe` fills.
    """

    step, rhs, equations = map(staticmethod, (functions.step, functions.rhs, functions.equations))
    observe, prepare = staticmethod(functions.observe), staticmethod(functions.prepare)

    def __init__(self, resolved: Scenario, nominal: Nominal, chosen: Chosen, observe: Sequence[str]) -> None:
        self._resolved, self._chosen = resolved, chosen
        self._first = first = prepare(resolved, list(resolved.labels[:1]), nominal=nominal)
        self._outline, self._machine = compiled_of(resolved, first, True)
        wanted = rows.wanted(Results(resolved, nominal), self._outline.observed, observe)
        self._evaluating = compiled(
            first.model, method_of(resolved, first.model), selection_of(resolved, first), wanted,
            self._machine.sizes.parameters,
        )  # fmt: skip
        self._shape = self._shape_of(resolved, first)
        self._routines: dict[str, Flat] = {name: kept(ROUTINES, name) for name in ("step", "evaluate", "prepare")}
        self._hoisting = np.array(self._evaluating.prepares, np.int64)
        self._prepares = np.array([*self._machine.prepares, *self._hoisting], np.int64)
        self.state_rows, self.observed = layout.state_rows(self._machine.sizes), tuple(observe)
        self._tables: dict[bytes, Numbers] = {}  # of which parameters have the addresses, each once

    def start(
        self,
        parameters: Mapping[str, Any] | None = None,
        *,
        samples: Any = None,
        runs: Sequence[int] | None = None,
    ) -> Blocks:
        """Make the states in which runs begin, and their parameters.

        Parameters
        ----------
        parameters, samples, runs
            As of `Prepared.run`.

        Returns
        -------
        Blocks
            states (blocks, state_rows, 8) and parameters (blocks, rows, 8), blocks being the runs by 8.

        Raises
        ------
        ScenarioError
            As of `Prepared.run`; also if the joints of a run cannot be assembled, or its numbers need other kernels.
        """
        resolved, labels, nominal = self._chosen(parameters, samples, runs)
        prepared = prepare(resolved, labels, nominal=nominal)
        bad = np.flatnonzero(prepared.codes != SUCCESS)
        if len(bad):
            rule, remedy = "cannot begin with its numbers", "leave it out (runs), or ask lienumba.run why"
            raise ScenarioError.at(f"run {labels[bad[0]]}", rule, remedy)
        if self._shape_of(resolved, prepared) != self._shape:
            raise ScenarioError.at(
                "parameters" if samples is None else "samples",
                "have a number that is exactly 0, 1 or -1 in other places than in what was prepared",
                "name what varies in sweep.vary, or give such numbers when you prepare",
            )
        batch = batch_of(resolved, prepared, self._outline, self._machine)
        own = [self._kept(x) if isinstance(x, Numbers) else x for x in batch.parameters]
        batch = replace(batch, parameters=own)
        found = Blocks(*begin(batch, slice(0, len(labels)), self._evaluating.parameters, {}))
        room = aligned(self._evaluating.work_rows, W)
        for block in found.parameters:
            self._routines["prepare"](block.ctypes.data, self._hoisting, room.ctypes.data)
        return found

    def workspace(self, threads: int | None = None) -> np.ndarray:
        """Make the memory in which functions compute. It keeps the machine code in memory.

        Parameters
        ----------
        threads : int, optional
            How many workspaces to make; each thread needs its own.

        Returns
        -------
        ndarray (size,), or (threads, size)
            With the addresses of this process: another one makes its own.
        """
        first = layout.workspace(self._machine.sizes).work
        own = max(self._machine.buffer_rows, first + self._evaluating.work_rows) * W
        size, number = functions.HEAD + own, 1 if threads is None else threads
        memory: Any = (ctypes.c_double * (number * size + ALIGNMENT // 8))()
        memory.kernels = self
        raw = np.frombuffer(memory)
        offset = (-raw.ctypes.data % ALIGNMENT) // 8
        found = raw[offset : offset + number * size].reshape(number, size)
        for one in found:
            workspace.write(
                one, self._machine, self._evaluating, self._resolved.data.projection, self._routines, self._prepares
            )
        return found if threads is not None else found[0]

    def right_hand_side(self) -> RightHandSide:
        """Make what `rhs` fills.

        Returns
        -------
        RightHandSide
            rows, and views of them: a (6 k, 8) of k bodies, multipliers (m, 8), and rates (n, 8).
        """
        k, m = 6 * self._evaluating.bodies, self._evaluating.constraints
        every = np.zeros((self._evaluating.rows["rhs"], W))
        return RightHandSide(every, every[:k], every[k : k + m], every[k + m :])

    def equation_arrays(self) -> Equations:
        """Make what `equations` fills.

        Returns
        -------
        Equations
            rows, and views of them: M (6 k, 6 k, 8) of k bodies, C (m, 6 k, 8), Q (6 k, 8) and xi (m, 8).
        """
        k, m = 6 * self._evaluating.bodies, self._evaluating.constraints
        every = np.zeros((self._evaluating.rows["equations"], W))
        M, C, Q, xi = np.split(every, np.cumsum([k * k, m * k, k]))
        return Equations(every, M.reshape(k, k, W), C.reshape(m, k, W), Q, xi)

    def row(self, name: str) -> int:
        """Find a number among the parameters of a block, or among the rows of its state.

        Parameters
        ----------
        name : str
            The path of a number, such as "parameters.force" or "bodies.top.mass": a row of parameters. In body
            coordinates also a name of the dataset, such as "velocity.top.z": a row of the state.

        Returns
        -------
        int
            The row.

        Raises
        ------
        ScenarioError
            If it is in no row, or if it decides about several numbers.
        """
        bodies = () if self._machine.kernels[layout.PLACE] else self._first.model.bodies
        found = rows.state_row(bodies, name)
        return rows.parameter_row(self._resolved, self._first, name) if found is None else found

    def needs_prepare(self, path: str) -> bool:
        """Whether `prepare` has to be called after a change of a parameter.

        Parameters
        ----------
        path : str
            The path of a number that is in a row of parameters.

        Returns
        -------
        bool
            False where nothing is computed from it beforehand.

        Raises
        ------
        ScenarioError
            As of `row`.
        """
        row = rows.parameter_row(self._resolved, self._first, path)
        return row in self._evaluating.hoists or row in self._outline.hoists

    def _kept(self, table: Numbers) -> Numbers:
        """A table that stays in memory, because copies of parameters may have its address."""
        return self._tables.setdefault(table.array.tobytes(), table)

    @staticmethod
    def _shape_of(resolved: Scenario, prepared: Prepared) -> tuple[object, ...]:
        """What of numbers is compiled in: those that no slot holds, and which redundant rows are in use."""
        selection = selection_of(resolved, prepared)
        numbers = leaves(split(prepared.model)[0])
        return numbers, selection.rows, selection.masks, selection.singular
