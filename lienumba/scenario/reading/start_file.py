"""The section [start]: coordinates by name, and a dataset from which they are taken."""

from pathlib import Path
from typing import Any

import numpy as np

from lienumba.errors import ScenarioError
from lienumba.scenario.base.toml import Keys
from lienumba.words import listed, show

AT = "start.file"
SAME = 1e-9  # relative: a time nearer than this to a stored one is that
VALUES = ("q", "qd")
OF_FILE = ("file", "run", "time")


def located(raw: Keys, folder: Path) -> Keys:
    """The scenario with the path of the file of its start, which is relative to this folder, and `q.piston.angle = ...`
    without quotes, which TOML reads as a table in a table, as one name."""
    start = raw.get("start")
    if not isinstance(start, dict):
        return raw
    flat = {key: _flat(x) if key in VALUES else x for key, x in start.items()}
    if isinstance(flat.get("file"), str):
        flat["file"] = (folder / flat["file"]).as_posix()
    return {**raw, "start": flat}


def _flat(given: Any) -> Any:
    if not isinstance(given, dict):
        return given
    found: Keys = {}
    for name, item in given.items():
        inner = _flat(item)
        found |= {f"{name}.{rest}": x for rest, x in inner.items()} if isinstance(inner, dict) else {name: item}
    return found


def read_in(raw: Keys) -> Keys:
    """The scenario with the coordinates that the file of its start has, below those that it gives itself."""
    model: Any = raw.get("model")
    start = model.get("start") if isinstance(model, dict) else None
    if not isinstance(start, dict) or not any(key in start for key in OF_FILE):
        return raw
    if not isinstance(start.get("file"), str):
        key = next(key for key in OF_FILE if key in start)
        raise ScenarioError.at(f"start.{key}", "has no meaning without a file", 'give file = "out.nc"', start[key])
    given = {key: x for key, x in start.items() if key not in OF_FILE}
    found = _read(start["file"], start.get("run"), start.get("time"))
    for key in VALUES:
        own = given.get(key, {})
        given[key] = {**_below(found[key], own), **own} if isinstance(own, dict) else own
    return {**raw, "model": {**model, "start": given}}


def _below(found: dict[str, float], own: Keys) -> dict[str, float]:
    """Without what a list gives for all coordinates of a joint."""
    return {name: x for name, x in found.items() if name.partition(".")[0] not in own}


def _read(file: str, run: object, time: object) -> dict[str, dict[str, float]]:
    """q and qd by coordinate, of one run at a stored time: the only or first run, the last time of all."""
    from lienumba.store.files import read as opened

    try:
        dataset = opened(Path(file))
    except ScenarioError as error:
        raise error.inside(f"{AT} = {show(file)}") from None
    with dataset as ds:
        missing = [name for name in VALUES if name not in ds or "time" not in ds[name].dims]
        if missing:
            remedy = "give one that was run with output.joint_coordinates = true"
            raise ScenarioError.at(AT, f"has no {listed(missing)}", remedy, file)
        labels, times = ds[VALUES[0]][ds[VALUES[0]].dims[0]].values.tolist(), ds["time"].values
        place = labels.index(run) if run in labels else 0 if run is None else None
        if place is None:
            raise ScenarioError.at("start.run", f"{file} has no such run", f"give one such as {labels[0]}", run)
        if time is not None and not isinstance(time, int | float):
            raise ScenarioError.at("start.time", "must be a number", "give a stored time in s", time)
        at = len(times) - 1 if time is None else int(np.argmin(np.abs(times - time)))
        if time is not None and not abs(times[at] - time) <= SAME * max(abs(time), 1.0):
            raise ScenarioError.at("start.time", "is not stored", f"the nearest stored time is {times[at]:.9g}", time)
        found = {name: ds[name].values[place, at] for name in VALUES}
        names = [str(name) for name in ds["coordinate"].values]
    if not all(np.isfinite(x).all() for x in found.values()):
        rule = f"run {labels[place]} has no state at t = {times[at]:.9g} s"
        raise ScenarioError.at(AT, rule, "give a run and a time that it reached", file)
    return {key: dict(zip(names, x.tolist(), strict=True)) for key, x in found.items()}
