"""q, qd and tau of the whole mechanism in the dataset."""

from functools import cache
from typing import Any

import numpy as np
import pytest
import xarray as xr

import lienumba
from lienumba.analysis.panels.select_panels import named_panels
from lienumba.mechanics.system.joint_coordinates import UNITS
from lienumba.present.info import describe_dataset
from tests.rigs import all_joints


@cache
def run(coordinates: str = "lie", stored: bool = True) -> xr.Dataset:
    return lienumba.run(all_joints.scenario(coordinates, joint_coordinates=stored))


def test_labels_and_units() -> None:
    ds = run()
    assert dict(zip(ds.coordinate.values, ds.coordinate_units.values, strict=True)) == all_joints.COORDINATES
    for name in ("q", "qd", "tau"):
        assert ds[name].dims == ("run", "time", "coordinate")
        assert np.isfinite(ds[name].values).all()


@pytest.mark.parametrize("coordinates", ["lie", "joint"])
def test_they_are_what_quantities_of_the_joints_are(coordinates: str) -> None:
    """To the last bit, and over all turns."""
    ds = run(coordinates)
    for label in all_joints.COORDINATES:
        joint, _, own = label.partition(".")
        if own in ("rx", "ry", "rz"):
            names = [f"of_{joint}.rotation_vector", f"of_{joint}.angular_velocity"]
            value, rate = (ds[name].sel(axis=own[1]) for name in names)
        else:
            of = [str(x) for x in ds.data_vars if str(x).startswith(f"of_{joint}.")]
            value, rate = ds[next(x for x in of if x.endswith(f".{own}"))] if own else ds[of[0]], None
            rate = ds[of[of.index(str(value.name)) + 1]]
        np.testing.assert_array_equal(value.values, ds.q.sel(coordinate=label).values)
        np.testing.assert_array_equal(rate.values, ds.qd.sel(coordinate=label).values)
    assert ds.q.sel(coordinate="wheel").values[0, -1] == pytest.approx(12.5 + 0.3 * np.sin(1.5), abs=1e-9)


def test_both_ways_have_the_same() -> None:
    lie, joint = run(), run("joint")
    for name, bound in (("q", 1e-7), ("qd", 3e-6), ("tau", 1e-5)):
        np.testing.assert_allclose(joint[name].values, lie[name].values, rtol=0, atol=bound)


@pytest.mark.parametrize("coordinates", ["lie", "joint"])
def test_nothing_else_changes(coordinates: str) -> None:
    with_them, without = run(coordinates), run(coordinates, False)
    assert not {"q", "qd", "tau", "coordinate", "coordinate_units"} & {*without.variables}
    for name in without.data_vars:
        np.testing.assert_array_equal(with_them[name].values, without[name].values, err_msg=str(name))


def test_summaries_by_component_and_of_all() -> None:
    summary = {"q.crank": ["max"], "tau": ["rms"], "qd.piston.displacement": ["final"]}
    ds = lienumba.run(all_joints.scenario(joint_coordinates=True, mode="summary", summary=summary, full_runs="0:1"))
    full = run()
    assert ds["q.crank_max"].values == full.q.sel(coordinate="crank").max("time").values
    assert ds["q.crank_max"].attrs["units"] == "rad"
    assert ds["qd.piston.displacement_final"].values == full.qd.sel(coordinate="piston.displacement")[:, -1].values
    assert ds["qd.piston.displacement_final"].attrs["units"] == "m s-1"
    assert ds.tau_rms.dims == ("run", "coordinate")
    np.testing.assert_array_equal(ds.q.values, full.q.values)


def test_only_those_that_are_named() -> None:
    ds = lienumba.run(all_joints.scenario(joint_coordinates=True, variables=["q"]))
    assert "q" in ds
    assert not {"qd", "tau", "position"} & {*ds.data_vars}
    assert {"q", "qd", "tau"} <= {*lienumba.run(all_joints.scenario(joint_coordinates=True, variables=["energy"]))}


@pytest.mark.parametrize(
    ("output", "quantity", "said"),
    [
        ({"variables": ["q"]}, "", "q.*joint_coordinates = true"),
        ({"summary": {"tau.crank": ["max"]}}, "", "tau.crank.*joint_coordinates = true"),
        ({"joint_coordinates": True, "summary": {"q.crnk": ["max"]}}, "", "q.crnk.*q.crank"),
        ({"joint_coordinates": True}, "tau", "output.joint_coordinates: .*tau.*another name"),
    ],
)
def test_sentences(output: dict[str, Any], quantity: str, said: str) -> None:
    scenario = all_joints.scenario(**output)
    if quantity:
        scenario["quantities"].append({"name": quantity, "type": "point", "body": "a"})
    with pytest.raises(lienumba.ScenarioError, match=said):
        lienumba.run(scenario)


def test_a_quantity_may_be_called_so_where_they_are_not_stored() -> None:
    scenario = all_joints.scenario(variables=["q"])
    scenario["quantities"].append({"name": "q", "type": "point", "body": "a"})
    assert lienumba.run(scenario).q.dims == ("run", "time", "axis")


def test_panels_are_of_one_unit() -> None:
    panels = named_panels(run(), ["q", "tau"]).panels
    units = all_joints.COORDINATES
    assert [x.label for x in panels] == ["q (rad)", "q (m)", "tau (N·m)", "tau (N)"]
    for panel in panels:
        of = {units[str(run().coordinate.values[line.place["coordinate"]])] for line in panel.lines}
        assert len(of) == 1
    assert [x.lines[0].place["coordinate"] for x in named_panels(run(), ["q.piston"]).panels] == [5, 6]
    assert {*UNITS} == {"q", "qd", "tau"}


def test_info_names_them() -> None:
    assert "coordinates: 14: crank, slide, ball.rx" in describe_dataset(run())
