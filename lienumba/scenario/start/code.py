"""Laws of the user's own: what the scenario says of them becomes code of the model, tried once on symbols."""

import inspect
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from lienumba.compiler.foreign.calls import TRACED, called_by
from lienumba.compiler.symbols import COMPARISONS, Graph, Symbol, live
from lienumba.errors import BadValueError, ScenarioError
from lienumba.groups.state import ELEMENT
from lienumba.integrators.methods import METHODS
from lienumba.laws import Load
from lienumba.mechanics.elements import quantities, user_laws
from lienumba.mechanics.mechanism import kinematics
from lienumba.mechanics.mechanism.kinematics import Instant, Motion
from lienumba.mechanics.mechanism.model import GROUND, Code, Force, Model
from lienumba.mechanics.mechanism.model_numbers import map_numbers
from lienumba.numerics.jets import Jet, lift
from lienumba.scenario.base.code import line_of, said_of
from lienumba.scenario.schema.scenario import Integrator
from lienumba.scenario.start.repeats import check_repeats, needs_samples
from lienumba.words import listed, show, suggestion

REMEDIES = (  # of errors of Python, by what they say
    (
        "determine Numba type",
        "calls a function of Numba on a number of the state",
        "decorate it with @lienumba.jit instead",
    ),
    (
        "may not branch",
        "decides on a number of the state, which is known only while it runs",
        "write where(condition, number, other number), minimum, maximum or clip of lienumba.laws",
    ),
    ("ufunc", "calls NumPy on a number of the state", "use the functions and Vector of lienumba.laws"),
    (
        "real number",
        "needs an ordinary number, but this one is known only while it runs",
        "use the functions of lienumba.laws instead of math or NumPy",
    ),
    ("is not iterable", "needs a vector here: three numbers, or a Vector of lienumba.laws", ""),
    (
        "unsupported operand",
        "combines numbers in a way that a law cannot",
        "there are + - * / **, comparisons, and the functions of lienumba.laws",
    ),
)
POINTS, FRAMES = (
    (kinematics.AT_REST, kinematics.AT_REST),
    (kinematics.UNIT, kinematics.UNIT),
)  # any: the start decides them later
VELOCITIES = 12  # the first row of them in the state of a body
EXAMPLES = {"states": "states = { integral = ... }", "memory": "memory = { line = 200 }, and every"}  # of keys
BEND = 1e-6  # of a velocity-level law, relative to itself: above, it is not affine in the velocities


def code_of(
    place: str, reference: str, code: Code, seen: Sequence[str], parameters: Sequence[str], known: Sequence[str]
) -> Code:
    """The code of a law with what its function asks for; seen: its bodies and joints; parameters: their names;
    known: the quantities that it may ask for."""
    at = f"{place}.function"
    arguments = inspect.signature(code.function).parameters.values()
    for name, what in (("t", "the time"), ("states", "the states of the law"), ("memory", "the memory of the law")):
        if name in parameters and (name != "memory" or code.memory):
            raise ScenarioError.at(f"{place}.parameters.{name}", f"is the name of {what}", "give another name")
    has = {"t": True, "states": code.states, "memory": code.memory, "interval": code.every is not None}
    own = {name for name, given in has.items() if given}
    plain = [p for p in arguments if p.kind in (p.POSITIONAL_ONLY, p.POSITIONAL_OR_KEYWORD)]
    placed = [p.name for p in plain if p.name not in own and p.name not in parameters]
    any_number = any(p.kind == p.VAR_POSITIONAL for p in arguments)
    if len(placed) < len(seen) and not any_number:
        rule = f"has {len(placed)} arguments for {listed(seen)}, which it sees"
        raise ScenarioError.at(at, rule, "give it one for each of them", reference)
    names = () if any_number else tuple(placed[: len(seen)])
    by_name = {p.name for p in arguments if p.kind in (p.POSITIONAL_OR_KEYWORD, p.KEYWORD_ONLY)}
    asked = by_name - set(placed if any_number else names)
    open_ended = any(p.kind == p.VAR_KEYWORD for p in arguments)
    for name in parameters:
        if name not in asked and not open_ended:
            rule, remedy = "the function has no argument of this name", suggestion(name, sorted(asked))
            raise ScenarioError.at(f"{place}.parameters.{name}", rule, remedy)
    needed = {p.name for p in arguments if p.name in asked and p.default is p.empty}
    missing = sorted(needed - {*parameters, *own, *known})
    if missing:
        given = f"neither {' nor '.join(sorted(own, reverse=True))}, nor a quantity, nor one of {place}.parameters"
        example = EXAMPLES.get(missing[0], f"parameters = {{ {missing[0]} = ... }}")
        raise ScenarioError.at(at, f"has the argument {missing[0]}, which is {given}", f"give {example}", reference)
    return replace(
        code,
        names=names,
        wants=frozenset(asked & own),
        quantities=frozenset(asked & set(known) - set(parameters)),
    )


