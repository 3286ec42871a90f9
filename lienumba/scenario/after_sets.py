"""What is wrong with the numbers of a model once an event has set its parameters."""

import copy
from collections.abc import Callable
from typing import TYPE_CHECKING

from lienumba.errors import Problem, ScenarioError
from lienumba.mechanics.elements.events import SET
from lienumba.scenario.base import paths
from lienumba.scenario.base.problems import tables
from lienumba.scenario.base.toml import Keys, table_in
from lienumba.scenario.formulas.parameters import TIME

if TYPE_CHECKING:
    from lienumba.scenario.resolve import Scenario

BESIDE = ("study", "sweep", "requirements", "measures")  # what the numbers of the model do not depend on


def check_sets(
    raw: Keys, base: "Scenario", resolve: "Callable[[Keys], Scenario]"
) -> tuple[list[Problem], list[Problem]]:
    """What is wrong, and what may be: where others of the parameters that events set are given by other events, which
    may come first. raw: the scenario as it is written; base: the same, resolved."""
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
        point = copy.deepcopy({key: x for key, x in raw.items() if key not in BESIDE})
        model = table_in(point, "model")
        model["events"] = [x for x in tables(model.get("events")) if x.get("action") != SET.name]
        point["parameters"] = {**table_in(point, "parameters"), **numbers}
        errors, warnings = list[Problem](), list[Problem]()
        try:
            warnings = [x for x in resolve(point).warnings if x not in base.warnings]
        except ScenarioError as error:
            errors = list(error.problems)
        alone = parameters.held <= numbers.keys()
        for told, found in ((errors, wrong if alone else doubtful), (warnings, doubtful)):
            own = [x for x in told if x.place.startswith("model.") and x.place not in later]
            found += [x.inside(f"events.{event.name}.parameters") for x in own]
    return wrong, doubtful
