"""Whether two datasets say the same of a run, to the bit, as far as both say something."""

import numpy as np
import xarray as xr

from lienumba.store.layout import FULL, VARIABLES


def of_run(ds: "xr.Dataset", label: int) -> "xr.Dataset":
    """All that a dataset has of a run, loaded."""
    found = ds.isel(run=[int((ds["run"].values == label).argmax())])
    if FULL in ds.dims:
        found = found.isel({FULL: (ds[FULL].values == label).nonzero()[0][:1]})
    return found.load()


def common(there: "xr.Dataset", here: "xr.Dataset") -> "tuple[xr.Dataset, xr.Dataset]":
    """Both, with what they have in common. The iterations since the stored time before are not: they belong to an
    interval between stored times."""
    since = [name for name, spec in VARIABLES.items() if spec.since]
    names = [name for name in there.data_vars if name in here.data_vars and name not in since]
    one, other = xr.align(there[names], here[names], join="inner")
    return one, other


def times_of(ds: "xr.Dataset") -> int:
    """At how many times the course of the run is known."""
    return int(ds.sizes.get("time", 0)) if ds.sizes.get(FULL, 1) else 0


def first_difference(there: "xr.Dataset", here: "xr.Dataset") -> str:
    """Where two datasets of the same variables and labels first differ, in words; "" if they are the same."""
    found = []
    for order, name in enumerate(map(str, there.data_vars)):
        dims, others = (tuple(map(str, ds[name].dims)) for ds in (there, here))
        if dims != others:
            return f"{name} has the dimensions {', '.join(dims)} there, and {', '.join(others)} here"
        places = np.argwhere(_differ(there[name].values, here[name].values))
        if len(places):
            timed = "time" in dims
            place = places[places[:, dims.index("time")].argmin()] if timed else places[0]
            found.append((place[dims.index("time")] if timed else np.inf, order, name, place))
    if not found:
        return ""
    _, _, name, place = min(found, key=lambda entry: entry[:2])
    return _told(there[name], here[name], tuple(place))


def _differ(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Where bits differ; one NaN is like another."""
    if a.dtype.kind != "f":
        return np.asarray(a != b)
    both = np.isnan(a) & np.isnan(b)
    return np.asarray(~both & (a.astype(float).view(np.int64) != b.astype(float).view(np.int64)))


def _told(there: "xr.DataArray", here: "xr.DataArray", place: tuple[int, ...]) -> str:
    labels = {str(dim): there[dim].values[n] for dim, n in zip(there.dims, place, strict=True)}
    time = labels.get("time")
    rest = [str(label) for dim, label in labels.items() if dim not in ("run", FULL, "time")]
    where = f" ({', '.join(rest)})" if rest else ""
    when = "" if time is None else f" at t = {time:g} s"
    a, b = (x.values[place].item() for x in (there, here))
    return f"{there.name}{where}{when} is {a!r} there and {b!r} here"
