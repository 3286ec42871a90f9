"""Importance sampling: runs where they tell most, with weights that make up for it.

The normal score z of a stream is drawn about `shift` and wider or narrower by `scale`, whatever distribution it is
made into. A tenth of the runs is drawn as the inputs are, so that the weight of a run, the density of the inputs over
that of the mixture, is 10 at most, wherever the proposals lead (T. Hesterberg, Technometrics 37 (1995) 185).
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from lienumba.keys.literature import Reference
from lienumba.numerics.operations import exp
from lienumba.sweep.normal import inverse, probability
from lienumba.sweep.samplers.independent import ONEILL, draw
from lienumba.sweep.samplers.sampler import Sampler
from lienumba.sweep.samplers.streams import LARGEST, uniforms

DEFENSIVE = 0.1  # the part of the runs that is drawn as the inputs are
LARGEST_EXPONENT = 700.0  # of exp
MIXTURE = "sweep.proposal"  # the stream that decides as what a run is drawn


class Proposal(BaseModel):
    """Where the normal score of an input is drawn instead, in standard deviations of it."""

    model_config = ConfigDict(extra="forbid", frozen=True, defer_build=True)

    shift: Annotated[float, Field(strict=True, ge=-6.0, le=6.0)] = Field(
        default=0.0, description="how far the input is shifted, in its standard deviations, from -6 to 6"
    )
    scale: Annotated[float, Field(strict=True, ge=0.2, le=5.0)] = Field(
        default=1.0, description="by what the standard deviation is multiplied, from 0.2 to 5"
    )


def proposed(
    u: Mapping[str, np.ndarray], proposals: Mapping[str, Proposal], labels: np.ndarray, seed: int
) -> tuple[dict[str, np.ndarray], np.ndarray]:
    """The uniform numbers (runs,) of the streams with proposals, as they are drawn by these, and the weights (runs,)
    of the runs; labels from 0 on."""
    own = uniforms(MIXTURE, labels, seed) < DEFENSIVE
    found, exponents, scales = {}, np.zeros(labels.shape), 1.0
    for name, proposal in proposals.items():
        z = inverse(u[name])
        moved = np.where(own, z, proposal.shift + proposal.scale * z)
        own_score = (moved - proposal.shift) / proposal.scale
        exponents = exponents + 0.5 * (moved * moved - own_score * own_score)
        scales *= proposal.scale
        found[name] = np.where(own, u[name], np.clip(probability(moved), 5e-324, LARGEST))
    ratio = exp(np.clip(exponents, -LARGEST_EXPONENT, LARGEST_EXPONENT)) / scales
    return found, 1.0 / (DEFENSIVE + (1.0 - DEFENSIVE) * ratio)


HESTERBERG = Reference(
    "hesterberg1995", "article", "Hesterberg, Tim", 1995,
    "Weighted average importance sampling and defensive mixture distributions",
    "Technometrics", "37(2):185--194", "10.1080/00401706.1995.10484303",
)  # fmt: skip
IMPORTANCE = Sampler("importance", draw, (HESTERBERG, ONEILL), weighted=True)
