"""Every way in which an input of `[sweep.vary]` may vary."""

from typing import Annotated, Any

from pydantic import Discriminator, Tag

from lienumba.sweep.distributions.base import Kind
from lienumba.sweep.distributions.external import Column, Expression
from lienumba.sweep.distributions.inertia import Inertia
from lienumba.sweep.distributions.rotations import Direction, RotationNormal, RotationUniform
from lienumba.sweep.distributions.scalar import (
    Choice,
    Constant,
    Lognormal,
    Normal,
    Triangular,
    TruncatedNormal,
    Uniform,
)
from lienumba.sweep.distributions.scipy_named import SciPy

NAMED: dict[str, type[Kind]] = {
    "normal": Normal, "uniform": Uniform, "truncated_normal": TruncatedNormal, "lognormal": Lognormal,
    "triangular": Triangular, "choice": Choice, "constant": Constant, "rotation_normal": RotationNormal,
    "rotation_uniform": RotationUniform, "direction": Direction, "inertia": Inertia,
}  # fmt: skip
BY_KEY: dict[str, type[Kind]] = {"scipy": SciPy, "expression": Expression, "column": Column}  # that stands for a name
FORMS = NAMED | BY_KEY


def form_of(value: Any) -> str | None:
    """Which of the forms an entry of `vary` is written in; None if it is none of them."""
    if isinstance(value, Kind):
        return next(name for name, kind in FORMS.items() if isinstance(value, kind))
    if not isinstance(value, dict):
        return None
    name = value.get("distribution")
    if name is not None:
        return name if isinstance(name, str) and name in NAMED else None
    return next((key for key in BY_KEY if key in value), None)


Distribution = Annotated[
    Annotated[Normal, Tag("normal")]
    | Annotated[Uniform, Tag("uniform")]
    | Annotated[TruncatedNormal, Tag("truncated_normal")]
    | Annotated[Lognormal, Tag("lognormal")]
    | Annotated[Triangular, Tag("triangular")]
    | Annotated[Choice, Tag("choice")]
    | Annotated[Constant, Tag("constant")]
    | Annotated[RotationNormal, Tag("rotation_normal")]
    | Annotated[RotationUniform, Tag("rotation_uniform")]
    | Annotated[Direction, Tag("direction")]
    | Annotated[Inertia, Tag("inertia")]
    | Annotated[SciPy, Tag("scipy")]
    | Annotated[Expression, Tag("expression")]
    | Annotated[Column, Tag("column")],
    Discriminator(form_of),
]
