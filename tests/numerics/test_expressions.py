"""Formulas: what they are worth on floats, arrays, jets and symbols."""

import math
import operator

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lienumba.numerics import operations
from lienumba.numerics.expressions import Formula
from lienumba.numerics.grammar import ExpressionError
from lienumba.numerics.jets import Jet, lift
from tests.compiler.evaluation import assert_same_bits, traced

POINTS = np.random.default_rng(5).uniform(0.13, 0.93, 40)

# text -> the same by mpmath, of t
MEANINGS = {
    "1.5e-3 + 1_000": lambda m, t: m.mpf("1000.0015"),
    "pi*t": lambda m, t: m.pi * t,
    "90*deg - t": lambda m, t: m.pi / 2 - t,
    "+60*rpm*cos(t)": lambda m, t: 2 * m.pi * m.cos(t),
    "sin(3*t)": lambda m, t: m.sin(3 * t),
    "tan(t)": lambda m, t: m.tan(t),
    "asin(t)": lambda m, t: m.asin(t),
    "acos(t)": lambda m, t: m.acos(t),
    "atan(-7*t)": lambda m, t: m.atan(-7 * t),
    "atan2(t - 0.5, 0.3 - t)": lambda m, t: m.atan2(t - m.mpf("0.5"), m.mpf("0.3") - t),
    "exp(-4*t)": lambda m, t: m.exp(-4 * t),
    "log(5*t)": lambda m, t: m.log(5 * t),
    "tanh(2*t)": lambda m, t: m.tanh(2 * t),
    "tanh((0.5 - t)/9)": lambda m, t: m.tanh((m.mpf("0.5") - t) / 9),
    "floor(7*t) + t": lambda m, t: m.floor(7 * t) + t,
    "ceil(-7*t)": lambda m, t: m.ceil(-7 * t),
    "mod(5*t - 2, 0.75)": lambda m, t: m.fmod(5 * t - 2, m.mpf("0.75")) % m.mpf("0.75"),
    "mod(3*t, -1)": lambda m, t: (3 * t) % m.mpf(-1),
    "sinc(8*t - 4)": lambda m, t: m.sin(8 * t - 4) / (8 * t - 4) if t != m.mpf("0.5") else m.mpf(1),
    "sinc(1e-4*t)": lambda m, t: m.sin(m.mpf("1e-4") * t) / (m.mpf("1e-4") * t) if t else m.mpf(1),
    "sinh(3*t - 1)": lambda m, t: m.sinh(3 * t - 1),
    "sinh(1e-9*t)": lambda m, t: m.sinh(m.mpf("1e-9") * t),
    "cosh(3*t - 1)": lambda m, t: m.cosh(3 * t - 1),
    "hypot(t - 0.5, 2*t)": lambda m, t: m.hypot(t - m.mpf("0.5"), 2 * t),
    "abs(t - 0.5)": lambda m, t: abs(t - m.mpf("0.5")),
    "sign(t - 0.5)*t": lambda m, t: m.sign(t - m.mpf("0.5")) * t,
    "min(t, 0.4)": lambda m, t: min(t, m.mpf("0.4")),
    "min(1 - t, t, t*t, 0.2)": lambda m, t: min(1 - t, t, t * t, m.mpf("0.2")),
    "max(1 - t, 0.6, t, sin(9*t))": lambda m, t: max(1 - t, m.mpf("0.6"), t, m.sin(9 * t)),
    "clip(t, 0.3, 0.6)": lambda m, t: min(max(t, m.mpf("0.3")), m.mpf("0.6")),
    "clip(t, t*t, 0.5)": lambda m, t: min(max(t, t * t), m.mpf("0.5")),
    "where(t < 0.5, t, t*t)": lambda m, t: t if t < 0.5 else t * t,
    "where(t <= 0.5, 1, 2)": lambda m, t: m.mpf(1 if t <= 0.5 else 2),
    "where(t >= 0.5, 3, t)": lambda m, t: m.mpf(3) if t >= 0.5 else t,
    "where(0.3 < t < 0.6, t, -t)": lambda m, t: t if 0.3 < t < 0.6 else -t,
    "where(t < 0.3 or t > 0.6, t, -t)": lambda m, t: t if t < 0.3 or t > 0.6 else -t,
    "where(t > 0.3 and t < 0.6 and 1 < 2, t, -t)": lambda m, t: t if 0.3 < t < 0.6 else -t,
    "where(not t > 0.3 or not (t < 0.6 and t > 0.4), t, 1)": lambda m, t: t if t <= 0.4 or t >= 0.6 else m.mpf(1),
    "where(t > where(t > 0.5, 0.7, 0.3), 1, t)": lambda m, t: m.mpf(1) if t > (0.7 if t > 0.5 else 0.3) else t,
    "-t**2": lambda m, t: -(t**2),
    "(-t)**3": lambda m, t: -(t**3),
    "t**-2": lambda m, t: t**-2,
    "t**0.5": lambda m, t: m.sqrt(t),
    "t**1.5": lambda m, t: t ** m.mpf("1.5"),
    "t**-0.3": lambda m, t: t ** -m.mpf("0.3"),
    "2**t": lambda m, t: m.mpf(2) ** t,
    "t**t": lambda m, t: t**t,
    "(t - 2)**7": lambda m, t: (t - 2) ** 7,
    "2**-t**2": lambda m, t: m.mpf(2) ** (-(t**2)),
    "t**3**2/4": lambda m, t: t**9 / 4,
    "2 - 3 - t": lambda m, t: -1 - t,
    "1 + 2*t/4 - -t": lambda m, t: 1 + t / 2 + t,
    "0.3*sin(2*t) + 0.1*t**2": lambda m, t: m.mpf("0.3") * m.sin(2 * t) + m.mpf("0.1") * t * t,
    "exp(-t/0.2)*cos(30*t)/(1 + t)": lambda m, t: m.exp(-t / m.mpf("0.2")) * m.cos(30 * t) / (1 + t),
}


