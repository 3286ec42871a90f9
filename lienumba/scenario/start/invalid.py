"""A sweep of which no run is possible: which of its inputs is to blame."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, NoReturn

import numpy as np

from lienumba.errors import ScenarioError
from lienumba.scenario.start.build import build, unphysical
from lienumba.words import listed

if TYPE_CHECKING:
    from lienumba.scenario.resolve import Scenario


def refuse_invalid(scenario: "Scenario", samples: Mapping[str, np.ndarray]) -> NoReturn:
    """Raise a ScenarioError that names what makes every run of these samples invalid: an input alone, or all."""
    runs = len(next(iter(samples.values())))
    vary = scenario.data.sweep.vary
    guilty = []
    for path, kind in vary.items():
        own = {name: samples[name] for name in kind.columns(path)}
        if unphysical(*build(scenario, own), own, runs).all():
            guilty.append(path)
    shown = listed(f'"{path}"' for path in guilty or vary)
    example = ", ".join(f"{name} = {values[0]:.6g}" for name, values in samples.items())
    raise ScenarioError.at(
        "sweep.vary",
        (
            f"no run is possible with {shown} varied: every sample has a mass, inertia, length, friction "
            "or rotation that nothing has, or is no finite number"
        ),
        f"give values nearer to the nominal ones. The first run: {example}",
    )
