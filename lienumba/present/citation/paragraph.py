"""A paragraph for the section on methods of a publication: what a scenario, or a dataset, was computed with."""

from collections.abc import Callable, Iterable

from lienumba.integrators.methods import METHODS
from lienumba.integrators.methods.charts import GROUPS, JOINT
from lienumba.integrators.methods.comparators import COORDINATES
from lienumba.integrators.methods.tableau import Tableau
from lienumba.mechanics.elements.events import ends_run
from lienumba.mechanics.system.projection import WEIGHTS
from lienumba.present.citation.laws import contacts, events, laws
from lienumba.present.citation.runs import ends, sweep
from lienumba.present.citation.sampling import capital
from lienumba.present.citation.source import CitedScenario
from lienumba.scenario.base.toml import Tables
from lienumba.words import listed, number, plural

PACKAGES = {
    "python": "Python", "numpy": "NumPy", "scipy": "SciPy", "numba": "Numba", "xarray": "xarray",
}  # fmt: skip
CITED = {"numpy": "harris2020", "scipy": "virtanen2020", "numba": "lam2015", "xarray": "hoyer2017"}
ABSOLUTE_UNITS = {"position": "m", "rotation": "rad", "velocity": "m/s", "angular_velocity": "rad/s", "state": ""}


def paragraph(source: CitedScenario) -> str:
    """Plain text; references are marked [@key]."""
    parts: tuple[Callable[[CitedScenario], str], ...] = (
        _model,
        _group,
        _method,
        _constraints,
        laws,
        contacts,
        events,
        _study,
        sweep,
        ends,
        _software,
    )
    return " ".join(filter(None, (part(source) for part in parts)))


def _model(source: CitedScenario) -> str:
    model, title = source.content["model"], source.content["title"]
    kinds = {
        "bodies": ("rigid body", "rigid bodies"), "joints": ("joint", "joints"), "drivers": ("driver", "drivers"),
        "forces": ("force law", "force laws"), "limits": ("rigid stop", "rigid stops"),
        "contacts": ("contact", "contacts"),
    }  # fmt: skip
    parts = [plural(len(model[kind]), one, many) for kind, (one, many) in kinds.items() if model.get(kind)]
    name = f' "{title}"' if title else ""
    return f"The multibody system{name} ({listed(parts)}) was simulated with lienumba {_version(source)} [@lienumba]."


def _version(source: CitedScenario) -> str:
    return source.versions["lienumba"]


def _group(source: CitedScenario) -> str:
    coordinates, groups = source.values("integrator.coordinates"), source.values("integrator.group")
    model = source.content["model"]
    constrained = model["joints"] or model["drivers"]
    form = "as differential-algebraic equations of index 1 in state space" if constrained else "in state space"
    start = f"Its equations of Newton and Euler, formulated {form} [@terze2015], were integrated "
    ways = []
    if "lie" in coordinates:
        named = _or(GROUPS[name].words for name in groups)
        ways.append(f"on the Lie group of the states of all bodies, each with the group {named}")
    if JOINT in coordinates:
        ways.append("on the Lie group of the joints of a tree [@featherstone2008], loops closed by constraints")
    vectors = [COORDINATES[name].words for name in coordinates if name in COORDINATES]
    if vectors:
        ways.append(f"with rotations as vectors, namely {_or(vectors)}, which each step began anew")
    return f"{start}{', and for comparison '.join(ways)}."


def _method(source: CitedScenario) -> str:
    methods = [METHODS[name] for name in source.values("integrator.method")]
    named = listed([f"{method.words} of {_order(source, method)}" for method in methods])
    charts = not all(method.composed or method.series for method in methods)
    lie = "lie" in source.values("integrator.coordinates") and charts
    frame = f", in the framework of Munthe-Kaas [@munthekaas1998; @munthekaas1999]{_series(source)}" if lie else ""
    stopped = any(ends_run(event["action"]) for event in source.content.get("events", []))
    duration = f"over {'at most ' if stopped else ''}{_seconds(source, 'integrator.end_time')}"
    return f"The integrator was {named}{frame}, {_steps(source)}, {duration}."


def _order(source: CitedScenario, method: Tableau) -> str:
    if method.series:
        if given := source.values("integrator.order"):
            return f"order {_or(str(order) for order in given)}"
        if source.values("integrator.tolerance"):
            return "the order that the tolerance asks for"
    return f"order {method.order}"


def _series(source: CitedScenario) -> str:
    given = source.values("integrator.dexpinv")
    if not given:
        return ""
    ways = [
        "in closed form" if x == "closed" else f"cut behind {plural(x, 'commutator', 'commutators')}" for x in given
    ]
    return f" with the inverse of dexp {_or(ways)}"