def exactly(text, *values):
    """The formula by mpmath: numbers in, floats out."""
    with mpmath.workdps(40):
        return np.array([float(MEANINGS[text](mpmath, mpmath.mpf(t))) for t in values])


# ---------------------------------------------------------------- values
@pytest.mark.parametrize("text", MEANINGS)
def test_values_on_floats(text):
    np.testing.assert_allclose(
        [Formula(text)(t) for t in POINTS.tolist()], exactly(text, *POINTS), rtol=1e-14, atol=1e-15
    )


@pytest.mark.parametrize("text", MEANINGS)
def test_values_on_arrays_have_the_bits_of_floats(text):
    formula = Formula(text)
    on_arrays = np.broadcast_to(formula(POINTS), POINTS.shape)
    assert_same_bits(on_arrays, np.array([formula(t) for t in POINTS.tolist()]))


def test_values_on_symbols():
    formulas = [Formula(text) for text in MEANINGS]
    compiled = traced(lambda t: tuple(formula(t) for formula in formulas), (0,))(POINTS[None])
    for text, values in zip(MEANINGS, compiled, strict=True):
        np.testing.assert_allclose(values, exactly(text, *POINTS), rtol=1e-14, atol=1e-15, err_msg=text)


@pytest.mark.parametrize("text", MEANINGS)
def test_derivatives_on_jets(text):
    """Along t + b s + c s^2/2, in floats and in arrays."""
    b, c = 0.7, -1.3
    expected = []
    with mpmath.workdps(40):
        for t in POINTS[:12].tolist():
            path = mpmath.mpf(t), mpmath.mpf(b), mpmath.mpf(c)
            series = mpmath.taylor(lambda s: MEANINGS[text](mpmath, path[0] + path[1] * s + path[2] * s * s / 2), 0, 2)  # noqa: B023
            expected.append([float(series[0]), float(series[1]), float(2 * series[2])])
    formula = Formula(text)
    one_by_one = [lift(formula(Jet(t, b, c))) for t in POINTS[:12].tolist()]
    together = lift(formula(Jet(POINTS[:12], np.full(12, b), np.full(12, c))))
    got = np.array([[float(x) for x in (j.a, j.b, j.c)] for j in one_by_one])
    np.testing.assert_allclose(got, expected, rtol=1e-12, atol=1e-12)
    every = np.array([np.broadcast_to(x, 12) for x in (together.a, together.b, together.c)]).T
    assert_same_bits(every, got)


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("pi/60", math.pi / 60.0), ("45*deg", math.pi / 4.0), ("3000*rpm", 100.0 * math.pi), ("-2**2", -4.0),
        ("(-2)**2", 4.0), ("2**-1", 0.5), ("2**3**2", 512.0), ("-1 - -1", 0.0), ("2*3 + 4*5", 26.0), ("7 - 2 - 3", 2.0),
        ("24/4/3", 2.0), ("2 + 3*4**2/8", 8.0), ("--3", 3.0), ("+-+3", -3.0), ("0x10 + 1_0 + .5", 26.5),
        ("where(1 < 2, 3, 4)", 3.0), ("where(not 1 < 2, 3, 4)", 4.0), ("where(1 < 2 <= 2, 3, 4)", 3.0),
        ("where(1 < 2 and not 2 >= 3 or 1 > 2, 3, 4)", 3.0), ("where(1 > 2 or 2 > 3 and 3 < 4, 3, 4)", 4.0),
        ("min(9,8,7,6,5,4,3,2,1)", 1.0), ("max(1,2,3,9,5,6,7,8,4)", 9.0), ("clip(7, -1, 2)", 2.0),
        ("floor(-2.5)", -3.0), ("ceil(-2.5)", -2.0), ("mod(-1, 3)", 2.0),
        ("mod(7, 3)", 1.0), ("sinc(0)", 1.0),
        ("sign(-3)", -1.0), ("sign(0)", 0.0), ("abs(-3)", 3.0), ("sqrt(9)", 3.0), ("9**0.5", 3.0), ("0**0", 1.0),
        ("where(1 < 2, 5, 1/0)", 5.0), ("  2 # two", 2.0), ("1e-400", 0.0),
    ],
)  # fmt: skip
def test_constants(text, value):
    formula = Formula(text)
    assert formula.constant == pytest.approx(value, rel=1e-15)
    assert formula.used == frozenset()
    assert formula(123.0) == formula.constant


