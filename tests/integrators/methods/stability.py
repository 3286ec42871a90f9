"""How long steps of explicit methods may be before they blow up what dies out: z = h lambda with |R(z)| <= 1.

Hairer and Wanner, *Solving Ordinary Differential Equations II* (1996), section IV.2.
"""

from math import factorial

import numpy as np
import numpy.typing as npt

from lienumba.integrators.methods.tableau import Tableau

Floats = npt.NDArray[np.float64]
FARTHEST, STEPS = 40.0, 4000  # where, and how finely, the edge is looked for
GROWTH = 1e-4  # of a step, which does not count


def polynomial(method: Tableau, order: int | None = None) -> Floats:
    """The coefficients of R, from that of 1 on; order: of a series."""
    if method.series:
        return np.array([1.0 / factorial(n) for n in range((order or method.order) + 1)])
    A = np.zeros((len(method.b), len(method.b)))
    for row, own in enumerate(method.A):
        A[row, : len(own)] = [float(x) for x in own]
    found, x, b = [1.0], np.ones(len(method.b)), np.array([float(w) for w in method.b])
    for _ in method.b:
        found.append(float(b @ x))
        x = A @ x
    return np.array(found)


def reach(R: Floats, directions: npt.NDArray[np.complex128]) -> Floats:
    """How far from 0 the method is stable along each of these directions, complex numbers of size 1."""
    r = np.linspace(0.0, FARTHEST, STEPS + 1)[1:]
    grown = np.abs(np.polynomial.polynomial.polyval(np.multiply.outer(directions, r), R)) > 1.0 + GROWTH
    return np.where(grown.any(axis=-1), r[grown.argmax(axis=-1)], FARTHEST)
