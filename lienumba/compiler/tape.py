"""Recorded graphs, computed again on other numbers: symbols of another graph, floats, or arrays of runs.

A tape that is replayed often becomes a Python function of one statement for each operation, whose source is generated
and compiled once: on floats it takes a twentieth of the time of a loop over the operations, which gives the same bits.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import count
from math import isfinite
from typing import Any

from lienumba.compiler.series import FUNCTIONS
from lienumba.compiler.symbols import Symbol, live, uncollected

REPLAYS_BEFORE_COMPILING = 12  # as many on floats take as long as compiling the function
OPERATORS = {
    "+": "{} + {}", "-": "{} - {}", "*": "{} * {}", "neg": "-{}", "<": "{} < {}", "<=": "{} <= {}", "==": "{} == {}",
    "fma": "{2} + {0} * {1}", "fms": "{0} * {1} - {2}", "fnma": "{2} - {0} * {1}",
}  # fmt: skip
CALLS = {op: "divide" if op == "/" else op for op in FUNCTIONS if op not in OPERATORS}


@dataclass
class Tape:
    """A recorded graph. constants: the first numbers; steps: each an operation with the positions of its operands, or
    an input's array and row; results: positions of the values; replays: the number so far."""

    constants: list[Any]
    steps: list[tuple[str, Any]]
    results: list[int]
    replays: int = 0

    @staticmethod
    @uncollected()
    def of(values: Sequence[object]) -> "Tape":
        nodes = live(values)
        constants = [x for node in nodes if node.op != "input" for x in node.args if not isinstance(x, Symbol)]
        constants += [x for x in values if not isinstance(x, Symbol)]
        places = {node.id: n for n, node in enumerate(nodes, len(constants))}
        number = count()

        def place(x: object) -> int:
            return places[x.id] if isinstance(x, Symbol) else next(number)

        steps = [(node.op, node.args if node.op == "input" else tuple(place(x) for x in node.args)) for node in nodes]
        return Tape(constants, steps, [place(x) for x in values])

    def replayed(self, given: Callable[[str, int], Any]) -> list[Any]:
        """The values, where inputs are given(array, row)."""
        self.replays += 1
        if self.replays > REPLAYS_BEFORE_COMPILING:
            return self._function(given)
        known = list(self.constants)
        so_far = known.__getitem__
        for op, args in self.steps:
            known.append(given(*args) if op == "input" else FUNCTIONS[op](*map(so_far, args)))
        return [known[n] for n in self.results]

    @cached_property
    def _function(self) -> Callable[[Callable[[str, int], Any]], list[Any]]:
        """`replayed` as one function."""
        names = {f"constant_{n}": x for n, x in enumerate(self.constants)} | {CALLS[op]: FUNCTIONS[op] for op in CALLS}
        exec(compile("\n".join(self._source()), "<tape>", "exec"), names)
        return names["replay"]

    def _source(self) -> Iterator[str]:
        """Yield the lines of a function `replay`; a variable is used again after the last step that reads it."""
        last = {n: step for step, (op, args) in enumerate(self.steps) if op != "input" for n in args}
        for n in self.results:
            last[n] = len(self.steps)
        known = [repr(x) if _is_literal(x) else f"constant_{n}" for n, x in enumerate(self.constants)]
        free, fresh = list[str](), count()
        yield "def replay(given):"
        for step, (op, args) in enumerate(self.steps):
            if op == "input":
                value = f"given{args}"
            else:
                taken = [known[n] for n in args]
                value = OPERATORS[op].format(*taken) if op in OPERATORS else f"{CALLS[op]}({', '.join(taken)})"
                free += [known[n] for n in {*args} if n >= len(self.constants) and last[n] == step]
            known.append(free.pop() if free else f"x{next(fresh)}")
            yield f"  {known[-1]} = {value}"
        yield f"  return [{', '.join(known[n] for n in self.results)}]"


def _is_literal(x: object) -> bool:
    return type(x) is float and isfinite(x)


def replayed(values: Sequence[object], given: Callable[[str, int], Any]) -> list[Any]:
    """What a graph computes, on other numbers: given(array, row) for each of its inputs."""
    return Tape.of(values).replayed(given)
