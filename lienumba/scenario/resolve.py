"""The resolved scenario: checked, every default filled in, ready to be built, stored and hashed."""

import copy
import hashlib
import json
import os
from collections.abc import Mapping, Sequence, Set
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pydantic import ValidationError

from lienumba.errors import Problem, ScenarioError
from lienumba.mechanics.elements.events import SET
from lienumba.mechanics.elements.inputs import written
from lienumba.mechanics.elements.quantities import QUANTITIES
from lienumba.mechanics.system.joint_coordinates import JOINT_COORDINATES
from lienumba.mechanics.system.output_variables import usual
from lienumba.numerics.number import Vector
from lienumba.scenario.base import paths, timegrid, toml
from lienumba.scenario.base.code import PYTHON, identities
from lienumba.scenario.base.paths import BESIDE, LISTS, START
from lienumba.scenario.base.problems import tables
from lienumba.scenario.base.toml import Keys, table_in
from lienumba.scenario.base.units import units
from lienumba.scenario.checks.integrator import damping_of, method_of
from lienumba.scenario.checks.scenario import check_scenario
from lienumba.scenario.formulas.numbers import take
from lienumba.scenario.formulas.parameters import TIME, Parameters
from lienumba.scenario.reading.loading import apply_overrides, load, name_unnamed, with_files
from lienumba.scenario.schema import messages
from lienumba.scenario.schema.scenario import ScenarioData, Tolerance
from lienumba.scenario.schema.skeleton import broken
from lienumba.sweep.design import NOMINAL_RUN
from lienumba.sweep.samplers import SAMPLERS
from lienumba.words import plural

if TYPE_CHECKING:
    import xarray as xr

    from lienumba.scenario.study_points import Plan

OPTIONAL = ("limits", "contacts", "noise")  # lists that are left out where they are empty
FIRST = ("name", "type")  # keys that head a table
BEHIND_SETS = ("study", "sweep", "requirements", "measures")  # what the numbers of the model do not depend on


