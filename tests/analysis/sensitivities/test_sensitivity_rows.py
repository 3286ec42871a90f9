"""The rows of a sensitivity analysis, of outputs that are known functions of their inputs."""

import numpy as np
import pytest

from lienumba.analysis import sensitivity
from lienumba.analysis.sensitivities.sensitivity_rows import sensitivity_rows
from tests.analysis.sweep_example import sweep

RNG = np.random.default_rng(5)
SAMPLES = {name: RNG.standard_normal(400) for name in ("bodies.a.mass", "bodies.b.mass", "bodies.c.mass")}
A, B, C = SAMPLES.values()


def rows(**outputs):
    return sensitivity_rows(sensitivity(sweep(SAMPLES, **outputs), [*outputs]))


def test_inputs_stand_by_their_strength_with_units():
    (one,) = rows(tip=B + 0.1 * A).outputs
    table, more = one.tornado(most=2)
    assert table.headings == [
        "input", "rank correlation", "explains", "10 %", "90 %", "mean below", "mean above", "change",
    ]  # fmt: skip
    assert table.rows[0][2].startswith("99 ± 0.")
    assert [row[0] for row in table.rows] == ["bodies.b.mass (kg)", "bodies.a.mass (kg)"]
    assert more == " (the first 2 of 3 inputs)"
    assert one.headline.startswith("tip (m), 400 runs: mean ")
    low, high = np.quantile(B, (0.1, 0.9))
    assert table.rows[0][3:5] == [f"{low:.4g}", f"{high:.4g}"]
    below, above = ((B + 0.1 * A)[which].mean() for which in (np.less_equal(B, low), np.greater_equal(B, high)))
    assert table.rows[0][5:7] == [f"{below:.4g}", f"{above:.4g}"]


def test_what_rises_and_falls_again_stands_first():
    (one,) = rows(tip=A * A + 0.3 * B).outputs
    table, _ = one.tornado(most=3)
    assert table.rows[0][0] == "bodies.a.mass (kg)"


def test_a_random_sweep_has_no_sobol_indices_and_says_so():
    found = rows(tip=B)
    assert found.outputs[0].sobol_headline == ""
    assert "sweep.sampler" in found.notes[0]
    assert found.headline == "Made up: 400 of 400 runs good, 0 failed"


def test_tenths_of_an_input_with_two_values_are_none():
    ds = sweep({"bodies.a.mass": np.repeat([0.0, 1.0], [399, 1])}, tip=A)
    (row,) = sensitivity_rows(sensitivity(ds, "tip")).outputs[0].inputs
    assert row.tornado[1:] == ["–"] * 5


def test_the_strongest_of_all_outputs_come_first():
    found = rows(tip=0.2 * A + C, heel=B + 0.01 * A)
    assert set(found.strongest[:2]) == {1, 2}
    assert found.strongest[2] == 0


def test_the_note_that_outputs_were_chosen_stands_apart():
    ds = sweep(SAMPLES, tip=B)
    asked, chosen = (sensitivity_rows(sensitivity(ds, names)) for names in ("tip", ()))
    assert asked.chosen == ""
    assert chosen.chosen.startswith("these outputs were chosen")
    assert chosen.chosen not in chosen.notes
    assert asked.notes == chosen.notes


@pytest.mark.parametrize(("time", "said"), [(0.5, "series (m) at t = 0.5 s, "), (None, "series (m) at t = 1 s, ")])
def test_the_time_of_a_series_is_told(time, said):
    found = sensitivity(sweep(SAMPLES, series=np.stack([A, B, C], axis=1)), "series", time)
    assert sensitivity_rows(found).outputs[0].headline.startswith(said)
