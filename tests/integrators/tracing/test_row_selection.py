"""Rows that say the same: some are used, and others instead where these get weak on the way."""

from itertools import combinations
from typing import Any

import numpy as np
import pytest

import lienumba
from lienumba.batch import statuses
from lienumba.batch.execute import execute, tasks
from lienumba.batch.integrate import Batch
from lienumba.batch.records import Layout, per_run
from lienumba.groups.state import ELEMENT
from lienumba.integrators import codes
from lienumba.integrators.drivers.row_selection import select_rows
from lienumba.integrators.tracing.compiled import compiled
from lienumba.integrators.tracing.program import Method
from lienumba.integrators.tracing.row_selection import UNIQUE, RowSelection, initial_selection
from lienumba.integrators.tracing.template import split
from lienumba.mechanics.start import assembly
from lienumba.mechanics.system import constraints, dynamics, kkt
from lienumba.mechanics.system.rank import nominal, rank_of
from tests.facade import Instant, Model
from tests.rigs import linkages
from tests.rigs.scenarios import BENNETT, scenario, simulate, start_of, state_at

RK4 = Method("rk4", "local", "mass")


def bennett() -> tuple[Model, Instant]:
    """The linkage of the scenarios, in floats, and its start."""
    model, states = start_of(scenario(BENNETT, 1e-3, 1e-3))
    return model, Instant(tuple(map(tuple, states.tolist())))


def dense(entries: kkt.Entries) -> np.ndarray:
    C = np.zeros((20, 18))
    for key, x in entries.items():
        C[key] = x
    return C


def choice_at(model: Model, now: Instant) -> RowSelection:
    return initial_selection(model, rank_of(model, now).exchangeable, now)


def integrate(model: Model, now: Instant, choice: RowSelection, step: float, steps: int, *, fixed: bool = False) -> Any:
    """Status, last good step, the masks at every tenth step, and all variables there, of one run."""
    program, machine = compiled(model, RK4, choice, fixed)
    held = program.augmented
    states = np.concatenate([np.ravel(now.bodies)[None], held.start(now.angles, choice, 1)], axis=1)
    outputs = np.arange(0, steps + 1, 10)
    codes = np.zeros(1, np.int8)
    batch = Batch(machine, split(model)[1], states, codes, step * steps, step, step * outputs, 1e-11, 10)
    (chunk,) = execute(tasks(batch, 1, lambda chunk: chunk), 1, lambda done: None)
    first = ELEMENT * program.sizes.elements + held.first_mask
    layout = Layout.of(model)
    values = {name: per_run(layout.variable(name, chunk, program), 1)[0] for name in layout.names}
    masks = chunk.records[0, :, first : first + len(held.masks), 0]
    return int(chunk.codes[0]), int(chunk.steps[0]), masks, values


def test_as_many_rows_are_chosen_as_the_rank_needs() -> None:
    for model, now in (bennett(), *(assembled(make) for make in (linkages.door, linkages.planar_four_bar))):
        rank, choice = rank_of(model, now), choice_at(model, now)
        assert choice.rows == rank.exchangeable
        assert set(choice.masks) == {0.0, 1.0}
        assert len(choice.dropped) == rank.rows - rank.rank
        assert choice.margin > 1e-4
    assert initial_selection(model, (), now) is UNIQUE


def assembled(make: Any) -> tuple[Model, Instant]:
    model, start = make()
    done = assembly.assemble(model, start, 1)
    assert done.good.all()
    return nominal(done.model), done.instant(0)


def test_rows_are_exchanged_on_the_way_and_the_run_goes_on() -> None:
    """More than one full turn: the first choice would not hold; always as many rows as the rank."""
    model, now = bennett()
    choice = choice_at(model, now)
    status, steps, masks, values = integrate(model, now, choice, 1e-3, 1200)
    assert (status, steps) == (0, 1200)
    np.testing.assert_array_equal(masks[0], choice.masks)
    changes = np.flatnonzero((masks[1:] != masks[:-1]).any(axis=1))
    assert len(changes) >= 1
    assert len({row.tobytes() for row in masks}) > 1
    assert set(masks.ravel()) == {0.0, 1.0}
    assert (masks.sum(axis=1) == sum(choice.masks)).all()
    assert values["position_violation"].max() < 1e-11
    assert values["velocity_violation"].max() < 1e-10
    assert np.abs(values["energy_residual"]).max() < 1e-8
    spun = np.unwrap(np.arctan2(values["rotation"][:, 0, 1, 0], values["rotation"][:, 0, 0, 0]))
    assert abs(spun[-1] - spun[0]) > 2 * np.pi


