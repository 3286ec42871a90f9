"""Which row of an array is what: of states, of parameters, of observed variables."""

from collections.abc import Iterable, Sequence

import numpy as np

from lienumba.engine.results import Results
from lienumba.errors import ScenarioError
from lienumba.integrators.tracing.evaluating.kernels import Wanted
from lienumba.integrators.tracing.template import Slot, leaves, split
from lienumba.mechanics.mechanism.model import Body
from lienumba.scenario.base import paths
from lienumba.scenario.resolve import Scenario
from lienumba.scenario.start.prepare import Prepared, prepare
from lienumba.store.names import COURSE, match
from lienumba.words import show, suggestion

PROBE = 2.0**-10  # by how much a number is changed to find its row, relative to it or to 1
AXES = tuple(f".{x}" for x in "xyz")
PARTS = {  # of the 18 rows of a body in a state, in their order
    "position": AXES, "rotation": tuple(x + y for x in AXES for y in AXES), "velocity": AXES, "angular_velocity": AXES,
}  # fmt: skip


def state_rows(bodies: Sequence[Body]) -> dict[str, int]:
    """The rows of bodies in a state, by the names that the dataset has."""
    names = [f"{part}.{body.name}{x}" for body in bodies for part, components in PARTS.items() for x in components]
    return {name: n for n, name in enumerate(names)}


def state_row(bodies: Sequence[Body], name: str) -> int | None:
    """The row of a state that has this name, None for what is no part of a state; bodies: none if the state is of joint
    coordinates."""
    known = state_rows(bodies)
    if name not in known and name.partition(".")[0] in PARTS:
        remedy = suggestion(name, known) if bodies else "the state is of joint coordinates; read it by observe"
        raise ScenarioError.at(name, "is in no row of a state", remedy)
    return known.get(name)


def parameter_row(resolved: Scenario, prepared: Prepared, path: str) -> int:
    """The row of the parameters that holds the number of a path.

    It is found by another preparation, in which this number alone is changed: the number of a row has to be this one,
    and no other row and nothing that is compiled in may change with it.
    """
    value = _value(resolved, path)
    values = value + PROBE * max(abs(value), 1.0) * np.arange(1, 3)
    name = paths.canonical(path, dict(resolved.data.model))
    probe = prepare(resolved, [0, 0], {name: values}, prepared.nominal, asked=3)
    places = zip(leaves(split(prepared.model)[0]), leaves(probe.model), strict=True)
    touched = [(slot, x) for slot, x in places if np.ndim(x) == 1 and x[0] != x[1]]
    rows = [slot.row for slot, x in touched if isinstance(slot, Slot) and np.array_equal(x, values)]
    if len(rows) == len(touched) == 1:
        return int(rows[0])
    rule, remedy = "decides about several numbers of the equations", "give it to Kernels.start"
    if not touched:
        rule = "is in no row of the parameters"
    elif not all(isinstance(slot, Slot) for slot, _ in touched):
        rule = "is exactly 0, 1 or -1, and so it is compiled in"
        remedy = "give another number when you prepare, or name it in sweep.vary"
    raise ScenarioError.at(path, rule, remedy, value)


def _value(resolved: Scenario, path: str) -> float:
    """The nominal number at a path."""
    model = dict(resolved.data.model)
    values = {f"parameters.{name}": x for name, x in resolved.parameters.values().items()}
    known = {name: values[name] for name in values if name.removeprefix("parameters.") in resolved.parameters.numbers}
    try:
        tokens = paths.named(paths.parse(path), model)
        value = known.get(paths.text_of(tokens))
        value = paths.get(model, tokens) if value is None else value
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise paths.PathError("leads to no number", paths.nearest_path(path, model))
    except paths.PathError as error:
        raise ScenarioError(error.of(path)) from None
    return float(value)


def wanted(results: Results, observed: Iterable[str], names: Sequence[str]) -> Wanted:
    """The variables of these names, and which of their components each is; observed: variables that kernels know."""
    known, variables = results.names, {*observed, *PARTS}
    every = [x for x in known.every.values() if x.kind == COURSE and x.variable in variables]
    found = []
    for name in names:
        own = [x for x in match(name, known) if x in every]
        if len(own) != 1:
            rule = f"is {len(own)} numbers" if own else "is no number of a state that is stored"
            remedy = f"give one, such as {show(own[0].name)}" if own else suggestion(name, [x.name for x in every])
            raise ScenarioError.at("observe", rule, remedy, name)
        components = [x.place for x in every if x.variable == own[0].variable]
        found.append((own[0].variable, components.index(own[0].place)))
    return found
