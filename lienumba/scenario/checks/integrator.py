"""How steps are made: of a given length, or as long as a tolerance of the error allows; which methods, charts and
stabilisations go together."""

from lienumba.integrators.methods import DEFAULT_PAIR, METHODS
from lienumba.integrators.methods.charts import JOINT, R3xSO3
from lienumba.integrators.methods.comparators import COORDINATES
from lienumba.integrators.methods.generalized_alpha import DAMPING, GENERALIZED_ALPHA
from lienumba.integrators.methods.taylor import TAYLOR, order_for
from lienumba.mechanics.elements.events import ENGAGE, LOCK, RELEASE, UNLOCK
from lienumba.scenario.base.problems import Report
from lienumba.scenario.base.toml import Keys
from lienumba.scenario.formulas.measures import is_formula
from lienumba.scenario.schema.scenario import Integrator, Projection, Tolerance
from lienumba.words import listed, show

OPPOSITE = {LOCK.name: UNLOCK.name, RELEASE.name: ENGAGE.name}
BOUNDS = ("first_step", "max_step", "min_step")
MOST_STEPS = 2**31 - 1  # of a run: counts of steps are int32 in files

Lists = dict[str, list[Keys]]  # what stands in the lists of the model


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
    before, end = len(report.problems), integrator.end_time
    if integrator.step is None and integrator.tolerance is None:
        report.miss(
            "integrator.step",
            "give the time step in s, above 0, or integrator.tolerance, the error of one step, with one of "
            f"{', '.join(pairs())}",
        )
    elif integrator.step is not None and integrator.tolerance is not None:
        report.add("", "integrator.step and integrator.tolerance are both given", "leave one of them out")
    elif integrator.tolerance is None:
        rule = f"bounds steps that a tolerance chooses, but integrator.step = {integrator.step!r} gives them"
        for key in given:
            _wrong(integrator, key, rule, "leave it out, or give integrator.tolerance instead", report)
    else:
        _check_bounds(integrator, given, report)
    for key in ("step", "max_step"):
        step = getattr(integrator, key)
        if step is not None and end / step > MOST_STEPS:
            rule = f"asks for {end / step:.2g} steps until integrator.end_time = {end!r}"
            _wrong(integrator, key, f"{rule}, at most {MOST_STEPS:,} are possible", "give a longer one", report)
    return len(report.problems) == before


def _wrong(integrator: Integrator, key: str, rule: str, remedy: str, report: Report) -> None:
    report.add(f"integrator.{key}", rule, remedy, getattr(integrator, key))


def _check_bounds(integrator: Integrator, given: list[str], report: Report) -> None:
    if method_of(integrator) not in pairs():
        rule = f'the method "{integrator.method}" does not estimate its error'
        report.add("integrator.tolerance", rule, f"take {listed(pairs(), 'or')}, or give integrator.step instead")
    steps = {key: float(getattr(integrator, key)) for key in given}
    for key, step in steps.items():
        if step > integrator.end_time:
            rule = f"is longer than the run, integrator.end_time = {integrator.end_time!r}"
            report.add(f"integrator.{key}", rule, "give a shorter one", step)
    for shorter, longer in (("min_step", "max_step"), ("min_step", "first_step"), ("first_step", "max_step")):
        if shorter in steps and longer in steps and steps[shorter] > steps[longer]:
            rule = f"is longer than integrator.{longer} = {steps[longer]!r}"
            report.add(f"integrator.{shorter}", rule, "give a shorter one", steps[shorter])


def may_change(integrator: Integrator) -> bool:
    """Whether steps have a continuous extension, on which events are found."""
    return integrator.coordinates not in COORDINATES and not METHODS[integrator.method].composed


def _changing(lists: Lists) -> str:
    """What of a scenario asks for places between the ends of steps, as it is written; "" if nothing does."""
    if lists["events"]:
        return "[[events]]"
    if lists["measures"] or any(is_formula(str(x.get("value"))) for x in lists["requirements"]):
        return "[[measures]]" if lists["measures"] else "[[requirements]]"
    if lists["limits"]:
        return "[[model.limits]]"
    if any("stiffness" not in contact for contact in lists["contacts"]):
        return "[[model.contacts]]"
    return "friction with static" if any("static" in force for force in lists["forces"]) else ""


def _switching(lists: Lists) -> str:
    """What of a scenario turns constraints on and off; "" if nothing does."""
    if any(event.get("action") in (*OPPOSITE, *OPPOSITE.values()) for event in lists["events"]):
        return "[[events]]"
    if any(joint.get("locked") is True for joint in lists["joints"]):
        return "locked = true"
    return _changing({**lists, "events": [], "measures": [], "requirements": []})


