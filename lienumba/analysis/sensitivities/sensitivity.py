"""Which inputs of a sweep an output depends on: rank correlations, a tornado, Sobol' indices."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
import xarray as xr

from lienumba.analysis.mode_runs import as_runs
from lienumba.analysis.sensitivities import morris, outputs, sobol
from lienumba.analysis.sensitivities.explained import explained
from lienumba.analysis.sensitivities.outputs import Output
from lienumba.analysis.sensitivities.ranks import rank_interval, standard_ranks, tornado
from lienumba.analysis.weights import kept_of, note_of
from lienumba.batch.statuses import GOOD
from lienumba.errors import ScenarioError
from lienumba.scenario.base.toml import Tables
from lienumba.store.form import scenario_tables
from lienumba.store.study_layout import is_study
from lienumba.sweep.distributions.external import Given
from lienumba.sweep.distributions.registry import class_of
from lienumba.sweep.samplers import INDICES, sampler_of
from lienumba.words import plural

FEWEST = 4  # runs, which give the first interval of a rank correlation
ROUNDING = 1e-12  # of the largest value of a variable: what varies by less is constant
ROWS = 1024  # of the saltelli sweep that is proposed
INDEPENDENT = (
    "rank correlations and changes are of samples A and B alone, since the other runs of a saltelli sweep repeat their "
    "numbers"
)
DEPENDENT = (
    "rank correlations, changes and first indices of inputs that depend on one another hold the effects of all of these"
)
NO_SOBOL = "total Sobol' indices are left out, since [[sweep.correlate]] makes inputs depend on one another"
NOT_LAID_OUT = (
    "total Sobol' indices are left out, since the runs are not laid out as those of a saltelli sweep; analyse the "
    "dataset as lienumba run wrote it"
)
CHOSEN = "these outputs were chosen; ask for others by name, such as position or tip.z"
INPUT, OUTPUT = "of the input", "of the output"  # units
ENDS = {"low": "lower", "high": "upper"}
INTERVALS = {
    "rank_correlation": ("1", "Spearman's rank correlation of input and output", "confidence"),
    "change": (OUTPUT, "mean output at the highest tenth of the input minus that at the lowest", "confidence"),
    "first_order": ("1", "first Sobol' index: the part of the variance that the input explains alone", "confidence"),
    "total_order": ("1", "total Sobol' index: the part of the variance that takes the input", "bootstrap"),
    "mu": (OUTPUT, "mean elementary effect of the input", "confidence"),
    "mu_star": (OUTPUT, "mean size of the elementary effects of the input", "confidence"),
    "sigma": (OUTPUT, "standard deviation of the elementary effects of the input", "confidence"),
}
OF_BOTH = {
    "input_low": (INPUT, "10 % quantile of the input"),
    "input_high": (INPUT, "90 % quantile of the input"),
    "low": (OUTPUT, "mean output where the input lies in its lowest tenth"),
    "high": (OUTPUT, "mean output where the input lies in its highest tenth"),
    **{name: texts[:2] for name, texts in INTERVALS.items()},
    **{
        f"{name}_{end}": (units, f"{side} end of the 95 % {kind} interval of {name}")
        for name, (units, _, kind) in INTERVALS.items()
        for end, side in ENDS.items()
    },
}
OF_OUTPUT = {
    "mean": (OUTPUT, "mean output over the runs that count"),
    "deviation": (OUTPUT, "standard deviation of the output over the runs that count"),
    "runs": ("1", "runs that count for rank correlations and changes"),
    "rows": ("1", "complete rows that count for Sobol' indices"),
}

COUNTS = ("runs", "rows")
FIRST_OF_ROWS = (
    "rank correlations, changes and first indices are of the first run of each row, since the others repeat its numbers"
)


def sensitivity(ds: xr.Dataset, output: str | Sequence[str] = (), time: float | None = None) -> xr.Dataset:
    """How outputs of a sweep depend on its inputs, over the good runs, all with 95 % intervals.

    Rank correlations, a tornado, first Sobol' indices, and of a sweep with `sampler = "saltelli"` total ones.

    Parameters
    ----------
    ds : xarray.Dataset
        What `lienumba.run` or `lienumba.modes` returned of a scenario with [sweep].
    output : str or sequence of str
        Names such as `tip` or `position.top.z`, or `failed`, of modes `frequency.3`; those that say most if omitted.
    time : float, optional
        A stored time in s at which series are read; the last if omitted.

    Returns
    -------
    xarray.Dataset
        On the dimensions `output` and `input`; a vector that is drawn as one has ranks by its elements and Sobol'
        indices as a whole. The attribute `notes` says what has been left out.
    """
    ds = as_runs(ds)
    samples = _samples(ds)
    sweep = scenario_tables(ds, "the dataset").get("sweep", {})
    sampled = ds["run"].values >= 0
    inputs, notes = _varying(samples, sampled)
    runs, rows, of_plan = _plan(ds["run"].values, sweep, samples)
    steps = morris.design_of(ds["run"].values, sweep, samples) if sampler_of(sweep).screening else None
    kept = kept_of(ds)
    if kept is not None:
        runs, of_plan = runs[kept[runs]], [*of_plan, note_of(ds, kept)]
    independent = not _in_rows(sweep) or steps is not None
    found, left_out = [], []
    for one in outputs.read(ds, [output] if isinstance(output, str) else output, time, sampled):
        reason = _unusable(one, runs)
        if reason:
            left_out.append(reason)
        else:
            found.append(one)
    if not found:
        raise ScenarioError(f"{left_out[0]}; {_remedy(ds)}")
    evenly = sampler_of(sweep).evenly
    return _dataset(ds, found, inputs, runs, rows, steps, independent, evenly).assign_attrs(
        title=str(ds.attrs.get("title", "")),
        scenario_sha256=str(ds.attrs.get("scenario_sha256", "")),
        runs=int(sampled.sum()),
        failed=int((~ds["status"].isin(GOOD).values & sampled).sum()),
        rows=steps.rows if steps is not None else 0 if rows is None else len(rows.table),
        notes="\n".join([*notes, *of_plan, *left_out, *([] if output else [CHOSEN])]),
    )


def _samples(ds: xr.Dataset) -> dict[str, np.ndarray]:
    """The samples (runs,) of each input."""
    if is_study(ds):
        raise ScenarioError("the dataset is that of a study, which compares settings; give one of a sweep alone")
    names = [str(name) for name, x in ds.coords.items() if x.attrs.get("role") == "input"]
    if not names:
        raise ScenarioError("the dataset has no inputs; give one of a scenario with [sweep.vary]")
    return {name: ds[name].values for name in names}


def _varying(samples: dict[str, np.ndarray], sampled: np.ndarray) -> tuple[dict[str, np.ndarray], list[str]]:
    """The inputs that have more than one value, and a note of the others."""
    if (count := int(np.count_nonzero(sampled))) < 2:
        raise ScenarioError(f"the dataset has {plural(count, 'run', 'runs')} with samples; give one of several")
    constant = [name for name, x in samples.items() if not (x[sampled] != x[sampled][:1]).any()]
    if len(constant) == len(samples):
        raise ScenarioError(f"the inputs do not vary: {', '.join(constant)}; give each a spread in [sweep.vary]")
    note = [f"inputs that do not vary are left out: {', '.join(constant)}"] if constant else []
    return {name: x for name, x in samples.items() if name not in constant}, note


def _plan(
    labels: np.ndarray, sweep: Tables, samples: dict[str, np.ndarray]
) -> tuple[np.ndarray, sobol.Rows | None, list[str]]:
    """The runs (indices) that count for ranks, the rows of Sobol' indices if there are any, and what to say of it."""
    every, in_rows = np.flatnonzero(labels >= 0), _in_rows(sweep)
    rows = sobol.rows_of(labels, sweep, samples) if in_rows else None
    runs, notes = (every, []) if rows is None else (rows.independent, [INDEPENDENT])
    if sweep.get("correlate") or any(issubclass(class_of(entry), Given) for entry in sweep.get("vary", {}).values()):
        notes = [*notes, DEPENDENT]
    if sweep.get("correlate"):
        return runs, None, [*notes, NO_SOBOL]
    if sampler_of(sweep).row is not None and not in_rows:
        first = sampler_of(sweep).counting(labels, len(sobol.sampled_inputs(sweep)))
        return np.flatnonzero(first), None, [*notes, FIRST_OF_ROWS]
    if in_rows:
        return runs, rows, notes if rows is not None else [*notes, NOT_LAID_OUT]
    d = len(sobol.sampled_inputs(sweep)) or len(samples)
    proposal = f"({d} + 2)*2^m runs, such as sweep.runs = {(d + 2) * ROWS}"
    return runs, None, [*notes, f'total Sobol\' indices need sweep.sampler = "{INDICES}" and {proposal}']


