"""Rows of texts with headings, which a terminal and a page only draw."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import repeat
from typing import TYPE_CHECKING, Literal

from lienumba.words import readable

if TYPE_CHECKING:
    from rich.table import Table

Kind = Literal["word", "number", "unit"]
WORD: Kind = "word"
NUMBER: Kind = "number"
UNIT: Kind = "unit"
NONE = "–"  # what stands where there is no number
ROUNDING = 1e-12  # of the largest value of a variable: what is less, or varies by less, is rounding


@dataclass(frozen=True)
class TextTable:
    """headings: of the columns; kinds: what each column holds; rows: one text for each column."""

    headings: Sequence[str]
    kinds: Sequence[Kind]
    rows: Sequence[Sequence[str]]

    @staticmethod
    def of(words: Sequence[str], numbers: Sequence[str], rows: Sequence[Sequence[str]]) -> TextTable:
        """Columns of words with these headings, and of numbers with those."""
        return TextTable([*words, *numbers], [*repeat(WORD, len(words)), *repeat(NUMBER, len(numbers))], rows)

    def on_terminal(self, title: str | None = None) -> Table:
        """The table as rich prints it."""
        from rich import box
        from rich.table import Table

        table = Table(title=None if title is None else _safe(title), box=box.SIMPLE_HEAD, title_justify="left")
        for heading, kind in zip(self.headings, self.kinds, strict=True):
            table.add_column(_safe(heading), justify="right" if kind == NUMBER else "left", no_wrap=kind == WORD)
        for row in self.rows:
            table.add_row(*map(_safe, row))
        return table


def _safe(text: str) -> str:
    """A text that neither rich nor a terminal obeys."""
    from rich.markup import escape

    return escape(readable(text))


def number_text(value: float, form: str, scale: float = 0.0) -> str:
    """A number in this format, if there is one; what is rounding beside this scale is 0, which has no sign."""
    if value != value:
        return NONE
    text = f"{0.0 if abs(value) <= ROUNDING * scale else value:{form}}"
    return text if any(digit in text.partition("e")[0] for digit in "123456789in") else text.removeprefix("-")


def short_text(value: float, digits: int) -> str:
    """A number of so many significant digits, below a million without a power of ten: 1200, not 1.2e+03."""
    text = number_text(value, f".{digits}g")
    return f"{float(text):.0f}" if "e+" in text and abs(value) < 1e6 else text
