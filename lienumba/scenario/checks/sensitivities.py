"""What is differentiated, and by which numbers."""

from lienumba.integrators.methods import METHODS
from lienumba.scenario.base import paths
from lienumba.scenario.base.problems import Report
from lienumba.scenario.base.toml import Keys
from lienumba.scenario.checks.integrator import method_of
from lienumba.scenario.checks.sweep import nominal_of
from lienumba.scenario.formulas.parameters import Parameters
from lienumba.scenario.schema.scenario import Integrator, Sensitivities
from lienumba.sweep.distributions.base import NUMBER

PLACE = "sensitivities"


def check_sensitivities(
    asked: Sensitivities, raw: Keys, model: Keys, parameters: Parameters, integrator: Integrator | None, report: Report
) -> None:
    """Check the section against the model as written."""
    sweep = raw.get("sweep")
    if "study" in raw:
        report.add(PLACE, "a study compares settings", "leave one of the two out")
    if asked.by is None and not (isinstance(sweep, dict) and sweep.get("vary")):
        remedy = 'give paths in sensitivities.by, such as "bodies.top.mass", or vary something'
        report.add(f"{PLACE}.by", "there is nothing to differentiate by, because the sweep varies nothing", remedy)
    for n, name in enumerate(asked.of):
        if name in asked.of[:n]:
            report.add(f"{PLACE}.of[{n}]", "is there twice", "remove one", name)
    seen: set[str] = set()
    for n, path in enumerate(asked.by or ()):
        place = f"{PLACE}.by[{n}]"
        try:
            number = nominal_of(path, model, parameters, NUMBER)
            if number is None:
                raise paths.PathError("has no number", "write it into the scenario")
            name = paths.canonical(path, model)
        except paths.PathError as error:
            report.problems.append(error.of(path).inside(place))
            continue
        if name in seen:
            report.add(place, "is there twice", "remove one", path)
        seen.add(name)
    if integrator is not None:
        _check_method(integrator, report)


def _check_method(integrator: Integrator, report: Report) -> None:
    name = method_of(integrator)
    method = METHODS.get(name)
    if method is not None and method.carries:
        rule = "has no derivatives of its steps"
        report.add("integrator.method", rule, 'give another method, such as "dop853", "rk4" or "radau5"', name)
    if integrator.engine is not None:
        report.add("integrator.engine", "knows no derivatives", "leave it out", integrator.engine)
