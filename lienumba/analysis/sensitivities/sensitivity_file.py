"""A sensitivity analysis as a file: CSV with one row for each output and input, or netCDF."""

from __future__ import annotations

from pathlib import Path

import xarray as xr

from lienumba.store import files

ENDINGS = (".csv", ".nc")


def save(found: xr.Dataset, target: Path) -> None:
    """Write what `sensitivity` found."""
    if target.suffix.lower() == ".nc":
        files.write(found, target)
        return
    with files.whole(target) as partial:
        found.drop_vars("output_long_name").to_dataframe().reset_index().to_csv(partial, index=False)
