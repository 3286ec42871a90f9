"""What every distribution of the registry promises: its form, its columns, its words."""

import numpy as np
import pytest
from pydantic import TypeAdapter

from lienumba.sweep.distributions.base import INERTIA, NUMBER, ROTATION, VECTOR
from lienumba.sweep.distributions.external import Given
from lienumba.sweep.distributions.registry import DISTRIBUTIONS, AnyDistribution, class_of, form_of

ENTRIES = {
    "normal": ({"std": 0.5}, "normal, mean the nominal value, standard deviation 0.5 kg"),
    "uniform": ({"low": 1, "high": 2.5}, "uniform between 1 kg and 2.5 kg"),
    "truncated_normal": (
        {"std": 0.1, "low": 0.9, "relative": True},
        "normal, mean the nominal value, standard deviation 0.1 times the nominal value, truncated to values above 0.9 "
        "times the nominal value",
    ),
    "lognormal": ({"sigma": 0.2}, "lognormal, median the nominal value, standard deviation of the logarithm 0.2"),
    "triangular": ({"low": 0, "high": 3}, "triangular between 0 kg and 3 kg, mode the nominal value"),
    "choice": ({"values": [1, 2]}, "one of 1 kg or 2 kg, all as likely"),
    "constant": ({"value": 2}, "2 kg in all runs"),
    "rotation_normal": (
        {"std": 0.1},
        "the nominal rotation times exp of a normal rotation vector in body axes, mean 0, standard deviation 0.1 rad",
    ),
    "rotation_uniform": ({}, "uniform on SO(3)"),
    "direction": ({}, "of nominal length, its direction uniform on the sphere"),
    "inertia": (
        {"std": 0.1},
        "the nominal mass distribution stretched at random, relative standard deviation of its second moments 0.1",
    ),
    "scipy": ({"scipy": "gamma", "a": 2.5}, "gamma of scipy.stats with a = 2.5"),
    "expression": ({"expression": "2*m"}, "the formula 2*m"),
    "column": ({"column": "m"}, "from the table"),
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
def test_forms_columns_and_words(name: str) -> None:
    keys, words = ENTRIES[name]
    entry = keys if DISTRIBUTIONS[name].key else {"distribution": name, **keys}
    given = TypeAdapter(AnyDistribution).validate_python(entry)
    assert form_of(entry) == form_of(given) == name
    assert type(given) is class_of(entry) is DISTRIBUTIONS[name]
    assert given.words(" kg") == words
    if not isinstance(given, Given):
        found = given.draw(list(U[: given.dimensions]), NOMINAL[given.shape])
        assert len(found) == len(given.columns("a"))
        assert all(np.isfinite(x).all() for x in found)