def _steps(source: CitedScenario) -> str:
    integrator, ways = source.content["integrator"], []
    if source.values("integrator.step"):
        ways.append(f"with a fixed step of {_seconds(source, 'integrator.step')}")
    if source.values("integrator.tolerance"):
        limits = (("first_step", "the first tried"), ("min_step", "the shortest"), ("max_step", "the longest"))
        given = [f"{what} {number(integrator[key])} s" for key, what in limits if integrator.get(key) is not None]
        tolerances = _or(_tolerance(x) for x in source.values("integrator.tolerance"))
        ways.append(
            f"with steps that each run chose for an error per step of {tolerances}"
            + (f" ({', '.join(given)})" if given else "")
        )
    return " or ".join(ways)


def _tolerance(given: float | Tables) -> str:
    """Of one step: one number, or absolute errors of their own."""
    relative = number(given["relative"] if isinstance(given, dict) else given)
    absolute = given.get("absolute", {}) if isinstance(given, dict) else {}
    said = [
        f"{number(x)} {ABSOLUTE_UNITS[key]}".strip() + f" in {key.replace('_', ' ')}" for key, x in absolute.items()
    ]
    if len(said) < len(ABSOLUTE_UNITS):
        said.append(f"{relative} in SI units{' in all else' if said else ''}")
    return f"{relative} relative and {listed(said)} absolute"


def _constraints(source: CitedScenario) -> str:
    model = source.content["model"]
    if not model["joints"] and not model["drivers"]:
        return ""
    projected, rates = _projected(source), source.values("projection.baumgarte")
    said = []
    if projected:
        said.append(
            f"After every step the state was projected onto the constraints [@terze2015]: {'; '.join(projected)}."
        )
    if rates:
        each = _or(map(number, rates))
        said.append(
            f"Violations of the constraints were damped by Baumgarte's method [@baumgarte1972], rate {each} 1/s."
        )
    kept = [
        name
        for name, key in (("positions", "position"), ("velocities", "velocity"))
        if source.values(f"projection.{key}") == ["none"]
    ]
    if projected and kept:
        said.append(f"{capital(listed(kept))} were not projected.")
    return " ".join(said) or "Violations of the constraints were neither projected nor damped."


def _projected(source: CitedScenario) -> list[str]:
    """How positions and velocities were brought back."""
    forms = {"local": "in local coordinates of the rotations", "embedded": "in the elements of the rotation matrices"}
    positions = [forms[x] for x in source.values("projection.position") if x != "none"]
    velocities = [WEIGHTS[x].words for x in source.values("projection.velocity") if x != "none"]
    violation, most = (_or(map(number, source.values(f"projection.{key}"))) for key in ("tolerance", "max_iterations"))
    chord = ", the later ones by the elimination of the first" if source.values("projection.chord") == [True] else ""
    found = []
    if positions:
        found.append(f"positions {_or(positions)}, to a violation of {violation} m in at most {most} iterations{chord}")
    if velocities:
        found.append(f"velocities with {_or(velocities)} as weight")
    return found


def _study(source: CitedScenario) -> str:
    if not source.grids:
        return ""
    grids = "; ".join(
        " by ".join(f"{path} ({', '.join(map(_plain, values))})" for path, values in grid.items())
        for grid in source.grids
    )
    return (
        f"This was a study of the settings {grids}, compared with {_reference(source.content['study']['reference'])}."
    )


def _reference(reference: Tables) -> str:
    if "file" in reference or "sha256" in reference:
        return f"a dataset (sha256 {reference.get('sha256', 'unknown')})"
    if all(isinstance(x, dict) for x in reference.values()) and not any("." in key for key in reference):
        return "formulas of the motion"
    settings = ", ".join(f"{key.removeprefix('integrator.')} = {_plain(x)}" for key, x in reference.items())
    method = METHODS.get(str(reference.get("method", reference.get("integrator.method"))))
    return f"a reference solution ({settings}{f'; {method.words}' if method else ''})"


def _software(source: CitedScenario) -> str:
    named = [
        f"{name} {source.versions[key]}" + (f" [@{CITED[key]}]" if key in CITED else "")
        for key, name in PACKAGES.items()
        if key in source.versions
    ]
    return f"lienumba ran on {listed(named)}."


def _seconds(source: CitedScenario, path: str) -> str:
    return f"{_or(map(number, source.values(path)))} s"


def _or(words: Iterable[str]) -> str:
    return listed(dict.fromkeys(words), "or")


def _plain(value: object) -> str:
    return value if isinstance(value, str) else number(value) if isinstance(value, int | float | list) else str(value)