@dataclass(frozen=True)
class Scenario:
    """A scenario without a fault that can be seen before its mechanism is assembled."""

    data: ScenarioData
    warnings: list[Problem] = field(default_factory=list)
    file: Path | None = None
    parameters: Parameters = field(default_factory=Parameters)
    plan: "Plan | None" = None  # of its study

    @property
    def steps(self) -> int | None:
        """The number of integration steps of each run; None where steps choose their length."""
        step = self.data.integrator.step
        return None if step is None else _count(self.data.integrator.end_time, step)

    @cached_property
    def times(self) -> list[float]:
        """The stored times in s, exact decimals, none behind the end."""
        output, end = self.data.output, self.data.integrator.end_time
        if output.times is not None:
            return [min(time, end) for time in output.times]
        assert output.every is not None, "filled in by resolve"
        return timegrid.stored_times(end, output.every)

    @cached_property
    def output_steps(self) -> list[int]:
        """The step of the grid after which each of `times` is stored; step 0 is the start."""
        step = self.data.integrator.step
        assert step is not None, "only where steps are of one length"
        return [_count(time, step) for time in self.times]

    def units(self, path: str) -> str:
        """The units of the number at a canonical path."""
        model = dict(self.data.model)
        kind, _, name = path.partition(".")
        return self.parameters.units_of(name, model) if kind == "parameters" else units(path, model)

    def headline(self) -> str:
        """The size of the scenario in one line."""
        data = self.data
        parts = [
            plural(len(data.model.bodies), "body", "bodies"),
            plural(len(data.model.joints), "joint", "joints"),
            *([plural(len(data.model.drivers), "driver", "drivers")] if data.model.drivers else []),
            *([plural(len(data.model.forces), "force", "forces")] if data.model.forces else []),
            *([plural(len(data.model.limits), "limit", "limits")] if data.model.limits else []),
            *([plural(len(data.model.contacts), "contact", "contacts")] if data.model.contacts else []),
            self._stepping(),
            plural(len(self.times), "stored time", "stored times"),
            plural(data.sweep.runs, "run", "runs"),
        ]
        if data.sweep.vary:
            parts.append(plural(len(data.sweep.vary), "varied number", "varied numbers"))
        if self.plan is not None:
            parts.append(f"study of {plural(len(self.plan.points), 'point', 'points')}")
        return ", ".join(parts)

    def _stepping(self) -> str:
        method, tolerance = self.data.integrator.method, self.data.integrator.tolerance
        if self.steps is not None:
            return f"{plural(self.steps, 'step', 'steps')} of {method}"
        relative = tolerance.relative if isinstance(tolerance, Tolerance) else tolerance
        return f"{method} at tolerance {relative:g}"

    @property
    def labels(self) -> range:
        """The labels of all runs, from that of the nominal run on where it is asked for."""
        return range(NOMINAL_RUN if self.data.sweep.nominal else 0, self.data.sweep.runs)

    @property
    def weighted(self) -> bool:
        """Whether its runs have weights."""
        sweep = self.data.sweep
        return SAMPLERS[sweep.sampler].weighted or (sweep.table is not None and sweep.table.weights is not None)

    def nominal(self) -> dict[str, float | Vector]:
        """The nominal value of every varied path: a number, or as many as the design table has of it."""
        from lienumba.scenario.checks.sweep import nominal_numbers

        model, values = dict(self.data.model), self.parameters.values()
        found = {}
        for path, kind in self.data.sweep.vary.items():
            first, *rest = paths.parse(path)
            number = values[paths.text_of(rest)] if first == "parameters" else paths.get(model, [first, *rest])
            found[path] = nominal_numbers(number, kind.shape)
        return found

    def to_dict(self) -> dict[str, Any]:
        """The scenario's keys and values with every default written out."""
        data = self.data.model_dump(exclude_none=True)
        model = data["model"]
        self.parameters.restore(model)
        for kind in LISTS:
            model[kind] = [{key: item[key] for key in FIRST if key in item} | item for item in model[kind]]
        for kind in OPTIONAL:
            if not model[kind]:
                del model[kind]
        optional = ("parameters", "tables", "files")
        for x in (model, *model["bodies"]):
            for key in x.keys() & {"shapes", "ground_shapes"}:
                x[key] = [{"type": shape["type"]} | shape for shape in x[key]]
        listed = {**{kind: model.pop(kind, None) for kind in BESIDE}, **{key: data[key] for key in optional}}
        return {key: item for key, item in {**data, **listed}.items() if item or key not in listed}

    @cached_property
    def _written(self) -> Mapping[str, Any]:
        return self.to_dict()

    def to_toml(self) -> str:
        """The scenario as TOML with every default written out."""
        return self._toml

    @cached_property
    def _toml(self) -> str:
        return toml.dumps(self._written)

    def sha256(self) -> str:
        """The hash of what determines a run: neither title nor output nor the number of runs, unless samples depend on
        it."""
        return self._sha256

    @cached_property
    def _sha256(self) -> str:
        content = dict(self._written)
        content["sweep"] = sweep = dict(content["sweep"])
        if content.pop("output")["joint_coordinates"]:  # which make joints count their turns
            content["joint_coordinates"] = True
        del content["title"], sweep["nominal"]
        content.pop("sensitivities", None)
        content["model"] = _without_shapes(content["model"])
        judging = [x for kind in paths.JUDGING for x in content.pop(kind, ())]
        texts = _without_those_of(judging, content.pop("files", {}), content["model"])
        content |= {"files": texts} if texts else {}
        content |= {"untraced": found} if (found := identities(texts)) else {}
        if "noise" in content:  # of a file its checksum decides, wherever it is
            content["noise"] = [{key: x for key, x in item.items() if key != "table"} for item in content["noise"]]
        sweep.pop("stop", None)
        sampler = SAMPLERS[self.data.sweep.sampler]
        if not sampler.whole:
            del sweep["runs"]
        if sampler.order_matters:
            sweep["order"] = list(sweep["vary"])
        if not sweep["correlate"]:
            del sweep["correlate"]
        if not sweep["proposal"]:
            del sweep["proposal"]
        if "study" in content:
            study = {key: x for key, x in content["study"].items() if key != "repeats"}
            reference = study["reference"].items()
            study["reference"] = {key: x for key, x in reference if key != "file"}  # its checksum stays
            content["study"] = study
        used, model = self.parameters.used_quantities(), content["model"]
        own = any(law["type"] == PYTHON for law in (*model["forces"], *model["joints"]))  # may ask for any of them
        turns = [name for name, kind in QUANTITIES.items() if kind.reads_coordinates]  # which they make a joint count
        quantities = content.pop("quantities", [])
        decisive = [q for q in quantities if own or q["name"] in used or q["type"] in turns]
        content |= {"quantities": decisive} if decisive else {}
        text = json.dumps(content, sort_keys=True, separators=(",", ":"), allow_nan=False)
        return hashlib.sha256(text.encode()).hexdigest()


def _without_those_of(judging: Sequence[Keys], files: Keys, model: Keys) -> Keys:
    """The texts of Python files but for those that measures alone name."""
    laws, asked = (
        {str(x["function"]).rpartition(":")[0] for x in items if "function" in x}
        for items in ((*tables(model["forces"]), *tables(model["joints"])), judging)
    )
    return {file: text for file, text in files.items() if file in laws or file not in asked}


