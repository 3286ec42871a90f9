"""From the text of a scenario to its tables: what is wrong with a text that is no TOML, as sentences."""

import re
import tomllib
from collections.abc import Collection
from pathlib import Path
from typing import Any

from lienumba.errors import BadValueError, Problem, ScenarioError
from lienumba.scenario.base.plain import plain
from lienumba.scenario.base.toml import Keys
from lienumba.store.targets import DATASET_STARTS
from lienumba.words import absence, printable

LARGEST = 256 * 2**20  # bytes of a file
TOO_DEEP = "nests tables or lists too deeply", "take brackets, braces or dots out"
NO_TOML = "is not TOML", "give a number, a list in [] or a text in quotes (bare words need none)"
WORDS = re.compile(r"[A-Za-z_][\w.-]*( [\w.-]+)*|-?\d+:\d+(,-?\d+(:\d+)?)*")  # texts that need no quotes


def read_toml(path: Path) -> Keys:
    """The tables of a file; a ScenarioError if it cannot be read, or is no TOML, or holds what no scenario can."""
    text = _text(path)
    try:
        return plain(tomllib.loads(text))
    except tomllib.TOMLDecodeError as error:
        raise ScenarioError(_syntax(path, text, str(error))) from None
    except RecursionError:
        raise ScenarioError.at(f"{path}", *TOO_DEEP) from None
    except ValueError:  # of Python: so many digits
        raise ScenarioError.at(f"{path}", *_long_number(text)) from None


def parse_value(text: str) -> Any:
    """The value of `--set path=text`: TOML; or words, a name with dots, or a range such as 0:20, as a string."""
    try:
        parsed = tomllib.loads(f"value = {text}")
        if list(parsed) == ["value"]:
            return parsed["value"]
    except RecursionError:
        raise BadValueError("", TOO_DEEP[1], verb=TOO_DEEP[0]) from None
    except ValueError:
        if WORDS.fullmatch(text.strip()):
            return text.strip()
    raise BadValueError("", NO_TOML[1], verb=NO_TOML[0])


def _text(path: Path) -> str:
    """The text of a file."""
    shown = printable(str(path))
    read = content(path, "TOML", (".toml",), LARGEST, "put numbers into files: tables, recordings, samples")
    if read.startswith(DATASET_STARTS):
        raise ScenarioError.at(
            "", f"{shown} is a dataset, not a scenario", f"give a TOML file, or: lienumba info {shown}"
        )
    if not read.strip():
        raise ScenarioError.at(
            "", f"{shown} is empty", "write a scenario into it: [model] with bodies, and [integrator]"
        )
    try:
        return read.decode("utf-8-sig").replace("\r\n", "\n")
    except UnicodeDecodeError:
        raise ScenarioError.at("", f"{shown} is not a text file in UTF-8", "give the path of a TOML file") from None


def _long_number(text: str) -> tuple[str, str]:
    """What is wrong where Python refuses to read a number."""
    line = next((n for n, x in enumerate(text.splitlines(), 1) if re.search(r"\d{4000}", x.replace("_", ""))), None)
    return f"has a whole number of thousands of digits{f' in line {line}' if line else ''}", "write it as 1e30"


def _syntax(path: Path, text: str, message: str) -> Problem:
    """A TOML syntax error: line, column, the line itself, and the usual cause."""
    match = re.fullmatch(r"(.*) \(at (?:line (\d+), column (\d+)|end of document)\)", message, re.DOTALL)
    lines = text.split("\n")
    if match is None or match.group(2) is None:
        number, column = len(lines), len(lines[-1]) + 1
    else:
        number, column = int(match.group(2)), int(match.group(3))
    reason = match.group(1) if match else message
    line = lines[number - 1].strip() if number <= len(lines) else ""
    where = f"{printable(str(path))}, line {number}, column {column}"
    cause = _usual_cause(line[:1000], reason)
    return Problem(where, f"not valid TOML: {printable(reason)}, in `{printable(line[:80])}`", cause)


def _usual_cause(line: str, reason: str) -> str:
    value = line.partition("=")[2].strip()
    if "overwrite" in reason or "twice" in reason:
        return "this key or table is there twice; keep one of them"
    if re.fullmatch(r"[-+]?\d+,\d+", value):
        return f"a decimal number has a point: {value.replace(',', '.')}"
    if value.endswith((";", ",")):
        return "a line ends without a comma or semicolon"
    if re.search(r"(^|[\s\[,=])[-+]?\.\d", value) or re.search(r"\d\.(\D|$)", value):
        return "a decimal point needs a digit on both sides: 0.5, 15.0"
    if re.match(r"(True|False|None|none|null)\b", value):
        return "write true or false in lower case; leave a key out to omit it"
    if re.match(r"[\d.]+\s*(kg|m|s|rad|deg|Nm|N)\b", value):
        return "write the number alone, without its unit"
    if re.match(r"[A-Za-z]", value):
        return "a text needs quotes"
    if re.match(r"[\w.]*\[\d+\]|[\w.]+\[", line) and "=" in line:
        return "a path with an index needs quotes"
    if "=" not in line and not line.startswith("["):
        return "a line is `key = value` or `[section]`"
    return "check brackets, quotes and commas"


def content(path: Path, kind: str, endings: Collection[str], largest: int, instead: str) -> bytes:
    """All bytes of a file; a ScenarioError if it cannot be read, or has more than the largest.

    kind: of the file that is wanted, such as "TOML"; endings: of the names of such files; instead: the remedy where it
    is too large.
    """
    shown = printable(str(path))
    try:
        if path.is_dir():
            raise ScenarioError.at("", f"{shown} is a folder", f"give the path of a {kind} file in it")
        if not path.exists():
            rule, remedy = absence(path, endings)
            raise ScenarioError.at("", f"{shown} {rule}", remedy)
        with path.open("rb") as file:
            found = file.read(largest + 1)
    except OSError as error:
        remedy = "check its permissions" if isinstance(error, PermissionError) else "check the path"
        raise ScenarioError.at(f"{shown} cannot be read", str(error.strerror), remedy) from None
    if len(found) > largest:
        raise ScenarioError.at(shown, f"is larger than {largest >> 20} MiB", instead)
    return found
