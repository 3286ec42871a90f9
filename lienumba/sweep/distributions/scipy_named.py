"""Any distribution of scipy.stats by its name, with SciPy's own parameters; its samples have SciPy's bits."""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np
from pydantic import ConfigDict, Field, StrictStr, model_validator

from lienumba.errors import BadValueError
from lienumba.sweep.distributions.base import Finite, Scalar
from lienumba.words import ALIKE, Written, suggestion


class SciPy(Scalar):
    """scipy.stats.<scipy>(**parameters); with `relative`, its samples are multiples of the nominal value."""

    model_config = ConfigDict(extra="allow", frozen=True, defer_build=True)
    __pydantic_extra__: dict[str, Finite]

    key: ClassVar[str] = "scipy"

    scipy: StrictStr = Field(description='the name of a distribution of scipy.stats, such as "lognorm"')

    @model_validator(mode="after")
    def _known(self) -> SciPy:
        from scipy import stats

        found = getattr(stats, self.scipy, None)
        if not isinstance(found, stats.rv_continuous | stats.rv_discrete):
            kinds = (stats.rv_continuous, stats.rv_discrete)
            names = [name for name in dir(stats) if isinstance(getattr(stats, name), kinds)]
            raise BadValueError(
                "is no distribution of a number in scipy.stats", suggestion(self.scipy, names), "scipy", self.scipy
            )
        shapes = [name.strip() for name in found.shapes.split(",")] if found.shapes else []
        known = [*shapes, "loc", *(["scale"] if isinstance(found, stats.rv_continuous) else [])]
        given = self.__pydantic_extra__ or {}
        for name in given:
            if name not in known:
                rule, remedy = f"{self.scipy} has no such parameter", suggestion(name, known, ALIKE)
                raise BadValueError(rule, remedy, name, Written(f"{given[name]:g}"))
        missing = [name for name in shapes if name not in given]
        if missing:
            raise BadValueError(f"needs {' and '.join(missing)}", f"give {missing[0]} = ...", "scipy", self.scipy)
        if not all(x == x for x in found.support(**given)):
            shown = ", ".join(f"{name} = {x:g}" for name, x in given.items())
            raise BadValueError(
                f"does not exist with {shown}", "its documentation tells what may be given", "scipy", self.scipy
            )
        return self

    def ppf(self, u: np.ndarray, nominal: float) -> np.ndarray:
        from scipy import stats

        found: Any = getattr(stats, self.scipy)
        samples = np.asarray(found.ppf(u, **(self.__pydantic_extra__ or {})), float) * self.scale(nominal)
        return samples