def test_a_program_without_the_rows_that_are_needed_says_so() -> None:
    model, now = bennett()
    choice = choice_at(model, now)
    status, steps, masks, values = integrate(model, now, choice, 1e-3, 1200, fixed=True)
    assert status == codes.RESELECT
    assert 0 < steps < 1200
    good = np.isfinite(values["energy"])
    assert (masks[good] == choice.masks).all()
    assert values["position_violation"][good].max() < 1e-11
    _, _, others, _ = integrate(model, now, choice, 1e-3, 10 * (steps // 10))
    assert (others == choice.masks).all()  # so long, the choice held


def test_what_is_stored_of_a_run_that_went_again_is_of_its_second_pass() -> None:
    """From its start, though the first program got some way."""
    model, now = bennett()
    _, _, _, values = integrate(model, now, choice_at(model, now), 1e-3, 600)
    here = simulate(BENNETT, 1e-3, 0.6, output={"every": 0.01, "also": ["multiplier"]})
    for name in ("position", "rotation", "velocity", "angular_velocity", "energy", "multiplier"):
        np.testing.assert_array_equal(here[name], values[name])


def test_the_same_motion_as_with_seventeen_rows() -> None:
    """Three less by hand: the last hinge is a point on a line. They do until 0.21 s, the first choice until 0.1 s."""
    by_hand = {"model": {**BENNETT["model"], "joints": [dict(joint) for joint in BENNETT["model"]["joints"]]}}
    by_hand["model"]["joints"][3]["type"] = "point_on_line"
    apart = []
    for step in (2e-3, 1e-3):
        whole, less = (simulate(m, step, 0.2) for m in (BENNETT, by_hand))
        assert (len(whole["constraint"]), len(less["constraint"])) == (20, 17)
        ends = zip(state_at(whole), state_at(less), strict=True)
        apart.append(max(np.abs(a - b).max() for a, b in ends))
    assert apart[1] < 2e-9
    assert np.log2(apart[0] / apart[1]) == pytest.approx(4.0, abs=0.5), apart


def test_the_order_of_the_method_across_exchanges() -> None:
    """Positions and velocities after more than half a turn, against steps an eighth as long."""
    fine = np.concatenate([np.ravel(x) for x in state_at(simulate(BENNETT, 1.25e-4, 0.8))])
    errors = []
    for step in (2e-3, 1e-3, 5e-4):
        end = np.concatenate([np.ravel(x) for x in state_at(simulate(BENNETT, step, 0.8))])
        errors.append(np.abs(end - fine).max())
    slopes = np.log2(np.divide(errors[:-1], errors[1:]))
    assert slopes == pytest.approx(4.0, abs=0.4), errors
    assert errors[-1] > 1e-12


@pytest.mark.parametrize("which", range(2))
def test_a_bad_initial_selection_is_mended(which: int) -> None:
    """The two weakest of all the choices that are independent at all."""
    model, now = bennett()
    choice, C = choice_at(model, now), dense(constraints.jacobian(model, now))
    sets = [(np.linalg.svd(np.delete(C, left, axis=0))[1][-1], left) for left in combinations(range(20), 3)]
    left = sorted(x for x in sets if x[0] > 1e-9)[which][1]
    bad = RowSelection(choice.rows, tuple(float(row not in left) for row in choice.rows), choice.margin)
    status, steps, masks, values = integrate(model, now, bad, 1e-3, 300)
    assert (status, steps) == (0, 300)
    assert (masks[1:] != bad.masks).any()
    assert values["position_violation"].max() < 1e-11
    assert values["velocity_violation"].max() < 1e-10


# ---------------------------------------------------------------- the choice itself
def table_of(S: np.ndarray, masks: list[float]) -> np.ndarray:
    """As the driver lays it out, with other numbers in the other lanes."""
    q = len(S)
    table = np.full((q * (q + 1) // 2 + 2 * q + 1, 8), 3.25)
    table[: q * (q + 1) // 2, 2] = S[np.tril_indices(q)]
    table[q * (q + 1) // 2 : q * (q + 1) // 2 + q, 2] = np.diag(S)
    table[q * (q + 1) // 2 + q : q * (q + 1) // 2 + 2 * q, 2] = masks
    return table


def chosen(C: np.ndarray, masks: list[float]) -> list[float]:
    S, q = C @ C.T, len(C)
    table = table_of(S, masks)
    before = table.copy()
    select_rows(table, 2, q, np.empty((q + 2, q)))
    np.testing.assert_array_equal(np.delete(table, 2, axis=1), np.delete(before, 2, axis=1))
    found: list[float] = table[q * (q + 1) // 2 + q : q * (q + 1) // 2 + 2 * q, 2].tolist()
    return found


def test_a_good_choice_stays() -> None:
    C = np.array([[1.0, 0.0, 0.0], [1.0, 1e-1, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    for masks in ([1.0, 0.0, 1.0, 1.0], [0.0, 1.0, 1.0, 1.0]):
        assert chosen(C, masks) == masks


def test_a_weak_one_gives_way() -> None:
    C = np.array([[1.0, 0.0, 0.0], [1.0, 1e-3, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    assert chosen(C, [1.0, 1.0, 0.0, 1.0]) == [1.0, 0.0, 1.0, 1.0]


def test_a_row_that_says_something_new_is_taken() -> None:
    C = np.array([[1.0, 0.0, 0.0], [1.0, 1e-3, 0.0], [0.0, 0.0, 1.0]])
    assert chosen(C, [1.0, 0.0, 1.0]) == [1.0, 1.0, 1.0]


@pytest.mark.parametrize("seed", range(20))
def test_as_many_rows_as_the_rank_and_well_conditioned(seed: int) -> None:
    rng = np.random.default_rng(seed)
    q, rank = 12, int(rng.integers(3, 9))
    C = rng.normal(size=(q, rank)) @ rng.normal(size=(rank, 15)) * 10 ** rng.uniform(-3, 3, size=(q, 1))
    rows = np.flatnonzero(chosen(C, [0.0] * q))
    assert len(rows) == rank
    scaled = C / np.linalg.norm(C, axis=1)[:, None]
    whole, part = np.linalg.svd(scaled)[1][rank - 1], np.linalg.svd(scaled[rows])[1][-1]
    assert part > 0.05 * whole


def test_the_schur_complement_is_what_is_left_of_the_rows() -> None:
    """Beyond what the rows say that all need: here none but the last hinge may be left out."""
    model, now = bennett()
    entries = constraints.jacobian(model, now)
    metric = dynamics.shapes(model)
    C = dense(entries) / np.sqrt([metric[c, c] for c in range(6 * len(model.bodies))])
    masked = tuple(range(15, 20))
    triangle, scales = kkt.schur_complement(kkt.Structure.of(model, masked), metric, entries)
    S = np.zeros((5, 5))
    S[np.tril_indices(5)] = triangle
    needed, last = C[:15], C[15:]
    away = last @ needed.T @ np.linalg.solve(needed @ needed.T, needed @ last.T)
    np.testing.assert_allclose(S + np.tril(S, -1).T, last @ last.T - away, rtol=0, atol=1e-12)
    np.testing.assert_allclose(scales, np.diag(last @ last.T), rtol=1e-14)


def test_the_public_run_hides_who_went_again() -> None:
    data = scenario(BENNETT, 2e-3, 0.3)
    data["sweep"] = {"runs": 24, "vary": {"joints.hinge1.rate": {"distribution": "uniform", "low": 0.5, "high": 8}}}
    events: list[Any] = []
    here = lienumba.run(data, workers=1, progress=events.append)
    assert (here["status"] == statuses.SUCCESS).all()
    assert (here["steps"] == 150).all()
    assert [event.stage for event in events].count("compile") <= 2
    assert all(event.done <= event.total and event.failed == 0 for event in events)
    assert all(event.total == 24 for event in events if event.total)  # those that go again count once
    assert events[-1].done == events[-1].total
