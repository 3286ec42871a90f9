"""The generalised-alpha method: of order 2, one implicit stage at the end of a step, damping as strong as is asked for.

With v' as the equations of motion have it, and the algorithmic acceleration a that goes from step to step,

    (1 - am) a_1 + am a_0 = (1 - af) v'_1 + af v'_0
    dq = h v_0 + h^2 ((1/2 - beta) a_0 + beta a_1),    dv = h ((1 - gamma) a_0 + gamma a_1)

(Chung and Hulbert 1993; on Lie groups Bruels, Cardona and Arnold 2012), where q_1 = q_0 exp(dq). With gamma =
1/2 + af - am, a belongs to the time t + (am - af) h: so the first a, and every one behind a step of another length,
is moved there along v', and the order is that of equal steps (Arnold, Bruels and Cardona 2015 on starting values).
"""

from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from lienumba.integrators.methods.tableau import Tableau
from lienumba.keys.literature import Reference
from lienumba.numerics.number import Number

DAMPING = 0.8  # rho_infinity, where none is given

GENERALIZED_ALPHA = Tableau(
    "generalized_alpha", 2, "the generalised-alpha method on Lie groups [@chung1993; @bruels2012; @arnold2015]",
    ((Fraction(0),) * 3, (Fraction(0), Fraction(1), Fraction(0)), (Fraction(0), Fraction(1), Fraction(0))),
    (Fraction(0), Fraction(1), Fraction(0)),
    references=(
        Reference(
            "chung1993", "article", "Chung, Jintai and Hulbert, Gregory M.", 1993,
            "A time integration algorithm for structural dynamics with improved numerical dissipation: the "
            "generalized-alpha method",
            "Journal of Applied Mechanics", "60(2):371--375", "10.1115/1.2900803",
        ),
        Reference(
            "bruels2012", "article", "Brüls, Olivier and Cardona, Alberto and Arnold, Martin", 2012,
            "Lie group generalized-alpha time integration of constrained flexible multibody systems",
            "Mechanism and Machine Theory", "48:121--137", "10.1016/j.mechmachtheory.2011.07.017",
        ),
        Reference(
            "arnold2015", "article", "Arnold, Martin and Brüls, Olivier and Cardona, Alberto", 2015,
            "Error analysis of generalized-alpha Lie group time integration methods for constrained mechanical systems",
            "Numerische Mathematik", "129(1):149--179", "10.1007/s00211-014-0633-1",
        ),
    ),
    carries=True,
)  # fmt: skip


@dataclass(frozen=True)
class Weights:
    """What a step takes of v' at its start, of the a that the step before has left, and of v' at its end: `dq` of the
    rest of dq / h^2, `dv` of dv / h, `a` of the a that it leaves."""

    dq: tuple[Any, Any, Any]
    dv: tuple[Any, Any, Any]
    a: tuple[Any, Any, Any]


def weights(rho: float, ratio: Number) -> Weights:
    """Of a step whose predecessor was `ratio` times as long: 1 where all are equal, 0 at the start, where a is v'."""
    am, af = (2.0 * rho - 1.0) / (rho + 1.0), rho / (rho + 1.0)
    gamma = 0.5 + af - am
    beta = 0.25 * (gamma + 0.5) * (gamma + 0.5)
    moved = (am - af) * (1.0 - ratio)
    first = (-moved, 1.0, moved)
    behind = (af / (1.0 - am), 0.0, (1.0 - af) / (1.0 - am))
    second = tuple(x - (am / (1.0 - am)) * y for x, y in zip(behind, first, strict=True))

    def mixed(one: float, two: float) -> tuple[Any, Any, Any]:
        x, y, z = (one * a + two * b for a, b in zip(first, second, strict=True))
        return x, y, z

    return Weights(mixed(0.5 - beta, beta), mixed(1.0 - gamma, gamma), mixed(0.0, 1.0))
