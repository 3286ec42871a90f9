"""What the sampler of a sweep needs: as many runs as fit, not too many inputs, correlations that can be, a table with a
row for each run and columns for all that varies with them."""

from collections.abc import Mapping

from lienumba.errors import Problem
from lienumba.scenario.base import paths
from lienumba.scenario.base.problems import Report, read
from lienumba.scenario.base.toml import Keys
from lienumba.scenario.schema.sweep import Correlation
from lienumba.store.layout import WEIGHT
from lienumba.sweep.copula import MatrixError, cholesky
from lienumba.sweep.distributions.base import Distribution
from lienumba.sweep.distributions.external import Column
from lienumba.sweep.distributions.inertia import Inertia
from lienumba.sweep.distributions.rotations import Direction, RotationNormal, RotationUniform
from lienumba.sweep.samplers import DEFAULT, GROWING, SAMPLERS, Sampler
from lienumba.sweep.samplers.importance import IMPORTANCE
from lienumba.sweep.samplers.independent import TABLE
from lienumba.sweep.table import SampleTable
from lienumba.words import listed, plural, show, suggestion


def check_sampler(sweep: Keys, vary: Mapping[str, Distribution], model: Keys, report: Report) -> None:
    """Check the sampler with the inputs that vary, by their canonical paths."""
    sampler, runs = SAMPLERS.get(str(sweep.get("sampler", DEFAULT))), sweep.get("runs", 1)
    inputs = sum(kind.dimensions > 0 for kind in vary.values())
    if sampler is not None:
        if sampler.row is not None:
            _check_rows(sampler, sampler.row(inputs), inputs, runs, report)
        used = sampler.dimensions(sum(kind.dimensions for kind in vary.values()))
        if sampler.most_dimensions is not None and used > sampler.most_dimensions:
            others = sorted(x.name for x in SAMPLERS.values() if x.most_dimensions is None and not x.from_table)
            rule = f"has at most {sampler.most_dimensions} dimensions, but sweep.vary needs {used}"
            report.add("sweep.sampler", rule, f"take {listed(map(show, others), 'or')}", sampler.name)
    _check_correlations(sweep, sampler, vary, model, report)
    _check_proposals(sweep, sampler, vary, model, report)


def _check_proposals(
    sweep: Keys, sampler: Sampler | None, vary: Mapping[str, Distribution], model: Keys, report: Report
) -> None:
    """Proposals are of streams that are drawn, with a sampler that weighs."""
    given = sweep.get("proposal", {})
    if sampler is None or not isinstance(given, dict):
        return
    if sampler.weighted and not given:
        remedy = 'give { "path" = { shift = 2.0 } } for one input at least'
        report.miss("sweep.proposal", remedy)
    if given and not sampler.weighted:
        remedy = f'give sampler = "{IMPORTANCE.name}", or take sweep.proposal out'
        report.add("sweep.sampler", "takes no proposals", remedy, sampler.name)
    streams = {name: kind for path, kind in vary.items() for name in kind.streams(path)}
    seen: dict[str, str] = {}
    for path in given:
        at = f'sweep.proposal."{path}"'
        try:
            name = paths.canonical(path, model)
        except paths.PathError as error:
            report.problems.append(error.of(path).inside(at))
            continue
        if name not in streams:
            whole = vary.get(name)
            own = whole.streams(name) if whole is not None else []
            remedy = f"give one of its parts, {listed(map(show, own), 'or')}" if own else suggestion(name, streams)
            report.add(at, "is drawn as a whole of several" if own else "is not drawn from a distribution", remedy)
        elif name in seen:
            report.add(at, f"is the same as {show(seen[name])}", "give it once")
        seen.setdefault(name, path)


def _check_rows(sampler: Sampler, row: int, inputs: int, runs: object, report: Report) -> None:
    """Runs in whole rows, of so many each."""
    if not inputs:
        report.add("sweep.sampler", "no distribution varies", "give at least two", sampler.name)
    elif isinstance(runs, int) and runs % row:
        below = runs - runs % row
        rule = f'must be a multiple of {row} for the sampler "{sampler.name}" with {inputs} inputs that vary'
        report.add("sweep.runs", rule, f"give {' or '.join(str(n) for n in (below, below + row) if n)}", runs)


