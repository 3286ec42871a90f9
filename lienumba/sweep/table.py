"""Samples that somebody else has drawn: a table with a row for each run."""

from __future__ import annotations

from typing import Annotated

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from lienumba.errors import ScenarioError
from lienumba.sweep.distributions.base import Finite
from lienumba.words import Written, option


class SampleTable(BaseModel):
    """As the scenario keeps it: with its numbers, whichever file they came from."""

    model_config = ConfigDict(extra="forbid", defer_build=True)

    columns: dict[str, list[Finite]] = Field(description="the columns by their names, one number for each row")
    runs: list[Annotated[int, Field(strict=True, ge=0)]] | None = Field(
        default=None, description="the run of each row (or omit it: 0, 1, 2 ...)"
    )
    weights: list[Annotated[Finite, Field(ge=0.0)]] | None = Field(
        default=None, description="the weight of each row, at least 0 (or omit it: all count alike)"
    )

    def rows(self) -> int:
        return len(next(iter(self.columns.values()), []))

    def end(self) -> int:
        """One more than the last run."""
        return self.rows() if self.runs is None else max(self.runs, default=-1) + 1

    def indices(self, labels: np.ndarray) -> np.ndarray:
        """The rows of these runs; a ScenarioError where there is none."""
        own = np.arange(self.rows()) if self.runs is None else np.array(self.runs)
        order = np.argsort(own)
        if not len(own) and len(labels):
            raise ScenarioError.at("sweep.table", "has no rows", "give one for each run")
        places = order[np.minimum(np.searchsorted(own, labels, sorter=order), len(own) - 1)]
        lacking = labels[own[places] != labels] if len(labels) else labels
        if len(lacking):
            raise ScenarioError.at(
                "sweep.table",
                f"has no row for run {lacking[0]}",
                f"run those that it has ({option('runs', Written('...'))}), or leave out its column run, so that its "
                "rows are runs 0, 1, 2 ...",
            )
        return places