def test_what_depends_on_time_is_no_constant():
    assert Formula("t - t").constant is None
    assert Formula("t - t").used == {"t"}


def test_other_names_and_equality():
    formula = Formula("kp*(1 - t) + kd", frozenset({"t", "kp", "kd", "mass"}))
    assert formula.used == {"t", "kp", "kd"}
    assert formula(0.25, kp=8.0, kd=np.array([1.0, 2.0])).tolist() == [7.0, 8.0]
    assert Formula("t + 1") == Formula("t + 1")
    assert len({Formula("t + 1"), Formula("t + 1"), Formula("t +  1")}) == 2


@pytest.mark.parametrize(
    ("text", "t", "value"),
    [
        ("1/t", 0.0, math.inf), ("-1/t", 0.0, -math.inf), ("t/t", 0.0, math.nan), ("log(t)", 0.0, -math.inf),
        ("log(t)", -1.0, math.nan), ("sqrt(t)", -1.0, math.nan), ("t**0.5", -1.0, math.nan), ("t**1.5", -1.0, math.nan),
        ("t**-1", 0.0, math.inf), ("asin(t)", 1.5, math.nan), ("acos(t)", -1.5, math.nan), ("exp(t)", 1e3, math.inf),
        ("tanh(t)", math.inf, 1.0), ("sign(t)", math.nan, math.nan), ("where(t > 0, t, 7)", math.nan, 7.0),
        ("sin(t)", math.inf, math.nan), ("where(t > 0, sin(t)/t, 1)", 0.0, 1.0), ("t**1.5", 0.0, 0.0),
    ],
)  # fmt: skip
def test_outside_their_domain_formulas_do_not_raise(text, t, value):
    assert Formula(text)(t) == pytest.approx(value, nan_ok=True)
    with np.errstate(all="ignore"):
        assert Formula(text)(np.array([t]))[0] == pytest.approx(value, nan_ok=True)


