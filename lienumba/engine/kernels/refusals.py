"""What a single call of kernels cannot step: refused before anything is compiled."""

from collections.abc import Iterator

from lienumba.errors import Problem, ScenarioError
from lienumba.integrators.methods import METHODS
from lienumba.mechanics.system.discontinuities import discontinuities
from lienumba.mechanics.system.switches import switches_of
from lienumba.scenario.resolve import Scenario
from lienumba.scenario.start.prepare import Nominal

INSTEAD = "or simulate it with lienumba.run"


def refuse(resolved: Scenario, nominal: Nominal) -> None:
    """Raise a ScenarioError with a sentence for each reason why steps need the driver."""
    problems = [*_of_the_method(resolved), *_of_the_model(resolved, nominal)]
    if problems:
        raise ScenarioError(*problems)


def _of_the_method(resolved: Scenario) -> Iterator[Problem]:
    integrator = resolved.data.integrator
    method = METHODS[integrator.method]
    if method.implicit or method.series:
        rule = "solves equations in each step" if method.implicit else "chooses its order in each step"
        yield Problem(
            "integrator.method", f"{rule}, so a step is no single call", f"give rk4, {INSTEAD}", integrator.method
        )
    elif integrator.step is None:
        remedy = f"give integrator.step, {INSTEAD}"
        yield Problem("integrator.tolerance", "lets each run choose its steps, so a step is no single call", remedy)


def _of_the_model(resolved: Scenario, nominal: Nominal) -> Iterator[Problem]:
    model = nominal.model
    for event in model.events[:1]:
        yield Problem(f"events.{event.name}", "acts inside of a step", f"look for it in your loop, {INSTEAD}")
    for switch in switches_of(model)[:1]:
        remedy = f"leave it out, give a contact a stiffness, {INSTEAD}"
        yield Problem(f"model: {switch.name}", "turns constraints on and off inside of a step", remedy)
    sampled = [force for force in model.forces if force.code is not None and force.code.every is not None]
    if sampled:
        remedy = f"let your loop write its command to a parameter, {INSTEAD}"
        yield Problem(f"forces.{sampled[0].name}.every", "samples the law between steps", remedy)
    elif resolved.data.model.noise:
        yield Problem("noise", "has kinks on which steps must end", f"draw it in your loop, {INSTEAD}")
    elif discontinuities(model, resolved.data.integrator.end_time):
        rule = "has functions of time with jumps or kinks on which steps must end"
        yield Problem("model", rule, f"let your loop write their values to parameters, {INSTEAD}")
