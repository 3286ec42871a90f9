"""What measures ask of a model: signals, what is kept of each, and where they bend."""

from lienumba.mechanics.elements.quantities.evaluation import bends
from lienumba.mechanics.mechanism.model import INTEGRAL, LARGEST, LAST, NONE, SMALLEST, Kept, Model, Timed


def signals(model: Model) -> list[Timed]:
    """Those of all measures, and behind them the numbers at whose zeros some of these bend."""
    return [*_asked(model), *(x for found in _bent(model).values() for x in found)]


def turning(model: Model) -> dict[int, range]:
    """The numbers among the signals at whose zeros other ones bend, by the numbers of these."""
    found, first = dict[int, range](), len(_asked(model))
    for n, own in _bent(model).items():
        found[n] = range(first, first + len(own))
        first += len(own)
    return found


def kept(model: Model) -> list[Kept]:
    """What is kept of runs as a whole, by the numbers of signals among those of all measures."""
    found, before = list[Kept](), 0
    for measure in model.measures:
        for x in measure.kept:
            value, condition = (n if n == NONE else before + n for n in (x.value, x.condition))
            found.append(Kept(x.kind, value, condition, x.event))
        before += len(measure.signals)
    return found


def integrands(model: Model) -> tuple[int, ...]:
    """Of the signals those that steps can integrate by the weights of their stages wherever they do not bend."""
    every = _asked(model)
    wanted = dict.fromkeys(x.value for x in kept(model) if x.kind == INTEGRAL and x.value != NONE)
    return tuple(n for n in wanted if bends(model, every[n]) is not None)


def followed(model: Model) -> set[int]:
    """The signals of which it counts what they are between the ends of a step."""
    every = kept(model)
    asked = {x.condition for x in every} | {x.value for x in every if x.kind in (LARGEST, SMALLEST)}
    return (asked | {n for own in turning(model).values() for n in own}) - {NONE}


def lasting(model: Model) -> set[int]:
    """Those of which the last value counts."""
    return {x.value for x in kept(model) if x.kind == LAST} - {NONE}


def _asked(model: Model) -> list[Timed]:
    return [x for measure in model.measures for x in measure.signals]


def _bent(model: Model) -> dict[int, tuple[Timed, ...]]:
    """The numbers at whose zeros conditions bend, and values that are summed or compared."""
    every, wanted = _asked(model), kept(model)
    values = {x.value for x in wanted if x.kind in (INTEGRAL, LARGEST, SMALLEST)}
    asked = sorted((values | {x.condition for x in wanted}) - {NONE})
    found = {n: bends(model, every[n]) for n in asked}
    return {n: own for n, own in found.items() if own}