def tried(model: Model) -> Model:
    """The model with the rows of its own joints counted; a ScenarioError if one of its laws does not work."""
    if all(joint.code is None for joint in model.joints) and all(force.code is None for force in model.forces):
        return model
    placed = replace(model, joints=tuple(replace(j, points=j.points or POINTS, frames=FRAMES) for j in model.joints))
    graph = Graph()
    numbers = list[Any]()

    def slot(number: Any, structural: bool = False) -> Symbol:
        numbers.append(number)
        return graph.input("parameters", len(numbers) - 1)

    symbolic = map_numbers(placed, slot, slot)
    now = _state(symbolic, graph)
    returned = [[] if force.code is None else _try_force(symbolic, force, now) for force in symbolic.forces]
    initial = [x for force in placed.forces for x in _initial(force)]
    for force, values in zip(placed.forces, returned, strict=True):
        if force.code is not None:
            check = partial(check_repeats, values, numbers, initial)
            _called(f"model.forces.{force.name}", force.code, check)
    codes = [None if j.code is None else _tried_joint(symbolic, n, now) for n, j in enumerate(placed.joints)]
    first = map_numbers(placed, _first)
    for n, code in enumerate(codes):
        if code is not None and code.level == "velocity":
            _check_affine(first, n)
    forces = (
        force if force.code is None else replace(force, code=replace(force.code, untraced=called_by(values)))
        for force, values in zip(model.forces, returned, strict=True)
    )
    joints = (replace(j, code=c) for j, c in zip(model.joints, codes, strict=True))
    return replace(model, joints=tuple(joints), forces=tuple(forces))


def check_derivatives(model: Model, integrator: Integrator) -> None:
    """A ScenarioError for a law that has no derivatives at all times, with a method that needs them."""
    if not (METHODS[integrator.method].series or METHODS[integrator.method].implicit):
        return
    for force in model.forces:
        if force.code is not None and force.code.untraced and force.code.every is None:
            rule = f'integrator.method = "{integrator.method}" differentiates it, but it calls {force.code.untraced[0]}'
            remedy = f"sample it (every), choose an explicit method, or {TRACED}"
            raise ScenarioError.at(f"model.forces.{force.name}", f"{rule}, which is not traced", remedy)


def _first(number: object, structural: bool) -> Any:
    """A number of the first run."""
    return number if isinstance(number, float | int) else float(np.asarray(number).flat[0])


