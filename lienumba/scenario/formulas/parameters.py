"""Parameters, and what is written as formulas of them, of tables and of quantities.

`[parameters]` gives names to numbers; a parameter may be a formula of others. Any number of the model may be a formula
of parameters, and where a formula of the time may stand, of the time, of tables and of quantities. What a sweep varies
reaches everything that depends on it, run by run.
"""

import re
from collections.abc import Mapping, Set
from dataclasses import dataclass, field, replace
from graphlib import CycleError, TopologicalSorter
from keyword import kwlist
from typing import Any

from lienumba.errors import NOTHING, Problem
from lienumba.keys.formulas import LARGEST, explained
from lienumba.keys.types import NAME
from lienumba.mechanics.elements.quantities import owner
from lienumba.mechanics.mechanism.model import HELD, NOT_YET, Law
from lienumba.mechanics.mechanism.tables import Table
from lienumba.numerics.expressions import Formula
from lienumba.numerics.grammar import CONSTANTS, ExpressionError
from lienumba.scenario.base import paths
from lienumba.scenario.base.paths import INPUTS, Tokens
from lienumba.scenario.base.toml import Keys
from lienumba.scenario.base.units import units
from lienumba.scenario.formulas.measure_formula import MeasureFormula
from lienumba.words import listed

TIME = "t"
SMOOTH = "1 + 0*t"  # what stands for a formula of tables or quantities while numbers are checked: positive, and varies
RESERVED = {TIME, INPUTS, *CONSTANTS, *kwlist}  # which are no names; those of functions are none of tables
RESERVED_NAMES = f"reserved are {listed([TIME, INPUTS, *CONSTANTS, 'the keywords of Python'])}"


@dataclass(frozen=True)
class Parameters:
    """numbers: of the parameters that are no formulas; formulas: the others, each behind those that it uses; tables;
    inputs: those that are numbers, by their paths; quantities: every component that formulas may read; places: the
    numbers of the model (paths without `model`) that are formulas, but for those of the time alone; held: parameters
    that events set; times: those of events that formulas read, by their names in these; measures: formulas of whole
    runs, by their names."""

    numbers: dict[str, float] = field(default_factory=dict)
    formulas: dict[str, Formula] = field(default_factory=dict)
    tables: dict[str, Table] = field(default_factory=dict)
    inputs: dict[str, float] = field(default_factory=dict)
    quantities: frozenset[str] = frozenset()
    places: dict[Tokens, Formula] = field(default_factory=dict)
    held: frozenset[str] = frozenset()
    times: frozenset[str] = frozenset()
    measures: dict[str, MeasureFormula] = field(default_factory=dict)

    def values(self, samples: Mapping[str, Any] | None = None) -> dict[str, Any]:
        """Every parameter, and every input that is a number: a float, or an array (runs,); samples: by path,
        `parameters.kp`."""
        found: dict[str, Any] = {name: (samples or {}).get(name, x) for name, x in self.inputs.items()}
        for name in (*self.numbers, *self.formulas):
            sampled = (samples or {}).get(f"parameters.{name}")
            if sampled is not None:
                found[name] = sampled
            elif name in self.numbers:
                found[name] = self.numbers[name]
            else:
                found[name] = value_of(self.formulas[name], found)
        return found

    def held_values(self, samples: Mapping[str, Any]) -> dict[str, Any]:
        """What the parameters that events set are at the start, and the times of events."""
        values = self.values(samples)
        return {name: values[name] for name in sorted(self.held)} | dict.fromkeys(sorted(self.times), NOT_YET)

    def at_places(self, samples: Mapping[str, Any]) -> dict[Tokens, Any]:
        """The numbers of these samples for what is a formula, and functions of time where they are, by path."""
        values = self.values(samples)
        return {
            tokens: self.function(formula, values) if is_whole_input(tokens) else self.number(formula, values)
            for tokens, formula in self.places.items()
            if paths.text_of(list(tokens)) not in samples
        }

    def number(self, formula: Formula, values: Mapping[str, Any]) -> Any:
        """What a formula is with these values of the parameters: a number, or a law of time and state."""
        return self.function(formula, values) if self.varies(formula) else value_of(formula, values)

    def function(self, formula: Formula, values: Mapping[str, Any]) -> Law:
        """A formula with these values of the parameters as a function of time and state."""
        own, formula = {**values, **self.tables}, self.followed(formula)
        used = {name: own[name] for name in sorted(formula.used & own.keys())}
        state = self.quantities.union(map(held_name, self.held))
        return Law(formula, used, tuple(sorted(formula.used & state)))

    def followed(self, formula: Formula) -> Formula:
        """The same, where parameters that events set are read as they are in a run, also through other parameters."""
        if not self.all_used(formula) & self.held:
            return formula
        following = {name: held_name(name) for name in self.held}
        read = [*following.values()]
        for name, own in self.formulas.items():  # each behind those that it uses
            if name not in self.held and own.used & following.keys():
                following[name] = own.rewritten(following, read).text
        return formula.rewritten(following, read)

    def all_used(self, formula: Formula) -> set[str]:
        """The parameters that a formula depends on, also through others."""
        found: set[str] = set()
        waiting = [formula]
        while waiting:
            new = waiting.pop().used - found
            found |= new
            waiting += [self.formulas[name] for name in new if name in self.formulas]
        return found

    def varies(self, formula: Formula) -> bool:
        """Whether a formula depends on more than parameters."""
        return TIME in formula.used or self.reads(formula)

    def reads(self, formula: Formula) -> bool:
        """Whether a formula depends on tables, quantities or what events set."""
        return bool(formula.used & self.tables.keys()) or self.follows(formula)

    def follows(self, formula: Formula) -> bool:
        """Whether a formula depends on what only a run decides: quantities, and what events set."""
        return bool(formula.used & self.quantities or (self.held and self.all_used(formula) & self.held))

    def units_of(self, name: str, model: Keys) -> str:
        """The units of the numbers for which a parameter, such as "kp" or "k[0]", stands, alone or times plain numbers;
        "1" where none says, or they differ. model: of the scenario, checked."""
        found = {units(paths.text_of(list(place)), model) for place, x in self.places.items() if x.is_multiple(name)}
        return next(iter(found)) if len(found) == 1 else "1"

    def restore(self, model: Keys) -> None:
        """Put the texts of the formulas back into a model, in place."""
        for tokens, formula in self.places.items():
            paths.put(model, list(tokens), formula.text)

    def explain(self, problem: Problem) -> Problem:
        """A problem of a number that the file writes as a formula has both."""
        made = next((f for tokens, f in self.places.items() if paths.written(tokens) == problem.place), None)
        if made is None or problem.value is NOTHING:
            return problem
        return replace(problem, formula=made.text, value=NOTHING if problem.value == SMOOTH else problem.value)

    def used_quantities(self) -> set[str]:
        """The names of the quantities that decide about a run, because forces or drivers read them."""
        found: set[str] = set()
        waiting = [f for tokens, f in self.places.items() if tokens[0] != "quantities"]
        while waiting:
            new = {owner(name)[0] for name in waiting.pop().used & self.quantities} - found
            found |= new
            waiting += [f for tokens, f in self.places.items() if tokens[0] == "quantities" and tokens[1] in new]
        return found

    def unused(self, elsewhere: Set[str]) -> list[Problem]:
        """A warning for each parameter and table that nothing depends on; elsewhere: what else uses."""
        used = set(elsewhere).union(*(f.used for f in (*self.formulas.values(), *self.places.values())))
        used = used.union(*(measure.used for measure in self.measures.values()))
        parameters = [
            Problem(f"parameters.{name}", "nothing uses it", "write its name in a number of the model, or remove it")
            for name in (*self.numbers, *self.formulas)
            if name not in used
        ]
        parameters += [
            Problem(path, "nothing reads it", f"write {path} in a formula, or remove it")
            for path in self.inputs
            if path not in used
        ]
        return parameters + [
            Problem(f"tables.{name}", "nothing reads it", f"write {name}(t) in a formula, or remove it")
            for name in self.tables
            if name not in used
        ]


