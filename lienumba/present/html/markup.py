"""HTML as nested elements: every text is escaped on its way in, so that no title or name can be markup."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape

from lienumba.analysis.text_table import WORD, TextTable, number_text
from lienumba.words import is_number

VOID = {"input", "br"}
RAISED = str.maketrans("0123456789−", "⁰¹²³⁴⁵⁶⁷⁸⁹⁻")


class Markup(str):
    """Text that is HTML already."""

    __slots__ = ()


def element(name: str, *children: str, **attributes: str | bool) -> Markup:
    """One element; an attribute that is a Python word ends in an underscore, and - is written _."""
    given = "".join(
        f" {key}" if value is True else f' {key}="{escape(value)}"'
        for key, value in ((key.rstrip("_").replace("_", "-"), value) for key, value in attributes.items())
        if value is not False
    )
    return Markup(f"<{name}{given}>" + ("" if name in VOID else f"{join(children)}</{name}>"))


def join(children: Iterable[str]) -> Markup:
    """These one after the other."""
    return Markup("".join(child if isinstance(child, Markup) else escape(child, quote=False) for child in children))


def table(headings: Sequence[str], rows: Iterable[Sequence[str]], words: int, prose: bool = False) -> Markup:
    """A table; words: so many columns from the left hold words, the others numbers; prose: some hold sentences."""
    kinds = ["word" if n < words else "number" for n in range(len(headings))]
    head = element("tr", *(element("th", text, class_=kind) for text, kind in zip(headings, kinds, strict=True)))
    lines = ([element("td", text, class_=kind) for text, kind in zip(row, kinds, strict=True)] for row in rows)
    body = (element("tr", *line) for line in lines)
    whole = element("table", element("thead", head), element("tbody", *body))
    return element("div", whole, class_="scroll prose" if prose else "scroll", tabindex="0")


def text_table(found: TextTable) -> Markup:
    """A table of an analysis, whose words are its first columns; those without any are left out."""
    full = [n for n, kind in enumerate(found.kinds) if kind != WORD or any(row[n] for row in found.rows)]
    words = sum(found.kinds[n] == WORD for n in full)
    rows = [[row[n] for n in full] for row in found.rows]
    shown = ([*row[:words], *(typeset(text) if is_number(text) else text for text in row[words:])] for row in rows)
    return table([found.headings[n] for n in full], shown, words)


def facts(pairs: Iterable[tuple[str, str]]) -> Markup:
    """Names and what they are."""
    return element("dl", *(join((element("dt", name), element("dd", text))) for name, text in pairs if text))


def folded(summary: str, *children: str) -> Markup:
    """What is shown when asked for."""
    return element("details", element("summary", summary), *children)


def sentence(text: str) -> Markup:
    """A message as a sentence: with a capital, unless it begins with a name, and a full stop; `code` as such."""
    first = text.partition(" ")[0]
    named = not first.isalpha()
    whole = (text if named else text[:1].upper() + text[1:]).removesuffix(".") + "."
    parts = whole.split("`")
    return join(element("code", part) if n % 2 else part for n, part in enumerate(parts))


def number(x: float, digits: int = 6) -> str:
    """A number as it is printed: 4.4 × 10⁻¹⁶, −0.25."""
    return typeset(number_text(x, f".{digits}g"))


def typeset(text: str) -> str:
    """The text of a number, or of none, as a page has it."""
    if not any(digit in text for digit in "0123456789"):
        return text
    mantissa, _, power = text.partition("e")
    raised = str(int(power or 0)).replace("-", "−").translate(RAISED)
    return mantissa.replace("-", "−") + (f"\u00a0×\u00a010{raised}" if raised != "⁰" else "")
