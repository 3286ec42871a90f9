"""The layout of the dataset, and that plain xarray gives back what was put in."""

import warnings

import netCDF4
import numpy as np
import pytest
import xarray as xr

from lienumba.batch.statuses import STATUSES
from lienumba.errors import ScenarioError
from lienumba.integrators import codes
from lienumba.store import form, layout
from lienumba.store.layout import VARIABLES, narrowed
from lienumba.store.outputs import write
from tests.store.store_example import INPUTS, TIMES, example


@pytest.fixture
def written(tmp_path):
    original = example(bodies=("top", "tip"), joints=("pivot", "elbow"), efforts=("motor", "carrier.x", "carrier.y"))
    path = tmp_path / "out.nc"
    write(original, path)
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # whatever xarray wants to warn of, the user would see
        with xr.open_dataset(path) as opened:
            yield original, opened.load(), path


def test_round_trip_through_plain_open_dataset(written):
    original, opened, _ = written
    xr.testing.assert_identical(opened, original)
    for name in original.variables:
        kinds = (opened[name].dtype.kind, original[name].dtype.kind)
        assert kinds == ("O", "U") or opened[name].dtype == original[name].dtype, name
        assert opened[name].dims == original[name].dims, name


def test_dims_and_labels(written):
    _, opened, _ = written
    assert opened.rotation.dims == ("run", "time", "body", "axis", "body_axis")
    assert opened.joint_force.dims == ("run", "time", "joint", "axis")
    assert opened.multiplier.dims == ("run", "time", "constraint")
    assert opened.driver_effort.dims == ("run", "time", "effort")
    assert opened.event_time.dims == ("run", "event")
    assert opened.status.dims == ("run",)
    assert opened.run.dtype == np.int32
    assert list(opened.body.values) == ["top", "tip"]
    assert list(opened.constraint.values[:4]) == ["pivot[0]", "pivot[1]", "pivot[2]", "elbow[0]"]
    assert list(opened.effort.values) == ["motor", "carrier.x", "carrier.y"]
    assert list(opened.axis.values) == list(opened.body_axis.values) == ["x", "y", "z"]
    assert opened.status.dtype == np.int8
    assert all(opened[name].dtype == np.float64 for name, spec in VARIABLES.items() if spec.dtype == "float64")


def test_times_are_found_by_their_decimals(written):
    original, opened, _ = written
    assert opened.time.dtype == np.float64
    chosen = opened.position.sel(time=0.57, run=2, body="tip", axis="z")
    assert float(chosen) == original.position.values[2, TIMES.index(0.57), 1, 2]


def test_paths_with_brackets_are_coordinates_of_the_run(written):
    original, opened, path = written
    for name in INPUTS:
        assert name in opened.coords
        assert opened[name].dims == ("run",)
        assert opened[name].attrs["role"] == "input"
        np.testing.assert_array_equal(opened[name], original[name])
    assert opened["bodies.top.angular_velocity[1]"].attrs["units"] == "rad s-1"
    with netCDF4.Dataset(path) as raw:  # the names in the file are the paths themselves
        assert set(INPUTS) <= set(raw.variables)


def test_every_variable_describes_itself(written):
    _, opened, _ = written
    for name, variable in opened.variables.items():
        assert variable.attrs["units"], name
        assert variable.attrs["long_name"], name
    for name in ("position", "velocity", "joint_force", "joint_torque"):
        assert opened[name].attrs["frame"] == "global"
    assert opened.angular_velocity.attrs["frame"] == "body"
    assert opened.rotation.attrs["frame"] == "body to global"
    assert opened.time.attrs["units"] == opened.end_time.attrs["units"] == "s"


def test_coordinates_have_no_fill_value(written):
    _, opened, path = written
    with netCDF4.Dataset(path) as raw:
        for name in opened.coords:
            assert "_FillValue" not in raw[name].ncattrs(), name


@pytest.mark.parametrize(
    ("name", "meanings"),
    [
        ("change_kind", {-1: "none", codes.LOCKED: "locked", codes.IMPACT: "impact", codes.SLID: "slid"}),
        ("mode", {0: "off", 1: "closed", 2: "sliding"}),
        ("start_equilibrium", {codes.FOUND: "found", codes.UNSTABLE: "unstable"}),
    ],
)
def test_flags_mean_what_the_numbers_are(name, meanings):
    spec = VARIABLES[name]
    attributes = layout.variable(name, spec, np.zeros([1] * len(spec.dims)), 1).attrs
    said = dict(zip(attributes["flag_values"].tolist(), attributes["flag_meanings"].split(), strict=True))
    assert said | meanings == said


def test_status_flags_follow_cf(written):
    _, opened, path = written
    with netCDF4.Dataset(path) as raw:
        values, meanings = raw["status"].flag_values, raw["status"].flag_meanings.split()
        assert values.dtype == raw["status"].dtype == np.int8
    assert list(values) == [status.code for status in STATUSES]
    assert meanings == [status.name for status in STATUSES]
    assert meanings[0] == "success"
    assert list(opened.status.attrs["flag_values"]) == list(values)


