"""A model without its numbers, which are read at run time, so that one program serves all that differ in them alone."""

from dataclasses import dataclass
from typing import Any

from lienumba.compiler.symbols import Graph
from lienumba.mechanics.mechanism.model import Model, once_per_model
from lienumba.mechanics.mechanism.model_numbers import map_numbers


@dataclass(frozen=True)
class Slot:
    """A number of the model that is read at run time, from this row of the parameters."""

    row: int


@once_per_model
def split(model: Model) -> tuple[Model, list[Any]]:
    """The template of a model, with slots for its parameters, and their values. Exact 0, 1, -1 in structural places
    stay."""
    values: list[Any] = []

    def slot(value: Any) -> Slot:
        values.append(value)
        return Slot(len(values) - 1)

    def number(value: Any, structural: bool) -> Any:
        known = structural and isinstance(value, float | int) and value in (0, 1, -1)
        return float(value) if known else slot(value)

    return map_numbers(model, number, slot), values


def symbolic(template: Model, graph: Graph | None = None) -> tuple[Graph, Model]:
    """A graph, and the model with its inputs in the slots."""
    graph = graph or Graph()

    def number(x: Any, structural: bool = False) -> Any:
        return graph.input("parameters", x.row) if isinstance(x, Slot) else x

    return graph, map_numbers(template, number, number)


def leaves(model: Model) -> list[Any]:
    """Every number of a model, and what its tables hold, in one order for a model and its template."""
    found: list[Any] = []

    def note(value: Any, structural: bool = False) -> Any:
        found.append(value)
        return value

    map_numbers(model, note, note)
    return found
