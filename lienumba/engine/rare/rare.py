"""How probable it is that a requirement is not met, where that is too rare to be counted."""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from lienumba.batch.execute import usable_cores
from lienumba.engine.progress import shown
from lienumba.engine.rare.design_points import form
from lienumba.engine.rare.estimate import Estimate, Margins
from lienumba.engine.rare.importance import importance
from lienumba.engine.rare.limit import Limit, named
from lienumba.engine.rare.subset import subset
from lienumba.engine.runner import check_workers
from lienumba.errors import ScenarioError
from lienumba.scenario.resolve import resolve
from lienumba.store.linear_layout import RARE
from lienumba.words import show, suggestion

if TYPE_CHECKING:
    import xarray as xr

METHODS: dict[str, Callable[[Margins, int, int, int, float], Estimate]] = {
    "subset": subset,
    "importance": importance,
    "form": form,
}
RUNS = {"subset": 2400, "importance": 6000, "form": 40}
EXPECTED = {"subset": 6.4, "importance": 1.1, "form": 10.0}  # runs in all, of those asked for


def rare(
    scenario: Any,
    *,
    requirement: str | None = None,
    method: str = "subset",
    runs: int | None = None,
    confidence: float = 0.95,
    seed: int | None = None,
    overrides: Any = None,
    workers: int | None = None,
    allow_code: bool = False,
    progress: Any = None,
) -> "xr.Dataset":
    """Estimate the probability that a run does not meet a requirement, however small it is.

    Inputs are functions of standard normal numbers, correlations included; runs are simulated where those are on the
    way to failure, or fail. Failed runs of the simulation do not meet the requirement.

    Parameters
    ----------
    scenario : path, dict, System or Scenario
        With `[[requirements]]` and `[sweep.vary]`.
    requirement : str, optional
        Its name; may be omitted where there is one.
    method : str
        "subset" (subset simulation, with whatever limit), "importance" (sampling about the points where failures are
        most probable: narrower, where there are few of these), "form" (the limit is taken for a plane there: no
        interval).
    runs : int, optional
        Of each level of "subset" (2,400), or that "importance" draws (6,000).
    confidence : float
        Of the interval.
    seed, overrides, workers, allow_code, progress
        As in `lienumba.run`.

    Returns
    -------
    xarray.Dataset
        `probability` with `probability_low` and `probability_high`; of all runs that were simulated the inputs, their
        `status` and `requirement_margin` (run, requirement: below 0 if not met); on `design_point`, nearest first, the
        `distance` (in standard deviations), the inputs there as `design_INPUT`, and on `stream` the `direction` whose
        squares say how much each random number has to do with it. The attributes `runs_with_derivatives` and
        `notes` say whether design points were sought by exact gradients, and why not.

    Raises
    ------
    ScenarioError
        For bad input, and where a method cannot say anything, with what can.
    """
    resolved = resolve(scenario, overrides=overrides, seed=seed, allow_code=allow_code, counted=False)
    check_workers(workers)
    if method not in METHODS:
        raise ScenarioError(f"method = {show(method)}: is not known; {suggestion(str(method), METHODS)}")
    if runs is not None and (isinstance(runs, bool) or not isinstance(runs, int) or runs < 40):
        raise ScenarioError(f"runs = {show(runs)}: must be a whole number, at least 40; give such as 1000")
    if not 0.0 < confidence < 1.0:
        raise ScenarioError(f"confidence = {show(confidence)}: must be between 0 and 1; give such as 0.95")
    with shown(progress) as tell:
        runs = runs or RUNS[method]
        expected = int(EXPECTED[method] * runs)
        limit = Limit(resolved, named(resolved, requirement), workers or usable_cores(), tell, expected)
        found = METHODS[method](limit, limit.dimensions, runs, resolved.data.sweep.seed, float(confidence))
    variables, coordinates = limit.kept(), dict[str, Any]()
    what = f"probability that a run does not meet the requirement {show(limit.requirement)}"
    for name, x in (("", found.probability), ("_low", found.low), ("_high", found.high)):
        variables[f"probability{name}"] = ((), x, {"long_name": what, "units": "1", "confidence": found.confidence})
    if len(found.design_points):
        direction = found.design_points / np.maximum(found.distances, 1e-300)[:, None]
        coordinates["stream"] = limit.streams
        variables["distance"] = ("design_point", found.distances, {"units": "1"})
        variables["direction"] = (("design_point", "stream"), direction, {"units": "1"})
        for path, values in limit.inputs(found.design_points).items():
            variables[f"design_{path}"] = ("design_point", values, {"units": limit.units_of(path)})
    return limit.dataset(RARE, f"{method}: {limit.requirement}", variables, coordinates, method=method)
