"""What may push, what events ask for, and equations of which some are inequalities."""

import re
from collections.abc import Mapping
from itertools import combinations
from typing import Any

import numpy as np

from tests.oracles.mechanisms.engine import NEGLIGIBLE, Mechanism, Motion
from tests.oracles.mechanisms.numbers import number
from tests.oracles.mechanisms.places import Array, Function, Places, dot, point_of
from tests.oracles.mechanisms.quantities import SEEN

Table = Mapping[str, Any]
EQUAL = 1e-300  # of what is true where numbers are equal
AXES = {"x": 0, "y": 1, "z": 2}
TURNED = 3.0  # rad, beyond which angles are not followed


class UnlikeError(Exception):
    """What the two cannot be expected to do alike, or what is not known here."""


class ContradictingError(UnlikeError):
    """What has to hold at once asks for different motions."""


def complementary(M: Array, q: Array, B: Array, b: Array, C: Array, c: Array) -> tuple[Array, Array, Array]:
    """x, m and p with M x = q + B' m + C' p, B x = b, C x >= c, p >= 0, and one of the two equal for each row: by
    trying all subsets. Where several p do, one of those with the fewest entries."""
    columns = 1.0 / np.sqrt(np.diag(M))
    scale = float(np.abs(q * columns).max(initial=1.0)) + 1.0
    for size in range(len(C) + 1):
        for some in combinations(range(len(C)), size):
            A, a = np.concatenate([B, C[list(some)]]), np.concatenate([b, c[list(some)]])
            lengths = np.linalg.norm(A * columns, axis=1)
            D = np.concatenate([columns, 1.0 / lengths])
            K = np.block([[M, -A.T], [A, np.zeros((len(A), len(A)))]]) * D * D[:, None]
            x = D * np.linalg.lstsq(K, D * np.concatenate([q, a]), rcond=NEGLIGIBLE)[0]
            x, m, p = np.split(x, [len(q), len(q) + len(b)])
            slack = np.linalg.norm(C * columns, axis=1)
            if np.abs((A @ x - a) / lengths).max(initial=0.0) > 1e-7 * scale:
                continue
            if (p * lengths[len(b) :] > -1e-9 * scale).all() and ((C @ x - c) / slack > -1e-9 * scale).all():
                pushes = np.zeros(len(C))
                pushes[list(some)] = p
                return x, m, pushes
    raise ContradictingError("equations that contradict each other")


# ---------------------------------------------------------------- unilateral constraints
def stop(q: Function, side: float, value: float) -> Function:
    def f(places: Places, t: Any) -> Array:
        x = q(places, t)
        if abs(float(x[0, 0].real)) > TURNED and abs(value) < TURNED:
            raise UnlikeError("an angle of half a turn")
        return side * (x - value)

    return f


def gap(contact: Table) -> Function:
    """How far apart two surfaces are."""
    (a, b), (p, q) = contact["bodies"], contact["points"]
    if contact["type"] == "sphere_sphere":

        def between(places: Places, t: Any) -> Array:
            d = point_of(places, a, p) - point_of(places, b, q)
            return (np.sqrt(dot(d, d)) - sum(contact["radii"]))[:, None]

        return between
    normal = np.array(contact["normal"]) / np.linalg.norm(contact["normal"])

    def above(places: Places, t: Any) -> Array:
        d = point_of(places, a, p) - point_of(places, b, q)
        return (dot(places[b][1] @ normal, d) - contact.get("radius", 0.0))[:, None]

    return above


# ---------------------------------------------------------------- conditions
class Condition:
    """A comparison, or two of them with "and" or "or"."""

    def __init__(self, text: str, quantities: Mapping[str, Table]) -> None:
        self.both, self.parts = " and " in text, re.split(" and | or ", text)
        self.quantities = quantities
        names = {part.split(".")[0] for part in self.parts if self._quantity(part)}
        self.forces = any(quantities[n]["type"] == "reaction" or quantities[n].get("derivative", 0) == 2 for n in names)
        self.timed = not names

    def _quantity(self, part: str) -> bool:
        return part.split(".")[0] in self.quantities

    def value(self, m: Mechanism, now: Motion) -> float:
        values = [self._one(part, m, now) for part in self.parts]
        return min(values) if self.both else max(values)

    def _one(self, part: str, m: Mechanism, now: Motion) -> float:
        left, sign, right = part.rsplit(" ", 2)
        if not self._quantity(part):
            x = float(number(left)(now.t))
        else:
            name, *rest = left.split(".")
            table = self.quantities[name]
            found = SEEN[table["type"]](m, now, table)
            value = found[""] if rest[0] in AXES and "" in found else found[rest[0]]
            if "angle" in rest[0] and abs(float(np.max(value))) > TURNED:
                raise UnlikeError("an angle of half a turn")
            x = float(np.asarray(value).reshape(-1)[AXES[rest[-1]] if rest[-1] in AXES and np.size(value) > 1 else 0])
        away = x - float(right) if sign[0] == ">" else float(right) - x
        return away or (EQUAL if sign[1:] else 0.0)
