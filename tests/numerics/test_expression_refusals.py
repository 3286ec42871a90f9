"""Formulas: what they refuse, and that nothing in them ever runs."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lienumba.numerics.expressions import Formula
from lienumba.numerics.grammar import ExpressionError

REMEDY = (
    ", which is not allowed; use numbers, + - * / **, comparisons, t, pi, deg, rpm and the functions sin, cos, tan, "
    "asin, acos, atan, atan2, exp, log, sqrt, tanh, abs, sign, min, max, clip, floor, ceil, mod, sinc, "
    "sinh, cosh, hypot, where"
)
NO_FORMULA = 'is not a formula; write one such as "0.3*sin(2*t) + 0.1*t**2"'
FUNCTIONS = (
    '"abs", "acos", "asin", "atan", "atan2", "ceil", "clip", "cos", "cosh", "exp", "floor", "hypot", "log", "max", '
    '"min", "mod", "sign", "sin", "sinc", "sinh", "sqrt", "tan", "tanh", "where"'
)


def refusal(text):
    with pytest.raises(ExpressionError) as caught:
        Formula(text)
    return str(caught.value)


@pytest.mark.parametrize(
    "text",
    [
        "t.real", "pi.real", "sin.x", "t[0]", "lambda: t", "'x'", "b'x'", "f'{t}'", "[1]", "{}", "(t, t)",
        "[t for t in t]", "{t for t in t}", "(t for t in t)", "{t: t for t in t}", "sin(x=t)", "sin(**t)", "(t := 3)",
        "True", "None", "...", "1j", "2.0 + 3j", "t == 1", "t != 1", "t is t", "t in t", "t // 2", "t % 2", "t @ t",
        "t & 1", "t | 1", "t ^ 1", "t << 1", "t >> 1", "~t", "t if t > 1 else 2", "await t", "where(t > 1, t[0], 2)",
        "min(1, t.real)", "where(t > 1 and t == 2, 1, 2)", "__import__('os').system('x')", "t.__class__",
        "sin(t)(t)", "(lambda: t)()",
    ],
)  # fmt: skip
def test_what_is_no_arithmetic_is_named(text):
    message = refusal(text)
    found = message.removeprefix('contains "').removesuffix(f'"{REMEDY}')
    assert message == f'contains "{found}"{REMEDY}'
    assert found in text or found == "3j"


def test_a_starred_argument_is_refused():
    assert refusal("sin(*t)") == f'contains "*t"{REMEDY}'


@pytest.mark.parametrize(
    "text",
    ["", "   ", "#", "import os", "t = 1", "t := 2", "t; t", "t\nt", "yield t", "*t", "t <", "t)", "(t", "1 2", "t'",
     "\x00", "\ud800", "\u221e", "2t", "t.", "def f(): pass", "(" * 300 + "t" + ")" * 300, "not", "sin(", "t\\"],
)  # fmt: skip
def test_what_is_no_formula_is_refused(text):
    assert refusal(text) == NO_FORMULA


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("tt", 'has the unknown name "tt"; the nearest known name is "t"'),
        ("2*rmp", 'has the unknown name "rmp"; the nearest known name is "rpm"'),
        ("x + 1", 'has the unknown name "x"; known here are "deg", "pi", "rpm", "t"'),
        ("os", 'has the unknown name "os"; known here are "deg", "pi", "rpm", "t"'),
        ("sinus(t)", 'calls the unknown function "sinus"; the nearest known name is "sin"'),
        ("arctan(t)", 'calls the unknown function "arctan"; the nearest known name is "atan"'),
        ("eval(t)", f'calls the unknown function "eval"; known here are {FUNCTIONS}'),
        ("t(2)", f'calls the unknown function "t"; known here are {FUNCTIONS}'),
        ("pi(2)", f'calls the unknown function "pi"; known here are {FUNCTIONS}'),
        ("2*sin", 'uses the function "sin" without arguments; write sin(...)'),
        ("where", 'uses the function "where" without arguments; write where(...)'),
        ("sin()", "gives sin 0 arguments, it takes 1"),
        ("sin(t, t)", "gives sin 2 arguments, it takes 1"),
        ("atan2(t)", "gives atan2 1 argument, it takes 2"),
        ("clip(t, 1)", "gives clip 2 arguments, it takes 3"),
        ("where(t > 1, 2)", "gives where 2 arguments, it takes 3"),
        ("min(t)", "gives min 1 argument, it takes 2 to 9"),
        ("max(1,2,3,4,5,6,7,8,9,t)", "gives max 10 arguments, it takes 2 to 9"),
        ("t > 1", "is a condition, not a number; write where(condition, number, other number)"),
        ("not t > 1", "is a condition, not a number; write where(condition, number, other number)"),
        ("t > 1 and t < 2", "is a condition, not a number; write where(condition, number, other number)"),
        ("(t > 1) + 1", 'computes with the condition "t > 1"; write where(t > 1, number, other number)'),
        ("-(t > 1)", 'computes with the condition "t > 1"; write where(t > 1, number, other number)'),
        ("-(t < 1 or t > 2)", 'computes with the condition "t < 1 or t > 2"; write where(t < 1 or t > 2, number, other '
         "number)"),
        ("min(t > 1, 2)", 'computes with the condition "t > 1"; write where(t > 1, number, other number)'),
        ("(t > 1) > (t > 2)", 'computes with the condition "t > 1"; write where(t > 1, number, other number)'),
        ("where(t > 1, t > 2, 3)", 'computes with the condition "t > 2"; write where(t > 2, number, other number)'),
        ("where(t, 1, 2)", 'needs a condition instead of "t"; write one such as t > 1'),
        ("where(True, 1, 2)", 'needs a condition instead of "True"; write one such as t > 1'),
        ("where(t > 1 and t, 1, 2)", 'needs a condition instead of "t"; write one such as t > 1'),
        ("where(not t, 1, 2)", 'needs a condition instead of "t"; write one such as t > 1'),
        ("not 2*t", 'needs a condition instead of "2 * t"; write one such as t > 1'),
        ("t**65", "has the exponent 65, at most 64 is allowed"),
        ("t**-65", "has the exponent -65, at most 64 is allowed"),
        ("2**1e9", "has the exponent 1000000000.0, at most 64 is allowed"),
        ("1e300", "has the number 1e+300, which is too large"),
        ("t*1e999", "has a number, which is too large"),
        ("2" + "0" * 300, "has the number 2" + "0" * 75 + " ..., which is too large"),
        ("1/0", "has the value inf; it must be a finite number"),
        ("-1/0", "has the value -inf; it must be a finite number"),
        ("0/0", "has the value nan; it must be a finite number"),
        ("1e200*1e200", "has the value inf; it must be a finite number"),
        ("exp(1000)", "has the value inf; it must be a finite number"),
        ("log(0)", "has the value -inf; it must be a finite number"),
        ("sqrt(-1)", "has the value nan; it must be a finite number"),
        ("(-8)**(1/3)", "has the value nan; it must be a finite number"),
        ("t" + " " * 2000 + "+ 1", "is 2004 characters long, at most 2000 are allowed; shorten it"),
        ("1" * 10_000, "is 10000 characters long, at most 2000 are allowed; shorten it"),
        ("-" * 201 + "t", "nests more than 200 operations; split it"),
        ("-" * 1900 + "t", "nests more than 200 operations; split it"),
        ("+".join(["t"] * 202), "nests more than 200 operations; split it"),
    ],
)  # fmt: skip
def test_what_is_wrong_is_said(text, message):
    assert refusal(text) == message


def test_limits_are_reached_without_complaint():
    assert Formula("t**64")(2.0) == 2.0**64
    assert Formula("t**-64.0")(2.0) == 2.0**-64
    assert Formula("-" * 200 + "t")(3.0) == 3.0
    assert Formula("+".join(["t"] * 51))(2.0) == 102.0
    assert Formula("(" * 150 + "t" + ")" * 150)(3.0) == 3.0
    assert Formula("t".ljust(2000))(3.0) == 3.0
    assert Formula("t**(8*8*8*8)")(1.0) == 1.0


def test_what_other_names_mean_is_said():
    with pytest.raises(ExpressionError, match=r'has the unknown name "masss"; the nearest known name is "mass"'):
        Formula("masss*t", frozenset({"t", "mass"}))
    with pytest.raises(ExpressionError, match='has the unknown name "t"; known here are "deg", "mass", "pi", "rpm"'):
        Formula("2*t", frozenset({"mass"}))


def test_nothing_is_ever_executed(tmp_path):
    marker = tmp_path / "marker"
    command = f"__import__('pathlib').Path({str(marker)!r}).touch()"
    for text in (
        command,
        f"eval({command!r})",
        f"[{command}]",
        f"(lambda: {command})()",
        f"sin({command})",
        f"f'{{{command}}}'",
    ):
        refusal(text)
    for text in (
        f"where(t > 1, {command}, 1)",
        f"where({command}, 1, 2)",
        f"t**{command}",
        f"{command} > 1",
        f"t or {command}",
    ):
        refusal(text)
    assert not marker.exists()


PIECES = [
    "t", "1", "2.5", "0", "1e9", "+", "-", "*", "**", "/", "(", ")", ",", "<", ">=", "==", " and ", " or ", " not ",
    "sin", "where", "min", "pi", "x", "'", "[", "]", "~", ":", ".", "{", "}", "=", "lambda", " if ", " else ", "\n",
    "#", "@",
]  # fmt: skip


@settings(derandomize=True, max_examples=1500)
@given(st.lists(st.sampled_from(PIECES), max_size=12).map("".join))
@pytest.mark.filterwarnings("ignore::DeprecationWarning")
def test_any_text_is_a_formula_or_an_expression_error(text):
    try:
        value = Formula(text)(0.7)
    except ExpressionError:
        return
    assert isinstance(value, float)


@pytest.mark.parametrize(
    ("text", "remedy"),
    [
        ("t**1" + "0" * 400, "at most 64"),
        ("~" + "-" * 1900 + "t", "not allowed"),
    ],
    ids=["an exponent beyond floats", "what is forbidden around what is deep"],
)
def test_extremes_are_refused_too(text, remedy):
    with pytest.raises(ExpressionError, match=remedy):
        Formula(text)
