"""Formulas in place of numbers: what each may depend on, and what the other checks see instead.

A formula of parameters is replaced by its nominal number, one of parameters and the time by one of the time alone. One
that reads a table or a quantity has no value before the run: its place holds `SMOOTH` meanwhile, which pleases all.
"""

from collections.abc import Mapping
from dataclasses import replace
from math import inf

from lienumba.errors import Problem
from lienumba.keys.facts import has_choices, is_text
from lienumba.keys.formulas import LARGEST, explained
from lienumba.mechanics.elements import quantities
from lienumba.mechanics.elements.events import CONDITION, SET, time_of
from lienumba.mechanics.elements.forces import FORCES
from lienumba.mechanics.elements.inputs.base import InputType
from lienumba.mechanics.mechanism.model import EVENT_TIME, HELD
from lienumba.mechanics.mechanism.tables import Table
from lienumba.numerics.expressions import Formula
from lienumba.numerics.functions import FUNCTIONS
from lienumba.numerics.grammar import ExpressionError
from lienumba.scenario.base import paths
from lienumba.scenario.base.paths import INPUTS, JUDGING, MEASURES, REQUIREMENTS, Tokens
from lienumba.scenario.base.problems import tables as rows_of
from lienumba.scenario.base.problems import unique_name
from lienumba.scenario.base.toml import Keys, table_in
from lienumba.scenario.formulas.formula_names import Known, known_of
from lienumba.scenario.formulas.measure_formula import MeasureFormula
from lienumba.scenario.formulas.measures import is_formula, measure
from lienumba.scenario.formulas.parameters import (
    RESERVED,
    RESERVED_NAMES,
    SMOOTH,
    TIME,
    Parameters,
    is_whole_input,
    not_finite,
    order,
    section_of,
    value_of,
    whole,
)
from lienumba.scenario.schema import sections
from lienumba.scenario.schema.shapes import SHAPES, Shape
from lienumba.scenario.schema.tables import tables_of
from lienumba.words import is_number, show

SINGULAR = {"tables": "a table", "quantities": "a quantity", "noise": "a noise"}
NEVER = "t < 0"  # what stands for a condition of tables or quantities


def take(raw: Keys) -> tuple[Parameters, list[Problem]]:
    """The parameters of a scenario, and what is wrong with them and with formulas; in place, see above."""
    section = raw.get("parameters", {})
    if not isinstance(section, dict):
        rule, remedy = "must be a table of names and numbers", "write [parameters] and kp = 40 below"
        return Parameters(), [Problem("parameters", rule, remedy)]
    numbers, formulas, problems = section_of(section)
    tables: dict[str, Table] = {}
    if "tables" in raw:
        tables, wrong = tables_of(raw)
        problems += wrong
    parameters = Parameters(numbers, formulas, tables)
    if not problems:
        problems += not_finite(parameters)
    if problems:
        raw.pop("parameters", None)
        return Parameters(), problems
    model = raw.get("model")
    known = known_of(model)
    held = _held(model) & {*numbers, *formulas}
    parameters = replace(parameters, quantities=known.names, inputs=_input_numbers(model), held=held)
    problems = _taken_names(parameters, model)
    taking = _Taking(parameters, known, model, problems)
    taking.every()
    measures = _measures(parameters, taking.names, model, _end(raw), problems)
    return replace(parameters, measures=measures, times=_times(parameters, known, measures, model)), problems


def _times(
    parameters: Parameters, known: Known, measures: Mapping[str, MeasureFormula], model: object
) -> frozenset[str]:  # fmt: skip
    """The times of events that formulas read, or from which delays count."""
    read = [x.used for x in parameters.places.values()] + [x.used for x in measures.values()]
    delayed = [f"{x.get('name')}.{CONDITION}" for x in _rows(model, "events") if x.get("delay") is not None]
    return frozenset().union(*read) & known.sketch.held.keys() | {*map(time_of, delayed)}


def _end(raw: Keys) -> float:
    """When runs end, as far as that is known as yet."""
    end = table_in(raw, "integrator").get("end_time")
    return float(end) if isinstance(end, int | float) else inf


