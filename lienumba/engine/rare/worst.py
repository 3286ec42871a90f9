"""The worst that inputs within bounds can do to a requirement: differential evolution, then exact gradients."""

from typing import TYPE_CHECKING, Any

import numpy as np

from lienumba.batch.execute import usable_cores
from lienumba.engine.progress import shown
from lienumba.engine.rare.limit import Limit, named
from lienumba.engine.runner import check_workers
from lienumba.errors import ScenarioError
from lienumba.scenario.resolve import resolve
from lienumba.store.layout import MARGIN
from lienumba.store.linear_layout import WORST
from lienumba.sweep.copula import followed
from lienumba.sweep.normal import inverse
from lienumba.words import show

if TYPE_CHECKING:
    import xarray as xr

WITHIN = 0.9973  # of each input: three standard deviations
FEWEST = 40
STARTS, APART = 4, 1.0  # points from which gradients lead on; standard deviations between them
STEPS, FLAT = 30, 1e-10  # of such a search; the change that ends it, relative to the one over a standard deviation
LARGEST = 1e150  # instead of an infinite margin


def worst(
    scenario: Any,
    *,
    requirement: str | None = None,
    within: float = WITHIN,
    runs: int = 2000,
    seed: int | None = None,
    overrides: Any = None,
    workers: int | None = None,
    allow_code: bool = False,
    progress: Any = None,
) -> "xr.Dataset":
    """Search for the inputs within bounds with the smallest margin of a requirement.

    By differential evolution (R. Storn, K. Price, Journal of Global Optimization 11 (1997) 341), a generation of
    runs at a time. Where the margin has exact derivatives, it takes a quarter of the runs, and SciPy's SLSQP leads
    on from up to four of its points; it goes on as before where one of them is missing. The bounds of each input
    are the quantiles between which so large a part of its samples lies, whatever correlated ones are; what follows
    from others (a correlation of 1) does so here, too.

    Parameters
    ----------
    scenario : path, dict, System or Scenario
        With `[[requirements]]` and `[sweep.vary]`.
    requirement : str, optional
        Its name; may be omitted where there is one.
    within : float
        The part of each input's samples that lies between its bounds, below 1.
    runs : int
        About how many may be simulated.
    seed, overrides, workers, allow_code, progress
        As in `lienumba.run`.

    Returns
    -------
    xarray.Dataset
        Of all runs that were simulated their inputs, `status` and `requirement_margin` (run, requirement: below 0 if
        not met; NaN of a failed run, than which nothing is worse), and `worst`, the label of the run with the smallest.
        The attributes `runs_with_derivatives` and `notes` say where derivatives were taken, and why not.

    Raises
    ------
    ScenarioError
        For bad input.
    """
    from scipy.optimize import differential_evolution

    resolved = resolve(scenario, overrides=overrides, seed=seed, allow_code=allow_code, counted=False)
    check_workers(workers)
    if isinstance(runs, bool) or not isinstance(runs, int) or runs < FEWEST:
        raise ScenarioError(f"runs = {show(runs)}: must be a whole number, at least {FEWEST}; give such as 2000")
    if not 0.0 < within < 1.0:
        raise ScenarioError(f"within = {show(within)}: must be between 0 and 1; give such as 0.9973")
    with shown(progress) as tell:
        limit = Limit(resolved, named(resolved, requirement), workers or usable_cores(), tell, runs, False)
        size = max(5 * limit.dimensions, 16)
        edge = float(inverse(np.array([0.5 + 0.5 * within]))[0])

        following = _following(limit)

        def margins(z: np.ndarray) -> np.ndarray:
            z = following @ z
            within = (abs(z) <= edge).all(axis=0)
            found = np.full(z.shape[1], np.inf)
            reached = limit(z[:, within].T)
            found[within] = np.where(np.isnan(reached), -np.inf, reached)
            return found

        def evolved(count: int, init: str | np.ndarray = "sobol") -> Any:
            return differential_evolution(
                margins,
                [(-edge, edge)] * limit.dimensions,
                maxiter=max(count // size - 1, 1),
                popsize=max(size // limit.dimensions, 1),
                init=init,
                updating="deferred",
                vectorized=True,
                polish=False,
                tol=1e-8,
                rng=np.random.default_rng(resolved.data.sweep.seed),
            )

        if limit.differentiated is None:
            evolved(runs)
        else:
            last = evolved(runs // 4)
            order = np.argsort(last.population_energies, kind="stable")
            _descend(limit, last.population[order], last.population_energies[order], following, edge)
            if limit.missing:
                evolved(runs - limit.count, last.population)
    variables = limit.kept()
    found = variables[MARGIN][1][:, 0]
    label = int(np.argmin(np.where(np.isnan(found), -np.inf, found)))
    variables["worst"] = ((), label, {"long_name": "the run with the smallest margin"})
    return limit.dataset(WORST, f"worst case: {limit.requirement}", variables, {}, within=within)


def _following(limit: Limit) -> np.ndarray:
    """The matrix that makes of scores of all inputs those of which some follow from others."""
    scores = dict(zip(limit.streams, np.eye(limit.dimensions), strict=True))
    for group in limit.scenario.data.sweep.correlate:
        scores |= followed(scores, group.paths, group.matrix)
    return np.array(list(scores.values()))


def _descend(limit: Limit, points: np.ndarray, margins: np.ndarray, following: np.ndarray, edge: float) -> None:
    """From a few of the points (n, d), best first, to the least margins near them, by exact gradients; where there is
    none, no farther."""
    from scipy.optimize import LinearConstraint, minimize

    starts: list[np.ndarray] = []
    for point, margin in zip(points, margins, strict=True):
        if not np.isfinite(margin) or len(starts) == STARTS:  # nothing is worse than a run that fails
            break
        if all(np.linalg.norm(point - x) > APART for x in starts):
            starts.append(point)
    box = LinearConstraint(following, -edge, edge)
    for start in starts:
        scale: list[float] = []

        def scaled(z: np.ndarray, scale: list[float] = scale) -> tuple[float, np.ndarray]:
            margin, slopes, _ = limit.gradient(np.clip(following @ z, -edge, edge))
            slopes = slopes @ following if np.isfinite(slopes).all() else np.zeros(len(z))
            scale += [] if scale else [float(np.linalg.norm(slopes)) or 1.0]
            bounded = np.nan_to_num(margin / scale[0], nan=-LARGEST, posinf=LARGEST, neginf=-LARGEST)
            return float(bounded), slopes / scale[0]

        minimize(scaled, start, jac=True, method="SLSQP", constraints=box, options={"maxiter": STEPS, "ftol": FLAT})
