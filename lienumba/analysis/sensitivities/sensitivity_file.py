"""What was found of outputs as a file: CSV with one row for each output, and input, or netCDF."""

from __future__ import annotations

import xarray as xr

from lienumba.store.outputs import Output, whole, write

ENDINGS = (".csv", ".nc")


def save(found: xr.Dataset, output: Output) -> None:
    """Write what `sensitivity` or `compare` found."""
    if output.path.suffix.lower() == ".nc":
        write(found, output)
        return
    with whole(output) as partial:
        found.drop_vars("output_long_name", errors="ignore").to_dataframe().reset_index().to_csv(partial, index=False)
