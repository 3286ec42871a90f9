"""What is said of a dataset that has been changed, or of which a selection has kept too little."""

from __future__ import annotations

from typing import TYPE_CHECKING

from lienumba.errors import ScenarioError
from lienumba.store.layout import TOGETHER

if TYPE_CHECKING:
    import xarray as xr


def damaged(where: str, what: str) -> ScenarioError:
    """The error of a dataset that somebody or something has changed."""
    return ScenarioError(f"{where}: is not as lienumba wrote it, {what}; make it again, or give the file as it was")


def check_dimension(ds: xr.Dataset, dim: str, where: str) -> None:
    """Refuse one of which a single label is left, without its dimension."""
    if dim in ds.variables and dim not in ds.dims:
        label = ds[dim].values.tolist()
        raise ScenarioError(
            f"{where}: has only one {dim}, without its dimension; select with a list, such as ds.sel({dim}=[{label!r}])"
        )


def check_together(ds: xr.Dataset, where: str) -> None:
    """Refuse one that has something without what it is of no use without."""
    for name, needed in TOGETHER.items():
        for lost in (other for other in needed if name in ds and other not in ds):
            raise damaged(where, f"it has lost {lost}")
