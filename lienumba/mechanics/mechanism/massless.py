"""Bodies without mass and inertia, which joints carry between others; and masses where a metric needs other ones."""

from dataclasses import replace
from functools import reduce
from typing import Any

from lienumba.mechanics.mechanism.model import Body, Model
from lienumba.numerics.operations import is_zero, maximum, minimum


def is_massless(body: Body) -> bool:
    """Whether it has no mass by its structure, whatever a sweep varies."""
    return is_zero(body.mass)


def massless(model: Model) -> list[int]:
    """The bodies (indices) that are."""
    return [i for i, body in enumerate(model.bodies) if is_massless(body)]


def with_lent_masses(model: Model, part: float = 1.0) -> Model:
    """Massless bodies with a part of the smallest mass, and of the smallest mean moment of inertia, that bodies of the
    model have; the model itself if there are none."""
    if not massless(model):
        return model
    heavy = [body for body in model.bodies if not is_massless(body)]
    mass = _least([body.mass for body in heavy], part)
    moment = _least([(body.inertia[0] + body.inertia[1] + body.inertia[2]) / 3.0 for body in heavy], part)
    lent = (moment, moment, moment, 0.0, 0.0, 0.0)
    bodies = (replace(body, mass=mass, inertia=lent) if is_massless(body) else body for body in model.bodies)
    return replace(model, bodies=tuple(bodies))


def evened(model: Model, part: float) -> Model:
    """Bodies lighter than a part of the heaviest, and their moments of inertia, made larger until they are no
    lighter."""
    if not part:
        return model
    least = part * reduce(maximum, [body.mass for body in model.bodies], 0.0)
    factors = [maximum(least / body.mass, 1.0) for body in model.bodies]
    bodies = (
        replace(body, mass=body.mass * x, inertia=tuple(x * c for c in body.inertia))
        for body, x in zip(model.bodies, factors, strict=True)
    )
    return replace(model, bodies=tuple(bodies))


def _least(numbers: list[Any], part: float) -> Any:
    """A part of the smallest; of 1 if there is none."""
    return part * reduce(minimum, numbers) if numbers else part
