"""Tables that come from files, and what a run makes of them."""

from pathlib import Path
from typing import Any

import netCDF4
import numpy as np
import pytest
import xarray as xr

import lienumba
from lienumba.scenario.base.toml import dumps
from tests.facade import resolve

TIMES, VALUES = [0.0, 0.1, 0.25, 0.4, 1.0], [0.0, 3.0, -1.5, 2e-1, 4.0]
ROD: dict[str, Any] = {
    "model": {
        "gravity": [0, 0, 0],
        "bodies": [{"name": "rod", "mass": 2, "inertia": [0.1, 0.2, 0.3], "position": [0, 0, 0]}],
        "forces": [{"name": "jet", "type": "force", "body": "rod", "value": ["0.5*thrust(t)", "thrust(0.5 - t)", 0]}],
    },
    "integrator": {"step": 0.01, "end_time": 0.5},
    "output": {"every": 0.1},
}
INLINE = {"times": TIMES, "values": VALUES}
ROWS = list(zip(TIMES, VALUES, strict=True))


def joined(separator: str, start: str = "", end: str = "\n") -> str:
    lines = [["a", "t", "thrust"], *(["-1", repr(t), repr(x)] for t, x in ROWS)]
    return start + end.join(separator.join(line) for line in lines) + end


FILES = {
    "commas.csv": joined(","),
    "blanks after commas.csv": joined(", "),
    "semicolons.csv": joined(";"),
    "tabs.tsv": joined("\t"),
    "spaces.txt": joined("  "),
    "remarks.csv": joined(",", "# thrust of the jet, in N\n\n"),
    "windows.csv": joined(",", "\ufeff", "\r\n"),
    "units.csv": joined(",").replace("thrust\n", "thrust\n-,[s],[N]\n"),
}


def from_file(file: str, **keys: Any) -> dict[str, Any]:
    return ROD | {"tables": {"thrust": {"file": file, "time": "t", "value": "thrust", **keys}}}


def plain(**keys: Any) -> dict[str, Any]:
    return ROD | {"tables": {"thrust": INLINE | keys}}


@pytest.mark.parametrize("name", FILES)
def test_a_file_of_numbers_is_the_table_written_out(tmp_path: Path, name: str) -> None:
    (tmp_path / name).write_bytes(FILES[name].encode())
    assert resolve(from_file(str(tmp_path / name))).sha256() == resolve(plain()).sha256()


def test_times_are_found_by_their_name_and_moved_by_the_offset(tmp_path: Path) -> None:
    """As in logs, which count from 1970."""
    rows = "\n".join(f"{1.6e9 + t:.2f};{x}".replace(".", ",") for t, x in ROWS)
    (tmp_path / "log.csv").write_text(f"time;thrust\n{rows}\n", encoding="utf-8")
    table = {"file": str(tmp_path / "log.csv"), "value": "thrust", "decimal": ",", "offset": -1.6e9}
    read = resolve(ROD | {"tables": {"thrust": table}}).data.tables["thrust"]
    np.testing.assert_allclose(read.times, TIMES, rtol=0, atol=2.4e-7)  # the spacing of numbers near 1.6e9
    assert read.values == VALUES