def _sliding(lists: Lists) -> bool:
    """Whether a rigid contact may slide with friction."""
    return any("stiffness" not in contact and contact.get("friction", 0) != 0 for contact in lists["contacts"])


def check_method(integrator: Integrator, lists: Lists, report: Report) -> None:
    """dexpinv and the group belong to exponential coordinates; a method of several exponentials has no dexpinv; neither
    it nor other coordinates have a continuous extension."""
    value, method, changing = integrator.coordinates, METHODS[integrator.method], _changing(lists)
    as_vectors, both = value in COORDINATES, "leave one of the two out"
    between = "integrator.tolerance" if integrator.tolerance is not None else changing
    if value != "lie" and integrator.group != R3xSO3.__name__:
        whose = "joints" if value == JOINT else "rotations alone"
        rule = f'are coordinates of {whose}, not of integrator.group = "{integrator.group}"'
        _wrong(integrator, "coordinates", rule, both, report)
    if as_vectors and method.composed:
        rule = f'have no exponentials for integrator.method = "{method.name}" to compose'
        remedy = f'give the method "{method.flat}", which it is in a vector space'
        _wrong(integrator, "coordinates", rule, remedy, report)
    if between and as_vectors:
        rule = f"says where a body is at the ends of given steps only, but {between} asks for more"
        _wrong(integrator, "coordinates", rule, f'give "lie", or leave {between} out', report)
    if changing and between == changing and method.composed:
        rule = f"says where a body is at the ends of steps only, but {changing} asks for more"
        _wrong(integrator, "method", rule, f'give "{method.flat}", or leave {changing} out', report)
    _check_series(integrator, _sliding(lists), report)
    if integrator.rho_infinity is not None and method.name != GENERALIZED_ALPHA.name:
        rule = f'is that of the method "{GENERALIZED_ALPHA.name}", not of "{method.name}"'
        _wrong(integrator, "rho_infinity", rule, "leave it out, or give that method", report)
    if method.implicit and as_vectors:
        rule = f'has no implicit steps, as integrator.method = "{method.name}" makes them'
        _wrong(integrator, "coordinates", rule, 'give "lie" or "joint", or an explicit method', report)
    if integrator.dexpinv is not None and as_vectors:
        _wrong(integrator, "dexpinv", f"is not used with integrator.coordinates = {show(value)}", both, report)
    if integrator.dexpinv is not None and method.composed:
        rule = f'is not used by integrator.method = "{method.name}", which needs none'
        _wrong(integrator, "dexpinv", rule, "leave it out", report)


def _check_series(integrator: Integrator, slides: bool, report: Report) -> None:
    """A series is that of the state: whichever coordinates a step might have, it would be the same; orders are its
    own. That of slow sliding ends where its direction turns, within any given step."""
    method = METHODS[integrator.method]
    if not method.series:
        if integrator.order is not None:
            rule = f'is that of a series, but the method "{method.name}" has one of its own: {method.order}'
            _wrong(integrator, "order", rule, f'leave it out, or give the method "{TAYLOR.name}"', report)
        return
    if slides and integrator.step is not None:
        rule = (
            f'is too long for the method "{method.name}" where [[model.contacts]] with friction begin or end to slide'
        )
        _wrong(integrator, "step", rule, "give integrator.tolerance instead, or another method", report)
    for key, default in {"group": R3xSO3.__name__, "coordinates": "lie", "dexpinv": None}.items():
        if getattr(integrator, key) not in (default, JOINT):
            rule = f'makes no difference to integrator.method = "{method.name}", the series of the state itself'
            _wrong(integrator, key, rule, "leave it out", report)


def check_projection(projection: Projection, integrator: Integrator | None, lists: Lists, report: Report) -> None:
    """Neither chords nor the embedded form are of joints, and none of the three of what is turned on and off."""
    switching = _switching(lists)
    turned = f"is not for constraints that are turned on and off, as {switching} asks for"
    joints = f'is not for integrator.coordinates = "{JOINT}", which projects joints'
    for rule, holds in ((turned, switching), (joints, integrator is not None and integrator.coordinates == JOINT)):
        if holds and projection.chord:
            report.add("projection.chord", rule, "leave it out", True)
        if holds and projection.position == "embedded":
            report.add("projection.position", rule, 'give "local" or "none"', projection.position)
    if switching and projection.baumgarte is not None:
        report.add("projection.baumgarte", turned, "leave it out", projection.baumgarte)
