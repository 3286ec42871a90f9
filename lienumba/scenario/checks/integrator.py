"""How a method makes its steps: of a length that is given, or as long as a tolerance of the error allows."""

from typing import TYPE_CHECKING

from lienumba.integrators.methods import DEFAULT_PAIR, METHODS
from lienumba.integrators.methods.generalized_alpha import DAMPING, GENERALIZED_ALPHA
from lienumba.integrators.methods.taylor import order_for
from lienumba.scenario.schema.scenario import Integrator, Tolerance
from lienumba.words import listed

if TYPE_CHECKING:
    from lienumba.scenario.base.problems import Report

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


def check_integrator(integrator: Integrator, report: "Report") -> bool:
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


def _check_bounds(integrator: Integrator, given: list[str], report: "Report") -> None:
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