def _without_shapes(model: Keys) -> Keys:
    """What decides a run, and not how it looks."""
    kept = {key: item for key, item in model.items() if key != "ground_shapes"}
    bodies = [{key: x for key, x in body.items() if key != "shapes"} for body in tables(model["bodies"])]
    return {**kept, "bodies": bodies}


def _count(duration: float, step: float) -> int:
    number = timegrid.count(duration, step)
    assert number is not None, "checked by resolve"
    return number


def resolve(
    source: object,
    *,
    overrides: Mapping[str, object] | None = None,
    seed: int | None = None,
    allow_code: bool = False,
    counted: bool = True,
) -> Scenario:
    """Load a scenario (path, dict, System, Scenario), change it, check it; errors list all problems. counted: whether
    what it varies needs sweep.runs."""
    if overrides is not None and not isinstance(overrides, Mapping):
        rule, remedy = "must be a mapping from paths to values", 'give them such as {"integrator.step": 1e-4}'
        raise ScenarioError.at("overrides", rule, remedy, overrides)
    changes = dict(overrides or {})
    if seed is not None:
        if isinstance(seed, int) and seed >= 2**63:
            raise ScenarioError.at("seed", "must be below 2^63", "give a whole number from 0 to 2^63 - 1", seed)
        changes["sweep.seed"] = seed
    file = Path(source) if isinstance(source, str | os.PathLike) else getattr(source, "file", None)
    raw = load(source, allow_code)
    name_unnamed(raw)
    problems = apply_overrides(raw, changes)
    if not counted and isinstance(sweep := raw.get("sweep"), dict):
        sweep.setdefault("runs", 1)
    raw = with_files(raw, Path())
    model = table_in(raw, "model")
    if START in model:
        from lienumba.scenario.reading.datasets import read_start

        raw = read_start(raw)
    if "noise" in model:
        from lienumba.scenario.reading.run_tables import read_run_tables

        raw = read_run_tables(raw)
    sets = any(event.get("action") == SET.name for event in tables(table_in(raw, "model").get("events")))
    written = copy.deepcopy(raw) if sets or "study" in raw else raw
    scenario = _resolved(raw, problems, file)
    if sets:
        wrong, doubtful = _check_sets(written, scenario)
        if wrong:
            raise ScenarioError(*wrong)
        scenario = replace(scenario, warnings=[*scenario.warnings, *doubtful])
    if scenario.data.study is None:
        return scenario
    from lienumba.scenario.checks.reference_formulas import used
    from lienumba.scenario.study_points import plan_of

    elsewhere = used(scenario.data.study.reference, scenario.parameters)
    plan = plan_of(written, scenario, lambda point: _resolved(point, [], file, elsewhere))
    added = {problem: point.place for point in plan.points for problem in point.scenario.warnings}
    told = [problem.inside(place) for problem, place in added.items() if problem not in scenario.warnings]
    return replace(scenario, plan=plan, warnings=[*scenario.warnings, *told])


def _check_sets(raw: Keys, base: Scenario) -> tuple[list[Problem], list[Problem]]:
    """What is wrong with numbers of the model once an event has set its parameters, and what may be: where others of
    the parameters that events set are given by other events, which may come first. raw: the scenario as it is written;
    base: the same, resolved."""
    wrong, doubtful, parameters = list[Problem](), list[Problem](), base.parameters
    later = {  # what also depends on the time, or on the motion: it need not be asked before the event
        paths.written(tokens)
        for tokens, formula in parameters.places.items()
        if formula.used & {TIME, *parameters.tables, *parameters.quantities}
    }
    for event in base.data.model.events:
        numbers = {name: x for name, x in (event.parameters or {}).items() if isinstance(x, int | float)}
        if not numbers or not event.name:
            continue
        point = copy.deepcopy({key: x for key, x in raw.items() if key not in BEHIND_SETS})
        model = table_in(point, "model")
        model["events"] = [x for x in tables(model.get("events")) if x.get("action") != SET.name]
        point["parameters"] = {**table_in(point, "parameters"), **numbers}
        errors, warnings = list[Problem](), list[Problem]()
        try:
            warnings = [x for x in _resolved(point, [], base.file).warnings if x not in base.warnings]
        except ScenarioError as error:
            errors = list(error.problems)
        alone = parameters.held <= numbers.keys()
        for told, found in ((errors, wrong if alone else doubtful), (warnings, doubtful)):
            own = [x for x in told if x.place.startswith("model.") and x.place not in later]
            found += [x.inside(f"events.{event.name}.parameters") for x in own]
    return wrong, doubtful


