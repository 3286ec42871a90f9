"""What a table of samples must have: a row for each run, and columns for all that varies with them."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from lienumba.scenario.base import paths
from lienumba.scenario.base.problems import read
from lienumba.sweep.distributions.base import Distribution
from lienumba.sweep.distributions.external import Column
from lienumba.sweep.samplers import DEFAULT, SAMPLERS
from lienumba.sweep.samplers.independent import TABLE
from lienumba.sweep.table import SampleTable
from lienumba.words import show, suggestion

if TYPE_CHECKING:
    from lienumba.scenario.base.problems import Report


def check_table(sweep: dict[str, Any], vary: Mapping[str, Distribution], report: "Report") -> None:
    """Check the table with what varies by its columns."""
    sampler = sweep.get("sampler", DEFAULT)
    given = sampler in SAMPLERS and SAMPLERS[sampler].from_table
    raw, names = sweep.get("table"), {path: kind.names for path, kind in vary.items() if isinstance(kind, Column)}
    if given and raw is None:
        report.problems.append('sweep.table is missing; give { file = "design.csv" }, a table of samples')
        return
    if raw is None:
        report.problems += [
            f'sweep.vary."{path}".column: there is no table; give sweep.sampler = "{TABLE.name}" and sweep.table'
            for path in names
        ]
        return
    if not given:
        report.problems.append(
            f'sweep.sampler = {show(sampler)}: takes nothing from sweep.table; give sampler = "{TABLE.name}", or leave '
            "the table out"
        )
    table = read(SampleTable, raw)
    if table is None:
        return
    _check_rows(sweep, table, report)
    for path, needed in names.items():
        report.problems += [
            f'sweep.vary."{path}".column = {show(name)}: is no column of sweep.table; {suggestion(name, table.columns)}'
            for name in dict.fromkeys(needed)
            if name not in table.columns
        ]
    used = {name for needed in names.values() for name in needed}
    report.problems += [
        f"sweep.table: nothing varies with its column {show(name)}; take it out, or out of sweep.vary what draws it"
        for name in table.columns
        if name not in used and not any(str(problem).startswith(_taken(name)) for problem in report.problems)
    ]


def no_path(name: str, error: paths.PathError) -> str:
    """What is wrong with a column whose name is no path."""
    return f"{_taken(name)} {error}, or say in sweep.vary what varies with it: {{ column = {show(name)} }}"


def _taken(name: str) -> str:
    return f"sweep.table: its column {show(name)}, taken as a path,"


def _check_rows(sweep: dict[str, Any], table: SampleTable, report: "Report") -> None:
    rows = {name: len(numbers) for name, numbers in table.columns.items()}
    lengths = rows | ({} if table.runs is None else {"run": len(table.runs)})
    if len(set(lengths.values())) > 1:
        listed = ", ".join(f"{name}: {number}" for name, number in lengths.items())
        report.problems.append(
            f"sweep.table: its columns have different lengths ({listed}); give a number for each row"
        )
        return
    if not table.rows():
        report.problems.append("sweep.table: has no rows; give one for each run")
        return
    if table.runs is not None and len(set(table.runs)) < len(table.runs):
        twice = next(label for label in table.runs if table.runs.count(label) > 1)
        report.problems.append(f"sweep.table: has two rows for run {twice}; give each run one")
    runs = sweep.get("runs", 1)
    if isinstance(runs, int) and runs > table.end():
        last = "rows" if table.runs is None else "as the end of its column run"
        report.problems.append(
            f"sweep.runs = {runs}: sweep.table has only {table.end()} {last}; give at most that many, or leave runs out"
        )
