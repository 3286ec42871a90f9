"""What a file holds, as lines of text: a dataset of lienumba, or a scenario."""

from collections.abc import Callable, Collection, Iterable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from lienumba.store.layout import VERDICT, warnings_in
from lienumba.store.linear_layout import MODES, is_modes
from lienumba.store.targets import DATASET_STARTS
from lienumba.words import plural

if TYPE_CHECKING:
    import xarray as xr

    from lienumba.scenario.resolve import Scenario

FIRST_LABELS = 8  # of failed runs


def describe(file: Path, allow_code: bool = False, verbose: bool = False) -> str:
    """Lines about a dataset or a scenario; allow_code: whether code may run that a scenario brings; verbose: with the
    operations of its kernels."""
    return _either(file, describe_dataset, partial(describe_scenario, verbose=verbose), allow_code, (MODES,))


def cite(file: Path, allow_code: bool = False) -> str:
    """Return BibTeX entries for a dataset or a scenario."""
    from lienumba.present.cite import cite_dataset, cite_scenario

    return _either(file, cite_dataset, cite_scenario, allow_code)


def _either(
    file: Path,
    of_dataset: Callable[["xr.Dataset"], str],
    of_scenario: Callable[["Scenario"], str],
    allow_code: bool,
    kinds: Collection[str] = (),
) -> str:
    """What is told of a dataset or of a scenario, which the first bytes of a file tell apart; kinds: see `reading`."""
    if file.is_file():
        with file.open("rb") as stream:
            if stream.read(8).startswith(DATASET_STARTS):
                from lienumba.store.files import reading

                with reading(file, kinds) as (dataset, _):
                    return of_dataset(dataset)
    from lienumba.scenario.resolve import resolve

    return of_scenario(resolve(file, allow_code=allow_code))


def describe_dataset(dataset: "xr.Dataset") -> str:
    """What a dataset holds, how its runs ended, and where it comes from."""
    attributes = dataset.attrs
    runs = dataset["run"].values
    inputs = [str(name) for name, item in dataset.coords.items() if item.attrs.get("role") == "input"]
    rows: dict[str, str] = {
        "title": str(attributes.get("title", "")),
        "source": str(attributes.get("source", "")),
        "runs": f"{len(runs)} (labels {runs[0]} to {runs[-1]})",
        **(_modes(dataset) if is_modes(dataset) else _extent(dataset) | _variables(dataset)),
        "inputs": ", ".join(inputs) or "none",
        "status": "" if is_modes(dataset) else _statuses(dataset),
        "warnings": f"\n{'':13}".join(warnings_in(dataset)),
        "stopped": str(attributes.get("stopped", "")),
        "verdict": str(attributes.get(VERDICT, "")).replace("\n", f"\n{'':13}"),
        "size": f"{dataset.nbytes / 1e6:.1f} MB in memory",
        "reactions": _shared(dataset),
        "scenario": f"sha256 {attributes['scenario_sha256']}, seed {attributes.get('seed')}",
        "versions": ", ".join(
            f"{key.removesuffix('_version')} {value}" for key, value in attributes.items() if key.endswith("_version")
        ),
        "cpu": str(attributes.get("cpu", "")),
        "history": str(attributes.get("history", "")),
    }
    return _table(rows)


def _extent(dataset: "xr.Dataset") -> dict[str, str]:
    """What there is beside the runs: times, bodies and joints; or the grid of a study."""
    from lienumba.store.study_layout import grid_of, is_study

    if is_study(dataset):
        points = plural(dataset["time_per_run"].size, "point", "points")
        return {"study": f"{points}: {', '.join(_label(dataset, name) for name in grid_of(dataset))}"}
    times = dataset["time"].values.tolist() if "time" in dataset else []
    return {
        "times": f"{len(times)} from {times[0]:g} to {times[-1]:g} s" if len(times) else "none: of each run a summary",
        "bodies": _names(dataset, "body"),
        "joints": _names(dataset, "joint") if "joint" in dataset.coords or len(times) else "",
        "coordinates": _names(dataset, "coordinate") if "coordinate" in dataset.coords else "",
    }


def _modes(dataset: "xr.Dataset") -> dict[str, str]:
    """Times, and the frequencies of all modes at each of them."""
    from lienumba.analysis.mode_rows import mode_rows

    found = {"bodies": _names(dataset, "body"), "modes": str(dataset.sizes["mode"])}
    for rows, time in zip(mode_rows(dataset), dataset["time"].values, strict=True):
        table = [rows.table.headings, *rows.table.rows]
        widths = [max(map(len, column)) for column in zip(*table, strict=True)]
        lines = ["  ".join(x.ljust(width) for x, width in zip(row, widths, strict=True)).rstrip() for row in table]
        found[f"t = {time:g} s"] = f"\n{'':13}".join([rows.headline.partition(": ")[2], *lines, *rows.notes])
    return found


