"""What a table of samples must have: a row for each run, and columns for all that varies with them."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

from lienumba.errors import Problem
from lienumba.scenario.base import paths
from lienumba.scenario.base.problems import read
from lienumba.scenario.base.toml import Keys
from lienumba.store.layout import WEIGHT
from lienumba.sweep.distributions.base import Distribution
from lienumba.sweep.distributions.external import Column
from lienumba.sweep.samplers import DEFAULT, SAMPLERS
from lienumba.sweep.samplers.independent import TABLE
from lienumba.sweep.table import SampleTable
from lienumba.words import show, suggestion

if TYPE_CHECKING:
    from lienumba.scenario.base.problems import Report


def check_table(sweep: Keys, vary: Mapping[str, Distribution], report: "Report") -> None:
    """Check the table with what varies by its columns."""
    sampler = sweep.get("sampler", DEFAULT)
    given = isinstance(sampler, str) and sampler in SAMPLERS and SAMPLERS[sampler].from_table
    raw, names = sweep.get("table"), {path: kind.names for path, kind in vary.items() if isinstance(kind, Column)}
    if given and raw is None:
        report.miss("sweep.table", 'give { file = "design.csv" }, a table of samples')
        return
    if raw is None:
        for path in names:
            remedy = f'give sweep.sampler = "{TABLE.name}" and sweep.table'
            report.add(f'sweep.vary."{path}".column', "there is no table", remedy)
        return
    if not given:
        report.add(
            "sweep.sampler",
            "takes nothing from sweep.table",
            f'give sampler = "{TABLE.name}", or leave the table out',
            sampler,
        )
    table = read(SampleTable, raw)
    if table is None:
        return
    _check_rows(sweep, table, report)
    for path, needed in names.items():
        for name in dict.fromkeys(needed):
            if name not in table.columns:
                remedy = suggestion(name, table.columns)
                report.add(f'sweep.vary."{path}".column', "is no column of sweep.table", remedy, name)
    used = {name for needed in names.values() for name in needed}
    told = {problem.place for problem in report.problems}
    for name in table.columns:
        if name not in used and _taken(name) not in told:
            rule = f"nothing varies with its column {show(name)}"
            report.add("sweep.table", rule, "take it out, or out of sweep.vary what draws it")


def no_path(name: str, error: paths.PathError) -> Problem:
    """What is wrong with a column whose name is no path."""
    verb, remedy = error.problem.verb, error.problem.remedy
    other = f", or let another path vary with it in sweep.vary: {{ column = {show(name)} }}"
    verb, remedy = (verb, remedy + other) if remedy else (verb + other, "")
    return Problem(_taken(name), "", remedy, verb=verb, within=("sweep.table",))


def _taken(name: str) -> str:
    return f"its column {show(name)}, taken as a path,"


def _check_rows(sweep: Keys, table: SampleTable, report: "Report") -> None:
    rows = {name: len(numbers) for name, numbers in table.columns.items()}
    lengths = rows | {name: len(x) for name, x in (("run", table.runs), (WEIGHT, table.weights)) if x is not None}
    if len(set(lengths.values())) > 1:
        listed = ", ".join(f"{name}: {number}" for name, number in lengths.items())
        report.add("sweep.table", f"its columns have different lengths ({listed})", "give a number for each row")
        return
    if not table.rows():
        report.add("sweep.table", "has no rows", "give one for each run")
        return
    if table.runs is not None and len(set(table.runs)) < len(table.runs):
        twice = next(label for label in table.runs if table.runs.count(label) > 1)
        report.add("sweep.table", f"has two rows for run {twice}", "give each run one")
    runs = sweep.get("runs", 1)
    if isinstance(runs, int) and runs > table.end():
        last = "rows" if table.runs is None else "as the end of its column run"
        report.add(
            "sweep.runs",
            f"sweep.table has only {table.end()} {last}",
            "give at most that many, or leave runs out",
            runs,
        )
