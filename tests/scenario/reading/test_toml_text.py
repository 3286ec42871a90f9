"""Texts that are no scenarios, each with its sentence: the limits of the parser are those of no user."""

import os
from pathlib import Path

import pytest

from lienumba.errors import BadValueError
from lienumba.scenario.reading import toml_text
from lienumba.scenario.reading.toml_text import parse_value, read_toml
from tests.facade import ScenarioError


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("a = " + "[" * 2000 + "]" * 2000, "{}: nests tables or lists too deeply; take brackets, braces or dots out"),
        ("a = " + "{b=" * 400 + "1" + "}" * 400, "{}: nests tables or lists too deeply; take brackets, braces or dots"),
        ("a" + ".a" * 1500 + " = 1", "a.a.a: nests more than 32 tables and lists in one another; take brackets"),
        ("x = 1\na = " + "9" * 5000, "{}: has a whole number of thousands of digits in line 2; write it as 1e30"),
        ("a = 99999999999999999999", "a = 99999999999999999999: is a whole number that 64 bits cannot hold; give"),
        ("a = 1979-05-27", "a: is a date, which no scenario can hold; give a number, a text in quotes"),
        ("a = 07:32:00", "a: is a time, which no scenario can hold; give a number, a text in quotes"),
        ('a = "x\x1b[2J"', "{}, line 1, column 7: not valid TOML: Illegal character '\\x1b', in `a = \"x\\x1b[2J\"`"),
        ('a = "\\u001b"', 'a = "\\x1b": has a control character in it; take it out'),
        ('"a\\u0000" = 1', "the key a\\x00: has a character in its name that cannot be seen; take it out"),
    ],
    ids=range(10),
)  # fmt: skip
def test_texts(tmp_path: Path, text: str, said: str) -> None:
    path = tmp_path / "case.toml"
    path.write_text(text)
    with pytest.raises(ScenarioError) as error:
        read_toml(path)
    assert str(error.value).startswith(said.format(path))


def test_files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for path, said in (
        (tmp_path, "is a folder"),
        (tmp_path / "x.toml", "does not exist"),
        (tmp_path / ("x" * 5000), "cannot be read: File name too long; check"),
        (Path("a\0b"), "a\\x00b does not exist"),
    ):
        with pytest.raises(ScenarioError) as error:
            read_toml(path)
        assert said in str(error.value)
        assert "\0" not in str(error.value)
    monkeypatch.setattr(toml_text, "LARGEST", 10)
    (tmp_path / "large.toml").write_text("title = 'a title'")
    with pytest.raises(ScenarioError, match=r"large\.toml: is larger than 0 MiB; put numbers into files"):
        read_toml(tmp_path / "large.toml")


def test_windows_lines_and_a_mark_at_the_start(tmp_path: Path) -> None:
    (tmp_path / "case.toml").write_bytes(b'\xef\xbb\xbftitle = "x"\r\n[model]\r\n')
    assert read_toml(tmp_path / "case.toml") == {"title": "x", "model": {}}


@pytest.mark.parametrize("text", ["[" * 3000, "{a=" * 3000, "9" * 5000, "1\n2", ""])
def test_settings(text: str) -> None:
    with pytest.raises(BadValueError):
        parse_value(text)
    assert parse_value("rk4") == "rk4"
    assert parse_value("[1, 2]") == [1, 2]


@pytest.mark.skipif(os.name == "nt", reason="a folder in use stays there")
def test_a_working_folder_that_is_gone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from lienumba.scenario.reading.loading import load

    folder = tmp_path / "gone"
    folder.mkdir()
    (tmp_path / "case.toml").write_text('title = "x"')
    monkeypatch.chdir(folder)
    folder.rmdir()
    assert load(tmp_path / "case.toml") == {"title": "x"}
    with pytest.raises(ScenarioError, match=r"case\.toml does not exist"):
        load("case.toml")
