"""With which of the constraint rows that say the same all runs begin (`lienumba.integrators.drivers.row_selection`)."""

from dataclasses import dataclass

import numpy as np

from lienumba.integrators.drivers.row_selection import strongest
from lienumba.mechanics.mechanism.kinematics import Instant
from lienumba.mechanics.mechanism.massless import with_lent_masses
from lienumba.mechanics.mechanism.model import Model
from lienumba.mechanics.system import constraints, dynamics, kkt


@dataclass(frozen=True)
class RowSelection:
    """Of the exchangeable rows of C (indices) those in use, 1.0 or 0.0 for each, and the margin at the start, which may
    be a singular position."""

    rows: tuple[int, ...] = ()
    masks: tuple[float, ...] = ()
    margin: float = 0.0
    singular: bool = False

    @property
    def dropped(self) -> tuple[int, ...]:
        return tuple(row for row, used in zip(self.rows, self.masks, strict=True) if not used)


UNIQUE = RowSelection()  # no row says the same as others


def initial_selection(model: Model, exchangeable: tuple[int, ...], now: Instant) -> RowSelection:
    """By the nominal start `now` in floats."""
    if not exchangeable:
        return UNIQUE
    structure = kkt.Structure.of(model, exchangeable)
    C, M = constraints.jacobian(model, now), dynamics.mass_matrix(with_lent_masses(model), now)
    triangle, scales = kkt.schur_complement(structure, dynamics.shapes(model), C)
    S = np.zeros((len(scales), len(scales)))
    S[np.tril_indices(len(scales))] = triangle
    with np.errstate(over="ignore"):  # rows whose scales no number holds are as good as none
        S = (S + np.tril(S, -1).T) / np.sqrt(np.outer(scales, scales))
    masks = np.zeros(len(scales))
    strongest(S, np.ones(len(scales)), masks)
    mask = [1.0] * structure.rows
    for row, used in zip(exchangeable, masks, strict=True):
        mask[row] = float(used)
    zero = [0.0] * structure.rows
    margin = float(kkt.solve(structure, M, C, [0.0] * (6 * structure.bodies), zero, mask).margin)
    return RowSelection(exchangeable, tuple(masks.tolist()), margin)
