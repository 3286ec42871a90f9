"""Datasets that somebody or something has changed: attributes, variables, dimensions, bits."""

import random
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import netCDF4
import numpy as np
import xarray as xr

Change = Callable[[xr.Dataset, random.Random], xr.Dataset]
TEXTS = [
    "", "x", "5", "nan", "a b c", "days since 2000-01-01", "\x1b[31m\x1b]0;x\x07", "a\nb", "\x00", "µ" * 300,
    "[" * 3000, "model = 5", "[model]\nbodies = 3", "sweep = 1", "[sweep]\nruns = 'x'", "[sweep]\nvary = {a = 1}",
    "a = 1" * 2, "../../etc/passwd", "<script>", "success non_finite",
]  # fmt: skip


def value(pick: random.Random) -> Any:
    """What an attribute may hold."""
    return pick.choice([
        pick.choice(TEXTS), pick.randint(-5, 5), 2.5, float("nan"), np.array([1, 2, 3]), np.array([0.5]),
        np.array([], np.int32), np.int8(3), 1 << 40,
    ])  # fmt: skip


def attribute(ds: xr.Dataset, pick: random.Random) -> xr.Dataset:
    """One of the whole or of a variable: another value, or none; sometimes one that netCDF gives a meaning."""
    named = pick.choice([None, *ds.variables])
    attrs = ds.attrs if named is None else ds[named].attrs
    special = ["units", "coordinates", "flag_values", "flag_meanings", "role", "path", "not_unique", "calendar",
               "missing_value", "dtype", "bounds", "stopped", "title", "grid_mapping"]  # fmt: skip
    key = pick.choice([*attrs, *attrs, pick.choice(special)])
    if pick.random() < 0.3:
        attrs.pop(key, None)
    else:
        attrs[key] = value(pick)
    return ds


def scenario(ds: xr.Dataset, pick: random.Random) -> xr.Dataset:
    """A line of the scenario: gone, twice, with another value, or the text cut."""
    lines = str(ds.attrs.get("scenario", "")).split("\n")
    n = pick.randrange(len(lines))
    kind = pick.choice(["gone", "twice", "value", "cut", "word"])
    if kind == "gone":
        del lines[n]
    elif kind == "twice":
        lines.insert(n, lines[n])
    elif kind == "cut":
        lines = lines[:n]
    elif kind == "word":
        lines[n] = lines[n].replace(pick.choice("aeiou"), pick.choice('xyz_0"'))
    elif "=" in lines[n]:
        given = pick.choice(["5", "-1", "nan", '"x"', "[]", "{}", "true", "1e400", "[1, [2]]", "'top'", "99999999999"])
        lines[n] = f"{lines[n].partition('=')[0]}= {given}"
    return ds.assign_attrs(scenario="\n".join(lines))


def variable(ds: xr.Dataset, pick: random.Random) -> xr.Dataset:
    """One of another type, with other values, another name, or gone."""
    name = pick.choice([*ds.variables])
    x = ds.variables[name]
    kind = pick.choice(["gone", "type", "values", "name", "dims", "scalar"])
    if kind == "gone":
        return ds.drop_vars(name)
    if kind == "name":
        return ds.rename_vars({name: pick.choice(["x", "status", "run", "a b", "position", "\u202e"])})
    if kind == "dims" and x.dims:
        dims = list(x.dims)
        pick.shuffle(dims)
        dims[0] = pick.choice([dims[0], "elsewhere"])
        values = x.values if dims == list(x.dims) else np.zeros([2 + n for n in range(len(dims))])
        return ds.drop_vars(name).assign({name: (dims, values)})
    if kind == "scalar":
        return ds.drop_vars(name).assign({name: pick.choice([1.0, "x", 3])})
    if x.dtype.kind not in "fiu":
        values = np.array([pick.choice(TEXTS).replace("\x00", "") for _ in range(x.size)]).reshape(x.shape)
    elif kind == "type":
        values = x.values.astype(pick.choice(["f4", "i1", "u8", "S3"]), casting="unsafe")
    else:
        given = pick.choice([np.nan, np.inf, -np.inf, 1e308, -1e308, 0.0, -1.0, 77.0, 1e-320])
        values = np.where(np.random.default_rng(pick.randrange(99)).random(x.shape) < 0.5, given, x.values)
        values = values.astype(pick.choice([x.dtype, np.dtype("f8")]), casting="unsafe")
    kept = x.attrs if pick.random() < 0.8 else {}
    return ds.drop_vars(name).assign({name: (x.dims, values, kept)})


def dimension(ds: xr.Dataset, pick: random.Random) -> xr.Dataset:
    """One that is shorter, without labels, reversed, of another name, or of no length."""
    dim = pick.choice([*ds.dims])
    kind = pick.choice(["some", "none", "unlabelled", "reversed", "name", "one", "twice"])
    if kind == "unlabelled":
        return ds.drop_vars(dim, errors="ignore")
    if kind == "name":
        return ds.rename({dim: pick.choice(["elsewhere", "case", "full_run", "event", "time_"])})
    length = ds.sizes[dim]
    parts = {"some": list(range(0, length, 2)), "none": [], "reversed": list(range(length))[::-1], "twice": [0, 0]}
    return ds.isel({dim: 0 if kind == "one" else parts[kind]})


CHANGES: list[Change] = [attribute, attribute, scenario, scenario, variable, variable, dimension]


def changed(source: Path, target: Path, pick: random.Random) -> str:
    """Write a dataset with one or two changes, or with other bits; what was done."""
    if pick.random() < 0.2:
        return bits(source, target, pick)
    told = []
    with xr.open_dataset(source, engine="netcdf4", decode_times=False) as opened:
        ds = opened.load()
    for change in pick.choices(CHANGES, k=pick.choice([1, 1, 2])):
        try:
            ds = change(ds, pick)
            told.append(change.__name__)
        except (ValueError, KeyError, IndexError, TypeError):  # xarray knows that it cannot be
            continue
    for x in ds.variables.values():
        x.encoding.clear()
    try:
        ds.to_netcdf(target, engine="netcdf4")
    except Exception:  # it cannot be written so
        shutil.copy(source, target)
        return raw(target, pick)
    return " and ".join(told)


def raw(target: Path, pick: random.Random) -> str:
    """An attribute that xarray would not write."""
    with netCDF4.Dataset(target, "a") as file:
        where = pick.choice([file, *file.variables.values()])
        key = pick.choice([*where.ncattrs(), "units", "scale_factor", "add_offset", "coordinates"])
        try:
            where.setncattr(key, value(pick))
        except Exception:
            return "nothing"
    return f"raw {key}"


def bits(source: Path, target: Path, pick: random.Random) -> str:
    """Other bytes, fewer, more, or a hole."""
    content = bytearray(source.read_bytes())
    kind = pick.choice(["cut", "flip", "flip", "zeros", "more"])
    if kind == "cut":
        content = content[: pick.randrange(len(content))]
    elif kind == "flip":
        for _ in range(pick.choice([1, 1, 10])):
            content[pick.randrange(len(content))] ^= 1 << pick.randrange(8)
    elif kind == "zeros":
        first = pick.randrange(len(content))
        content[first : first + 512] = bytes(len(content[first : first + 512]))
    else:
        content += b"more"
    target.write_bytes(content)
    return kind
