"""Radau IIA: implicit collocation at the zeros of a Radau polynomial, stiffly accurate and L-stable, of order 2 s - 1.

Hairer and Wanner, *Solving Ordinary Differential Equations II* (1996), sections IV.5 and IV.8. The first stage of the
tableaus is F at the start of a step, which the estimate of the error reads alone; the others are those of collocation.
"""

from collections.abc import Sequence
from fractions import Fraction
from math import lcm

from lienumba.integrators.methods.tableau import Row, Tableau
from lienumba.keys.literature import Reference

WANNER = Reference(
    "hairer1996", "book", "Hairer, Ernst and Wanner, Gerhard", 1996,
    "Solving Ordinary Differential Equations II: Stiff and Differential-Algebraic Problems",
    "Springer, 2nd edition", "", "10.1007/978-3-642-05221-7",
)  # fmt: skip
ROOT = Fraction("2.449489742783178098197284074705891391965947")  # of 6

FIVE = (  # the zeros of P_5 - P_4 on [0, 1], of Legendre's polynomials
    Fraction("0.0571041961145176821931211925541156212350779"),
    Fraction("0.276843013638123827680045997685625141110889"),
    Fraction("0.583590432368916820056697668662917248693433"),
    Fraction("0.860240135656219447847912918875119766738378"),
    Fraction(1),
)


def _integral(p: Row, to: Fraction) -> Fraction:
    """Of a polynomial, from 0."""
    return sum((w * to ** (n + 1) / (n + 1) for n, w in enumerate(p)), Fraction(0))


def lagrange(nodes: Sequence[Fraction]) -> tuple[Row, ...]:
    """The coefficients of the polynomials that are 1 at one of the nodes and 0 at the others; computed in whole numbers
    over common denominators, since fractions of so many digits are slow to reduce."""
    common = lcm(*(c.denominator for c in nodes))
    whole = [int(c * common) for c in nodes]
    found = []
    for j, own in enumerate(whole):
        p, below = [1], 1
        for other in (*whole[:j], *whole[j + 1 :]):
            p = [common * a - other * b for a, b in zip([0, *p], [*p, 0], strict=True)]
            below *= own - other
        found.append(tuple(Fraction(a, below) for a in p))
    return tuple(found)


def collocation(name: str, words: str, nodes: Sequence[Fraction], damping: Fraction) -> Tableau:
    """damping: gamma of the estimate (I - h gamma J)^-1 h (gamma F_0 + sum e_j f_j), of order s + 1."""
    zero, s = Fraction(0), len(nodes)
    polynomials = lagrange(nodes)
    A = [tuple(_integral(p, c) for p in polynomials) for c in nodes]
    moments = [Fraction(n == 0) for n in range(s)]  # the quadrature with gamma at 0 is exact for polynomials below s
    errors = [-damping * sum((w * m for w, m in zip(p, moments, strict=True)), zero) for p in polynomials]
    return Tableau(
        name, 2 * s - 1, words, ((zero,) * (s + 1), *((zero, *row) for row in A)), (zero, *A[-1]),
        errors=((damping, *errors),), references=(WANNER,), damping=damping, layers=polynomials,
        begun=lagrange((zero, *nodes)),
    )  # fmt: skip


RADAU = (
    collocation("radau3", "the Radau IIA method [@hairer1996]", (Fraction(1, 3), Fraction(1)), 1 / ROOT),
    collocation(
        "radau5",
        "the Radau IIA method [@hairer1996]",
        ((4 - ROOT) / 10, (4 + ROOT) / 10, Fraction(1)),
        Fraction("0.2748888295956773677478286035994148"),
    ),
    collocation(
        "radau9",
        "the Radau IIA method [@hairer1996]",
        FIVE,
        1 / Fraction("6.286704751729276645173153341869409"),
    ),
)