def _in_rows(sweep: Tables) -> bool:
    """Whether runs were drawn in rows for Sobol' indices, which share numbers."""
    return sampler_of(sweep).sobol_indices


def _unusable(output: Output, runs: np.ndarray) -> str | None:
    """Why an output cannot be analysed."""
    values = output.values[runs]
    infinite = int(np.isinf(values).sum())
    values = values[np.isfinite(values)]
    if len(values) < FEWEST:
        have = plural(len(values), "good run has", "good runs have")
        return f"{output.name}: {have} a value, and an analysis takes at least {FEWEST}"
    if np.ptp(values) <= ROUNDING * output.scale:
        if infinite:
            others = f"and infinite in {plural(infinite, 'run', 'runs')}, such as a time of what never happens"
            return f"{output.name}: is {values[0]:.6g} in {plural(len(values), 'run', 'runs')}, {others}"
        return f"{output.name}: is {values[0]:.6g} in all runs, so it depends on no input"
    return None


def _remedy(ds: xr.Dataset) -> str:
    failed = int((~ds["status"].isin(GOOD)).sum())
    return "see with lienumba info why runs failed" if 2 * failed > ds.sizes["run"] else "ask for another output"


def _dataset(
    ds: xr.Dataset,
    found: list[Output],
    inputs: dict[str, np.ndarray],
    runs: np.ndarray,
    rows: sobol.Rows | None,
    steps: morris.Design | None,
    independent: bool,
    evenly: bool,
) -> xr.Dataset:
    """What was found of every output and input, labelled; independent: whether no run shares numbers with others;
    evenly: whether runs are spread more so than by chance."""
    drawn = rows.inputs if rows is not None else list(steps.steps) if steps is not None else []
    names = list(dict.fromkeys([*inputs, *drawn]))
    of_both = {name: np.full((len(found), len(names)), np.nan) for name in OF_BOTH}
    of_output = {name: np.zeros(len(found), int if name in COUNTS else float) for name in OF_OUTPUT}
    ranks: dict[bytes, list[np.ndarray]] = {}  # of the inputs, by the runs that count
    for n, output in enumerate(found):
        kept = runs[np.isfinite(output.values[runs])]
        y = output.values[kept]
        table = {name: x[n] for name, x in of_both.items()}
        if kept.tobytes() not in ranks:
            ranks = {kept.tobytes(): [standard_ranks(x[kept]) for x in inputs.values()]}
        for k, numbers in enumerate(_compare(y, (x[kept] for x in inputs.values()), ranks[kept.tobytes()])):
            _put(table, k, numbers)
        for k, x in enumerate(inputs.values() if independent else ()):
            _put(table, k, explained(x[kept], y, evenly))
        indices = None if rows is None else sobol.indices(output.values, rows)
        for name, numbers in ({} if indices is None else indices.by_input()).items():
            _put(table, names.index(name), numbers)
        for name, effects in ({} if steps is None else morris.effects(output.values, steps)).items():
            _put(table, names.index(name), effects)
        own = {"mean": y.mean(), "deviation": y.std(ddof=1), "runs": len(y), "rows": indices.rows if indices else 0}
        _put(of_output, n, own)
    data = {
        **{name: (("output", "input"), x, _texts(*OF_BOTH[name])) for name, x in of_both.items()},
        **{name: ("output", x, _texts(*OF_OUTPUT[name])) for name, x in of_output.items()},
    }
    return xr.Dataset(data, _coordinates(ds, found, names))


