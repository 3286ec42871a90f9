"""The numbers of a program by which memory is laid out."""

from typing import NamedTuple

from lienumba.groups.state import ELEMENT


class Sizes(NamedTuple):
    """Of a program, all whole numbers.

    elements: of S, those of the bodies first; element: rows of one; augmented: rows behind them; first_mask: the
    row there of the first mask of the exchangeable rows of C; fixed: whether only those in use are compiled;
    coordinates: of an element in a step; stages: of a step; slopes: kept of an element, of the stages, where lanes
    have a time of their own also of F at the end and of the extension's stages: there the last one is F at the end
    as the next step has it; events; correction: rows of an iterate of the position projection between its state and
    its violation; chord: rows behind its code; observed: rows that are; parameters: rows of them, with what is
    hoisted; series: rows of the coefficients of a step and what belongs to them; iterate: of implicit stages, rows;
    factors: of an eliminated matrix of theirs; history, first_history: augmented rows that a method carries on from
    step to step, and the first of them.
    first_mode: the augmented row where the modes begin: masks of the switched rows of C, how each switch is on, and
    their memory, which are `switched`, `switches` and `memory` rows; work: the augmented row of the work, if there is
    any; values: numbers that events read where they act; signals: that are looked at for what is kept of runs as a
    whole, which are so many; integrands: those that are integrated by the stages of a step; leaping: those that may
    jump where no body does; seen: numbers that F at the end of a step says of signals; weakens: whether steps know the
    margin of the constraints at both of their ends.
    """

    elements: int
    augmented: int
    first_mask: int
    exchangeable: int
    fixed: int
    coordinates: int
    stages: int
    slopes: int
    events: int
    correction: int
    element: int = ELEMENT
    chord: int = 0
    observed: int = 0
    parameters: int = 1
    series: int = 0
    first_mode: int = 0
    switched: int = 0
    switches: int = 0
    memory: int = 0
    work: int = 0
    values: int = 0
    iterate: int = 0
    factors: int = 0
    history: int = 0
    first_history: int = 0
    signals: int = 0
    kept: int = 0
    integrands: int = 0
    leaping: int = 0
    seen: int = 0
    weakens: int = 0
