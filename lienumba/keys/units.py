"""Units as texts: "kg m2 s-1", as datasets have them, and as people write them, "kg*m^2/s" or "N/(m s)"."""

from __future__ import annotations

import re

SUPERSCRIPTS = "⁰¹²³⁴⁵⁶⁷⁸⁹⁻"
PLAIN = str.maketrans(f"{SUPERSCRIPTS}·⋅−", "0123456789-**-")
FACTOR = re.compile(r"1|([^\s\d*/^()+.,;:-]+)(?:\^?([+-]?\d+(?:\.\d+)?)|\^\(([+-]?\d+(?:\.\d+)?)\))?")

Factors = list[tuple[str, float]]  # symbols with their powers, as they stand


def factors(units: str) -> Factors | None:
    """The factors of a unit, none of "1"; None if it cannot be read, or in two ways, as m/s kg."""
    first, *below = (units.strip() or "1").translate(PLAIN).replace("**", "^").split("/")
    found = []
    for sign, part in ((1, first), *((-1, x) for x in below)):
        bare = part.strip()
        grouped = bare.startswith("(") and bare.endswith(")")
        words = re.split(r"\s*\*\s*|\s+", (bare[1:-1] if grouped else bare).strip())
        if sign < 0 and len(words) > 1 and not grouped:
            return None
        for factor in map(FACTOR.fullmatch, words):
            if factor is None:
                return None
            if factor[1]:
                found.append((factor[1], sign * float(factor[2] or factor[3] or 1)))
    return found


def written(units: Factors) -> str:
    """As datasets have them."""
    return " ".join(f"{symbol}{'' if power == 1 else f'{power:g}'}" for symbol, power in units) or "1"