# ---------------------------------------------------------------- round trips
REACHED = {
    "+": (1, operator.add), "-": (1, operator.sub), "*": (2, operator.mul), "/": (2, operations.divide),
    "**": (4, operations.power),
}  # fmt: skip
BETWEEN = {"<": operator.lt, "<=": operator.le, ">": operator.gt, ">=": operator.ge}
NAMES = {"pi": math.pi, "deg": math.pi / 180.0, "rpm": math.pi / 30.0}
CALLS = dict.fromkeys(("sin", "cos", "exp", "log", "sqrt", "tanh", "abs", "atan"), 1)
CALLS |= {"atan2": 2, "min": 3, "max": 2, "clip": 3}
PLAIN = {
    "abs": lambda x: math.fabs(x) if x else x,
    "atan": lambda x: operations.atan2(x, 1.0),
    "min": lambda x, y, z: operations.minimum(operations.minimum(x, y), z),
    "max": operations.maximum,
    "clip": lambda x, low, high: high if x > high else low if x < low else x,
}


def grown(random, depth):
    """A random tree."""

    def below():
        return grown(random, random.randrange(depth))

    if not depth or random.random() < 0.1:
        names = ["t", "t", "k", *NAMES]
        numbers = [random.randrange(60), random.uniform(0.0, 4.0), 10.0 ** random.uniform(-30.0, 30.0)]
        return random.choice([("name", random.choice(names)), ("number", random.choice(numbers))])
    kind = random.choice([*REACHED, *REACHED, "negative", "call", "call", "where"])
    if kind == "**":
        return (kind, below(), ("number", random.randrange(-4, 5)) if random.random() < 0.8 else below())
    if kind == "call":
        name = random.choice(sorted(CALLS))
        return (kind, name, *(below() for _ in range(CALLS[name])))
    if kind == "where":
        return (kind, condition(random, depth), below(), below())
    return (kind, below()) if kind == "negative" else (kind, below(), below())


def condition(random, depth):
    kind = random.choice([*BETWEEN, *BETWEEN, "not", "and", "or"] if depth else sorted(BETWEEN))
    if kind in BETWEEN:
        return (kind, *(grown(random, random.randrange(depth + 1)) for _ in range(2)))
    return (kind, *(condition(random, depth - 1) for _ in range(1 if kind == "not" else 2)))


def written(tree):
    """The text, and how strongly it binds."""
    kind, *parts = tree
    if kind == "number":
        return (repr(parts[0]) if parts[0] >= 0 else f"-{-parts[0]}"), 5 if parts[0] >= 0 else 3
    if kind == "name":
        return parts[0], 5
    if kind in ("call", "where"):
        name, arguments = ("where", parts) if kind == "where" else (parts[0], parts[1:])
        return f"{name}({', '.join(written(x)[0] for x in arguments)})", 5
    if kind == "negative":
        return f"-{bracketed(parts[0], 3)}", 3
    if kind in BETWEEN:
        return f"{bracketed(parts[0], 1)} {kind} {bracketed(parts[1], 1)}", 0
    if kind == "not":
        return f"not {bracketed(parts[0], -1)}", -1
    if kind in ("and", "or"):
        own = -2 if kind == "and" else -3
        return f"{bracketed(parts[0], own)} {kind} {bracketed(parts[1], own + 1)}", own
    own = REACHED[kind][0]
    left, right = (5, 3) if kind == "**" else (own, own + 1)
    return f"{bracketed(parts[0], left)} {kind} {bracketed(parts[1], right)}", own


def bracketed(tree, least):
    text, strength = written(tree)
    return text if strength >= least else f"({text})"


def worth(tree, values):
    """What a tree is worth: the meaning of the text, without a text."""
    kind, *parts = tree
    if kind == "number":
        return float(parts[0])
    if kind == "name":
        return values[parts[0]]
    if kind == "call":
        function = PLAIN.get(parts[0]) or getattr(operations, parts[0])
        return function(*(worth(x, values) for x in parts[1:]))
    x = [worth(y, values) for y in parts]
    if kind == "where":
        return x[1] if x[0] else x[2]
    plain = {"negative": operator.neg, "not": operator.not_, "and": lambda a, b: a and b, "or": lambda a, b: a or b}
    return (plain | BETWEEN | {sign: f for sign, (_, f) in REACHED.items()})[kind](*x)


def names_in(tree):
    if tree[0] == "name":
        return {tree[1]} - set(NAMES)
    return set().union(*(names_in(x) for x in tree if isinstance(x, tuple)))


