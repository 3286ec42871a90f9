"""A scenario while it is made of a model: its elements, their names, and what is to be said of them."""

import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

from lienumba.importing.notes import Note

GROUND = "ground"
LAWS = "laws.py"  # the file of the functions


class Names:
    """The names of one kind: as in the source, as far as that makes a name here, each only once."""

    def __init__(self, *taken: str) -> None:
        self._taken = set(taken)
        self.renamed: dict[str, str] = {}

    def new(self, wanted: str) -> str:
        """A name like this."""
        text = re.sub(r"\W", "_", wanted, flags=re.ASCII).strip("_") or "x"
        text = text if text[0].isalpha() else f"n{text}"
        name, count = text, 2
        while name in self._taken:
            name, count = f"{text}_{count}", count + 1
        self._taken.add(name)
        if name != wanted:
            self.renamed[wanted] = name
        return name


@dataclass
class Draft:
    """Keys of the elements, by kinds, as the scenario has them."""

    bodies: list[dict[str, Any]] = field(default_factory=list)
    joints: list[dict[str, Any]] = field(default_factory=list)
    ground_shapes: list[dict[str, Any]] = field(default_factory=list)
    drivers: list[dict[str, Any]] = field(default_factory=list)
    forces: list[dict[str, Any]] = field(default_factory=list)
    quantities: list[dict[str, Any]] = field(default_factory=list)
    parameters: dict[str, float] = field(default_factory=dict)
    inputs: dict[str, Any] = field(default_factory=dict)
    laws: dict[str, str] = field(default_factory=dict)  # the texts of Python functions by their names
    uses: set[str] = field(default_factory=set)  # what these import of `lienumba.laws`
    notes: list[Note] = field(default_factory=list)
    body_names: Names = field(default_factory=lambda: Names(GROUND))
    joint_names: Names = field(default_factory=lambda: Names(GROUND))
    force_names: Names = field(default_factory=lambda: Names(GROUND))
    input_names: Names = field(default_factory=lambda: Names(GROUND, "recording"))
    value_names: Names = field(default_factory=lambda: Names("t", "pi", "deg", "rpm", "inputs"))

    def note(self, what: str, *places: str, lost: bool = True) -> None:
        """Something to be said."""
        self.notes.append(Note(what, places, lost))

    def force(self, name: str, type: str, **keys: object) -> None:
        """Add a force; what is None is left out."""
        given = {key: value for key, value in keys.items() if value is not None}
        self.forces.append({"name": self.force_names.new(name), "type": type, **given})

    def law(self, text: str, uses: Sequence[str] = ()) -> str:
        """The reference to a Python function by which forces or joints name it; uses: names of `lienumba.laws`."""
        found = re.match(r"def (\w+)", text)
        assert found is not None
        self.laws[found[1]] = text
        self.uses.update(uses)
        return f"{LAWS}:{found[1]}"

    @property
    def file(self) -> str:
        """The text of the file with the functions."""
        head = [f"from lienumba.laws import {', '.join(sorted(self.uses))}\n"] if self.uses else []
        return "\n\n".join([*head, *self.laws.values()])

    def parameter(self, name: str, value: float) -> str:
        """The name of a number by which formulas know it."""
        new = self.value_names.new(name)
        self.parameters[new] = value
        return new