def written_tables(ds: "xr.Dataset", where: str) -> Keys:
    """The scenario that a dataset brings, as tables with every default; none if it brings none, and no code of it runs.
    where: what the dataset is called."""
    from lienumba.store.form import current, scenario_tables
    from lienumba.store.refusals import damaged

    found = current(scenario_tables(ds, where))
    if not found:
        return {}
    try:
        raw = load({key: x for key, x in found.items() if key != "study"})  # whose reference may be gone
        raw |= {key: copy.deepcopy(x) for key, x in found.items() if key == "study"}
        parameters, wrong = take(raw)
        if not wrong:
            return Scenario(ScenarioData.model_validate(raw), [], None, parameters).to_dict()
    except ValidationError as error:
        wrong = messages.problems(error, raw)
    except ScenarioError as error:
        wrong = list(error.problems)
    raise damaged(where, f"its attribute scenario is none: {wrong[0]}")


def _resolved(raw: Keys, problems: list[Problem], file: Path | None, elsewhere: Set[str] = frozenset()) -> Scenario:
    """Check a scenario that has its files; problems: those known already; elsewhere: parameters that are used there."""
    if misshapen := broken(raw):
        raise ScenarioError(*problems, *misshapen)
    parameters, wrong = take(raw)
    found: list[Problem] = []
    data = None
    try:
        data = ScenarioData.model_validate(raw)
    except ValidationError as error:
        found += messages.problems(error, raw)
    if wrong and not parameters.places:  # nothing but the kinds of what formulas read can be judged without them
        kinds = (x for x in found if x.place.startswith("quantities.") and x.place.endswith(".type"))
        raise ScenarioError(*problems, *kinds, *wrong)
    report = check_scenario(raw, data, parameters)
    problems += [*wrong, *map(parameters.explain, found + report.problems)]
    if problems or data is None:
        raise ScenarioError(*problems)
    if data.study is not None:
        from lienumba.scenario.checks.reference_formulas import used

        elsewhere = used(data.study.reference, parameters)
    filled = _filled(data)
    if filled.sweep.vary:
        from lienumba.scenario.formulas import dependent_inputs

        elsewhere = elsewhere | dependent_inputs.used(filled.sweep.vary, parameters)
    warnings = [*map(parameters.explain, report.warnings), *parameters.unused(elsewhere)]
    return Scenario(filled, warnings, file, parameters)


def _filled(data: ScenarioData) -> ScenarioData:
    """Write out the defaults that depend on other keys, and the varied paths in their canonical form."""
    integrator, output, sweep = data.integrator, data.output, data.sweep
    if output.every is None and output.times is None:
        ends, steps = (_numbers_of_study(data, key) for key in ("end_time", "step"))
        steps += [] if integrator.step is None else [integrator.step]
        every = timegrid.default_interval(integrator.end_time, steps[::-1], ends)
        output = output.model_copy(update={"every": every})
    integrator = integrator.model_copy(update={"method": method_of(integrator), "rho_infinity": damping_of(integrator)})
    if "variables" not in output.model_fields_set:
        own = [seen.name for seen in (*data.model.quantities, *data.model.noise)]
        own += [force.name for force in data.model.forces if getattr(force, "states", None)]
        own += [paths.INPUTS] if any(map(written, data.model.inputs.values())) else []
        output = output.model_copy(update={"variables": [*usual(), *own]})
    both = list(dict.fromkeys([*output.variables, *output.also]))
    output = output.model_copy(update={"variables": both, "also": []})
    if output.joint_coordinates and not {*output.variables} & {*JOINT_COORDINATES}:
        output = output.model_copy(update={"variables": [*output.variables, *JOINT_COORDINATES]})
    model = dict(data.model)
    vary = {paths.canonical(path, model): distribution for path, distribution in sweep.vary.items()}
    correlate = [
        group.model_copy(update={"paths": [paths.canonical(path, model) for path in group.paths]})
        for group in sweep.correlate
    ]
    proposal = {paths.canonical(path, model): given for path, given in sweep.proposal.items()}
    sweep = sweep.model_copy(update={"vary": vary, "correlate": correlate, "proposal": proposal})
    asked = data.sensitivities
    if asked is not None:
        columns = [column for path, kind in vary.items() for column in kind.columns(path)]
        by = columns if asked.by is None else [paths.canonical(path, model) for path in asked.by]
        asked = asked.model_copy(update={"by": by})
    update = {"integrator": integrator, "output": output, "sweep": sweep, "sensitivities": asked}
    return data.model_copy(update=update)


def _numbers_of_study(data: ScenarioData, key: str) -> list[float]:
    """The values of a key of the integrator at the points and in the reference of a study."""
    if data.study is None:
        return []
    path = f"integrator.{key}"
    given = [value for grid in data.study.grid for value in grid.get(path, [])]
    given += [data.study.reference[name] for name in (key, path) if name in data.study.reference]
    return [float(value) for value in given if isinstance(value, int | float) and value > 0.0]
