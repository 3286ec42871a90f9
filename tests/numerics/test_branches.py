"""Conditions that compare what `where` and `sign` choose: margins of their branches."""

import numpy as np
import pytest

from lienumba.numerics.expressions import Formula

NAMES = ("x.a", "x.b", "x.c", "x.d")
Q = np.random.default_rng(1).standard_normal((4, 2000))


@pytest.mark.parametrize(("text", "expected"), [
    ("where(x.a > 0, 2, 1) > 1.5", lambda a, b, c, d: a > 0),
    ("where(x.a < x.a and x.b > 0, t, x.c) > x.d", lambda a, b, c, d: c > d),
    ("where(sign(x.a) > 0, x.b, x.c) > x.d", lambda a, b, c, d: np.where(a > 0, b, c) > d),
    ("not where(x.a > 0, where(x.b >= 1, 2, x.c), sign(x.d)) <= 0.5",
     lambda a, b, c, d: np.where(a > 0, np.where(b >= 1, 2, c), np.sign(d)) > 0.5),
    ("sign(x.a)*where(x.b > x.c, 2, x.d) > x.b", lambda a, b, c, d: np.sign(a) * np.where(b > c, 2, d) > b),
    ("1 < where(x.a >= x.a, x.b, 0) < 2", lambda a, b, c, d: (b > 1) & (b < 2)),
    ("where(x.a > 0, 1, 2) > 3 or x.b > 0", lambda a, b, c, d: b > 0),
])  # fmt: skip
def test_the_margin_is_above_zero_where_the_condition_holds(text, expected):  # type: ignore[no-untyped-def]
    """Also where the sides of what chooses are the same number."""
    formula = Formula(text, frozenset({"t", *NAMES}), condition=True)
    np.testing.assert_array_equal(formula(0.0, **dict(zip(NAMES, Q, strict=True))) > 0, expected(*Q))


def test_the_margin_passes_zero_as_what_chooses() -> None:
    """And not by a jump: it is as small as how far that is from where it chooses the other branch."""
    formula = Formula("where(x.a > 0.5, 2, x.b) > 1.5", frozenset({"t", *NAMES}), condition=True)
    for a in (0.5 - 1e-6, 0.5 + 1e-6):
        assert formula(0.0, **{"x.a": a, "x.b": -1.0}) == pytest.approx(a - 0.5, rel=1e-9)
