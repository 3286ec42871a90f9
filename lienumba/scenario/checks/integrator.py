"""How steps are made: of a given length, or as long as a tolerance of the error allows; which methods, charts and
stabilisations go together."""

from lienumba.integrators.methods import DEFAULT_PAIR, METHODS
from lienumba.integrators.methods.charts import JOINT, R3xSO3
from lienumba.integrators.methods.comparators import COORDINATES
from lienumba.integrators.methods.generalized_alpha import DAMPING, GENERALIZED_ALPHA
from lienumba.integrators.methods.taylor import TAYLOR, order_for
from lienumba.scenario.base.problems import Report
from lienumba.scenario.schema.scenario import Integrator, Projection, Tolerance
from lienumba.words import listed, show

BOUNDS = ("first_step", "max_step", "min_step")
MOST_STEPS = 2**31 - 1  # of a run: counts of steps are int32 in files


def pairs() -> list[str]:
    """The methods that estimate their error."""
    return [name for name, tableau in METHODS.items() if tableau.errors or tableau.series]


def method_of(integrator: Integrator) -> str:
    """The method, which may be omitted: a pair with a tolerance."""
    if "method" not in integrator.model_fields_set and integrator.tolerance is not None:
        return DEFAULT_PAIR
    return integrator.method


def order_of(integrator: Integrator) -> int | None:
    """The order of a series: that which is given, or the one that the tolerance asks for; None of other methods."""
    method = METHODS[method_of(integrator)]
    if not method.series or integrator.order is not None:
        return integrator.order
    tolerance = integrator.tolerance
    return method.order if tolerance is None else order_for(relative_of(tolerance))


def relative_of(tolerance: Tolerance | float) -> float:
    """What it is relative to the size."""
    return tolerance.relative if isinstance(tolerance, Tolerance) else tolerance


def damping_of(integrator: Integrator) -> float | None:
    """rho_infinity of the generalised-alpha method, None of others."""
    given = integrator.rho_infinity
    return DAMPING if given is None and integrator.method == GENERALIZED_ALPHA.name else given


def check_integrator(integrator: Integrator, report: Report) -> bool:
    """Check how steps are made; whether it is clear."""
    given = [key for key in BOUNDS if getattr(integrator, key) is not None]
    before = len(report.problems)
    if integrator.step is None and integrator.tolerance is None:
        report.miss(
            "integrator.step",
            (
                "give the time step in s, above 0, or integrator.tolerance, the error of one step, with one of "
                f"{', '.join(pairs())}"
            ),
        )
    elif integrator.step is not None and integrator.tolerance is not None:
        report.add("", "integrator.step and integrator.tolerance are both given", "leave one of them out")
    elif integrator.tolerance is None:
        for key in given:
            report.add(
                f"integrator.{key}",
                f"bounds steps that a tolerance chooses, but integrator.step = {integrator.step!r} gives them",
                "leave it out, or give integrator.tolerance instead",
                getattr(integrator, key),
            )
    else:
        _check_bounds(integrator, given, report)
    for key in ("step", "max_step"):
        step = getattr(integrator, key)
        if step is not None and integrator.end_time / step > MOST_STEPS:
            report.add(
                f"integrator.{key}",
                (
                    f"asks for {integrator.end_time / step:.2g} steps until integrator.end_time = "
                    f"{integrator.end_time!r}, at most {MOST_STEPS:,} are possible"
                ),
                "give a longer one",
                step,
            )
    return len(report.problems) == before


def _check_bounds(integrator: Integrator, given: list[str], report: Report) -> None:
    if method_of(integrator) not in pairs():
        report.add(
            "integrator.tolerance",
            f'the method "{integrator.method}" does not estimate its error',
            f"take {listed(pairs(), 'or')}, or give integrator.step instead",
        )
    steps = {key: float(getattr(integrator, key)) for key in given}
    for key, step in steps.items():
        if step > integrator.end_time:
            report.add(
                f"integrator.{key}",
                f"is longer than the run, integrator.end_time = {integrator.end_time!r}",
                "give a shorter one",
                step,
            )
    for shorter, longer in (("min_step", "max_step"), ("min_step", "first_step"), ("first_step", "max_step")):
        if shorter in steps and longer in steps and steps[shorter] > steps[longer]:
            report.add(
                f"integrator.{shorter}",
                f"is longer than integrator.{longer} = {steps[longer]!r}",
                "give a shorter one",
                steps[shorter],
            )


def may_change(integrator: Integrator) -> bool:
    """Whether steps have a continuous extension, on which events are found."""
    return integrator.coordinates not in COORDINATES and not METHODS[integrator.method].composed