def _measures(
    parameters: Parameters, names: frozenset[str], model: object, end: float, problems: list[Problem]
) -> dict[str, MeasureFormula]:
    """What runs are asked for as a whole, by name; also by requirements, whose values may be such formulas."""
    found: dict[str, MeasureFormula] = {}
    own = {str(table.get("name")) for table in _rows(model, MEASURES)}
    events = {}
    for event in _rows(model, "events"):
        written = parameters.places.get(("events", str(event.get("name")), "when"))
        events[str(event.get("name"))] = str(event.get("when", NEVER)) if written is None else written.text
    for kind, n, table in ((section, n, x) for section in JUDGING for n, x in enumerate(_rows(model, section))):
        name, text = table.get("name"), table.get("value")
        if kind == MEASURES and isinstance(name, str) and (text is None) == (table.get("function") is None):
            rule = "needs a value, a formula with reducers, or a function" if text is None else "has value and function"
            problems.append(Problem(f"{MEASURES}.{name}", rule, 'write one, such as value = "max(pointing.angle)"'))
        if not isinstance(name, str) or not isinstance(text, str) or (kind == REQUIREMENTS and not is_formula(text)):
            continue
        place = (kind, unique_name(_rows(model, kind), n) or n)
        if kind == REQUIREMENTS and name in {*found, *own}:
            rule, remedy = "is also the name of a measure", f"give another name, or value = {show(name)}"
            problems.append(Problem(paths.written((*place, "name")), rule, remedy, name))
            continue
        try:
            found[name] = measure(text, parameters, names, events, own - {name}, end)
        except ExpressionError as error:
            problems.append(error.at(paths.written((*place, "value")), text))
    return found


def _held(model: object) -> frozenset[str]:
    """The names of what events set."""
    named = (table_in(event, "parameters") for event in _rows(model, "events") if event.get("action") == SET.name)
    return frozenset(str(name) for table in named for name in table)


def _taken_names(parameters: Parameters, model: object) -> list[Problem]:
    """Names by which formulas know something must be different."""
    problems = []
    taken = dict.fromkeys(map(whole, (*parameters.numbers, *parameters.formulas)), "a parameter")
    if parameters.held:
        taken[HELD] = "what events set"
    if _rows(model, "events"):
        taken[EVENT_TIME] = "the times of events"
    for what, names in (
        ("tables", list(parameters.tables)),
        *(
            (kind, [name for q in _rows(model, kind) if isinstance(name := q.get("name"), str)])
            for kind in ("quantities", "noise")
        ),
    ):
        functions = FUNCTIONS if what == "tables" else ()
        remedy = f"give another name; {RESERVED_NAMES}" + (", and the functions of formulas" if functions else "")
        for name in names:
            if name in RESERVED or name in functions:
                problems.append(Problem(f"{what}.{name}", "its name has a meaning in formulas already", remedy))
            elif name in taken:
                problems.append(
                    Problem(f"{what}.{name}", f"its name is the name of {taken[name]}", "give another name")
                )
        taken |= dict.fromkeys(names, SINGULAR[what])
    return problems


def _input_numbers(model: object) -> dict[str, float]:
    """The inputs that are numbers, by their paths. What no number may be is told of elsewhere; formulas may
    name it."""
    inputs = table_in(model, INPUTS) if isinstance(model, dict) else {}
    return {
        paths.text_of([INPUTS, name]): float(x) if abs(x) <= LARGEST else 1.0
        for name, x in inputs.items()
        if isinstance(x, int | float) and not isinstance(x, bool)
    }


def _rows(model: object, kind: str) -> list[Keys]:
    return rows_of(model.get(kind)) if isinstance(model, dict) else []


