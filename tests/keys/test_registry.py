"""Registries: order, names, helpful errors; what is derived from one follows it."""

from typing import Literal

import pytest
from pydantic import Field, ValidationError

from lienumba.keys.registry import Registry, literal
from lienumba.keys.types import Positive, Section
from lienumba.mechanics.elements.joints.keys import Between
from lienumba.scenario.schema.json_schema import json_schema
from lienumba.scenario.schema.messages import problems
from lienumba.scenario.schema.scenario import ScenarioData
from lienumba.scenario.schema.sections import section_of
from tests.facade import JOINTS


class Apple(Section):
    type: Literal["apple"]


class Pear(Section):
    type: Literal["pear"]


def fruit() -> Registry[type[Section]]:
    registry: Registry[type[Section]] = Registry("fruit", literal("type"))
    registry.add(Pear)
    registry.add(Apple)
    return registry


def test_records_stay_in_the_order_in_which_they_were_added():
    assert list(fruit()) == ["pear", "apple"]
    assert dict(fruit()) == {"pear": Pear, "apple": Apple}


def test_add_is_a_decorator():
    assert Registry("fruit", literal("type")).add(Apple) is Apple


def test_what_is_not_there_is_told_with_the_nearest_name():
    with pytest.raises(KeyError, match=r'there is no fruit "aple"; the nearest known name is "apple"'):
        fruit()["aple"]
    assert fruit().get("aple") is None
    assert "aple" not in fruit()
    assert ["apple"] not in fruit()


def test_a_name_is_taken_once():
    with pytest.raises(ValueError, match='there is a fruit "pear" already; give this one another name'):
        fruit().add(Pear)


def test_a_class_of_no_single_name_is_refused():
    class Any(Section):
        type: Literal["apple", "pear"]

    with pytest.raises(TypeError, match=r"Any\.type must be a Literal of one text"):
        fruit().add(Any)


def test_temporarily_ends_whatever_happens_and_listeners_hear_of_it():
    registry: Registry[type[Section]] = Registry("fruit", literal("type"))
    heard: list[list[str]] = []
    registry.listeners.append(lambda: heard.append(list(registry)))
    with pytest.raises(ZeroDivisionError), registry.temporarily(Apple, Pear):
        raise ZeroDivisionError
    assert heard == [["apple"], ["apple", "pear"], []]


class Rope(Between):
    type: Literal["rope"]
    slack: Positive = Field(description="the slack in m, above 0")


def scenario(**keys: object) -> dict[str, object]:
    body = {"name": "bob", "mass": 1.0, "inertia": [1.0, 1.0, 1.0]}
    joint = {"name": "r", "type": "rope", "bodies": ["ground", "bob"], **keys}
    return {"model": {"bodies": [body], "joints": [joint]}, "integrator": {"step": 0.1, "end_time": 1.0}}


def told(raw: dict[str, object]) -> list[str]:
    with pytest.raises(ValidationError) as error:
        ScenarioData.model_validate(raw)
    return [str(problem) for problem in problems(error.value, raw)]


def test_a_class_that_is_added_is_known_to_schema_and_messages_and_no_longer_afterwards():
    before = json_schema()
    (unknown,) = told(scenario(slack=1.0))
    assert unknown.startswith('model.joints.r.type = "rope": is not known')
    with JOINTS.temporarily(Rope):
        data = ScenarioData.model_validate(scenario(slack=1.0))
        assert data.model.joints == [Rope(name="r", type="rope", bodies=["ground", "bob"], slack=1.0)]
        assert data.model_dump()["model"]["joints"][0]["slack"] == 1.0
        assert "Rope" in json_schema()["$defs"]
        assert section_of("joints", {"type": "rope"}) is Rope
        assert told(scenario(slack=0.0)) == [
            "model.joints.r.slack = 0.0: must be above 0; give the slack in m, above 0"
        ]
        assert (
            told(scenario(slak=1.0))[-1] == 'model.joints.r.slak is not a known key; the nearest known name is "slack"'
        )
    assert told(scenario(slack=1.0)) == [unknown]
    assert json_schema() == before
    assert section_of("joints", {"type": "rope"}) is None


def test_a_record_that_a_listener_refuses_is_not_added() -> None:
    registry: Registry[str] = Registry("word", str)
    registry.add("a")

    def refuse() -> None:
        if "bad" in registry:
            raise ValueError("no")

    registry.listeners.append(refuse)
    with pytest.raises(ValueError, match="no"):
        registry.add("bad")
    assert list(registry) == ["a"]
    with registry.temporarily("b"):
        registry.add("c")
    assert list(registry) == ["a", "c"]