def test_numbers_may_be_called_as_functions_are():
    """A quantity `where`, a parameter `min`: brackets tell them apart, also where numbers take the place of names."""
    formula = Formula("where(t > 1, where.x, min(min, t)) + sin(sin.y)", frozenset({"t", "where.x", "min", "sin.y"}))
    assert formula.used == {"t", "where.x", "min", "sin.y"}
    assert formula(2.0, **{"where.x": 3.0, "min": 0.5, "sin.y": 0.25}) == 3.0 + math.sin(0.25)
    bound = formula.bound({"min": 0.5, "sin.y": 0.25})
    assert bound == "where(t > 1, where.x, min(0.5, t)) + sin(0.25)"
    rewritten = formula.rewritten({"min": "2*k"}, ["t", "where.x", "sin.y", "k"])
    assert rewritten(1.0, k=0.25, **{"where.x": 3.0, "sin.y": 0.0}) == 0.5


@settings(derandomize=True, max_examples=600)
@given(st.randoms(use_true_random=False), st.floats(-3.0, 3.0), st.floats(-100.0, 100.0))
def test_round_trips(random, t, k):
    tree = grown(random, 5)
    text, expected = written(tree)[0], worth(tree, NAMES | {"t": t, "k": k})
    allowed = frozenset({"t", "k"})
    if not names_in(tree) and not math.isfinite(expected):
        with pytest.raises(ExpressionError, match="it must be a finite number"):
            Formula(text, allowed)
        return
    formula = Formula(text, allowed)
    assert formula.used == names_in(tree)
    assert formula.constant is None or formula.constant == expected
    assert_same_bits(np.array([float(formula(t, k=k))]), np.array([float(expected)]))


@settings(derandomize=True, max_examples=300)
@given(st.randoms(use_true_random=False), st.sampled_from([-2.0, 0.0, 1.0, 3.0]))
def test_conditions_are_numbers_above_0_where_they_hold(random, t):
    """Sides are small whole numbers, so that many are equal."""

    def tree(depth):
        kind = random.choice([*BETWEEN, "not", "and", "or"] if depth else sorted(BETWEEN))
        if kind in BETWEEN:
            side = ("name", "t"), ("number", random.randrange(4))
            return (kind, *random.sample(side, 2))
        return (kind, *(tree(depth - 1) for _ in range(1 if kind == "not" else 2)))

    grown = tree(3)
    formula = Formula(written(grown)[0], condition=True)
    assert (formula(t) > 0.0) == worth(grown, {"t": t})
    assert ((formula(np.array([t, t])) > 0.0) == worth(grown, {"t": t})).all()


def test_a_margin_passes_0_as_its_sides_do():
    assert Formula("t > 0.5 and t < 3", condition=True)(0.25) == -0.25
    assert Formula("not (2*t <= 1 or t >= 3)", condition=True)(2.0) == 1.0


# ---------------------------------------------------------------- where it is delicate
@pytest.mark.parametrize(("name", "exact"), [("asin", mpmath.asin), ("acos", mpmath.acos)])
def test_arcs_are_accurate_beside_one(name, exact):
    x = np.concatenate([sign * (1.0 - 10.0 ** np.linspace(-15.0, -1.0, 200)) for sign in (1.0, -1.0)])
    with mpmath.workdps(40):
        expected = [float(exact(mpmath.mpf(y))) for y in x.tolist()]
    np.testing.assert_allclose(Formula(f"{name}(t)")(x), expected, rtol=1e-14)


@pytest.mark.parametrize("text", ["where(t > 0, sin(t)/t, 1)", "where(t > 0, t**2.5, 0)", "where(t > 0, log(t), 0)"])
def test_where_chooses_among_jets_of_floats(text):
    """Both sides of `where` are evaluated: the one that is not chosen must not raise."""
    jet = lift(Formula(text)(Jet(0.0, 1.0)))
    assert (jet.b, jet.c) == (0.0, 0.0)


def test_broken_powers_above_two_start_smoothly():
    with np.errstate(all="ignore"):
        jet = Formula("t**2.5")(Jet(np.zeros(1), np.ones(1)))
    assert (jet.a, jet.b, jet.c) == (0.0, 0.0, 0.0)
