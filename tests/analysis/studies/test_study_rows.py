"""The rows of a study, of errors made up; terminal and page draw the same."""

import html
import re
from io import StringIO

import numpy as np
import pytest
from rich.console import Console

from lienumba.analysis.studies.study_rows import (
    EVALUATIONS,
    STEP,
    TIME,
    doubtful,
    failures,
    headline,
    lines,
    order_table,
    order_text,
    point_table,
    remarks,
    time_text,
)
from lienumba.present.html.markup import text_table, typeset
from lienumba.store.study_layout import Coordinate
from lienumba.words import is_number
from tests.rigs.made_studies import METHODS, STEPS, study

SQUARES = np.array(STEPS) ** 2 * np.ones((1, 2, 1))


def failing():
    """Three runs, of which two fail with the second method and the coarsest step, and one there with the next."""
    status = np.zeros((3, 2, 4), int)
    status[:2, 1, 0] = status[0, 1, 1] = 4
    return study(np.repeat(SQUARES, 3, axis=0), status=status)


def test_points_have_their_errors_and_costs():
    found = point_table(study(SQUARES), most=3)
    assert found.headings == [
        "method",
        "step",
        "position (m)",
        "velocity (m/s)",
        "steps",
        "evaluations",
        "time per run",
    ]
    assert found.kinds == ["word"] * 2 + ["number"] * 5
    assert found.rows == [
        ["first", "0.08", "6.4e-03", "6.4e-02", "10", "40", "10 ± 0.5 µs"],
        ["first", "0.04", "1.6e-03", "1.6e-02", "20", "80", "20 ± 1 µs"],
        ["first", "0.02", "4.0e-04", "4.0e-03", "40", "160", "40 ± 2 µs"],
    ]


def test_points_without_a_good_run_have_no_numbers():
    nowhere = point_table(study(SQUARES, status=3), most=1)
    assert nowhere.rows == [["first", "0.08", "–", "–", "–", "–", "1", "10 ± 0.5 µs"]]
    assert nowhere.headings[-2] == "failed"


def test_orders_of_each_curve():
    found = order_table(study(np.array(STEPS) ** 3 * np.array([[[1.0], [2.0]]])))
    assert found.headings == ["method", "position", "velocity", "points", "mean steps"]
    assert [row[0] for row in found.rows] == [*METHODS]
    assert [row[-2:] for row in found.rows] == [["4", "0.01 to 0.08 s"]] * 2
    assert all(re.fullmatch(r"3\.00 ± \d\S*", cell) for row in found.rows for cell in row[1:3])


def test_failures_say_where():
    (failure,) = failures(failing())
    assert (failure.count, failure.status.name) == (3, "rotation_too_large")
    assert failure.where == "method = second, step = 0.08 and 1 other point"
    assert headline(failing()) == "8 points, each with 3 runs"
    assert [*failures(study(SQUARES))] == []


@pytest.mark.parametrize(("cost", "x"), [(STEP, STEPS[::-1]), (EVALUATIONS, (320, 160, 80, 40)), (TIME, None)])
def test_lines_go_from_small_steps_to_large_ones(cost, x):
    first, second = lines(study(SQUARES * [[[1.0], [0.0]]]), "position_error", cost)
    assert (first.name, second.name) == METHODS
    np.testing.assert_allclose(first.y, np.array(STEPS[::-1]) ** 2)
    np.testing.assert_allclose(first.x, 1e-6 * np.array([80, 40, 20, 10]) if x is None else x)
    assert len(second.y) == 0, "an error of 0 has no place on a logarithmic axis"
    _, second = lines(study(SQUARES * [[[1.0], [0.0]]]), "position_error", cost, logarithmic=False)
    assert second.y.tolist() == [0.0] * 4


def test_points_of_no_curve_stand_for_themselves_over_what_they_cost():
    ds = study(SQUARES[:, :, 0], [Coordinate("method", "method", METHODS, "1", "integrator.method")], STEPS[0])
    assert lines(ds, "position_error", STEP) == []
    assert [(line.name, line.x.tolist()) for line in lines(ds, "position_error", EVALUATIONS)] == [
        ("first", [40.0]),
        ("second", [40.0]),
    ]


def test_what_the_reference_says_little_of():
    assert doubtful(study(SQUARES, floor=1e-6), "position") == pytest.approx(1e-4)
    assert doubtful(study(SQUARES, status=1), "position") == 0.0


def test_an_order_is_told_with_what_is_known_of_it():
    told = [order_text(*x) for x in ((np.nan,) * 3, (2.0, 1.9, 2.1), (2.0, np.nan, np.nan), (1.0, -1.0, 3.0))]
    assert told == ["–", "2.00 ± 0.1", "2.00", "none seen"]


def test_what_costs_least_is_told_where_the_reference_can_tell():
    """Of the second method errors are a hundredth; a reference good to 1e-9 tells nothing below 1e-7."""
    errors = np.array(STEPS) ** 2 * np.array([[[1.0], [0.01]]])
    least = "least time for position errors up to"
    coarse = f"{least} 0.001 m: method = second, step = 0.08 (10 ± 0.5 µs)"
    assert [*remarks(study(errors))] == [coarse]
    fine = study(errors * [1.0, 1.0, 1e-2, 1e-7])
    ends = [
        f"{least} 1e-06 m: method = second, step = 0.02 (40 ± 2 µs)",
        f"{least} 1e-09 m: method = first, step = 0.01 (80 ± 4 µs)",
        f"{least} 1e-12 m: method = second, step = 0.01 (80 ± 4 µs)",
    ]
    assert [*remarks(fine)][-3:] == ends
    floored = study(errors * [1.0, 1.0, 1e-2, 1e-7], floor=1e-9)
    assert [*remarks(floored)][-1] == ends[0]
    failed = study(errors, status=[[[0, 0, 0, 0], [4, 0, 0, 0]]])
    assert [*remarks(failed)] == [f"{least} 0.001 m: method = second, step = 0.04 (20 ± 1 µs)"]


def test_an_order_that_is_not_seen_has_a_reason():
    errors = np.array([[[1e-2, 2e-3, 3e-2, 1e-3], [1.0, 0.25, 0.0625, 0.015625]]])
    assert next(row[2] for row in order_table(study(errors)).rows) == "none seen"
    assert next(remarks(study(errors))).startswith("none seen: points lie so far from a line that the interval")


def test_times_have_three_digits_and_a_unit():
    assert time_text(1.5e-5, 4e-7) == "15 ± 0.2 µs"
    assert time_text(5.26e-4, 2.4e-4) == "526 ± 120 µs"
    assert time_text(9.996e-4) == "1000 µs"
    assert [*map(typeset, ("3.4e+00", "-1.5e+10", "2e-07"))] == ["3.4", "−1.5 × 10¹⁰", "2 × 10⁻⁷"]
    assert [*map(time_text, (12.345, 0.5, 1.5e-5, 2e-9, 3e-12))] == ["12.3 s", "500 ms", "15 µs", "2 ns", "0.003 ns"]


def test_terminal_and_page_show_the_same_cells():
    table = point_table(failing(), most=8)
    stream = StringIO()
    Console(file=stream, width=200).print(table.on_terminal())
    shown = [re.split(r"\s{2,}", line.strip()) for line in stream.getvalue().splitlines()]
    cells = [html.unescape(x) for x in re.findall(r"<td[^>]*>([^<]*)</td>", text_table(table))]
    assert len(cells) == 8 * len(table.headings)
    for n, row in enumerate(table.rows):
        assert cells[n * len(row) : (n + 1) * len(row)] == [typeset(x) if is_number(x) else x for x in row]
        assert row in shown