@pytest.mark.parametrize("suffix", ["nc", "nc4", "NC", "h5"])
def test_a_netcdf_file_is_the_table_written_out(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"thrust.{suffix}"
    with netCDF4.Dataset(path, "w") as file:
        file.createDimension("n", len(TIMES))
        file.createVariable("t", float, ("n",))[:] = TIMES
        file.createVariable("thrust", float, ("n",))[:] = VALUES
    assert resolve(from_file(str(path))).sha256() == resolve(plain()).sha256()


def test_a_path_counts_from_the_folder_of_the_scenario(tmp_path: Path) -> None:
    """Also from that of the scenario on which another one builds."""
    (tmp_path / "base").mkdir()
    (tmp_path / "base" / "thrust.csv").write_text(joined(","), encoding="utf-8")
    (tmp_path / "base" / "base.toml").write_text(dumps(from_file("thrust.csv")), encoding="utf-8")
    (tmp_path / "top.toml").write_text('extends = "base/base.toml"\n', encoding="utf-8")
    wanted = resolve(plain()).sha256()
    assert resolve(tmp_path / "base" / "base.toml").sha256() == wanted
    assert resolve(tmp_path / "top.toml").sha256() == wanted


def test_the_dataset_keeps_the_numbers_not_the_path(tmp_path: Path) -> None:
    (tmp_path / "thrust.csv").write_text(joined(","), encoding="utf-8")
    (tmp_path / "jet.toml").write_text(dumps(from_file("thrust.csv")), encoding="utf-8")
    ds = lienumba.run(tmp_path / "jet.toml", output=tmp_path / "jet.nc")
    (tmp_path / "thrust.csv").unlink()
    with xr.open_dataset(tmp_path / "jet.nc") as stored:
        texts = [x for x in stored.attrs.values() if isinstance(x, str) and "[model]" in x]
    (text,) = texts
    (tmp_path / "again.toml").write_text(text, encoding="utf-8")
    np.testing.assert_array_equal(lienumba.run(tmp_path / "again.toml").position, ds.position)


def momentum(kind: str) -> np.ndarray:
    """The integrals of both components of the force, exactly, at the stored times."""
    x = np.array(TIMES)

    def integral(t: float) -> float:
        edges = np.append(x[x < t], t)
        y = np.interp(edges, x, VALUES) if kind == "linear" else np.append(np.array(VALUES)[x < t], 0.0)
        return float(np.sum(np.diff(edges) * (0.5 * (y[1:] + y[:-1]) if kind == "linear" else y[:-1])))

    times = np.arange(6) * 0.1
    return np.array([[0.5 * integral(t), integral(0.5) - integral(0.5 - t)] for t in times])


@pytest.mark.parametrize("kind", ["hold", "linear"])
def test_a_free_body_gets_the_integral(kind: str) -> None:
    """To rounding, because steps land on the points, forwards and backwards through the table."""
    ds = lienumba.run(plain(interpolation=kind)).isel(run=0)
    np.testing.assert_allclose(2 * ds.velocity.values[:, 0, :2], momentum(kind), rtol=0, atol=1e-14)


@pytest.mark.parametrize("kind", ["hold", "linear", "cubic"])
@pytest.mark.parametrize(("outside", "before", "behind"), [("hold", 2.0, -3.0), (0, 0.0, 0.0)])
def test_outside_of_its_points_a_table_is_what_is_said(kind: str, outside: Any, before: float, behind: float) -> None:
    """A table of 2 and -3 that ends within the run: the impulses before 0.2 s and behind 0.3 s."""
    table = {"times": [0.2, 0.3], "values": [2, -3], "interpolation": kind, "outside": outside}
    jet = {"name": "jet", "type": "force", "body": "rod", "value": ["thrust(t)", 0, 0]}
    ds = lienumba.run(ROD | {"tables": {"thrust": table}, "model": ROD["model"] | {"forces": [jet]}}).isel(run=0)
    impulse = 2 * np.diff(ds.velocity.values[:, 0, 0])
    inside = 0.2 if kind == "hold" else -0.05
    wanted = [0.1 * before, 0.1 * before, inside, 0.1 * behind, 0.1 * behind]
    np.testing.assert_allclose(impulse, wanted, rtol=0, atol=1e-14)


def test_a_run_that_leaves_a_table_by_its_state_fails_where_that_is_an_error() -> None:
    """The rod moves at 1 m/s through a table that ends at 0.25 m."""
    table = {"times": [0, 0.25], "values": [0, 0], "outside": "error"}
    body = ROD["model"]["bodies"][0] | {"velocity": [1, 0, 0]}
    jet = {"name": "jet", "type": "force", "body": "rod", "value": ["thrust(at.x)", 0, 0]}
    seen = [{"name": "at", "type": "point", "body": "rod", "point": [0, 0, 0]}]
    model = ROD["model"] | {"bodies": [body], "forces": [jet]}
    ds = lienumba.run(ROD | {"tables": {"thrust": table}, "model": model, "quantities": seen})
    assert ds.status.attrs["flag_meanings"].split()[int(ds.status[0])] == "non_finite"
    assert float(ds.end_time[0]) == pytest.approx(0.25, abs=0.0101)  # a step


def test_a_table_may_be_scaled_and_delayed_run_by_run() -> None:
    data = plain(interpolation="hold", outside="hold")
    data["parameters"] = {"delay": 0.02, "scale": 1}
    jet = {"name": "jet", "type": "force", "body": "rod", "value": ["scale*thrust(t - delay)", 0, 0]}
    data["model"] = ROD["model"] | {"forces": [jet]}
    vary = {"parameters.delay": {"distribution": "uniform", "low": -0.1, "high": 0.3},
            "parameters.scale": {"distribution": "normal", "std": 0.3}}  # fmt: skip
    ds = lienumba.run(data | {"sweep": {"runs": 20, "seed": 9, "vary": vary}})
    for n in range(20):
        delay, scale = (float(ds[f"parameters.{name}"][n]) for name in ("delay", "scale"))
        edges = np.clip(np.append(np.array(TIMES) + delay, 9.0), 0.0, 0.5)
        wanted = scale * float(np.sum(np.diff(edges) * VALUES))
        assert 2 * float(ds.velocity[n, -1, 0, 0]) == pytest.approx(wanted, abs=1e-13)


@pytest.mark.parametrize(
    "text", ["root:$6$secret:19000:0\ndaemon:*:19000:0\n", "key secret\nhost a\nport 22\nuser b\n"]
)
def test_nothing_of_a_file_that_is_no_table_is_quoted(tmp_path: Path, text: str) -> None:
    (tmp_path / "file").write_text(text)
    for table in ("tables", "inputs"):
        with pytest.raises(lienumba.ScenarioError, match="is no table of numbers; give a first line") as error:
            resolve(ROD | {table: {"thrust": {"file": str(tmp_path / "file"), "time": "t", "value": "thrust"}}})
        assert "secret" not in str(error.value)