def test_a_failed_run_is_nan_in_counts_too(tmp_path):
    counts = np.array([[1, 2, 0], [1, -1, -1]])
    original = example(runs=2, times=[0.0, 0.1, 0.2], position_iterations=counts)
    write(original, tmp_path / "out.nc")
    with xr.open_dataset(tmp_path / "out.nc") as opened:
        expected = [[1.0, 2.0, 0.0], [1.0, np.nan, np.nan]]
        np.testing.assert_array_equal(original.position_iterations, expected)
        np.testing.assert_array_equal(opened.position_iterations, expected)
    with netCDF4.Dataset(tmp_path / "out.nc") as raw:
        assert raw["position_iterations"].dtype == np.int32


def test_numbers_keep_every_bit(tmp_path):
    position = np.full((1, 1, 1, 3), np.nan)
    position[0, 0, 0, :2] = [-0.0, np.nextafter(0.1, 1)]
    write(example(runs=1, times=[0.0], position=position), tmp_path / "out.nc")
    with xr.open_dataset(tmp_path / "out.nc") as opened:
        assert opened.position.values[0, 0, 0, :2].tobytes() == position[0, 0, 0, :2].tobytes()
        assert np.isnan(opened.position.values[0, 0, 0, 2])


def test_compressed_in_chunks_of_whole_runs(written):
    _, _, path = written
    large = example(runs=300)
    write(large, path)
    with netCDF4.Dataset(path) as raw:
        for name in VARIABLES:
            filters, chunks = raw[name].filters(), raw[name].chunking()
            assert (filters["zlib"], filters["shuffle"], filters["complevel"]) == (True, True, 1), name
            assert list(chunks[1:]) == list(raw[name].shape[1:]), name
            assert chunks[0] == 300 or np.prod(chunks) * raw[name].dtype.itemsize > 2**16, name


def test_a_body_without_joints_has_no_joint_variables(tmp_path):
    free = example(joints=(), efforts=())
    assert not {"joint_force", "joint_torque", "multiplier", "joint", "constraint"} & set(free.variables)
    assert not {"driver_effort", "effort"} & set(free.variables)
    write(free, tmp_path / "out.nc")
    with xr.open_dataset(tmp_path / "out.nc") as opened:
        xr.testing.assert_identical(opened, free)


def test_joints_without_drivers_have_no_efforts_and_drivers_alone_no_joints():
    joints, drivers = example(efforts=()), example(joints=())
    assert {"joint_force", "multiplier"} <= set(joints.variables)
    assert not {"driver_effort", "effort"} & set(joints.variables)
    assert {"driver_effort", "multiplier"} <= set(drivers.variables)
    assert not {"joint_force", "joint_torque", "joint"} & set(drivers.variables)


def test_reactions_that_are_not_unique_say_so(tmp_path):
    write(example(shared=("pivot", "motor")), tmp_path / "out.nc")
    with xr.open_dataset(tmp_path / "out.nc") as opened:
        for name in opened.variables:
            marked = name in ("joint_force", "joint_torque", "multiplier", "driver_effort")
            assert opened[name].attrs.get("not_unique") == ("pivot, motor" if marked else None), name
            assert ("least norm" in opened[name].attrs.get("comment", "")) == marked, name
    assert not any("not_unique" in variable.attrs for variable in example().variables.values())


def test_a_part_of_the_dataset_can_be_written_again(written, tmp_path):
    original, opened, _ = written
    for dataset in (original, opened):
        dataset.isel(run=[1, 2], time=slice(0, 5)).to_netcdf(tmp_path / "part.nc", engine="netcdf4")
        with xr.open_dataset(tmp_path / "part.nc") as part:
            np.testing.assert_array_equal(part.position, original.position[1:3, :5])


def test_wrong_shapes_are_refused():
    with pytest.raises(ValueError, match="time"):
        example(energy=np.zeros((4, 7)))


def test_counts_beyond_what_a_file_holds_are_the_largest_it_holds(tmp_path):
    most = np.iinfo(np.int32).max
    assert narrowed(np.array([5, 2**40, -1]), np.dtype("int32")).tolist() == [5, most, -1]
    write(example(runs=2, steps=np.array([7, 2**31])), tmp_path / "out.nc")
    with xr.open_dataset(tmp_path / "out.nc") as opened:
        assert opened.steps.dtype == np.int32
        assert opened.steps.values.tolist() == [7, most]


def test_status_names_of_older_files_are_read():
    status = layout.variable("status", VARIABLES["status"], np.zeros(3, np.int8), 3)
    older = {x.name: x.former for x in STATUSES if x.former}
    assert set(older.values()) == {"not_closed", "friction_pushes", "contradiction", "contact_violated"}
    words = status.attrs["flag_meanings"].split()
    status.attrs["flag_meanings"] = " ".join(older.get(word, word) for word in words)
    form._check_statuses(status, "old.nc")
    status.attrs["flag_meanings"] = " ".join(["nothing", *words[1:]])
    with pytest.raises(ScenarioError, match="what its statuses mean"):
        form._check_statuses(status, "old.nc")