class _Taking:
    """Takes formulas out of a model, in place."""

    def __init__(self, parameters: Parameters, known: Known, model: object, problems: list[Problem]) -> None:
        self.parameters, self.known, self.model, self.problems = parameters, known, model, problems
        self.values = parameters.values()
        self.names = frozenset({TIME, *self.values, *known.names})

    def every(self) -> None:
        read = {tokens: self.formula(tokens, text) for tokens, text in _formulas(self.model)}
        formulas = {tokens: formula for tokens, formula in read.items() if formula is not None}
        inner: dict[str, frozenset[str]] = {}
        for tokens, formula in formulas.items():
            if tokens[0] == INPUTS or (tokens[0] == "quantities" and len(tokens) == 3):
                name = paths.text_of(list(tokens[:2])) if tokens[0] == INPUTS else str(tokens[1])
                inner[name] = inner.get(name, frozenset()) | formula.used
        before, states = len(self.problems), {name for name in inner if self.known.is_state(name)}
        at_once = {name: used for name, used in inner.items() if name not in states}
        order(at_once, INPUTS if any(map(quantities.is_input, at_once)) else "quantities", self.problems)
        if len(self.problems) == before:  # no expression depends on itself
            self.known = self.known.with_values(inner)
        for tokens, formula in formulas.items():
            self.take(tokens, formula)

    def formula(self, tokens: Tokens, text: str) -> Formula | None:
        """None where the schema shall say what is wrong."""
        if is_number(text):
            return None
        try:
            return Formula(
                text, self.names, frozenset(self.parameters.tables), _is_condition(tokens), self.told(tokens)
            )
        except ExpressionError as error:
            if len(self.names) > 1 or self.parameters.tables:
                self.problems.append(explained(text, error).at(paths.written(tokens), text))
                paths.put(self.model, list(tokens), NEVER if _is_condition(tokens) else 1.0)
            return None

    def told(self, tokens: Tokens) -> frozenset[str]:
        """The names and tables that a formula may have at a place."""
        if _may_vary(tokens):
            return self.names.union(self.parameters.tables)
        return frozenset({TIME, *self.values} if tokens[0] == "gravity" else self.values)

    def take(self, tokens: Tokens, formula: Formula) -> None:
        if formula.used == {TIME} or (not formula.used and (tokens[0] == "gravity" or _may_vary(tokens))):
            return
        self.parameters.places[tokens] = formula
        place = paths.written(tokens)
        number: float | str | Formula
        if self.parameters.reads(formula):
            number = NEVER if _is_condition(tokens) else SMOOTH if _may_vary(tokens) else 1.0
            wrong = self.misuse(tokens, formula)
            self.problems += [Problem(place, *wrong, formula.text)] if wrong else []
        elif TIME in formula.used:
            number = formula.bound(self.values)
        elif _is_condition(tokens):
            number = NEVER
            self.problems.append(Problem(place, "never changes", "name a quantity in it, or the time t", formula.text))
        else:
            number = float(value_of(formula, self.values))
            if not abs(number) <= LARGEST:
                rule = f"is {number} with the nominal parameters"
                self.problems.append(Problem(place, rule, "it must be a finite number", formula.text))
                number = 1.0
            if is_whole_input(tokens):  # formulas read it as they read all inputs
                number = SMOOTH
        paths.put(self.model, list(tokens), number)

    def misuse(self, tokens: Tokens, formula: Formula) -> tuple[str, str] | None:
        """What is wrong with reading tables, quantities or what events set here, and the remedy."""
        read = sorted(formula.used & self.known.names)
        held = sorted(self.parameters.all_used(formula) & (self.parameters.held | self.known.sketch.held.keys()))
        fixed = "what a driver prescribes cannot jump" if tokens[0] == "drivers" else "is one number for the whole run"
        if held and (tokens[0] in ("gravity", "drivers") or not _may_vary(tokens)):
            return f"reads {held[0]}, which an event sets, but {fixed}", "name another parameter there"
        if tokens[0] == "gravity":
            rule = "reads a table or a quantity, but gravity may depend on t and parameters only"
            return rule, "put it into a force"
        if not _may_vary(tokens):
            what = read[0] if read else sorted(formula.used & self.parameters.tables.keys())[0]
            rule, remedy = f"reads {what}, but is one number for the whole run", "use parameters only"
            return rule, remedy if tokens[0] in JUDGING else f"{remedy}, or put it into a force"
        if tokens[0] in ("quantities", "events"):
            return None
        allowed, why = self.allowed(tokens)
        for name in read:
            if tokens[0] == "drivers" and self.known.singular(name):
                first = name.partition(".")[0]
                return f"reads {name}, which has no derivative at 0", f"read {first}.x, {first}.y or {first}.z"
            level = self.known.level(name)
            if level == quantities.OBSERVED:
                rule = (
                    f"reads {name}, which follows from the forces themselves (an acceleration, a reaction or an "
                    "effort), so no force or driver may depend on it"
                )
                return rule, "read positions and velocities"
            if level > allowed:
                return f"reads {name}, {self.known.described(name)}, but {why}", "read positions only"
        return None

    def allowed(self, tokens: Tokens) -> tuple[int, str]:
        """The highest level that may be read at a place of a driver, a force or an input, and why not more."""
        if tokens[0] == INPUTS:
            input_ = table_in(table_in({"model": self.model}, "model"), INPUTS).get(str(tokens[1]))
            follows = isinstance(input_, dict) and "kd" in input_ and "rate" not in input_
            if tokens[-1] == "target" and follows:
                return quantities.POSITION, "kd needs the rate of the target, unless rate is given"
            return quantities.VELOCITY, ""
        if tokens[0] == "drivers":
            return quantities.POSITION, "what a driver prescribes is differentiated"
        forces = {str(f.get("name")): f for f in _rows(self.model, "forces")}
        force, key = forces.get(str(tokens[1]), {}), str(tokens[2])
        kind = FORCES.get(str(force.get("type")))
        number = kind.numbers().get(key) if kind is not None else None
        if kind is not None and kind.has_potential() and (number is None or number.in_potential):
            return quantities.POSITION, f"{key} belongs to a potential energy, which is differentiated"
        if number is not None and number.rate_with in force:
            return quantities.POSITION, f"the {number.rate_with} needs the rate of the {key}"
        return quantities.VELOCITY, ""


