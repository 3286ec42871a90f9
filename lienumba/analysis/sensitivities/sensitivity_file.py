"""A sensitivity analysis as a file: CSV with one row for each output and input, or netCDF."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from lienumba.errors import ScenarioError
from lienumba.store import files

if TYPE_CHECKING:
    import xarray as xr

FORMATS = (".csv", ".nc")


def check_target(target: Path) -> None:
    """Refuse, before anything is computed, a file that cannot be written, or exists."""
    if target.suffix.lower() not in FORMATS:
        raise ScenarioError(f"output = {target}: is no table; give a name that ends in .csv or .nc")
    if target.exists():
        raise ScenarioError(f"output = {target}: exists already; choose another name, or delete it")
    files.check_target(target, overwrite=False)


def save(found: xr.Dataset, target: Path) -> None:
    """Write what `sensitivity` found."""
    if target.suffix.lower() == ".nc":
        files.write(found, target)
        return
    try:
        found.drop_vars("output_long_name").to_dataframe().reset_index().to_csv(target, index=False)
    except OSError as error:
        raise files.WriteError(
            f"output = {target}: could not be written ({error.strerror}); make room there, or choose another folder"
        ) from error
