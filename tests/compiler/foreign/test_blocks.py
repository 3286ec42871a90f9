"""What Numba compiles for laws: what it may read and call, and one sentence for what it may not."""

import inspect
import math
from typing import Any

import numba
import numpy as np
import pytest

import lienumba
from lienumba import laws
from lienumba.compiler import native
from lienumba.compiler.foreign import blocks
from lienumba.compiler.foreign.calls import Argument
from lienumba.errors import BadValueError
from tests.compiler.evaluation import assert_same_bits

TABLE, NAMES, LONG = np.array([3.0, 1.0, 2.0]), {"a": 1.0}, np.linspace(0.0, 1.0, 200)


@numba.njit(fastmath=True)
def fast(x):
    return x + x


@numba.njit
def plain(x):
    return x + x


@lienumba.jit
def inner(x, factor=2.0):
    return factor * TABLE[1] * x


REFUSED = {
    "math.sin(x)": "f reads math for sin, whose bits differ between machines; take sin of lienumba.laws",
    "np.arctan2(x, 1.0)": "f reads np for arctan2, whose bits differ between machines; take atan2 of lienumba.laws",
    "x**x": "f calls pow of a mathematics library, whose bits differ between machines; take exp and log, "
    r"as exp\(x\*log\(a\)\) of lienumba.laws",
    "x % 2.0": r"f uses % or // of floats, an operation of a mathematics library \(frem\); take mod and floor of "
    "lienumba.laws",
    "np.zeros(3)[0] + x": r"f allocates memory \(NRT_\w+\); keep numbers in variables, tuples and the law's memory",
    "np.dot(TABLE, TABLE) * x": r"f needs Numba while it runs \(numba_\w+\); write it with loops, or",
    "fast(x)": "f reads fast, which numba compiles without checks of indices; decorate it with lienumba.jit",
    "plain(x)": "f reads plain, which numba compiles without checks of indices; decorate it with lienumba.jit",
    "TABLE[x]": r"Numba cannot compile f: .*getitem.*; numbers arrive as floats: write int\(n\) for an index",
    "NAMES['a'] * x": "f reads NAMES, a dict, which is not known; let it read numbers, tuples, texts, arrays and",
    "(x, (x, x))": r"f returns Tuple\(.*\); let it return a number, or a tuple of numbers",
    "None": "f returns none; let it return a number, or a tuple of numbers",
    "x.y": r"Numba cannot compile f: Unknown attribute 'y' of type float64 .*; correct it",
    "unknown(x)": "Numba cannot compile f: NameError: name 'unknown' is not defined; correct the name, or",
}  # fmt: skip


def names_of(text: str) -> dict[str, Any]:
    """What a text defines that sees the names of this module."""
    names = {**globals(), "math": math}
    exec(text, names)
    return names


def function(text: str) -> Any:
    """A function of x."""
    return lienumba.jit(names_of(f"def f(x): return {text}")["f"])


@pytest.mark.parametrize("text", REFUSED)
def test_what_is_refused_is_refused_in_one_sentence(text):
    with pytest.raises(BadValueError, match=REFUSED[text]):
        function(text)(0.5)


def test_arguments_are_numbers_and_tuples_of_numbers():
    text = "x[0] + x[2] if len(x) > 2 else 0.0"
    assert function(text)((1.0, 5.0, 2.0)) == 3.0
    np.testing.assert_array_equal(function("x * x, 1")(np.array([1.0, 3.0])), [[1.0, 9.0], [1.0, 1.0]])
    with pytest.raises(BadValueError, match="f gets 'a', a str; give it numbers, or tuples of numbers"):
        function("x")("a")
    with pytest.raises(BadValueError, match="takes a plain function, not a ufunc; write it with def"):
        lienumba.jit(np.sqrt)
    with pytest.raises(BadValueError, match=r"f takes \*x; name each argument, and give it in its place"):
        lienumba.jit(names_of("def f(*x): return x[0]")["f"])
    with pytest.raises(BadValueError, match=r"Numba cannot compile f: Use of unsupported opcode \(IMPORT_NAME\)"):
        lienumba.jit(names_of("def f(x):\n  import math\n  return x")["f"])(1.0)


def test_it_may_call_others_with_arguments_by_name_and_sees_what_is_edited(monkeypatch):
    both = function("inner(x + 1.0) + 2.0 * x + inner(x, factor=0.5)")
    assert both(1.0) == 4.0 + 2.0 + 0.5
    monkeypatch.setattr("tests.compiler.foreign.test_blocks.TABLE", TABLE * [1, 3, 1])
    assert function("inner(x + 1.0) + 2.0 * x + inner(x, factor=0.5)")(1.0) == 12.0 + 2.0 + 1.5
    assert inner(1.0, factor=10.0) == 30.0


def test_an_index_out_of_range_and_what_is_not_finite_are_nan():
    """For every output."""
    assert np.isnan(function("TABLE[int(x)]")(3.0))
    assert function("TABLE[int(x)]")(2.0) == 2.0
    assert np.isnan(function("(x, 1.0 / (x - 2.0))")(2.0)).all()
    assert np.isnan(function("5 // int(x) + 5 % int(x)")(0.0))
    assert function("float(int(x))")(1e30) == 2.0**63


def test_a_run_that_has_failed_is_not_called():
    """Its loop would not end."""
    names = names_of("def f(x, limit):\n    while not x < limit:\n        x -= limit\n    return x")
    found = lienumba.jit(names["f"])(np.array([0.5, np.nan, 3.5]), np.array([1.0, 1.0, np.inf]))
    np.testing.assert_array_equal(found, [0.5, np.nan, 3.5])


def test_every_function_of_laws_may_be_called_to_the_bits_that_it_has_on_floats():
    numbers = {"where": "x < 0.5, x, 2.0", "clip": "x, 0.1, 0.9"}
    numbers |= dict.fromkeys(("atan2", "hypot", "maximum", "minimum", "mod"), "x, 0.3")
    names = [name for name in laws.__all__ if inspect.isfunction(getattr(laws, name))]
    assert len(names) == 24
    text = ", ".join(f"laws.{name}({numbers.get(name, 'x')})" for name in names)
    assert_same_bits(function(text)(0.7), eval(text, {"laws": laws, "x": 0.7}))
    assert function("math.sqrt(x) + np.sqrt(x) + laws.sqrt(x)")(2.0) == 3.0 * math.sqrt(2.0)


@numba.njit(error_model="numpy")
def many(x):
    """Too long to be inlined twice."""
    i = 0
    while i < len(LONG) - 2 and LONG[i + 1] < x:
        i += 1
    a = (x - LONG[i]) / (LONG[i + 1] - LONG[i])
    for k in range(3):
        a += LONG[k * 7 + i // 9] * x
        a = a * x + LONG[i] if a < -3.0 else a - LONG[i] if a > 50.0 else a
    return i, a, a * x, x, a - x


def test_no_c_library_clears_the_memory_of_tuples(monkeypatch):
    """At no level of optimisation."""
    monkeypatch.setattr(blocks, "GUARDED", blocks.GUARDED | {"forceinline": False})
    made = blocks.compiled(
        function("many(x)[1] + many(x * x)[2]").py_func, "lienumba_call_many", [Argument("number", 1)]
    )
    assert "@llvm.memset" in made.text
    assert all(b"memset" not in object_code(made.text, level, monkeypatch) for level in (0, 1))


def object_code(text: str, level: int, monkeypatch: pytest.MonkeyPatch) -> bytes:
    monkeypatch.setattr(native, "LEVEL", level)
    return native.emit(text, *native.cpu())
