"""The samples of a scenario's sweep: drawn, read from its table, and derived from one another."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from lienumba.scenario.formulas import dependent_inputs
from lienumba.sweep import design
from lienumba.sweep.design import NOMINAL_RUN, design_table
from lienumba.sweep.distributions.external import Expression

if TYPE_CHECKING:
    from lienumba.scenario.resolve import Scenario


def draw(
    scenario: "Scenario",
    labels: Sequence[int],
    uniforms: Mapping[str, np.ndarray] | None = None,
    *,
    correlate: bool = True,
) -> dict[str, np.ndarray]:
    """Samples (runs,) of every number that varies, by its path, for any of the runs; a run is the same in all of them.
    uniforms: numbers in (0, 1) by the names of all streams, instead of those that the sampler draws; correlate: whether
    they are independent as yet.

    What `build` needs to know of these runs: a quaternion or an inertia is there with all its components.
    """
    sweep, nominal = scenario.data.sweep, scenario.nominal()
    samples = design_table(
        {path: kind for path, kind in sweep.vary.items() if not isinstance(kind, Expression)},
        nominal,
        labels,
        sweep.seed,
        sampler=sweep.sampler,
        count=sweep.runs,
        correlate=[(group.paths, group.matrix) for group in sweep.correlate if correlate],
        table=sweep.table,
        proposals=sweep.proposal,
        uniforms=uniforms,
    )
    _derive(scenario, labels, nominal, samples)
    return {name: samples[name] for path, kind in sweep.vary.items() for name in kind.columns(path)}


def weights(scenario: "Scenario", labels: Sequence[int] | np.ndarray) -> np.ndarray:
    """Of runs of a sweep that gives them weights (runs,)."""
    sweep, labels = scenario.data.sweep, np.asarray(labels, np.int64)
    if sweep.table is None or sweep.table.weights is None:
        return design.weights(sweep.vary, sweep.proposal, labels, sweep.seed)
    found, drawn = np.ones(labels.shape), labels != NOMINAL_RUN
    found[drawn] = np.asarray(sweep.table.weights)[sweep.table.indices(labels[drawn])]
    return found


def _derive(
    scenario: "Scenario",
    labels: Sequence[int],
    nominal: Mapping[str, Any],
    samples: dict[str, np.ndarray],
) -> None:
    """Add what follows from other samples."""
    of_nominal = np.asarray(labels) == NOMINAL_RUN
    for path, formula in dependent_inputs.ordered(scenario.data.sweep.vary, scenario.parameters).items():
        values = scenario.parameters.values(samples) | samples
        with np.errstate(all="ignore"):  # a run with what is no number is marked
            found = formula(0.0, **{name: values[name] for name in formula.used})
        samples[path] = np.where(of_nominal, nominal[path], found)