def _variables(dataset: "xr.Dataset") -> dict[str, str]:
    """What is there beside what every dataset has of each run."""
    from lienumba.store.layout import FULL, VARIABLES

    kept = {str(name): x.dims for name, x in dataset.data_vars.items()}
    fates = {name for name, spec in VARIABLES.items() if "time" not in spec.dims and kept.get(name) == spec.dims}
    if FULL not in dataset.dims:
        return {"variables": ", ".join(name for name in kept if name not in fates)}
    runs = dataset[FULL].values
    return {
        "variables": ", ".join(name for name, dims in kept.items() if name not in fates and FULL not in dims),
        "full runs": f"{len(runs)} (labels {', '.join(map(str, runs[:FIRST_LABELS]))}"
        f"{', ...' if len(runs) > FIRST_LABELS else ''}), with "
        + ", ".join(name for name, dims in kept.items() if FULL in dims),
    }


def _label(dataset: "xr.Dataset", name: str) -> str:
    from lienumba.analysis.studies.study import text

    labels = dict.fromkeys(filter(None, map(text, dataset[name].values)))
    return f"{name} ({', '.join(labels)})"


def _shared(dataset: "xr.Dataset") -> str:
    names = next((x.attrs["not_unique"] for x in dataset.data_vars.values() if "not_unique" in x.attrs), None)
    return f"not unique for {names}; those of least norm are stored" if names else ""


def _names(dataset: "xr.Dataset", dimension: str) -> str:
    if dimension not in dataset.coords:
        return "none"
    names = [str(name) for name in dataset[dimension].values]
    return ", ".join(names) if len(names) <= 12 else f"{len(names)}: {', '.join(names[:10])}, ..."


def _statuses(dataset: "xr.Dataset") -> str:
    from lienumba.batch.statuses import GOOD, STATUSES

    codes = dataset["status"].values
    parts, reasons = [], []
    for status in STATUSES:
        ended = (codes == status.code).reshape(len(codes), -1)  # of a study: at any point
        labels = [str(label) for label in dataset["run"].values[ended.any(axis=1)]]
        if labels:
            more = ", ..." if len(labels) > FIRST_LABELS else ""
            which = "" if status.code == 0 else f" (runs {', '.join(labels[:FIRST_LABELS])}{more})"
            parts.append(f"{int(ended.sum())} {status.name}{which}")
            reasons += [] if status.code in GOOD else [f"{status.name}: {status.sentence}"]
    return f"\n{'':13}".join([", ".join(parts), *reasons])


def describe_scenario(scenario: "Scenario", verbose: bool = False) -> str:
    """What a mechanism is made of and what its constraints amount to at the start; verbose: its flops, too."""
    from lienumba.engine import runner
    from lienumba.mechanics.elements.inputs import input_form
    from lienumba.mechanics.elements.quantities import is_input
    from lienumba.mechanics.system import constraints
    from lienumba.scenario.start.hint import RESTS, hint

    nominal = runner.check_initial(scenario)
    model, rank = nominal.model, nominal.rank
    sizes = {c.name: c.rows for c in constraints.constraints_of(model)}
    redundant = ", ".join(f"{number} of {name}" for name, number in rank.redundant.items())
    rows = {
        "title": scenario.data.title,
        "size": scenario.headline(),
        "study": "" if scenario.plan is None else scenario.plan.headline(),
        "bodies": ", ".join(body.name for body in model.bodies),
        "joints": _each((joint.name, f"{joint.type}, {sizes[joint.name]}") for joint in model.joints) or "none",
        "drivers": _each((driver.name, f"{driver.motion}, {sizes[driver.name]}") for driver in model.drivers),
        "forces": _each((force.name, force.type) for force in model.forces if not is_input(force.name)),
        "quantities": _each((x.name, x.type) for x in model.quantities if not is_input(x.name)),
        "inputs": _each((name, input_form(x) or "") for name, x in scenario.data.model.inputs.items()),
        "constraints": f"{plural(rank.rows, 'row', 'rows')} of rank {rank.rank} at the start, "
        f"{plural(rank.freedom, 'degree', 'degrees')} of freedom",
        "redundant": f"{redundant} (rows that follow from those before them)" if redundant else "",
        "reactions": f"not unique for {', '.join(rank.shared)}; those of least norm are stored" if rank.shared else "",
        "start": "" if nominal.rests is None else RESTS[nominal.rests],
        "hint": hint(nominal) if scenario.plan is None else "",
        "flops": _flops(runner.operation_counts(scenario)) if verbose else "",
        "sha256": scenario.sha256(),
    }
    return _table(rows)


def _each(items: Iterable[tuple[str, str]]) -> str:
    return ", ".join(f"{name} ({what})" for name, what in items)


def _flops(counts: dict[str, dict[str, int]]) -> str:
    """Operations of each kernel, as its graph counts them; a fused one is two."""
    return ", ".join(f"{kernel} {numbers['flops']:,}" for kernel, numbers in counts.items()) + " (per run and call)"


def _table(rows: dict[str, str]) -> str:
    return "\n".join(f"{name + ':':<13}{text}" for name, text in rows.items() if text)
