"""Every numeric key of the schema takes the name of a parameter, or its message says that it does not."""

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

import lienumba
from lienumba.scenario.base.paths import BESIDE, written
from lienumba.scenario.formulas.numbers import take
from lienumba.scenario.reading.loading import load
from lienumba.scenario.schema.messages import NO_FORMULA
from tests.facade import ScenarioError, resolve
from tests.rigs.inputs import at_hinge
from tests.scenario.schema.every_table import EveryTable, Keys, branches

# What is read before formulas are: files, tables of numbers, the parameters themselves.
READ_FIRST = {
    ("StartSection", "run"), ("StartSection", "time"), ("TableSection", "times"), ("TableSection", "values"),
    ("Tabulated", "runs"), ("Tabulated", "samples"), ("scenario", "parameters"),
}  # fmt: skip
MISPLACED = ("Inertia",)  # whose messages lack the key
MODEL = ("model", *BESIDE)


def with_name(schema: Keys) -> Any:
    """The value of a key with the name of a parameter in place of every number; None where there is no number."""
    for form in branches(schema):
        own, item = form.get("additionalProperties"), form.get("items")
        if isinstance(form.get("type"), list) or form.get("type") in ("number", "integer"):
            return "p"
        if isinstance(item, dict) and (found := with_name(item)) is not None:
            return [found] * form.get("minItems", 1)
        if isinstance(own, dict) and "form" not in form and (found := with_name(own)) is not None:
            return {"limit": found}
    return None


def leaves(place: str, value: Any) -> Iterator[str]:
    if isinstance(value, str):
        yield place
    for n, x in enumerate(value) if isinstance(value, list) else ():
        yield from leaves(f"{place}[{n}]", x)
    for key, x in value.items() if isinstance(value, dict) else ():
        yield from leaves(f"{place}.{key}", x)


def test_every_number_takes_the_name_of_a_parameter_or_says_that_it_does_not() -> None:
    every = EveryTable()
    named: dict[int, Keys] = {id(table): {} for table in every.tables}
    for table in [x for x in every.tables if x.form not in MISPLACED]:
        new = {key: with_name(x) for key, x in table.known.items() if (table.form, key) not in READ_FIRST}
        named[id(table)] = {key: x for key, x in new.items() if x is not None and key not in table.keys}
        table.keys |= named[id(table)]
    every.data["parameters"] = {"p": 0.75}
    at = {x for place, table in every.placed() for x in leaves(place, named[id(table)])}
    at = {x.lstrip(".") for x in at}
    taken = {written(tokens) for tokens in take(load(every.data))[0].places}
    with pytest.raises(ScenarioError) as caught:
        resolve(every.data)
    refused = {x.place: x.rule for x in caught.value.problems if x.rule.endswith(NO_FORMULA)}
    assert at - taken - refused.keys() == {"integrator.dexpinv"}  # a number or a name
    assert not {x for x in refused if x.partition(".")[0] in MODEL}
    assert len(at & taken) > 700


def test_a_limit_follows_a_parameter() -> None:
    """2 t is limited by 0.5, and by 0.75 in the other run."""
    system = at_hinge("0").parameter("top", 0.5).input("x", {"value": "2*t", "limit": "top"})
    system = system.sweep(runs=2).vary("parameters.top", distribution="choice", values=[0.5, 0.75])
    ds = lienumba.run(system)
    np.testing.assert_allclose(ds["inputs.x"], np.minimum(2 * ds.time, ds["parameters.top"]).T, rtol=1e-15)


def test_a_limit_that_is_a_constant_formula_may_vary() -> None:
    system = at_hinge("0").input("x", {"value": "2*t", "limit": "1/2"}).sweep(runs=2)
    ds = lienumba.run(system.vary("inputs.x.limit", distribution="choice", values=[0.5, 0.75]))
    np.testing.assert_allclose(ds["inputs.x"], np.minimum(2 * ds.time, ds["inputs.x.limit"]).T, rtol=1e-15)
