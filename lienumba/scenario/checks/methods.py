"""Which methods, charts and stabilisations go together."""

from typing import TYPE_CHECKING

from lienumba.integrators.methods import METHODS
from lienumba.integrators.methods.charts import R3xSO3
from lienumba.scenario.schema.scenario import Integrator, Projection

if TYPE_CHECKING:
    from lienumba.scenario.base.problems import Report


def check_method(integrator: Integrator, events: bool, report: "Report") -> None:
    """dexpinv and the group belong to exponential coordinates; a method of several exponentials has no dexpinv; neither
    it nor other coordinates have a continuous extension."""
    chosen = f'integrator.coordinates = "{integrator.coordinates}"'
    as_vectors, method = integrator.coordinates != "lie", METHODS[integrator.method]
    if as_vectors and integrator.group != R3xSO3.__name__:
        report.problems.append(
            f'{chosen}: are coordinates of rotations alone, not of integrator.group = "{integrator.group}"; leave one '
            "of the two out"
        )
    if as_vectors and method.composed:
        report.problems.append(
            f'{chosen}: have no exponentials for integrator.method = "{method.name}" to compose; give the method '
            f'"{method.flat}", which it is in a vector space'
        )
    between = "integrator.tolerance" if integrator.tolerance is not None else "[[events]]" if events else None
    if between and as_vectors:
        report.problems.append(
            f'{chosen}: says where a body is at the ends of given steps only, but {between} asks for more; give "lie", '
            f"or leave {between} out"
        )
    if between == "[[events]]" and method.composed:
        report.problems.append(
            f'integrator.method = "{method.name}": says where a body is at the ends of steps only, but [[events]] asks '
            f'for more; give "{method.flat}", or leave [[events]] out'
        )
    if integrator.dexpinv is None:
        return
    given = f'"{integrator.dexpinv}"' if isinstance(integrator.dexpinv, str) else integrator.dexpinv
    if as_vectors:
        report.problems.append(f"integrator.dexpinv = {given}: is not used with {chosen}; leave one of the two out")
    if method.composed:
        report.problems.append(
            f'integrator.dexpinv = {given}: is not used by integrator.method = "{method.name}", which needs none; '
            "leave it out"
        )


def check_projection(projection: Projection, report: "Report") -> None:
    """Violations are damped or projected; chords are of projected positions."""
    if projection.chord and projection.position == "none":
        report.problems.append(
            'projection.chord = true: is for projected positions, and projection.position = "none" projects none; '
            'leave it out, or give position = "local" or "embedded"'
        )
    projected = [
        f'projection.{key} = "{value}"'
        for key, value in (("position", projection.position), ("velocity", projection.velocity))
        if value != "none"
    ]
    if projection.baumgarte is not None and projected:
        report.problems.append(
            f"projection.baumgarte = {projection.baumgarte!r}: damps violations instead of projecting, against "
            f'{" and ".join(projected)}; give position = "none" and velocity = "none", or leave baumgarte out'
        )
