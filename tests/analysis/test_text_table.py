"""Numbers as tables show them: what is rounding is 0, and 0 has no sign."""

import numpy as np
import xarray as xr

import lienumba
from lienumba.analysis import summarise
from lienumba.analysis.summary import Quantiles
from lienumba.analysis.summary_rows import quantile_rows
from lienumba.analysis.text_table import number_text
from tests.rigs.changing import changing
from tests.rigs.everything import EVERYTHING


def test_zero_has_no_sign_however_it_comes_about():
    assert [number_text(x, ".6g") for x in (-0.0, 0.0, -1.5e-7, np.nan, -np.inf)] == ["0", "0", "-1.5e-07", "–", "-inf"]
    assert [number_text(x, ".2f") for x in (-0.001, -0.0, -0.01, 0.001)] == ["0.00", "0.00", "-0.01", "0.00"]


def test_what_is_rounding_beside_its_scale_is_zero():
    assert [number_text(x, ".6g", 2.0) for x in (1.9e-12, -1.9e-12, 2.1e-12, -3.0)] == ["0", "0", "2.1e-12", "-3"]
    assert number_text(1e-30, ".6g") == "1e-30"  # a scale that nobody knows says nothing


def test_a_door_that_is_locked_stands_still_in_the_summary_and_moves_by_rounding_in_the_dataset():
    ds = changing()
    found = quantile_rows(summarise(ds).final, 4)
    shown = {(row.quantity, row.body, row.axis): found.numbers(row) for row in found.first}
    assert {tuple(shown["angular_velocity", "door", axis]) for axis in "xyz"} == {("0", "0", "0")}
    assert 0 < abs(ds["angular_velocity"].sel(body="door").isel(time=-1)).max() < 1e-13  # it turned at 2 rad/s
    assert shown["position", "door", "y"][1] != "0"


def test_what_comes_to_rest_is_at_rest_beside_what_it_was_on_the_way():
    """It begins at rest, too, so that neither end tells its scale."""
    ds = changing()
    ds["turning"] = xr.where(ds.time == ds.time[-1], 1e-14, 3.0 * ds.time) + 0.0 * ds.run
    ds["turning"] = ds["turning"].transpose("run", "time")
    (row,) = (row for row in summarise(ds).final if row.quantity == "turning")
    assert quantile_rows([row], 4).numbers(row) == ["0", "0", "0"]
    assert row.median == 1e-14


def test_of_each_kind_few_are_seen_at_once_and_of_many_the_last():
    """Joints and events are no bodies; what belongs to none of them is always seen."""

    def of(kind: str, number: int) -> list[Quantiles]:
        return [Quantiles("x", f"{kind}{n}", "", "m", 0.0, 1.0, 2.0, kind=kind) for n in range(number)]

    alone = Quantiles("energy", "", "", "J", 0.0, 1.0, 2.0)
    found = quantile_rows([*of("body", 3), alone, *of("coordinate", 3), *of("event", 1)], 9)
    assert (len(found.first), found.others) == (8, {})
    found = quantile_rows([*of("coordinate", 4), alone, *of("body", 5)], 9)
    assert [row.body for row in found.first] == ["coordinate3", "", "body4"]
    assert found.others == {"coordinates": 3, "bodies": 4}


def test_joints_are_told_beside_bodies():
    """Two bodies and two joints, the last of neither is alone."""
    model = EVERYTHING["model"]
    slide = {"name": "slide", "type": "prismatic", "bodies": ["ground", "ball"], "at": [0, 0, 0.5], "axis": [1, 0, 0]}
    joints = {"model": model | {"joints": [*model["joints"], slide], "contacts": [], "forces": []}}
    output = {"every": 0.1, "variables": ["q", "position"], "joint_coordinates": True}
    plain = {"output": output, "requirements": [], "sweep": {"runs": 1}, "parameters": {}, "measures": []}
    text = str(summarise(lienumba.run(EVERYTHING | joints | plain)))
    assert "the last of" not in text
    shown = [line.split()[:2] for line in text.splitlines()]
    for row in (["q", "hinge"], ["q", "slide"], ["position", "ball"], ["position", "rod"]):
        assert row in shown
