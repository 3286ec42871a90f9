"""The tables of forces, quantities and events in the documents and the template name what the registries know."""

import re
from keyword import kwlist

import pytest

from lienumba.mechanics.elements.events import ACTIONS
from lienumba.mechanics.elements.forces import FORCES
from lienumba.mechanics.elements.quantities import NOISES, QUANTITIES
from lienumba.numerics.functions import FUNCTIONS
from lienumba.scenario.base.problems import GROUND
from lienumba.scenario.formulas.parameters import RESERVED
from lienumba.store.layout import COORDINATES, FAILED, VARIABLES
from tests.documents.pages import ROOT

TEMPLATE = (ROOT / "scenarios" / "template.toml").read_text(encoding="utf-8")


def table(page: str, head: str) -> list[list[str]]:
    """The cells of the rows of the table of a page that begins with a line."""
    text = (ROOT / "docs" / page).read_text(encoding="utf-8").partition(f"\n{head}\n")[2]
    lines = text.partition("\n\n")[0].splitlines()[1:]
    return [line.strip("| ").split(" | ") for line in lines]


def of_template(name: str) -> str:
    """What the template says of a type, in the table of its comments."""
    found = re.search(rf"^#     {name} {{2,}}(.*)$", TEMPLATE, flags=re.MULTILINE)
    assert found is not None, f"scenarios/template.toml has no line for {name}"
    return found[1]


def test_the_table_of_forces_has_every_type_once() -> None:
    named = [name for row in table("write_a_scenario.md", "| forces | |") for name in re.findall(r"`(\w+)`", row[0])]
    assert sorted(named) == sorted(FORCES)


@pytest.mark.parametrize("name", [name for name in FORCES if FORCES[name].numbers()])
def test_the_template_tells_the_numbers_of_every_force(name: str) -> None:
    assert [key for key in FORCES[name].numbers() if not re.search(rf"\b{key}\b", of_template(name))] == []


def test_the_table_of_quantities_has_every_type_and_its_keys() -> None:
    rows = {row[0].strip("`"): row for row in table("your_own_laws.md", "| type | keys | numbers |")}
    assert sorted(rows) == sorted(QUANTITIES)
    for name, row in rows.items():
        fields = QUANTITIES[name].model_fields
        keys = {key for key in re.findall(r"`(\w+)`", row[1]) if key in fields}
        assert keys == fields.keys() - {"name", "type"}, name


@pytest.mark.parametrize("name", QUANTITIES)
def test_the_template_has_every_quantity_and_its_keys(name: str) -> None:
    assert of_template(name)
    for key in QUANTITIES[name].model_fields:
        assert re.search(rf"^(?:#     )?{key} = ", TEMPLATE, flags=re.MULTILINE), key


def test_the_table_of_reserved_names_has_every_one() -> None:
    rows = {row[0]: row[1] for row in table("write_a_scenario.md", "| not the name of | reserved |")}
    named = [set(re.findall(r"`(\w+)`", row)) for row in rows.values()]
    assert named == [
        {GROUND},
        RESERVED - {*kwlist} | {"if"},
        {*FUNCTIONS},
        {*VARIABLES, *COORDINATES, FAILED},
    ]


def test_the_table_of_noises_has_every_type_and_its_keys() -> None:
    rows = {row[0].strip("`"): row for row in table("write_a_scenario.md", "| noise | is | keys |")}
    assert sorted(rows) == sorted(NOISES)
    for name, row in rows.items():
        keys = NOISES[name].model_fields.keys() - {"name", "type", "units"}
        assert set(re.findall(r"`(\w+)`", row[2])) >= keys, name
        assert of_template(name)
        for key in keys:
            assert re.search(rf"^(?:#     )?{key} = ", TEMPLATE, flags=re.MULTILINE), key


@pytest.mark.parametrize("name", ACTIONS)
def test_every_action_of_events_is_told(name: str) -> None:
    assert f'"{name}"' in TEMPLATE
    assert f'"{name}"' in (ROOT / "docs" / "write_a_scenario.md").read_text(encoding="utf-8")
