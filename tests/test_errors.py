"""Problems are data until somebody reads them: how their sentences are made, and that none is mended afterwards."""

import ast
import pickle
from pathlib import Path

import pytest

import lienumba
from lienumba.errors import MISSING, NOTHING, UNKNOWN, BadValueError, Problem, missing
from lienumba.words import Written
from tests.facade import ScenarioError, resolve

PACKAGE = Path(lienumba.__file__).parent
SENTENCES = {
    "step = 2.0: is too long; give a shorter one": Problem("step", "is too long", "give a shorter one", 2.0),
    "step: is too long": Problem("step", "is too long"),
    "step = 2: is too long": Problem("step", "is too long", value=Written("2")),
    'title = "a": is bad': Problem("title", "is bad", value="a"),
    "title = None: is bad": Problem("title", "is bad", value=None),
    "both are given; leave one out": Problem("", "both are given", "leave one out"),
    "step is missing; give it": missing("step", "give it"),
    "step is missing: two need it; give it": missing("step", "give it", "two need it"),
    "setp is not a known key; try step": Problem("setp", "", "try step", verb=UNKNOWN),
    'mass = "m" = -1.0: must be above 0': Problem("mass", "must be above 0", value=-1.0, formula="m"),
    'mass = "m": must be above 0': Problem("mass", "must be above 0", value="m", formula="m"),
    "a.toml: grid[0]: step: is bad": Problem("step", "is bad", within=("a.toml", "grid[0]")),
}
MENDING = {
    "replace", "partition", "rpartition", "split", "splitlines", "startswith", "endswith", "removeprefix",
    "removesuffix",
}  # fmt: skip
TEXTS = {"error", "problem", "warning", "sentence", "sentences", "message", "remedy", "rule", "told"}


@pytest.mark.parametrize("sentence", SENTENCES)
def test_a_sentence_is_made_of_place_value_rule_and_remedy(sentence):
    assert str(SENTENCES[sentence]) == sentence


def test_a_key_of_a_table_gets_the_place_of_the_table():
    inner = BadValueError("must be below high", "exchange the two", "low", 2.0)
    assert str(inner) == "low = 2.0: must be below high; exchange the two"
    assert inner.at("vary.mass", {"low": 2.0}) == Problem(
        "vary.mass.low", "must be below high", "exchange the two", 2.0
    )
    assert BadValueError("is bad", "mend it").at("vary.mass", 3.0) == Problem("vary.mass", "is bad", "mend it", 3.0)


def test_an_error_tells_its_problems_in_lines_and_travels_between_processes():
    error = ScenarioError(Problem("a", "is bad", value=1), "b is bad", missing("c", "give it")).inside("x.toml")
    assert str(error) == "x.toml: a = 1: is bad\nx.toml: b is bad\nx.toml: c is missing; give it"
    again = pickle.loads(pickle.dumps(error))
    assert again.problems == error.problems
    assert again.problems[1].value is NOTHING


def test_a_scenario_error_has_its_problems_as_data():
    body = {"name": "top", "mass": "m", "inertia": [1, 1, 1], "position": [0, 0, 0], "rotation": [1, 0, 0, 0]}
    scenario = {
        "parameters": {"m": -2.0},
        "model": {"bodies": [body]},
        "quantities": [{"name": "q", "type": "point", "body": "topp"}, {"name": "r", "type": "point"}],
        "integrator": {"step": 0.1, "end_tim": 1},
    }
    with pytest.raises(ScenarioError) as caught:
        resolve(scenario)
    found = {problem.place: problem for problem in caught.value.problems}
    assert (found["model.bodies.top.mass"].value, found["model.bodies.top.mass"].formula) == (-2.0, "m")
    assert found["integrator.end_tim"].verb == UNKNOWN
    assert "integrator.end_time" not in found  # which is what was meant
    assert found["quantities.r.body"].verb == MISSING
    assert found["quantities.q.body"].value == "topp"
    assert 'model.bodies.top.mass = "m" = -2.0: must be above 0; give the mass in kg, above 0' in str(caught.value)


def test_as_many_sentences_as_somebody_reads() -> None:
    alike = [Problem(f"bodies.b{i}.mass", f"is {i}e-3, too small", "raise it") for i in range(200)]
    error = ScenarioError(*alike, Problem("title", "is bad"))
    lines = str(error).splitlines()
    assert len(error.problems) == 201
    assert lines[0] == "bodies.b0.mass: is 0e-3, too small; raise it"
    assert lines[20:] == ["title: is bad", "180 more problems like these; correct these first"]
    different = [Problem("title", "is " + "x" * i) for i in range(150)]
    assert str(ScenarioError(*different)).splitlines()[100:] == ["50 more problems like these; correct these first"]


@pytest.mark.parametrize("room", ["scenario", "engine", "sweep", "keys", "numerics"])
def test_no_sentence_is_mended(room):
    """The text of an error, a problem, a warning is only ever handed on."""
    found = []
    for path in (PACKAGE / room).rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text())):
            if not (isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and node.func.attr in MENDING):
                continue
            text = node.func.value
            if isinstance(text, ast.Call) and getattr(text.func, "id", "") == "str" and text.args:
                text = text.args[0]
            if getattr(text, "id", "") in TEXTS:
                found.append(f"{path.relative_to(PACKAGE)}:{node.lineno} {ast.unparse(node)}")
    assert found == []


def test_no_terminal_obeys_what_a_message_quotes():
    told = str(ScenarioError("a\u202eb\x1b[31m is bad", Problem("c\x07", "is bad")))
    assert told == "a\\u202eb\\x1b[31m is bad\nc\\x07: is bad"
