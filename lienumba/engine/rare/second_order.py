"""The probability if the limit were a paraboloid at the point where failures are most probable."""

import numpy as np
from scipy import stats

from lienumba.engine.rare.design_points import design_points
from lienumba.engine.rare.estimate import Estimate, Margins
from lienumba.errors import ScenarioError

STEP = 0.1  # of second differences, in standard deviations


def sorm(margins: Margins, dimensions: int, runs: int, seed: int, confidence: float) -> Estimate:
    """The second-order reliability method (K. Breitung, J. Eng. Mech. 110 (1984) 357; M. Hohenbichler, R. Rackwitz,
    J. Eng. Mech. 114 (1988) 2195): FORM's plane, bent by the curvatures of the limit there. No interval: how far the
    limit is from a paraboloid, nobody knows."""
    points, origin, taken = design_points(margins, dimensions, seed)
    distances = np.linalg.norm(points, axis=1)
    curvatures, more = _curvatures(margins, points[0])
    beta = float(distances[0])
    ratio = float(np.exp(stats.norm.logpdf(beta) - stats.norm.logsf(beta)))
    bends = 1.0 + curvatures * ratio
    if not (bends > 0.0).all():
        raise ScenarioError(
            f"the limit bends about the origin with a radius of {-1.0 / curvatures.min():.3g} standard "
            f"deviations, {beta:.3g} away from it: failures are not gathered about one point; "
            'take method = "importance"'
        )
    tail = float(stats.norm.sf(beta) / np.sqrt(bends.prod()))
    found = tail if origin > 0.0 else 1.0 - tail
    return Estimate("sorm", found, 0.0, 1.0, confidence, taken + more, points, distances)


def _curvatures(margins: Margins, point: np.ndarray) -> tuple[np.ndarray, int]:
    """The principal curvatures (d - 1,) of the limit in a point of it, above 0 where it bends away from the origin, and
    the runs that this took: second differences in axes of which the first is the limit's normal."""
    d = len(point)
    steps = STEP * np.eye(d)
    pairs = [(i, j) for i in range(d) for j in range(i)]
    corners = [a * steps[i] + b * steps[j] for i, j in pairs for a in (1, -1) for b in (1, -1)]
    g = margins(point + np.vstack([np.zeros(d), steps, -steps, *corners]))
    if not np.isfinite(g).all():
        raise ScenarioError('runs beside the most probable point of failure have no margin; take method = "subset"')
    ahead, behind, rest = g[1 : d + 1], g[d + 1 : 2 * d + 1], g[2 * d + 1 :].reshape(-1, 4)
    slope = (ahead - behind) / (2.0 * STEP)
    bend = np.diag((ahead - 2.0 * g[0] + behind) / STEP**2)
    for (i, j), (a, b, c, e) in zip(pairs, rest, strict=True):
        bend[i, j] = bend[j, i] = (a - b - c + e) / (4.0 * STEP**2)
    normal, size = slope / np.linalg.norm(slope), float(np.linalg.norm(slope))
    along = np.linalg.qr(np.column_stack([normal, np.eye(d)]))[0][:, 1:d]  # across the normal
    outwards = 1.0 if normal @ point <= 0.0 else -1.0  # the margin falls outwards, or rises where the origin fails
    found: np.ndarray = np.linalg.eigvalsh(along.T @ bend @ along) / size * outwards
    return found, len(g)
