"""Parameters, and numbers of the model that are written as formulas of them.

`[parameters]` gives names to numbers; a parameter may be a formula of others. Any number of the model may be a formula
of parameters, and where a formula of the time may stand, of both. The scenario is checked with their nominal values;
what a sweep varies reaches everything that depends on it, run by run.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from lienumba.expressions import CONSTANTS, FUNCTIONS, ExpressionError, Formula
from lienumba.mechanics.model import Law
from lienumba.scenario import paths
from lienumba.scenario.formulas import LARGEST, explained
from lienumba.scenario.schema_types import NAME
from lienumba.scenario.words import is_number, listed, show

TIME = "t"
RESERVED = {TIME, *CONSTANTS, *FUNCTIONS}
Tokens = tuple[paths.Token, ...]


@dataclass(frozen=True)
class Parameters:
    """numbers: of the parameters that are no formulas; formulas: the others, each behind those that it uses; places:
    the numbers of the model (paths without `model`) that are formulas of parameters, or of nothing."""

    numbers: dict[str, float] = field(default_factory=dict)
    formulas: dict[str, Formula] = field(default_factory=dict)
    places: dict[Tokens, Formula] = field(default_factory=dict)

    def values(self, samples: Mapping[str, Any] | None = None) -> dict[str, Any]:
        """Every parameter: a float, or an array (runs,); samples: by path, `parameters.kp`."""
        found: dict[str, Any] = {}
        for name in (*self.numbers, *self.formulas):
            sampled = (samples or {}).get(f"parameters.{name}")
            if sampled is not None:
                found[name] = sampled
            elif name in self.numbers:
                found[name] = self.numbers[name]
            else:
                found[name] = _value(self.formulas[name], found)
        return found

    def fill(self, model: dict[str, Any], samples: Mapping[str, Any]) -> None:
        """Put the numbers of these samples into a model, in place, and functions of time where they are."""
        values = self.values(samples)
        for tokens, formula in self.places.items():
            if paths.text_of(list(tokens)) not in samples:
                used = {name: values[name] for name in sorted(formula.used - {TIME})}
                number = Law(formula, used) if TIME in formula.used else _value(formula, values)
                paths.put(model, list(tokens), number)

    def restore(self, model: dict[str, Any]) -> None:
        """Put the texts of the formulas back into a model, in place."""
        for tokens, formula in self.places.items():
            paths.put(model, list(tokens), formula.text)

    def explain(self, problem: str) -> str:
        """A sentence about a number that the file writes as a formula shows both."""
        for tokens, formula in self.places.items():
            start = f"model.{paths.text_of(list(tokens))} = "
            if problem.startswith(start):
                return f"{start}{show(formula.text)} = {problem.removeprefix(start)}"
        return problem

    def unused(self) -> list[str]:
        """A warning for each parameter that nothing depends on."""
        used = set().union(*(f.used for f in (*self.formulas.values(), *self.places.values())))
        return [
            f"parameters.{name}: nothing uses it; write its name in a number of the model, or remove it"
            for name in (*self.numbers, *self.formulas)
            if name not in used
        ]


def _value(formula: Formula, values: Mapping[str, Any]) -> Any:
    return formula(0.0, **{name: values[name] for name in formula.used})


def take(raw: dict[str, Any]) -> tuple[Parameters, list[str]]:
    """The parameters of a scenario, and what is wrong with them; in place, nominal numbers take the place of every
    formula of parameters, so that the rest of the checks sees numbers."""
    section = raw.get("parameters", {})
    if not isinstance(section, dict):
        return Parameters(), ["parameters: must be a table of names and numbers; write [parameters] and kp = 40 below"]
    numbers, formulas, problems = _section(section)
    ordered = _ordered(formulas, problems)
    parameters = Parameters(numbers, ordered)
    if not problems:
        problems += _not_finite(parameters)
    if problems:
        raw.pop("parameters", None)
        return Parameters(), problems
    values = parameters.values()
    model = raw.get("model")
    for tokens, text in _formulas(model):
        if is_number(text):
            continue
        try:
            formula = Formula(text, frozenset({TIME, *values}))
        except ExpressionError as error:
            if values:
                problems.append(f"model.{paths.text_of(list(tokens))} = {show(text)}: {explained(text, error)}")
                paths.put(model, list(tokens), 1.0)
            continue  # where there are no parameters, the schema says what is wrong
        if formula.used == {TIME} or (not formula.used and tokens[0] in paths.WITH_FORMULAS):
            continue
        parameters.places[tokens] = formula
        number = formula.bound(values) if TIME in formula.used else float(_value(formula, values))
        if isinstance(number, float) and not abs(number) <= LARGEST:
            problems.append(
                f"model.{paths.text_of(list(tokens))} = {show(text)}: is {number} with the nominal parameters; it must "
                "be a finite number"
            )
            number = 1.0
        paths.put(model, list(tokens), number)
    return parameters, problems


def _section(section: dict[str, Any]) -> tuple[dict[str, float], dict[str, Formula], list[str]]:
    """Numbers, formulas and problems of the section [parameters]."""
    numbers: dict[str, float] = {}
    formulas: dict[str, Formula] = {}
    problems: list[str] = []
    names = frozenset(map(str, section)) - RESERVED
    for name, value in section.items():
        at = f"parameters.{name}"
        if not re.fullmatch(NAME, name) or name in RESERVED:
            reserved = "has a meaning in formulas already; give another" if name in RESERVED else "is no valid"
            problems.append(f'{at}: {reserved} name: a letter, then letters, digits or "_"')
        elif isinstance(value, str):
            try:
                formulas[name] = Formula(value, names)
            except ExpressionError as error:
                problems.append(f"{at} = {show(value)}: {explained(value, error)}")
        elif isinstance(value, bool) or not isinstance(value, int | float):
            problems.append(f"{at} = {show(value)}: must be a number or a formula of other parameters; give one number")
        elif not abs(value) <= LARGEST:
            problems.append(f"{at} = {show(value)}: must be a finite number, at most {LARGEST:g} in size")
        else:
            numbers[name] = float(value)
    return numbers, formulas, problems


def _ordered(formulas: dict[str, Formula], problems: list[str]) -> dict[str, Formula]:
    """Each formula behind those that it uses; a cycle is a problem."""
    ordered: dict[str, Formula] = {}
    waiting = dict(formulas)
    while waiting:
        ready = [name for name, formula in waiting.items() if not formula.used & set(waiting)]
        if not ready:
            cycle = [name for name in waiting if _reaches(name, name, waiting)]
            if cycle:
                depend = "depends on itself" if len(cycle) == 1 else "depend on one another"
                problems.append(f"parameters: {listed(cycle)} {depend} in a circle; give a number for {cycle[0]}")
            return ordered
        for name in ready:
            ordered[name] = waiting.pop(name)
    return ordered


def _reaches(start: str, end: str, formulas: dict[str, Formula]) -> bool:
    seen: set[str] = set()
    left = [start]
    while left:
        for name in formulas[left.pop()].used & set(formulas):
            if name == end:
                return True
            if name not in seen:
                seen.add(name)
                left.append(name)
    return False


def _not_finite(parameters: Parameters) -> list[str]:
    values = parameters.values()
    return [
        f"parameters.{name} = {show(formula.text)}: is {values[name]}; it must be a finite number"
        for name, formula in parameters.formulas.items()
        if not abs(values[name]) <= LARGEST
    ]


def _formulas(model: Any) -> list[tuple[Tokens, str]]:
    """The texts of a model that stand where numbers should, with their paths."""
    found: list[tuple[Tokens, str]] = []

    def walk(node: Any, tokens: Tokens) -> None:
        if isinstance(node, dict):
            for key, item in node.items():
                if not tokens or key not in paths.TEXT_KEYS:
                    walk(item, (*tokens, key))
        elif isinstance(node, list):
            names = [item.get("name") if isinstance(item, dict) else None for item in node]
            for index, item in enumerate(node):
                name = names[index]
                unique = names.count(name) == 1
                walk(item, (*tokens, name if isinstance(name, str) and unique else index))
        elif isinstance(node, str) and len(tokens) > 1:
            found.append((tokens, node))

    walk(model, ())
    return found