def _check_correlations(
    sweep: Keys, sampler: Sampler | None, vary: Mapping[str, Distribution], model: Keys, report: Report
) -> None:
    groups = sweep.get("correlate", [])
    seen: dict[str, str] = {}
    for index, raw in enumerate(groups if isinstance(groups, list) else ()):
        at = f"sweep.correlate[{index}]"
        group = read(Correlation, raw)
        if group is None:
            continue
        if sampler is not None and sampler.independent:
            rule = f'the sampler "{sampler.name}" is for inputs that vary independently'
            report.add(at, rule, f'leave the correlation out, or take "{GROWING}"')
        for number, path in enumerate(group.paths):
            here = f"{at}.paths[{number}]"
            try:
                name = paths.canonical(path, model)
                wrong = _not_correlated(name, vary)
            except paths.PathError as error:
                name, wrong = path, (error.problem.verb, error.problem.remedy)
            if name in seen:
                wrong = f"is there already as {seen[name]}", "put all its correlations into one matrix"
            seen.setdefault(name, here)
            if wrong:
                report.add(here, *wrong, path)
        problem = _wrong_matrix(f"{at}.matrix", group)
        report.problems += [problem] if problem else []


def _not_correlated(name: str, vary: Mapping[str, Distribution]) -> tuple[str, str] | None:
    """Why what stands at a path cannot be correlated, and the remedy."""
    kinds = {inner: kind for path, kind in vary.items() for inner in (path, *kind.streams(path), *kind.columns(path))}
    kind = kinds.get(name)
    if kind is None:
        return "does not vary", suggestion(name, kinds)
    if not kind.dimensions:
        return "is not drawn from a distribution", "correlate what is"
    if isinstance(kind, RotationUniform | Direction):
        return "is uniform on a sphere or on all rotations, which has no correlations", "take it out"
    if isinstance(kind, Inertia):
        return "is a part of a random inertia, which has no correlations", "take it out"
    if isinstance(kind, RotationNormal) and kind.covariance is not None:
        return "has correlations in its covariance already", "give std instead, and all correlations here"
    if isinstance(kind, RotationNormal) and not any(name in kind.streams(path) for path in vary):
        return "is a rotation", "give components of its rotation vector, which end with [0], [1] and [2]"
    return None


def _wrong_matrix(at: str, group: Correlation) -> Problem | None:
    """What is wrong with a matrix of correlations."""
    size, matrix = len(group.paths), group.matrix
    if len(matrix) != size or any(len(row) != size for row in matrix):
        lengths = " and ".join(sorted({str(len(row)) for row in matrix})) or "no"
        shape = f"{plural(len(matrix), 'row', 'rows')} of {lengths} numbers"
        return Problem(at, f"has {shape} for {size} paths", f"give {size} rows of {size}")
    for i, row in enumerate(matrix):
        if row[i] != 1.0:
            return Problem(f"{at}[{i}][{i}]", "must be 1, the correlation of a path with itself", "write 1", row[i])
        for j, x in enumerate(row):
            if not abs(x) <= 1.0:
                return Problem(f"{at}[{i}][{j}]", "is no correlation", "give a number from -1 to 1", x)
    try:
        cholesky(matrix)
    except MatrixError as error:
        return Problem(at, "", error.problem.remedy, verb=error.problem.rule)
    return None


def check_table(sweep: Keys, vary: Mapping[str, Distribution], report: Report) -> None:
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
        remedy = f'give sampler = "{TABLE.name}", or leave the table out'
        report.add("sweep.sampler", "takes nothing from sweep.table", remedy, sampler)
    table = read(SampleTable, raw)
    if table is None:
        return
    _check_table_rows(sweep, table, report)
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


def _check_table_rows(sweep: Keys, table: SampleTable, report: Report) -> None:
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
        rule = f"sweep.table has only {table.end()} {last}"
        report.add("sweep.runs", rule, "give at most that many, or leave runs out", runs)