def _is_condition(tokens: Tokens) -> bool:
    """Whether a condition is wanted at a place."""
    return tokens[0] == "events" and tokens[2:] == ("when",)


def _may_vary(tokens: Tokens) -> bool:
    """Whether the number of a place may read tables and quantities."""
    if tokens[0] == INPUTS:
        return len(tokens) == 2 or tokens[2] not in InputType.fixed
    if tokens[0] == "events":
        return tokens[2] in ("when", "parameters")
    return tokens[0] in paths.WITH_STATE and (tokens[0] != "quantities" or tokens[-1] == "value")


def _text_keys(tokens: Tokens, node: Keys) -> set[str]:
    """The keys of a table of the model whose values are texts as they should be."""
    if {"shapes", "ground_shapes"} & {*tokens[:1], *tokens[-2:-1]} and isinstance(tokens[-1], int):
        shape = SHAPES.get(str(node.get("type")), Shape)
        return {key for key in node if key not in shape.model_fields or is_text(shape, key)}
    if tokens == (INPUTS,) or {*tokens[2:3]} & {*paths.OWN_NAMES}:
        return set()  # its keys are names
    if tokens == (paths.START,):
        return {"from"}
    typed = len(tokens) == 2 and tokens[0] in (*sections.FORMS, INPUTS, *paths.JUDGING)
    section = sections.section_of(str(tokens[0]), node) if typed else None
    if section is None:
        return {*paths.TEXT_KEYS}
    known = section.model_fields
    return {
        key
        for key, x in node.items()
        if (key not in known and key in paths.TEXT_KEYS)
        or (key in known and (is_text(section, key) or (isinstance(x, str) and has_choices(section, key))))
    }


def _formulas(model: object) -> list[tuple[Tokens, str]]:
    """The texts of a model that stand where numbers should, with their paths."""
    found: list[tuple[Tokens, str]] = []

    def walk(node: object, tokens: Tokens) -> None:
        if isinstance(node, dict):
            texts = _text_keys(tokens, node)
            for key, item in node.items():
                if (not tokens or key not in texts) and not paths.is_recording((*tokens, key)):
                    walk(item, (*tokens, key))
        elif isinstance(node, list):
            named = all(isinstance(item, dict) for item in node)  # else its items are known by their indices
            for index, item in enumerate(node):
                name = unique_name(node, index) if named else None
                walk(item, (*tokens, index if name is None else name))
        elif isinstance(node, str) and len(tokens) > 1:
            found.append((tokens, node))

    walk(model, ())
    return found
