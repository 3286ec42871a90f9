"""What an import gives: a System that knows what was left out, and reads as if somebody had written it."""

from collections import deque
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from textwrap import wrap
from typing import Any

from lienumba.importing.notes import Note
from lienumba.scenario.base import toml
from lienumba.scenario.base.code import beside
from lienumba.scenario.base.toml import pairs
from lienumba.scenario.meshes.files import write_stl
from lienumba.scenario.meshes.packing import unpacked
from lienumba.scenario.system import System
from lienumba.store.outputs import Output, whole
from lienumba.words import plural

WIDTH = 110
MOST = 8  # places of a note in the summary
LISTS = ("joints", "drivers", "forces")
CONVENTIONS = (
    "Every body has the axes of its link; its origin is the mass centre. Angles and displacements of joints count "
    "as in the source. Units: kg, m, s, rad."
)


class Imported(System):
    """A scenario made of a model of another format.

    Parameters
    ----------
    data : dict
        Its keys and values.
    notes : sequence of Note
        What it has otherwise than the source, or lacks.
    origin : str
        What it was made of.
    licence : str
        What the head of the source says of licence and authors.

    Attributes
    ----------
    notes : tuple of Note
        What it has otherwise than the source, or lacks.
    origin : str
        What it was made of.
    licence : str
        What the head of the source says of licence and authors.
    """

    def __init__(self, data: dict[str, Any], notes: Sequence[Note], origin: str, licence: str = "") -> None:
        super().__init__()
        self._data, self.notes, self.origin, self.licence = data, tuple(notes), origin, licence

    def write(self, path: str | Path | Output) -> None:
        """Write the scenario, its laws into a Python file and its meshes into a folder beside it.

        Parameters
        ----------
        path : path
            The TOML file, replaced if it exists; laws go to a file of its name with "_laws.py", meshes to a folder of
            its name with "_meshes".
        """
        target = path.path if isinstance(path, Output) else Path(path)
        data, files = beside(self.to_dict(), target.stem)
        for name, text in files.items():
            with whole(target.parent / name) as partial:
                partial.write_text(text, encoding="utf-8")
        for shape in _shapes(data["model"]):
            if "data" in shape:
                name = f"{target.stem}_meshes/{shape['file']}"
                write_stl(target.parent / name, *unpacked(shape.pop("data")))
                shape["file"] = name
        with whole(path) as partial:
            partial.write_text(self._text(data), encoding="utf-8")

    def to_toml(self) -> str:
        """The scenario as the text of a TOML file, with its meshes in it.

        Returns
        -------
        str
            What `lienumba run` reads: at its head what was left out, each body with the joint that carries it.
        """
        return self._text(self.to_dict())

    def _text(self, data: dict[str, Any]) -> str:
        model = data.pop("model")
        quantities, events = data.pop("quantities", []), data.pop("events", [])
        late: dict[str, Any] = {key: data.pop(key) for key in ("integrator", "output", "files") if key in data}
        parts = [*self._head(), "", *toml.dumps(data).splitlines()]
        for kind, listed in (("quantities", quantities), ("events", events)):
            parts += _tables(kind, listed)
        lists = {kind: model.pop(kind, []) for kind in LISTS}
        ground = model.pop("ground_shapes", [])
        bodies = model.pop("bodies")
        parts += ["", "[model]", *pairs(model), *_tables("model.ground_shapes", ground)]
        joints = deque(lists["joints"])
        for body in bodies:  # each with the joint that carries it; the order of joints stays
            parts += _tables("model.bodies", [body])
            if joints and joints[0].get("bodies", [System.ground])[-1] == body["name"]:
                parts += _tables("model.joints", [joints.popleft()])
        parts += _tables("model.joints", joints)
        for kind in ("drivers", "forces"):
            parts += _tables(f"model.{kind}", lists[kind])
        return "\n".join([*parts, "", *toml.dumps(late).splitlines()]) + "\n"

    def summary(self) -> str:
        """What became of the source, in a few lines.

        Returns
        -------
        str
            The numbers of bodies, joints and inputs, and all notes, with some of their places.
        """
        model = self._data["model"]
        counts = [
            plural(len(model["bodies"]), "body", "bodies"),
            plural(len(model["joints"]), "joint", "joints"),
            plural(len(self._data.get("inputs", {})), "input", "inputs"),
        ]
        return "\n".join([f"{self.origin}: {', '.join(counts)}", *_told(self.notes, MOST)])

    def _head(self) -> Iterator[str]:
        lines = [f"Made of {self.origin}.", "", CONVENTIONS]
        if self.licence:
            lines += ["", "The source says of itself:", *self.licence.splitlines()]
        if self.notes:
            lines += ["", "Left out, or otherwise than in the source:"]
        for line in lines:
            yield from (f"# {x}" for x in wrap(line, WIDTH)) if line else ("#",)
        for line in _told(self.notes):
            yield f"# {line}"


def _shapes(model: dict[str, Any]) -> Iterator[dict[str, Any]]:
    """Of all bodies, and of the ground."""
    for body in model["bodies"]:
        yield from body.get("shapes", [])
    yield from model.get("ground_shapes", [])


def _told(notes: Sequence[Note], most: int | None = None) -> Iterator[str]:
    """A few lines for each note, with at most so many of its places."""
    for note in notes:
        named: dict[str, list[str]] = {}
        for place in note.places[:most]:
            kind, quote, name = place.partition(' "')
            named.setdefault(kind, []).append(f'"{name}' if quote else "")
        where = "; ".join(f"{kind} {', '.join(names)}".strip() for kind, names in named.items())
        more = f" and {len(note.places) - most} more" if most and len(note.places) > most else ""
        text = f"- {note.what}: {where}{more}" if where else f"- {note.what}"
        yield from wrap(text, WIDTH, subsequent_indent="  ", break_on_hyphens=False)


def _tables(name: str, listed: Iterable[dict[str, Any]]) -> list[str]:
    return [line for item in listed for line in ("", f"[[{name}]]", *pairs(item))]
