"""Whatever a scenario is made of becomes plain, or is refused with a sentence, before anything reads it."""

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import lienumba
from lienumba.scenario.base.plain import DEEPEST, LONGEST_KEY, WHOLE, plain
from tests.facade import ScenarioError, resolve
from tests.rigs.scenario_example import EXAMPLE


def test_a_copy_in_plain_types() -> None:
    numbers = [1.0, math.inf]
    source = {
        "a": np.float64(0.5), "b": np.arange(3), "c": (np.int32(4), np.bool_(True)), "d": Path("x/y.csv"),
        "none": None, "e": {"f": np.array([[1.5, 2.5]])}, "g": numbers, "h": np.str_("text"),
    }  # fmt: skip
    found = plain(source)
    assert found == {
        "a": 0.5, "b": [0, 1, 2], "c": [4, True], "d": "x/y.csv", "e": {"f": [[1.5, 2.5]]}, "g": [1.0, math.inf],
        "h": "text",
    }  # fmt: skip
    assert {*map(type, (found["a"], found["h"], *found["b"], *found["c"]))} == {float, str, int, bool}  # type: ignore[misc]
    assert found["g"] is not numbers


def nested(depth: int, kind: type) -> Any:
    value: Any = 1.0
    for _ in range(depth):
        value = [value] if kind is list else {"a": value}
    return value


def cycle() -> list[Any]:
    value: list[Any] = []
    value.append(value)
    return value


@pytest.mark.parametrize(
    ("source", "sentence"),
    [
        ({5: 1}, 'the key = 5: must be a text; give keys in quotes, such as "title"'),
        ({"a": {(1, 2): 1}}, 'a: its key: must be a text; give keys in quotes, such as "title"'),
        ({"a": nested(DEEPEST + 1, dict)}, "a.a.a: nests more than 32 tables and lists in one another; take brackets"),
        ({"a": nested(100_000, list)}, "a[0][0]: nests more than 32 tables and lists in one another; take brackets"),
        ({"a": cycle()}, "a[0][0]: nests more than 32 tables and lists in one another; take brackets"),
        ({"a": WHOLE}, "a = 9223372036854775808: is a whole number that 64 bits cannot hold; give"),
        ({"a": [0, 10**5000]}, "a[1] = a number of thousands of digits: is a whole number that 64 bits cannot"),
        ({"a\x1b[2J": 1}, "the key a\\x1b[2J: has a character in its name that cannot be seen; take it out"),
        ({"a": "b\0"}, 'a = "b\\x00": has a control character in it; take it out'),
        ({"a": "\ud800"}, 'a = "\\ud800": has a control character in it; take it out'),
        ({"files": {"a.py": "\0"}}, 'files.a.py = "\\x00": has a control character in it; take it out'),
        ({"k" * 251: 1}, f"the key {'k' * 56} ...: is 251 characters long, at most {LONGEST_KEY} are allowed; give"),
        ({"a": [None]}, "a[0]: is empty, which no scenario can hold; give a number, a text in quotes, a list"),
        ({"a": {1, 2}}, "a: is a set, which no scenario can hold; give a number, a text in quotes, a list or a table"),
        ({"a": 1j}, "a: is a complex, which no scenario can hold; give a number, a text in quotes, a list or a"),
        ({"a": print}, "a: is a builtin_function_or_method, which no scenario can hold; give a number"),
    ],
    ids=range(16),
)  # fmt: skip
def test_what_no_scenario_can_hold(source: dict[Any, Any], sentence: str) -> None:
    with pytest.raises(ScenarioError) as error:
        plain(source)
    assert str(error.value).startswith(sentence)


def test_as_deep_as_allowed() -> None:
    assert plain({"a": nested(DEEPEST, list)}) == {"a": nested(DEEPEST, list)}
    assert plain({"files": {"a.py": "x = '\x1b'"}})["files"] == {"a.py": "x = '\x1b'"}
    assert plain({"a": -WHOLE, "b": "line\n\tline"}) == {"a": -WHOLE, "b": "line\n\tline"}


@pytest.mark.parametrize(
    ("overrides", "sentence"),
    [
        ({5: 1}, '{"5": 1}: the path 5: must be a text; write one such as bodies.top.mass or bodies.top.position[1]'),
        ("x=1", 'overrides = "x=1": must be a mapping from paths to values; give them such as {"integrator.step"'),
        ({"bodies.top.mass": nested(50, list)}, '{"bodies.top.mass": [[[[[[[[['),
        ({"projection[0]": 1}, '{"projection[0]": 1}: the path projection[0] has the index 0 of a table, which has'),
        ({"title": "\x1b]0;x\x07"}, '{"title": \\x1b]0;x\\x07}: the value \\x1b]0;x\\x07 is not TOML; give a number'),
    ],
)  # fmt: skip
def test_settings(overrides: Any, sentence: str) -> None:
    with pytest.raises(ScenarioError) as error:
        resolve(EXAMPLE | {"projection": {}}, overrides=overrides)
    assert any(line.startswith(sentence) for line in str(error.value).splitlines()), str(error.value)


def test_a_path_object_is_a_scenario_too(tmp_path: Path) -> None:
    (tmp_path / "case.toml").write_text(lienumba.System.to_toml(_example()))
    assert resolve(tmp_path / "case.toml").sha256() == resolve(EXAMPLE).sha256()


def _example() -> lienumba.System:
    system = lienumba.System()
    system._data = EXAMPLE
    return system
