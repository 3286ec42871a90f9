"""The shape of a mechanism's KKT matrix: in which order its variables are eliminated, and what may be left out."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from lienumba.mechanics.mechanism.model import Model
from lienumba.mechanics.system.constraints import constraints_of, permanent_rows, rows_of
from lienumba.mechanics.system.elimination_order import Couplings, elimination_order
from lienumba.mechanics.system.rotors import rotors_of
from lienumba.mechanics.system.switched.border import FrictionCoupling
from lienumba.numerics.number import Number

Entries = dict[tuple[int, int], Any]


@dataclass(frozen=True)
class Structure:
    """The shape of a mechanism's KKT matrix. `order`: the variables (6 k velocities, then m rows) as eliminated where A
    is block diagonal; `coupled`: where it is a mass matrix with rotors, which couple bodies.

    looped: the constraints close loops; masked: the rows that may be left out, because others say the same; dropped
    rows are left out always, their mask is the float 0. from_singular: the start is a singular position; where a pivot
    vanishes like there, the solution is the expected one, since C does not say where the lost constraint acts.
    friction_rows: the rows of contacts with friction, the last of the order, which are solved together (see
    `FrictionCoupling`); switched: where the rows begin that a run turns on and off; coasts: see `kkt.corrected`.
    """

    bodies: int
    rows: int
    order: tuple[int, ...]
    looped: bool = False
    masked: tuple[int, ...] = ()
    from_singular: bool = False
    alike: tuple[tuple[int, ...], ...] = ()  # for each row those of its constraint and kind, which share one scale
    coupled: tuple[int, ...] = ()
    friction_rows: tuple[int, ...] = ()
    switched: int = 0
    coasts: bool = False

    @staticmethod
    def of(
        model: Model, masked: tuple[int, ...] = (), dropped: tuple[int, ...] = (), from_singular: bool = False
    ) -> "Structure":
        friction = _friction_rows(model)
        k, blocks = len(model.bodies), _blocks(model, {*dropped, *friction})
        couplings = [(*rotor.bodies, rotor.constant) for rotor in rotors_of(model) if len(rotor.bodies) == 2]

        def order(couplings: Couplings) -> tuple[int, ...]:
            found: list[int] = []
            for block in elimination_order(k, [(b.bodies, len(b.rows)) for b in blocks], couplings):
                if block < k:
                    found += range(6 * block, 6 * block + 6)
                else:
                    found += [6 * k + row for row in blocks[block - k].rows]
            return (*found, *(6 * k + row for row in (*dropped, *friction)))

        plain = order(())
        return Structure(
            k, len(plain) - 6 * k, plain, bool(masked) or _has_loop(_permanent(blocks)), masked, from_singular,
            _alike(model), order(couplings) if couplings else plain, friction, permanent_rows(model),
        )  # fmt: skip

    def order_for(self, A: Entries) -> tuple[int, ...]:
        """The order in which [A C^T; C 0] is eliminated."""
        return self.coupled if any(i // 6 != j // 6 for i, j in A) else self.order

    def bordered(self) -> "Structure":
        """With all rows that are switched on and off behind the others, to be solved together."""
        n, first = 6 * self.bodies, 6 * self.bodies + self.switched
        rows = tuple(range(self.switched, self.rows))
        last = tuple(n + row for row in rows)
        order, coupled = ((*(v for v in x if v < first), *last) for x in (self.order, self.coupled))
        return replace(self, order=order, coupled=coupled, friction_rows=rows)

    def weights(self, mask: Sequence[Number], coupling: FrictionCoupling | None) -> list[Any]:
        """By what rows count before the elimination: by the mask, but those that lean on each other."""
        weights = list(mask)
        for row in self.friction_rows if coupling is not None else ():
            weights[row] = 1.0
        return weights

    @staticmethod
    def closing(
        model: Model,
        tied: set[int],
        masked: tuple[int, ...] = (),
        dropped: tuple[int, ...] = (),
        from_singular: bool = False,
    ) -> "Structure":
        """Of the rows alone that do without the joints `tied` (indices), once all velocities are eliminated."""
        every, permanent, friction = rows_of(model), permanent_rows(model), _friction_rows(model)
        left = [rows for n, rows in enumerate(every) if n not in tied]
        order = [row for rows in left for row in range(rows.start, rows.stop) if row not in (*dropped, *friction)]
        order = [row for row in order if row not in masked] + [row for row in order if row in masked]
        rows = every[-1].stop if every else 0
        closes = any(row < permanent for row in order)
        looped = bool(masked) or (closes and _has_loop(_permanent(_blocks(model, set(dropped)))))
        return Structure(
            0, rows, (*order, *friction), looped, masked, from_singular, _alike(model), (), friction, permanent
        )


def _alike(model: Model) -> tuple[tuple[int, ...], ...]:
    return tuple(
        tuple(rows.start + other for other, k in enumerate(c.kinds) if k == kind)
        for c, rows in zip(constraints_of(model), rows_of(model), strict=True)
        for kind in c.kinds
    )


@dataclass
class _Block:
    """The rows that tie the same bodies together, eliminated together; `ties`: how many constraints could do without
    the others, which a driver of a joint's own coordinate or of a body's orientation could not; switched: whether all
    are."""

    bodies: tuple[int, ...]
    rows: list[int] = field(default_factory=list)
    ties: int = 0
    switched: bool = False


def _blocks(model: Model, dropped: set[int]) -> list[_Block]:
    blocks: dict[frozenset[int], _Block] = {}
    for constraint, every in zip(constraints_of(model), rows_of(model), strict=True):
        rows = [row for row in range(every.start, every.stop) if row not in dropped]
        if not rows:
            continue
        switched = constraint.switch is not None
        block = blocks.setdefault(frozenset(constraint.bodies), _Block(constraint.bodies, switched=switched))
        block.rows += rows
        block.ties += constraint.ties and not switched
        block.switched &= switched
    return list(blocks.values())


def _permanent(blocks: list[_Block]) -> list[_Block]:
    return [block for block in blocks if not block.switched]


def _friction_rows(model: Model) -> tuple[int, ...]:
    """The rows of all contacts, where any has friction."""
    every = zip(constraints_of(model), rows_of(model), strict=True)
    return tuple(row for c, rows in every if c.switch and c.switch.shares for row in range(rows.start, rows.stop))


def _has_loop(blocks: list[_Block]) -> bool:
    """Whether a constraint ties bodies that others have tied already."""
    group: dict[int, int] = {}

    def root(body: int) -> int:
        while body in group:
            body = group[body]
        return body

    for block in blocks:
        first, *others = block.bodies
        if block.ties > 1:
            return True
        for other in others:
            a, b = root(first), root(other)
            if a == b:
                return True
            group[a] = b
    return False