def _try_force(model: Model, force: Force, now: Instant) -> list[Any]:
    """Try a law; what it returns."""
    assert force.code is not None
    place = f"model.forces.{force.name}"
    if force.code.returns == user_laws.POTENTIAL:
        _check_levels(place, model, force.code, quantities.POSITION)
        ends = user_laws.ends_of(model, force.code, force.bodies, force.numbers)
        found = _called(place, force.code, lambda: user_laws.energy(model, force, now, kinematics.still(now, ends)))
        again = _called(place, force.code, lambda: user_laws.energy(model, force, now, kinematics.still(now, ends)))
        if not _is_number(found):
            rule = f"must return one number, a potential energy in J, but returns {_kind(found)}"
            raise ScenarioError.at(place, rule, 'return the energy, or write returns = "loads"')
        _check_same(place, [found], [again])
        _refuse_untraced(place, [found], "a potential energy", "return loads instead")
        _refuse_velocities(place, [found], "a potential energy depends on positions only", "return loads instead")
        return []
    _check_levels(place, model, force.code, quantities.VELOCITY)
    loads, rates = _called(place, force.code, lambda: user_laws.outcome(model, force, now))
    loads_again, rates_again = _called(place, force.code, lambda: user_laws.outcome(model, force, now))
    for load in loads:
        for x in (*load.value, *load.at):
            if not _is_number(x):
                raise ScenarioError.at(
                    place, f"the {load.kind} must be made of numbers, but has {_kind(x)}", "correct it"
                )
    sizes = [(f"the state {name}", 1) for name in force.code.states]
    names = [name for name, size in (*sizes, *((f"memory.{x}", n) for x, n in force.code.memory)) for _ in range(size)]
    for name, x in zip(names, rates, strict=True):
        if not _is_number(x):
            raise ScenarioError.at(place, f"{name} needs a number, but gets {_kind(x)}", "correct it")
    returned = [*_numbers(loads), *rates]
    _check_same(place, returned, [*_numbers(loads_again), *rates_again])
    name, why = needs_samples(returned)
    if name and force.code.every is None:
        raise ScenarioError.at(place, f"calls {name}, which {why}, but is not sampled", "give every, an interval in s")
    return returned


def _initial(force: Force) -> list[Any]:
    """The initial states of a law, and its memory."""
    return [] if force.code is None else list(user_laws.initial(force))


def _numbers(loads: Sequence[Load]) -> list[Any]:
    return [x for load in loads for x in (*load.value, *load.at)]


def _check_same(place: str, once: Sequence[Any], twice: Sequence[Any]) -> None:
    """A law is run once and compiled: it must say the same whenever it is asked."""
    same = [a is b or (_is_float(a) and repr(a) == repr(b)) for a, b in zip(once, twice, strict=False)]
    if len(once) != len(twice) or not all(same):
        raise ScenarioError.at(
            place,
            "the function returns something else each time that it is called",
            "it must depend on nothing but its arguments (no random numbers, no counters)",
        )


def _tried_joint(model: Model, index: int, now: Instant) -> Code:
    joint = model.joints[index]
    assert joint.code is not None
    place = f"model.joints.{joint.name}"
    _check_levels(place, model, joint.code, quantities.POSITION)
    ends = user_laws.ends_of(model, joint.code, joint.bodies, joint.numbers)
    rows = _called(place, joint.code, lambda: user_laws.residual(model, index, kinematics.still(now, ends)))
    again = _called(place, joint.code, lambda: user_laws.residual(model, index, kinematics.still(now, ends)))
    for row in rows:
        if not _is_number(row):
            raise ScenarioError.at(place, f"must return numbers that vanish where it holds, but returns {_kind(row)}")
    if not rows:
        raise ScenarioError.at(place, "returns no equation", "return one number or several that vanish where it holds")
    _check_same(place, rows, again)
    _refuse_untraced(place, rows, "an equation of a joint", TRACED)
    level = joint.code.level
    for row in rows:
        if not _reads(row, 0 if level == "position" else VELOCITIES):
            what = (
                "the bodies; correct" if level == "position" else 'velocities; leave level = "velocity" out, or correct'
            )
            raise ScenarioError.at(place, f"an equation does not depend on {what} the function")
    kinds = joint.code.returns or "m" * len(rows)
    if len(kinds) != len(rows):
        raise ScenarioError.at(
            f"{place}.rows", f"has {len(kinds)} entries for {len(rows)} equations", "give one for each"
        )
    if joint.code.level == "position":
        _refuse_velocities(place, rows, "a constraint of positions may not", 'give level = "velocity"')
    return replace(joint.code, returns=kinds)