def _put(table: dict[str, np.ndarray], index: int, numbers: dict[str, float]) -> None:
    for name, value in numbers.items():
        table[name][index] = value


def _compare(y: np.ndarray, samples: Iterable[np.ndarray], ranks: list[np.ndarray]) -> list[dict[str, float]]:
    """Ranks and tornado of an output y (n,) over each input (n,)."""
    own, found = standard_ranks(y), []
    for x, rank in zip(samples, ranks, strict=True):
        r = float(own @ rank)
        low, high = rank_interval(r, len(y))
        correlation = {"rank_correlation": r, "rank_correlation_low": low, "rank_correlation_high": high}
        found.append(correlation | tornado(x, y))
    return found


def _texts(units: str, long_name: str) -> dict[str, str]:
    return {"units": units, "long_name": long_name}


def _coordinates(ds: xr.Dataset, found: list[Output], inputs: list[str]) -> dict[str, Any]:
    units = [str(ds[name].attrs.get("units", "1")) if name in ds.coords else "" for name in inputs]
    return {
        "output": ("output", [x.name for x in found], _texts("1", "name of the output")),
        "input": ("input", inputs, _texts("1", "path of the input")),
        "output_units": ("output", [x.units for x in found], _texts("1", "units of the output")),
        "output_long_name": ("output", [x.long_name for x in found], _texts("1", "what the output is")),
        "output_time": ("output", [x.time for x in found], _texts("s", "time of the output; NaN: once in a run")),
        "input_units": ("input", units, _texts("1", "units of the input")),
    }
