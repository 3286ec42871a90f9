"""Units as datasets have them, and as people write them, are printed with the same meaning, or as they were written."""

import re

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lienumba.analysis.labels import unit_label
from lienumba.analysis.statistics.blockwise import power
from lienumba.keys.units import SUPERSCRIPTS, factors, written

SIZES = {"m": 1.7, "s": 2.3, "kg": 3.1, "rad": 0.9, "Ω": 5.3, "°C": 7.7, "µm": 0.13, "%": 0.01, "N": 11.0}
Product = tuple[str, float]


def meaning(label: str) -> float:
    """What a label comes to, by nothing of the code: multiplied and divided from left to right."""
    value, sign = 1.0, 1
    for part in re.split(r"([·/])", label):
        if part in ("·", "/"):
            sign = 1 if part == "·" else -1
        elif part not in ("", "1"):
            symbol, above = re.fullmatch(rf"(.+?)([{SUPERSCRIPTS}]*)", part).groups()
            value *= SIZES[symbol] ** (sign * int(above.translate(str.maketrans(SUPERSCRIPTS, "0123456789-")) or 1))
    return value


@st.composite
def products(draw: st.DrawFn) -> Product:
    """A product of units, as somebody writes it, and what it comes to."""
    factor = st.tuples(st.sampled_from([*SIZES]), st.integers(-3, 3).filter(bool))
    found = draw(st.lists(factor, min_size=1, max_size=4))
    value, words = 1.0, []
    for symbol, n in found:
        value *= SIZES[symbol] ** n
        raised = f"{n}".translate(str.maketrans("0123456789-", SUPERSCRIPTS))
        spelt = [f"{symbol}{n}", f"{symbol}^{n}", f"{symbol}**{n}", f"{symbol}^({n})", f"{symbol}{raised}"]
        words.append(draw(st.sampled_from([*spelt, symbol] if n == 1 else spelt)))
    return draw(st.sampled_from([" ", "*", " * ", "·", "  "])).join(words), value


@settings(max_examples=300, deadline=None)
@given(products(), st.lists(products(), max_size=3), st.booleans())
def test_units_are_printed_with_their_meaning(above: Product, below: list[Product], one: bool) -> None:
    text, value = ("1", 1.0) if one else above
    for more, size in below:
        text, value = f"{text}/({more})", value / size
    assert meaning(unit_label(text)) == pytest.approx(value, rel=1e-12)
    assert meaning(unit_label(written(factors(text)))) == pytest.approx(value, rel=1e-12)
    assert meaning(unit_label(power(text, 2))) == pytest.approx(value**2, rel=1e-12)


@settings(max_examples=300, deadline=None)
@given(st.text(st.sampled_from("mskgNrad123 */^()-.%·²⁻µ°_"), max_size=12))
def test_of_no_text_anything_is_lost(text: str) -> None:
    """What is not understood stays as it is; of the rest symbols and numbers of powers are there, in some order."""
    label = unit_label(text)
    if factors(text) is None:
        assert label == text.strip()
    else:
        assert sorted(re.findall(r"[A-Za-zµ%°_]", label)) == sorted(re.findall(r"[A-Za-zµ%°_]", text))


@pytest.mark.parametrize(
    ("units", "label"),
    {
        "rad/s": "rad/s", "m/s": "m/s", "N/m": "N/m", "1/s": "1/s", "m/s^2": "m/s²", "m/s2": "m/s²", "m/s/s": "m/s/s",
        "N/(m s)": "N/m/s", "(N m)/rad": "N·m/rad", "kg*m/s": "kg·m/s", "m**2": "m²", "m²": "m²", "s⁻¹": "1/s",
        "W/m2": "W/m²", "%": "%", "km/h": "km/h", "deg": "deg", "°C": "°C", "rad s-0.5": "rad/s^0.5",
        "m/s kg": "m/s kg", "m/s*kg": "m/s*kg", "1000 kg": "1000 kg", "N-m": "N-m", "m//s": "m//s", "/s": "/s",
    }.items(),
)  # fmt: skip
def test_units_as_people_write_them(units: str, label: str) -> None:
    assert unit_label(units) == label


def test_powers_of_what_is_no_unit() -> None:
    assert [power(x, 2) for x in ("m s-1", "m/s", "1", "N-m")] == ["m2 s-2", "m2 s-2", "1", "(N-m)^2"]
