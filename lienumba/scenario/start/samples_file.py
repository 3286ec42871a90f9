"""The design table alone, as a CSV or netCDF file that may serve as the table of a sweep."""

from collections.abc import Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from lienumba.errors import ScenarioError
from lienumba.scenario.reading.sample_table import RUN
from lienumba.scenario.schema.tables import ENDINGS
from lienumba.scenario.start.design import draw, weights
from lienumba.store.layout import WEIGHT
from lienumba.store.outputs import Output, whole, write
from lienumba.store.targets import DATASET_STARTS, claimed
from lienumba.sweep.design import NOMINAL_RUN

if TYPE_CHECKING:
    from lienumba.scenario.resolve import Scenario

CSV = ".csv"


@dataclass(frozen=True)
class InputStatistics:
    """Of the samples of one input, the nominal run left out; mean, std: by the weights of the runs."""

    path: str
    units: str
    mean: float
    std: float
    low: float
    high: float


def claimed_samples(target: Path, overwrite: bool) -> AbstractContextManager[Output]:
    """Own the table, from before anything is drawn; refuse one that could not be written or must not be replaced."""
    return claimed(target, "table of samples", (CSV, *ENDINGS), overwrite, (*DATASET_STARTS, RUN.encode()))


def sample(scenario: "Scenario", labels: Sequence[int], output: Output) -> list[InputStatistics]:
    """Draw the samples of these runs into a file; how each input statistics."""
    samples = draw(scenario, labels)
    weight = {WEIGHT: weights(scenario, labels)} if scenario.weighted else {}
    if not samples:
        raise ScenarioError.at("sweep.vary", "is empty, so there is nothing to draw", "vary at least one number")
    of = {path: scenario.units(path) for path in samples}
    if output.path.suffix.lower() == CSV:
        _write_csv(labels, samples | weight, output)
    else:
        _write_netcdf(scenario, labels, samples, weight, of, output)
    drawn = np.array([label != NOMINAL_RUN for label in labels])
    counted = drawn if drawn.any() else ~drawn
    own = weight[WEIGHT][counted] if weight else np.ones(int(counted.sum()))
    found = []
    for path, x in ((path, x[counted]) for path, x in samples.items()):
        mean = float(np.average(x, weights=own))
        std = float(np.average((x - mean) ** 2, weights=own) ** 0.5)
        found.append(InputStatistics(path, of[path], mean, std, float(x.min()), float(x.max())))
    return found


def _write_csv(labels: Sequence[int], samples: dict[str, np.ndarray], output: Output) -> None:
    """Every number with all its digits."""
    lines = [",".join([RUN, *samples])]
    columns = [map(repr, column.tolist()) for column in samples.values()]
    lines += [",".join(row) for row in zip(map(str, labels), *columns, strict=True)]
    with whole(output) as partial:
        partial.write_text("\n".join(lines) + "\n", encoding="utf-8")


def _write_netcdf(
    scenario: "Scenario",
    labels: Sequence[int],
    samples: dict[str, np.ndarray],
    weight: dict[str, np.ndarray],
    of: dict[str, str],
    output: Output,
) -> None:
    import xarray as xr

    from lienumba.store import layout

    run = xr.Variable(RUN, np.asarray(labels, np.int32), layout.texts(*layout.COORDINATES[RUN]), {"_FillValue": None})
    attributes = {
        "title": scenario.data.title, "scenario": scenario.to_toml(), "scenario_sha256": scenario.sha256(),
        "seed": scenario.data.sweep.seed,
    }  # fmt: skip
    spec = layout.VARIABLES[WEIGHT]
    own = {name: xr.Variable(RUN, x, layout.texts(spec.units, spec.long_name)) for name, x in weight.items()}
    write(xr.Dataset(own, {RUN: run} | layout.input_coordinates(samples, of, len(labels)), attributes), output)
