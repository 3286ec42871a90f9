"""The table of samples of `[sweep]`: from a CSV or netCDF file to columns that inputs vary with."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from lienumba.errors import BadValueError, ScenarioError
from lienumba.keys.formulas import LARGEST
from lienumba.scenario.base.text_table import text_table
from lienumba.scenario.base.toml import Keys, table_in
from lienumba.scenario.schema.tables import ENDINGS, decimal_of, reading
from lienumba.store.layout import WEIGHT
from lienumba.store.opening import netcdf_file
from lienumba.words import show

AT = "sweep.table"
RUN = "run"  # the column of the labels
GROUPED = {".rotation": 4, ".target": 4, ".inertia": 6}  # what several columns give together, by its last key
Columns = dict[str, list[float]]


def with_samples(raw: Keys, folder: Path) -> Keys:
    """The scenario with the numbers of its table of samples in place of the file, whose path is relative to this
    folder; each column whose name is a path takes the place of what `vary` says of it."""
    sweep = raw.get("sweep")
    table = sweep.get("table") if isinstance(sweep, dict) else None
    if not isinstance(sweep, dict) or not isinstance(table, dict):
        return raw
    if "file" in table:
        table = _read(table, folder)
    columns, vary = table.get("columns"), sweep.get("vary", {})
    if not isinstance(columns, dict) or not isinstance(vary, dict):
        return {**raw, "sweep": {**sweep, "table": table}}
    counted = {"runs": _end(table)} if "runs" not in sweep else {}
    vary = {**vary, **_entries(columns, vary)}
    return {**raw, "sweep": {**sweep, **counted, "vary": vary, "table": table}}


def _end(table: Keys) -> int:
    """One more than the last run of a table, which may be wrong in itself."""
    runs, columns = table.get("runs"), [x for x in table_in(table, "columns").values() if isinstance(x, list)]
    whole = isinstance(runs, list) and runs and all(isinstance(label, int) for label in runs)
    return max(runs) + 1 if whole and isinstance(runs, list) else max(map(len, columns), default=0)


def _entries(columns: Mapping[str, object], vary: Mapping[str, object]) -> Keys:
    """What varies with the columns that no entry of `vary` names yet."""
    given = [entry["column"] for entry in vary.values() if isinstance(entry, dict) and "column" in entry]
    named = {
        name for entry in given for name in (entry if isinstance(entry, list) else [entry]) if isinstance(name, str)
    }
    left = [name for name in columns if name not in named]
    found: Keys = {}
    for name in left:
        stem = name.partition("[")[0]
        width = next((number for key, number in GROUPED.items() if stem.endswith(key)), 0)
        group = [f"{stem}[{i}]" for i in range(width)]
        if name in group and set(group) <= set(left) and not vary.keys() & set(group):
            found[stem] = {"column": group}
        else:
            found[name] = {"column": name}
    return found


def _read(table: Keys, folder: Path) -> Keys:
    for key in table:
        if key not in ("file", "decimal"):
            raise ScenarioError.at(
                f"{AT}.{key}", "the samples come from file already", f"leave out either file or {key}"
            )
    path = folder / str(table["file"])
    with reading(AT, table["file"], path):
        columns = _netcdf(path) if path.suffix.lower() in ENDINGS else _text(path, decimal_of(AT, table))
        for name, numbers in columns.items():
            for row, x in enumerate(numbers):
                if not abs(x) <= LARGEST:
                    raise BadValueError(f"row {row + 1} of column {show(name)}: {x} is no finite number", "correct it")
        runs, weights = columns.pop(RUN, None), columns.pop(WEIGHT, None)
        if any(x < 0.0 for x in weights or ()):
            raise BadValueError(f"column {WEIGHT}: has a weight below 0", "correct it")
        weighted = {} if weights is None else {"weights": weights}
        if runs is None:
            return {"columns": columns, **weighted}
        if not all(x.is_integer() and x >= -1.0 for x in runs):
            raise BadValueError(f"column {RUN}: has labels that are no whole numbers from 0 on", "correct them")
        kept = [row for row, x in enumerate(runs) if x >= 0.0]  # the nominal run is not sampled
        return {
            "columns": {name: [numbers[row] for row in kept] for name, numbers in columns.items()},
            "runs": [int(runs[row]) for row in kept],
            **{name: [numbers[row] for row in kept] for name, numbers in weighted.items()},
        }


def _text(path: Path, decimal: str) -> Columns:
    table = text_table(path, decimal)
    return {name: table[name] for name in table.names}


def _netcdf(path: Path) -> Columns:
    """The sampled inputs of a dataset, and its runs."""
    with netcdf_file(path) as file:
        inputs = [name for name, x in file.variables.items() if getattr(x, "role", None) == "input"]
        if not inputs:
            raise BadValueError(
                'has no sampled inputs (variables with the attribute role = "input")',
                "give a dataset of a sweep, or a file that lienumba sample has written",
            )
        read = [*inputs, *(name for name in (RUN, WEIGHT) if name in file.variables)]
        return {name: np.ma.filled(np.ma.asarray(file.variables[name][:], float), np.nan).tolist() for name in read}
