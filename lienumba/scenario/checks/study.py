"""What is wrong with a study in itself: its reference and the paths of its grids. Its points are tried one by one."""

from collections.abc import Iterable, Mapping, Sequence

from lienumba.errors import UNKNOWN
from lienumba.mechanics.elements.events import ends_run
from lienumba.mechanics.system.output_variables import usual
from lienumba.scenario.base import paths
from lienumba.scenario.base.problems import Report
from lienumba.scenario.base.toml import Keys
from lienumba.scenario.checks import reference_formulas
from lienumba.scenario.formulas.parameters import Parameters
from lienumba.scenario.reading.extends import replaced_by
from lienumba.scenario.reading.loading import MODEL_KEYS, tokens_of
from lienumba.scenario.schema.scenario import Integrator
from lienumba.scenario.study_errors import STATE
from lienumba.words import printable, show, suggestion

MARK = "sha256"  # of the reference's file
SETTINGS = ("integrator", "projection")
ROOTS = ("model", *MODEL_KEYS, "parameters", "tables", *SETTINGS)
EXAMPLES = {
    "model": "bodies.top.mass", "parameters": "parameters.kp", "tables": "tables.thrust.interpolation",
    "integrator": "integrator.step", "projection": "projection.velocity",
}  # fmt: skip
SAME = {
    "sweep": "whose samples are the same at each point",
    "output": "which is the same at each point, so that errors can be compared",
    "study": "which is the grid itself",
}
FORMS = 'settings such as { method = "dop853", step = 1e-4 }, formulas, or { file = "ref.nc" }'


def check_study(
    study: Mapping[str, object],
    output: object,
    model: Keys,
    bodies: Sequence[str],
    parameters: Parameters,
    report: Report,
) -> None:
    """Check the section [study]; output: the section of it; model: as written."""
    reference = study.get("reference")
    if isinstance(reference, dict):
        _check_reference(reference, bodies, parameters, report)
    one_problem = isinstance(reference, dict) and "file" in reference
    grids = study.get("grid")
    for number, grid in enumerate(grids if isinstance(grids, list) else []):
        if isinstance(grid, dict):
            _check_grid(f"study.grid[{number}]", grid, one_problem, model, report)
    events = model.get("events")
    for event in events if isinstance(events, list) else []:
        if isinstance(event, dict) and ends_run(event.get("action")):
            at = f"model.events.{event.get('name')}.action"
            report.add(at, "a study compares motions to their end", 'give "record"', event["action"])
    output = output if isinstance(output, dict) else {}
    for key in ("mode", "summary", "full_runs", "precision"):
        if output.get(key) not in (None, {}, "full", "float64"):
            report.add(f"output.{key}", "has no meaning in a study, which stores errors", "leave it out")
    stored = output.get("variables")
    if isinstance(stored, list) and not set(usual()) <= set(map(str, stored)):
        report.warn("output.variables", "has no meaning in a study, which stores errors", "leave it out")


def _check_reference(reference: Keys, bodies: Sequence[str], parameters: Parameters, report: Report) -> None:
    at = "study.reference"
    if not reference:
        report.add(at, "is empty", f"give {FORMS}", {})
    elif "file" in reference:
        _check_keys(at, reference, ("file", MARK), "a file", report)
        if not isinstance(reference["file"], str):
            report.add(f"{at}.file", "must be a text in quotes", value=reference["file"])
    elif reference.keys() & set(STATE):
        if _check_keys(at, reference, STATE, "formulas", report):
            reference_formulas.check_formulas(reference, bodies, parameters, report)
    else:
        for key in reference:
            _check_setting(at, key, report)
            both = set(replaced_by(key)) & reference.keys()
            if both and key == min(key, *both):
                report.add(at, f"gives both {key} and {min(both)}", "leave one of them out")


def _check_keys(at: str, reference: Iterable[str], known: Sequence[str], what: str, report: Report) -> bool:
    other = [key for key in reference if key not in known]
    if other:
        report.add(f"{at}.{_shown(other[0])}", f"has no meaning beside {what}", "leave one of them out")
    return not other


def _check_setting(at: str, key: str, report: Report) -> None:
    root, dot, _ = key.partition(".")
    known = [name for name in Integrator.model_fields if name != "end_time"]
    if key in ("end_time", "integrator.end_time"):
        report.add(f"{at}.{_shown(key)}", "is that of the scenario", "leave it out")
    elif not dot and key not in known:
        report.add(f"{at}.{_shown(key)}", "", suggestion(key, [*known, "file", *STATE]), verb=UNKNOWN)
    elif dot and root not in SETTINGS:
        rule = "is not a setting of integrator or projection, and a reference solves the same problem"
        report.add(f"{at}.{_shown(key)}", rule, "leave it out")


def numerical(tokens: list[paths.Token]) -> bool:
    """Whether a setting says how a problem is solved, not which."""
    return tokens[0] in SETTINGS and tokens != ["integrator", "end_time"]


def _check_grid(place: str, grid: Keys, one_problem: bool, model: Keys, report: Report) -> None:
    if not grid:
        report.add(place, "is empty", 'give paths with lists of values, such as "integrator.step" = [1e-2]')
    seen: dict[tuple[paths.Token, ...], str] = {}
    for path, values in grid.items():
        at = f"{place}.{_shown(path)}"
        if isinstance(values, dict):
            report.add(at, "a path needs quotes", f'write "{_dotted(path, values)}" = [...]')
            continue
        if not isinstance(values, list) or not values:
            report.add(at, "must be a list of values", "give at least one in []", values)
            continue
        try:
            tokens = _known(path)
            if one_problem and not numerical(tokens):
                raise paths.PathError(
                    "changes what is solved, but study.reference.file has one motion",
                    "give the reference as settings or formulas",
                )
            ending = [x for x in values if ends_run(x)] if tokens[-1] == "action" else []
            if ending:
                raise paths.PathError(
                    "stops runs at a value, but a study compares motions to their end", f"leave {show(ending[0])} out"
                )
            named = tuple(paths.named(tokens, model))
            if named in seen:
                raise paths.PathError(f'is the same as "{seen[named]}"', "give it once")
            seen[named] = path
            other = [twin for key in replaced_by(named[-1]) if (twin := seen.get((*named[:-1], key))) is not None]
            if other:
                raise paths.PathError(f'takes the place of "{other[0]}", so they cannot be crossed', "give two grids")
        except paths.PathError as error:
            report.problems.append(error.of(printable(path)).inside(at))
            continue
        twice = next((i for i, value in enumerate(values) if value in values[:i]), None)
        if twice is not None:
            report.add(f"{at}[{twice}]", "is there twice", "give it once", values[twice])


def _known(path: str) -> list[paths.Token]:
    """The keys of a path that a grid may have."""
    tokens = tokens_of(path)
    root = str(tokens[0])
    if root in SAME:
        raise paths.PathError(
            f"is part of {root}, {SAME[root]}", f"give a path of the model or of {' or '.join(SETTINGS)}"
        )
    if root not in ROOTS:
        raise paths.PathError("leads to nothing that a study can change", suggestion(root, ROOTS))
    if len(tokens) == 1:
        raise paths.PathError("is a whole section", f"give the path of one of its keys, such as {EXAMPLES[root]}")
    return tokens


def _dotted(key: str, value: object) -> str:
    """The path that was written without quotes, which TOML reads as tables in tables."""
    while isinstance(value, dict) and value:
        inner, value = next(iter(value.items()))
        key = f"{key}.{inner}"
    return key


def _shown(key: str) -> str:
    return show(key) if not key.isidentifier() else key