def is_whole_input(tokens: Tokens) -> bool:
    """Whether a formula is an input, not one number of it."""
    return tokens[0] == INPUTS and len(tokens) == 2


def held_name(name: str) -> str:
    """How a formula reads a parameter that events set."""
    return f"{HELD}.{name}"


def value_of(formula: Formula, values: Mapping[str, Any]) -> Any:
    """The number that a formula of parameters is."""
    return formula(0.0, **{name: values[name] for name in formula.used})


def section_of(section: Keys) -> tuple[dict[str, float], dict[str, Formula], list[Problem]]:
    """Numbers, formulas (each behind those that it uses) and problems of the section [parameters]; of a list every
    number has the name of the whole with its index."""
    numbers: dict[str, float] = {}
    formulas: dict[str, Formula] = {}
    problems: list[Problem] = []
    every: dict[str, Any] = {}
    for name, value in section.items():
        if not re.fullmatch(NAME, name) or name in RESERVED:
            rule, remedy = 'is no valid name: a letter, then letters, digits or "_"', ""
            if name in RESERVED:
                rule, remedy = "has a meaning in formulas already", f"give another name; {RESERVED_NAMES}"
            problems.append(Problem(f"parameters.{name}", rule, remedy))
        elif isinstance(value, list) and value:
            every |= {f"{name}[{n}]": x for n, x in enumerate(value)}
        else:
            every[name] = value
    names = frozenset(every)
    for name, value in every.items():
        at = f"parameters.{name}"
        if isinstance(value, str):
            try:
                formulas[name] = Formula(value, names, told=names - {name})
            except ExpressionError as error:
                problems.append(explained(value, error).at(at, value))
        elif isinstance(value, bool) or not isinstance(value, int | float):
            remedy = "give one number, or a list of numbers"
            problems.append(Problem(at, "must be a number or a formula of other parameters", remedy, value))
        elif not abs(value) <= LARGEST:
            problems.append(Problem(at, f"must be a finite number, at most {LARGEST:g} in size", value=value))
        else:
            numbers[name] = float(value)
    behind = order({name: formula.used for name, formula in formulas.items()}, "parameters", problems)
    return numbers, {name: formulas[name] for name in behind}, problems


def whole(name: str) -> str:
    """The name of a parameter without the index that a number of a list has."""
    return name.partition("[")[0]


def order(uses: Mapping[str, Set[str]], what: str, problems: list[Problem], instead: str = "a number") -> list[str]:
    """The names, each behind those that it uses; a cycle is a problem. what: the section; instead: of a formula."""
    before = {name: [x for x in uses if x in used] for name, used in uses.items()}
    try:
        return [*TopologicalSorter(before).static_order()]
    except CycleError as error:
        cycle = [name for name in uses if name in error.args[1]]
        depend = "depends on itself" if len(cycle) == 1 else "depend on one another"
        problems.append(Problem(what, f"{listed(cycle)} {depend} in a circle", f"give {instead} for {cycle[0]}"))
        return []


def not_finite(parameters: Parameters) -> list[Problem]:
    values = parameters.values()
    return [
        Problem(f"parameters.{name}", f"is {values[name]}", "it must be a finite number", formula.text)
        for name, formula in parameters.formulas.items()
        if not abs(values[name]) <= LARGEST
    ]
