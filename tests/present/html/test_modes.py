"""The page of a dataset of modes: what it says, and what its charts and its stage are made of."""

import numpy as np

import lienumba
from lienumba.scene import mode_scene
from tests.rigs.pages import Read, array, page_of
from tests.rigs.places import SCENARIOS


def test_tables_charts_and_shapes_are_those_of_the_dataset() -> None:
    found = lienumba.modes(SCENARIOS / "top_over_spin.toml", at=[0, 0.01], overrides={"sweep.runs": 9})
    page = Read(page_of(found, "top.nc"))
    unstable = int((~found.stable.isel(time=0)).sum())
    assert f"3 modes of 9 runs: {unstable} unstable at t = 0 s;" in page.text
    assert "Modes at t = 0.01 s" in page.text
    assert "lienumba modes scenario.toml --at 0,0.01 -o top.nc" in page.text
    plane, fan = page.chart("Eigenvalues"), page.chart("Frequencies over parameters.spin")
    for n in range(3):
        own = found.isel(time=0, mode=n)
        np.testing.assert_array_equal(array(plane["traces"][n]["x"]), own.growth)
        np.testing.assert_array_equal(array(plane["traces"][n]["y"]), own.angular_frequency)
        order = np.argsort(own["parameters.spin"].values)
        np.testing.assert_array_equal(array(fan["traces"][n]["y"]), own.frequency[order])
    motion = page.data["motion"]
    assert motion["cycles"] is True
    assert [run["label"] for run in motion["runs"]] == [x.label for x in mode_scene(found, modes=range(1, 4)).runs]
    assert {float(array(run["times"])[-1]) for run in motion["runs"]} == {motion["duration"]}


def test_without_shapes_the_page_says_how_to_find_them() -> None:
    page = Read(page_of(lienumba.modes(SCENARIOS / "machine_on_mounts.toml", runs=[0], shapes=False)))
    assert "This dataset has no shapes of modes: find them with shapes=True." in page.text
    assert "6 modes of 1 run, in none of which a mode grows." in page.text
    assert "motion" not in page.data
