"""What the comments of the gallery say happens."""

import numpy as np

import lienumba
from tests.rigs.places import SCENARIOS

LOAD = 60 * 9.81 * 0.2  # N m, of the hoist at its drum


def test_brakes_hold_the_load_or_slip_where_they_are_worn() -> None:
    ds = lienumba.run(SCENARIOS / "brake.toml", progress=False)
    holds = ds["parameters.static"].values > LOAD
    assert (ds.status == 0).all()
    assert 10 < holds.sum() < 60
    np.testing.assert_array_equal(ds.last_mode.values[:, 0], np.where(holds, 1, 2))
    height = ds.position.sel(body="load", axis="z")
    assert (height.max("time") > height.isel(time=0) + 0.1).all()
    assert (ds["drum.rate"].values[~holds, -1] < -1.0).all()
    assert abs(ds["drum.rate"].values[holds, -1]).max() < 1e-12
