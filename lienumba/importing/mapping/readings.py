"""What formulas of forces read: coordinates of joints, and sums of them, as quantities with names."""

from collections.abc import Iterable, Mapping

from lienumba.importing.mapping.draft import Draft
from lienumba.importing.mapping.frames import neat
from lienumba.importing.mapping.source import HINGE, Source
from lienumba.importing.mapping.tree import Tree


class Readings:
    """Adds each quantity when a formula first reads it."""

    def __init__(self, source: Source, draft: Draft, tree: Tree) -> None:
        self._source, self._draft, self._tree = source, draft, tree
        self._known: dict[int, str] = {}

    def coordinate(self, joint: int) -> str:
        """The formula of a hinge's angle, or a slide's displacement."""
        return f"{self._joint(joint)}.{'angle' if self._hinge(joint) else 'displacement'}"

    def rate(self, joint: int) -> str:
        """The formula of its rate."""
        return f"{self._joint(joint)}.{'rate' if self._hinge(joint) else 'speed'}"

    def lengths(self, coefficients: Mapping[int, float]) -> str:
        """The formula of a sum of coordinates."""
        return total(product(c, self.coordinate(joint)) for joint, c in coefficients.items())

    def rates(self, coefficients: Mapping[int, float]) -> str:
        """The formula of its rate."""
        return total(product(c, self.rate(joint)) for joint, c in coefficients.items())

    def named(self, name: str, formula: str) -> str:
        """A name for a formula."""
        new = self._draft.value_names.new(name)
        self._draft.quantities.append({"name": new, "type": "expression", "value": formula})
        return new

    def _hinge(self, joint: int) -> bool:
        return bool(self._source.model.jnt_type[joint] == HINGE)

    def _joint(self, joint: int) -> str:
        if joint not in self._known:
            name = self._draft.value_names.new(f"q_{self._tree.joints[joint]}")
            self._draft.quantities.append({"name": name, "type": "joint", "joint": self._tree.joints[joint]})
            self._known[joint] = name
        return self._known[joint]


def product(factor: float, text: str) -> str:
    """factor*text; "" for 0."""
    if not factor:
        return ""
    return text if factor == 1.0 else f"-{text}" if factor == -1.0 else f"{neat(factor)!r}*{text}"


def total(parts: Iterable[str]) -> str:
    """The sum of those that are not empty; "0" of none."""
    text = " + ".join(part for part in parts if part)
    return text.replace("+ -", "- ") or "0"
