"""The units of parameters, as far as what they stand for says them."""

from collections.abc import Mapping

from lienumba.numerics.expressions import Formula
from lienumba.scenario.base.paths import Tokens, text_of
from lienumba.scenario.base.toml import Keys
from lienumba.scenario.base.units import units

UNKNOWN = "1"


def units_of_parameter(name: str, places: Mapping[Tokens, Formula], model: Keys) -> str:
    """Those of the numbers for which a parameter stands, alone or times plain numbers; "1" where none says, or they
    differ.

    Parameters
    ----------
    name
        As formulas have it, such as "kp" or "k[0]".
    places
        The formulas of a scenario, by where they stand.
    model
        Of the scenario, checked.
    """
    found = {units(text_of(list(place)), model) for place, x in places.items() if x.is_multiple(name)}
    return next(iter(found)) if len(found) == 1 else UNKNOWN
