"""What every distribution of the registry promises: its form and its columns."""

import numpy as np
import pytest
from pydantic import TypeAdapter

from lienumba.sweep.distributions.base import INERTIA, NUMBER, ROTATION, VECTOR
from lienumba.sweep.distributions.external import Given
from lienumba.sweep.distributions.registry import DISTRIBUTIONS, AnyDistribution, class_of, form_of

ENTRIES = {
    "normal": {"std": 0.5},
    "uniform": {"low": 1, "high": 2.5},
    "truncated_normal": {"std": 0.1, "low": 0.9, "relative": True},
    "lognormal": {"sigma": 0.2},
    "triangular": {"low": 0, "high": 3},
    "choice": {"values": [1, 2]},
    "constant": {"value": 2},
    "rotation_normal": {"std": 0.1},
    "rotation_uniform": {},
    "direction": {},
    "inertia": {"std": 0.1},
    "scipy": {"scipy": "gamma", "a": 2.5},
    "expression": {"expression": "2*m"},
    "column": {"column": "m"},
}
NOMINAL = {
    NUMBER: 1.0,
    VECTOR: (0.0, 3.0, 4.0),
    ROTATION: (1.0, 0.0, 0.0, 0.0),
    INERTIA: (1.0, 1.0, 1.5, 0.0, 0.0, 0.1),
}
U = np.random.default_rng(7).random((6, 500))


def test_every_distribution_has_a_case() -> None:
    assert ENTRIES.keys() == DISTRIBUTIONS.keys()


@pytest.mark.parametrize("name", ENTRIES)
def test_forms_and_columns(name: str) -> None:
    keys = ENTRIES[name]
    entry = keys if DISTRIBUTIONS[name].key else {"distribution": name, **keys}
    given = TypeAdapter(AnyDistribution).validate_python(entry)
    assert form_of(entry) == form_of(given) == name
    assert type(given) is class_of(entry) is DISTRIBUTIONS[name]
    if not isinstance(given, Given):
        found = given.draw(list(U[: given.dimensions]), NOMINAL[given.shape])
        assert len(found) == len(given.columns("a"))
        assert all(np.isfinite(x).all() for x in found)