def _called(place: str, code: Code, call: Callable[[], Any]) -> Any:
    """What a call returns; a ScenarioError with the line of the user's file if it does not work."""
    file = code.function.__code__.co_filename
    try:
        return call()
    except user_laws.LawError as error:
        raise ScenarioError.at(place, f"{code.function.__name__}: {error}") from None
    except BadValueError as error:
        raise ScenarioError(error.at(place)) from None
    except (Exception, SystemExit) as error:
        name, line = f"{code.function.__name__} in {file}", line_of(error, file)
        known = next((known for sign, *known in REMEDIES if sign in str(error)), None)
        if known is not None:
            rule, remedy = known
            raise ScenarioError.at(place, f"{name}, {line or 'it'} {rule}", remedy) from None
        raise ScenarioError.at(place, f"{name}, {said_of(error, file)}", "correct it") from None


def _state(model: Model, graph: Graph) -> Instant:
    """A state of symbols, with whatever states of laws."""
    bodies = tuple(tuple(graph.inputs("state", ELEMENT, ELEMENT * i)) for i in range(len(model.bodies)))
    first, states = 0, {}
    for force in model.forces:
        if force.code is not None and force.code.kept:
            states[force.name] = tuple(graph.inputs("extra", force.code.kept, first))
            first += force.code.kept
    return Instant(bodies, graph.input("clock", 0), states=states)


def _check_levels(place: str, model: Model, code: Code, allowed: int) -> None:
    for quantity in model.quantities:
        if quantity.name in code.quantities:
            names = [quantities.joined(quantity.name, c) for c in quantities.components(model, quantity)]
            level = max(quantities.level(model, name) for name in names)
            if level > allowed:
                why, remedy = "which follows from the forces themselves", "read positions and velocities"
                if level != quantities.OBSERVED:
                    why, remedy = quantities.kind_of(quantity).instead(model, quantity)
                raise ScenarioError.at(place, f"reads the quantity {quantity.name}, {why}", remedy)


def _refuse_velocities(place: str, rows: Sequence[Any], why: str, remedy: str) -> None:
    if any(_reads(row, VELOCITIES) for row in rows):
        raise ScenarioError.at(place, f"depends on velocities, but {why}", remedy)


def _refuse_untraced(place: str, rows: Sequence[Any], what: str, remedy: str) -> None:
    if names := called_by(rows):
        raise ScenarioError.at(place, f"{what} is differentiated, but calls {names[0]}, which is not traced", remedy)


def _reads(row: object, first: int) -> bool:
    """Whether a number depends on rows of a body's state from this one on."""
    for node in live((row,)):
        for x in (node, *node.args):
            if getattr(x, "op", "") == "input" and x.args[0] == "state" and x.args[1] % ELEMENT >= first:
                return True
    return False


def _check_affine(model: Model, index: int) -> None:
    """psi may have no curvature along velocities."""
    joint = model.joints[index]
    assert joint.code is not None
    place, ends = f"model.joints.{joint.name}", user_laws.ends_of(model, joint.code, joint.bodies, joint.numbers)
    bodies = tuple(tuple(0.3 + 0.17 * ((7 * i + 5 * n) % 11) for n in range(ELEMENT)) for i in range(len(model.bodies)))
    view = kinematics.still(Instant(bodies), ends)
    jets = {
        i: Motion(m.r, m.R, *(tuple(Jet(x, 0.4 + 0.3 * n) for n, x in enumerate(v)) for v in (m.v, m.w)))
        for i, m in view.motions.items()
        if i != GROUND
    }
    for row in user_laws.residual(model, index, replace(view, motions=jets)):
        x = lift(row)
        if not abs(x.c) <= BEND * (abs(x.a) + abs(x.b)):
            raise ScenarioError.at(
                place,
                (
                    "must be affine in the velocities (a sum of velocities times functions of positions and t), but "
                    "is not"
                ),
                "rewrite it, or use a force",
            )


def _is_number(x: object) -> bool:
    return _is_float(x) or (isinstance(x, Symbol) and x.op not in COMPARISONS)


def _is_float(x: object) -> bool:
    return isinstance(x, float | int) and not isinstance(x, bool)


def _kind(x: object) -> str:
    if getattr(x, "op", "") in COMPARISONS:
        return "a comparison"
    return "nothing" if x is None else f"{show(x)}" if isinstance(x, str | bool) else f"a {type(x).__name__}"