def check_method(integrator: Integrator, changing: str, switching: str, slides: bool, report: Report) -> None:
    """dexpinv and the group belong to exponential coordinates; a method of several exponentials has no dexpinv; neither
    it nor other coordinates have a continuous extension. changing: what asks for one, beside a tolerance;
    switching: what turns constraints on and off; slides: whether contacts do, with friction."""
    chosen, value = "integrator.coordinates", integrator.coordinates
    as_vectors, method = value in COORDINATES, METHODS[integrator.method]
    whose = "joints" if value == JOINT else "rotations alone"
    if value != "lie" and integrator.group != R3xSO3.__name__:
        report.add(
            chosen,
            f'are coordinates of {whose}, not of integrator.group = "{integrator.group}"',
            "leave one of the two out",
            value,
        )
    if as_vectors and method.composed:
        report.add(
            chosen,
            f'have no exponentials for integrator.method = "{method.name}" to compose',
            f'give the method "{method.flat}", which it is in a vector space',
            value,
        )
    between = "integrator.tolerance" if integrator.tolerance is not None else changing
    if between and as_vectors:
        report.add(
            chosen,
            f"says where a body is at the ends of given steps only, but {between} asks for more",
            f'give "lie", or leave {between} out',
            value,
        )
    if changing and between == changing and method.composed:
        report.add(
            "integrator.method",
            f"says where a body is at the ends of steps only, but {changing} asks for more",
            f'give "{method.flat}", or leave {changing} out',
            method.name,
        )
    _check_series(integrator, slides, report)
    _check_damping(integrator, report)
    if method.implicit and as_vectors:
        report.add(
            chosen,
            f'has no implicit steps, as integrator.method = "{method.name}" makes them',
            'give "lie" or "joint", or an explicit method',
            value,
        )
    if integrator.dexpinv is None:
        return
    given = integrator.dexpinv
    if as_vectors:
        report.add(
            "integrator.dexpinv", f"is not used with {chosen} = {show(value)}", "leave one of the two out", given
        )
    if method.composed:
        report.add(
            "integrator.dexpinv",
            f'is not used by integrator.method = "{method.name}", which needs none',
            "leave it out",
            given,
        )


def _check_series(integrator: Integrator, slides: bool, report: Report) -> None:
    """A series is that of the state: whichever coordinates a step might have, it would be the same; orders are its
    own. That of slow sliding ends where its direction turns, within any given step."""
    method = METHODS[integrator.method]
    if not method.series:
        if integrator.order is not None:
            report.add(
                "integrator.order",
                f'is that of a series, but the method "{method.name}" has one of its own: {method.order}',
                f'leave it out, or give the method "{TAYLOR.name}"',
                integrator.order,
            )
        return
    if slides and integrator.step is not None:
        report.add(
            "integrator.step",
            f'is too long for the method "{method.name}" where [[model.contacts]] with friction begin or end to slide',
            "give integrator.tolerance instead, or another method",
            integrator.step,
        )
    own = {"group": R3xSO3.__name__, "coordinates": "lie", "dexpinv": None}
    for key, default in own.items():
        value = getattr(integrator, key)
        if value not in (default, JOINT):
            report.add(
                f"integrator.{key}",
                f'makes no difference to integrator.method = "{method.name}", the series of the state itself',
                "leave it out",
                value,
            )


def _check_damping(integrator: Integrator, report: Report) -> None:
    if integrator.rho_infinity is not None and integrator.method != GENERALIZED_ALPHA.name:
        report.add(
            "integrator.rho_infinity",
            f'is that of the method "{GENERALIZED_ALPHA.name}", not of "{integrator.method}"',
            "leave it out, or give that method",
            integrator.rho_infinity,
        )


def check_projection(projection: Projection, integrator: Integrator | None, switching: str, report: Report) -> None:
    """Violations are damped or projected; chords are of projected positions, and neither they nor the embedded form are
    of joints. switching: what turns constraints on and off, if anything does."""
    if switching:
        turned = f"is not for constraints that are turned on and off, as {switching} asks for"
        if projection.chord:
            report.add("projection.chord", turned, "leave it out", True)
        if projection.position == "embedded":
            report.add("projection.position", turned, 'give "local" or "none"', projection.position)
        if projection.baumgarte is not None:
            report.add("projection.baumgarte", turned, "leave it out", projection.baumgarte)
    if integrator is not None and integrator.coordinates == JOINT:
        joints, remedy = f'is not for integrator.coordinates = "{JOINT}", which projects joints', "leave it out"
        if projection.chord:
            report.add("projection.chord", joints, remedy, True)
        if projection.position == "embedded":
            report.add("projection.position", joints, 'give "local" or "none"', projection.position)
    if projection.chord and projection.position == "none":
        report.add(
            "projection.chord",
            'is for projected positions, and projection.position = "none" projects none',
            'leave it out, or give position = "local" or "embedded"',
            True,
        )
    projected = [
        f'projection.{key} = "{value}"'
        for key, value in (("position", projection.position), ("velocity", projection.velocity))
        if value != "none"
    ]
    if projection.baumgarte is not None and projected:
        report.add(
            "projection.baumgarte",
            f"damps violations instead of projecting, against {' and '.join(projected)}",
            'give position = "none" and velocity = "none", or leave baumgarte out',
            projection.baumgarte,
        )
