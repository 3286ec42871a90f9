"""Options in messages: arguments for who calls Python, options for who types a command."""

import ast
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import lienumba
from lienumba.scenario.base.arguments import check_count
from lienumba.words import option, settings, to_terminal
from tests.facade import ScenarioError
from tests.rigs.scenarios import TOP, scenario

PACKAGE = Path(lienumba.__file__).parent
TYPED = re.compile(r"(?<![\w<!-])--[a-z]")
ONLY_TYPED = {"engine/checks/mujoco.py", "analysis/summary_text.py"}  # of `check`; whole commands in a summary
SPEAKING = ("cli/", "present/", "words.py")  # to a terminal, or with whole commands to the reader of a page


def top() -> dict[str, Any]:
    return scenario(TOP, 1e-3, 0.01)


CALLS: dict[str, tuple[Callable[[Path], object], str]] = {
    "a dataset is there": (
        lambda file: lienumba.run(top(), output=file),
        "choose another name, replace it with overwrite=True, or add runs to it with resume=True",
    ),
    "both": (
        lambda file: lienumba.run(top(), output=file, resume=True, overwrite=True),
        "resume=True goes on with what is there, and overwrite=True starts again; give one of them",
    ),
    "a path of prepare": (
        lambda file: lienumba.prepare(top(), overrides={"bodies.tpo.mass": 3.0}),
        '{"bodies.tpo.mass": 3.0}: the path bodies.tpo.mass has no "tpo" here; the nearest known name is "top"',
    ),
    "a path of a prepared run": (
        lambda file: lienumba.prepare(top()).run({"bodies.tpo.mass": 3.0}),
        '{"bodies.tpo.mass": 3.0}: the path bodies.tpo.mass has no "tpo" here; the nearest known name is "top"',
    ),
    "a text of prepare": (
        lambda file: lienumba.prepare(top(), overrides={"integrator.step": "1 ms"}),
        '{"integrator.step": 1 ms}: the value 1 ms is not TOML',
    ),
    "too many runs": (lambda file: check_count(10**15, 1), 'run parts of them, one after the other: part="1/'),
}


@pytest.mark.parametrize("name", CALLS)
def test_python_is_told_of_arguments(name: str, tmp_path: Path) -> None:
    file = tmp_path / "top.nc"
    lienumba.run(top(), output=file)
    call, sentence = CALLS[name]
    with pytest.raises(ScenarioError) as error:
        call(file)
    assert sentence in str(error.value)
    assert not TYPED.search(str(error.value))


def test_a_terminal_is_told_of_options() -> None:
    python = (option("allow_code"), option("run", 17), option("worst", "swing"), settings("a.b", "1"), settings())
    assert python == ("allow_code=True", "run=17", 'worst="swing"', '{"a.b": 1}', "overrides")
    with to_terminal():
        typed = (option("allow_code"), option("run", 17), option("worst", "swing"), settings("a.b", "1"), settings())
    assert typed == ("--allow-code", "--run 17", "--worst swing", "--set a.b=1", "--set")
    assert option("resume") == "resume=True"


def test_no_message_has_options_of_its_own() -> None:
    """They come from `words`, which knows who reads them."""
    found = []
    for path in PACKAGE.rglob("*.py"):
        name = path.relative_to(PACKAGE).as_posix()
        if name.startswith(SPEAKING) or name in ONLY_TYPED:
            continue
        tree = ast.parse(path.read_text(encoding="utf-8"))
        texts = [node.value for node in ast.walk(tree) if isinstance(node, ast.Expr)]  # docstrings
        found += [
            (name, node.value)
            for node in ast.walk(tree)
            if isinstance(node, ast.Constant) and isinstance(node.value, str) and node not in texts
            if TYPED.search(node.value)
        ]
    assert found == []
