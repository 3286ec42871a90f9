"""Each variable of each kind of dataset is removed once: what reads the rest ends with success or a sentence."""

import contextlib
from collections.abc import Callable
from pathlib import Path

import xarray as xr

from faults_campaign import subjects
from faults_campaign.attack import Outcome, book
from faults_campaign.commands import tried

READING = (
    ["info"], ["analyse"], ["table", "-o", "a.csv"], ["report", "-o", "b.html"], ["plot", "-o", "c.png"],
    ["animate", "-o", "d.svg"],
)  # fmt: skip


def removals(folder: Path, tell: Callable[[str], None]) -> Outcome:
    """By every reading command, and compared with the dataset as it was."""
    found = Outcome()
    for kind, sound in subjects.prepared(folder).items():
        with xr.open_dataset(sound) as ds:
            names = [*map(str, ds.variables)]
        for n, name in enumerate(names):
            path = folder / f"{kind}{n}.nc"  # HDF5 may still hold another open
            with xr.open_dataset(sound) as ds:
                ds.drop_vars(name).to_netcdf(path, engine="netcdf4")
            lines = [[command, str(path), *rest] for command, *rest in READING]
            with contextlib.chdir(folder):
                for line in [*lines, ["compare", str(path), str(sound)]]:
                    end = tried(line)
                    book(found, end.code, end.fault, f"{kind} without {name}, {line[0]}")
            path.unlink()
            found.files += 1
        tell(f"{kind}: each of {len(names)} variables removed, {len(found.faults)} faults")
    return found
