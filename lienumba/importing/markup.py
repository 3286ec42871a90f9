"""XML whose elements know their lines, with the comments at the head of the file."""

import re
import xml.etree.ElementTree as ET
from dataclasses import dataclass
from pathlib import Path
from xml.parsers import expat

from lienumba.errors import ScenarioError
from lienumba.scenario.reading.toml_text import content

LARGEST = 1e10  # of a number that says how something moves; MuJoCo takes no larger coordinates
LARGEST_FILE = 64 << 20  # bytes
ENDINGS = (".urdf", ".xml", ".mjcf")
COMMENT = re.compile(rb"<!--(.*?)-->", re.DOTALL)
DASHES, BETWEEN = re.compile(rb"-(?=-|$)"), b"\x7f"  # XML wants something between dashes of a comment


class Element(ET.Element):
    """An element and the line on which it begins."""

    line: int = 0


@dataclass(frozen=True)
class Markup:
    """root: the outermost element; head: the comments before its first child, one below the other."""

    root: Element
    head: str


class _Builder:
    """Makes elements of what the parser meets."""

    def __init__(self) -> None:
        self.parser = expat.ParserCreate()
        self.tree = ET.TreeBuilder(element_factory=self.element)
        self.depth, self.at_head, self.head = 0, True, list[str]()
        self.parser.StartElementHandler = self.start
        self.parser.EndElementHandler = self.end
        self.parser.CharacterDataHandler = self.tree.data
        self.parser.CommentHandler = self.comment

    def element(self, tag: str, attributes: dict[str, str]) -> Element:
        made = Element(tag, attributes)
        made.line = self.parser.CurrentLineNumber
        return made

    def start(self, tag: str, attributes: dict[str, str]) -> None:
        self.at_head = self.at_head and self.depth == 0
        self.depth += 1
        self.tree.start(tag, attributes)

    def end(self, tag: str) -> None:
        self.depth -= 1
        self.at_head = False
        self.tree.end(tag)

    def comment(self, text: str) -> None:
        if self.at_head:
            self.head.append(text.replace(BETWEEN.decode(), ""))


def markup(path: Path) -> Markup:
    """The elements of a file; a ScenarioError where there is none, or no XML."""
    text = _bytes(path)
    if not text.strip():
        raise ScenarioError.at("", f"{path} is empty", "give a URDF or MJCF file")
    builder = _Builder()
    try:
        builder.parser.Parse(text, True)
    except (expat.ExpatError, LookupError) as error:
        raise _no_xml(path, text, error) from None
    root = builder.tree.close()
    assert isinstance(root, Element)
    if root.tag == "mujoco":  # which MuJoCo reads by itself, as UTF-8
        _check_encoding(path, text)
    return Markup(root, "\n".join(builder.head))


def _check_encoding(path: Path, text: bytes) -> None:
    try:
        text.decode()
    except UnicodeDecodeError as error:
        line = text.count(b"\n", 0, error.start) + 1
        raise ScenarioError.at(f"{path}, line {line}", "is not in UTF-8", "save the file in it") from None


def _bytes(path: Path) -> bytes:
    instead = "give a URDF or MJCF file, with its meshes in files of their own"
    text = content(path, "URDF or MJCF", ENDINGS, LARGEST_FILE, instead)
    # robots in use have `--` within comments, and space before their declaration
    text = COMMENT.sub(lambda found: b"<!--" + DASHES.sub(b"-" + BETWEEN, found[1]) + b"-->", text)
    return text.lstrip() if text.lstrip().startswith(b"<?xml") else text


def _no_xml(path: Path, text: bytes, error: Exception) -> ScenarioError:
    number, reason = getattr(error, "lineno", 1), str(error)
    if isinstance(error, expat.ExpatError):
        reason = expat.ErrorString(error.code)
    lines = text.decode("utf-8", "replace").splitlines()
    line = lines[min(number, len(lines)) - 1].strip()
    return ScenarioError.at(
        f"{path}, line {number}", f"not valid XML: {reason}, in `{line[:80]}`", "give a URDF or MJCF file"
    )
