"""What a citation is written from."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from lienumba.scenario.base.toml import Tables

if TYPE_CHECKING:
    import xarray as xr

INSTEAD = {"integrator.step": "integrator.tolerance", "integrator.tolerance": "integrator.step"}


@dataclass(frozen=True)
class CitedScenario:
    """content: the resolved scenario; units, nominal: of the varied paths; versions: by package; dataset: what came
    out, or None."""

    content: Tables
    units: Mapping[str, str]
    nominal: Tables
    versions: Mapping[str, str]
    dataset: "xr.Dataset | None" = None

    @property
    def grids(self) -> list[Tables]:
        """Those of a study; none of a sweep."""
        found: list[Tables] = self.content.get("study", {}).get("grid", [])
        return found

    def values(self, path: str) -> list[Any]:
        """What a setting was: its one value, or those on the grids of a study."""
        section, _, key = path.partition(".")
        found: list[Any] = []
        for grid in self.grids or [{}]:
            replaced = INSTEAD.get(path) in grid
            found += grid.get(path, [] if replaced else [self.content[section].get(key)])
        return [value for n, value in enumerate(found) if value is not None and value not in found[:n]]
