"""What was found of outputs as a file: CSV with one row for each output, and input, or netCDF."""

from __future__ import annotations

from contextlib import AbstractContextManager
from pathlib import Path

import xarray as xr

from lienumba.errors import ScenarioError
from lienumba.store.outputs import Output, whole, write
from lienumba.store.targets import CHOOSE, DATASET_STARTS, claimed

ENDINGS = (".csv", ".nc")
STARTS = (b"output,", *DATASET_STARTS)  # of a file of each


def claimed_findings(target: Path, overwrite: bool, *read: Path) -> AbstractContextManager[Output]:
    """Own the file of what is found in the files `read`, from before these are opened; refuse one of them, and one that
    must not be replaced."""
    if target.exists() and any(path.exists() and path.samefile(target) for path in read):
        raise ScenarioError(f"output = {target}: is what is to be read; {CHOOSE}")
    return claimed(target, "table", ENDINGS, overwrite, STARTS)


def save(found: xr.Dataset, output: Output) -> None:
    """Write what `sensitivity` or `compare` found."""
    if output.path.suffix.lower() == ".nc":
        write(found, output)
        return
    with whole(output) as partial:
        found.drop_vars("output_long_name", errors="ignore").to_dataframe().reset_index().to_csv(partial, index=False)
