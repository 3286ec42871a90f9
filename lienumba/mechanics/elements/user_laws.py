"""Laws that a user writes as Python functions: what they are given, and what is made of what they return.

Positional: the law's bodies, then its joints; by name, as far as the function asks for them: t, its states, its
memory, the interval at which it is sampled, its parameters, quantities, and the states of other laws. A law with
states returns what it does together with the rates of its states, or where it is sampled with their new values; in
between, what it does is held as it was returned.
"""

from collections.abc import Sequence
from dataclasses import replace
from itertools import islice
from types import SimpleNamespace
from typing import Any

from lienumba import laws
from lienumba.errors import ScenarioError
from lienumba.groups import so3
from lienumba.mechanics.elements import joints
from lienumba.mechanics.elements.quantities import bodies_of, component, components, evaluate, rows
from lienumba.mechanics.mechanism import kinematics
from lienumba.mechanics.mechanism.kinematics import Instant, View
from lienumba.mechanics.mechanism.model import GROUND, Code, Coordinate, Force, Model
from lienumba.numerics.jets import lift
from lienumba.numerics.number import Number

LOADS, POTENTIAL = "loads", "potential"


class States:
    """The states of a law, or the arrays of its memory, by their names."""

    def __init__(self, values: dict[str, Any], what: str = "state") -> None:
        self.__dict__.update(values, _States__what=what)

    def __setattr__(self, name: str, value: Any) -> None:
        array = self.__dict__.get(name)
        if not isinstance(array, laws.Memory):
            raise AttributeError(f"a law does not set its {self.__what} {name}, but returns it")
        array[:] = value

    def __getattr__(self, name: str) -> Any:
        known = ", ".join(x for x in self.__dict__ if not x.startswith("_"))
        raise AttributeError(f"the law has no {self.__what} {name}; it has {known}")


class LawError(TypeError):
    """A law that does not return what it should; the message says what it must return."""


def ends_of(model: Model, code: Code, bodies: Sequence[int], numbers: dict[str, Any]) -> tuple[int, ...]:
    """The bodies (indices) whose motion it sees."""
    ends = [*bodies, *(i for j in code.joints for i in model.joints[j].bodies)]
    for quantity in model.quantities:
        if quantity.name in code.quantities:
            ends += [*quantity.bodies, quantity.relative_to, quantity.frame, *bodies_of(model, quantity.value)]
            ends += model.joints[quantity.joint].bodies if quantity.joint >= 0 else ()
    ends += bodies_of(model, *numbers.values())
    return tuple(dict.fromkeys(i for i in ends if i != GROUND))


def call(
    model: Model,
    code: Code,
    bodies: Sequence[int],
    numbers: dict[str, Any],
    view: View,
    states: Sequence[Any] = (),
    memory: dict[str, laws.Memory] | None = None,
) -> Any:
    """What the function returns. It writes to its memory."""
    given = [_body(view, i) for i in bodies] + [_joint(model, view, j, code.returns == LOADS) for j in code.joints]
    named = {name: evaluate(model, x, view) for name, x in numbers.items()}
    for quantity in model.quantities:
        if quantity.name in code.quantities:
            names = components(model, quantity)
            named[quantity.name] = _namespace(dict(zip(names, rows(model, quantity, view), strict=True)))
    for force in model.forces:
        if force.name in code.quantities:
            named[force.name] = States({name: component(model, f"{force.name}.{name}", view) for name in force.initial})
    if "t" in code.wants:
        named["t"] = view.t
    if "interval" in code.wants:
        named["interval"] = code.every
    if "states" in code.wants:
        named["states"] = States(dict(zip(code.states, states, strict=True)))
    if "memory" in code.wants:
        named["memory"] = States(memory or {}, "memory")
    if code.names:
        return code.function(**dict(zip(code.names, given, strict=True)), **named)
    return code.function(*given, **named)


def _body(view: View, i: int) -> laws.Body:
    m, v = view[i], laws.Vector.of
    return laws.Body(i, v(m.r), tuple(m.R), v(m.v), v(m.w))


def _joint(model: Model, view: View, j: int, rates: bool) -> laws.Joint:
    found = {}
    for kind in joints.coordinate_kinds(model.joints[j].type):
        which = Coordinate(j, kind)
        found[kind] = joints.coordinate(model, which, view)
        if rates:
            found[joints.freedom(model, which).rate] = joints.rate(model, which, view)
    return laws.Joint(j, **found)


def _namespace(values: dict[str, Any]) -> Any:
    """{"force.x": 1} as an object with .force.x; a single number without a name as it is."""
    if "" in values:
        return values[""]
    tree: dict[str, Any] = {}
    for name, x in values.items():
        *above, last = name.split(".")
        node = tree
        for part in above:
            node = node.setdefault(part, {})
        node[last] = x
    return SimpleNamespace(**{k: SimpleNamespace(**x) if isinstance(x, dict) else x for k, x in tree.items()})


# ---------------------------------------------------------------- joints
def residual(model: Model, index: int, view: View) -> tuple[Any, ...]:
    """The rows of a joint of the user's own."""
    joint = model.joints[index]
    assert joint.code is not None
    found = call(model, joint.code, joint.bodies, joint.numbers, view)
    return tuple(found) if isinstance(found, tuple | list | laws.Vector) else (found,)


# ---------------------------------------------------------------- forces
def outcome(model: Model, force: Force, now: Instant) -> tuple[list[laws.Load], list[Any]]:
    """The loads of a law and the rates of its states, or if it is sampled its new states and its new memory."""
    assert force.code is not None
    ends = ends_of(model, force.code, force.bodies, force.numbers)
    view = kinematics.still(now, ends)
    numbers = states_of(force, now)
    states, rest = numbers[: len(force.code.states)], iter(numbers[len(force.code.states) :])
    memory = {name: laws.Memory(islice(rest, size)) for name, size in force.code.memory}
    found = call(model, force.code, force.bodies, force.numbers, view, states, memory)
    kept = [x for array in memory.values() for x in array]
    if not force.code.states:
        return _loads(found), kept
    if not isinstance(found, tuple) or len(found) != 2:
        raise LawError(
            "it has states, so it must return a pair: its loads, and the rates (or new values) of its states"
        )
    return _loads(found[0] or []), [*_rates(found[1], force.code.states), *kept]


def _loads(found: Any) -> list[laws.Load]:
    if found is None:
        raise LawError("it returns nothing; return its loads, or [] where it does nothing")
    listed = [found] if isinstance(found, laws.Load) else found
    if not isinstance(listed, list | tuple) or not all(isinstance(x, laws.Load) for x in listed):
        raise LawError(
            "it must return loads, made with body.force(...), body.torque(...) or joint.effort(...): one, several, none"
        )
    for load in listed:
        if len(load.value) != (1 if load.kind == "effort" else 3) or len(load.at) != 3:
            raise LawError(f"the {load.kind} that it returns must have 3 numbers, and so must the point where it acts")
    return list(listed)


def _rates(found: Any, names: Sequence[str]) -> list[Any]:
    if isinstance(found, dict):
        if set(found) != set(names):
            raise LawError(f"it must return one number for each of its states, {', '.join(names)}")
        return [found[name] for name in names]
    listed = list(found) if isinstance(found, tuple | list) else [found]
    if len(listed) != len(names):
        raise LawError(f"it must return one number for each of its states, {', '.join(names)}")
    return listed


def states_of(force: Force, now: Instant) -> tuple[Any, ...]:
    """Its states and its memory, then what it holds of its loads if it is sampled; as at the start if not yet known."""
    found: tuple[Any, ...] = now.states.get(force.name) or initial(force)
    return found


def initial(force: Force) -> tuple[Any, ...]:
    """Its states at the start, behind them its memory."""
    kept = 0 if force.code is None else force.code.kept
    return (*force.initial.values(), *[0.0] * (kept - len(force.initial)))


def numbers_of(load: laws.Load) -> tuple[Number, ...]:
    """What a sample keeps of a load: its value, and where a force acts."""
    return (*load.value, *load.at) if load.kind == "force" else load.value


def acting(model: Model, force: Force, now: Instant) -> list[laws.Load]:
    """The loads now: those of the last sample where the law is sampled and has been."""
    assert force.code is not None
    found = outcome(model, force, now)[0]
    sampled = list(states_of(force, now)[force.code.kept :])
    if force.code.every is None or not sampled:
        return found
    kept = []
    for load in found:
        numbers = [sampled.pop(0) for _ in numbers_of(load)]
        size = len(load.value)
        kept.append(replace(load, value=tuple(numbers[:size]), at=tuple(numbers[size:]) or load.at))
    return kept


def generalized(model: Model, force: Force, now: Instant) -> tuple[dict[int, list[Any]], Any]:
    """Q by body (6 rows each), and the power that comes from no potential."""
    assert force.code is not None
    ends = ends_of(model, force.code, force.bodies, force.numbers)
    Q: dict[int, list[Any]] = {}
    if force.code.returns == POTENTIAL:
        for i in ends:
            column = kinematics.columns(lambda v: (energy(model, force, now, v),), kinematics.still(now, ends), i)[0]
            Q[i] = [-x for x in column]
        return Q, lift(energy(model, force, now, kinematics.waiting(now, ends))).b
    power: Any = 0.0
    view = kinematics.still(now, tuple(range(len(now.bodies))))
    for load in acting(model, force, now):
        for i, row in _rows(model, load, now, view):
            old = Q.get(i, [0.0] * 6)
            Q[i] = [a + b for a, b in zip(old, row, strict=True)]
            for u, x in zip(now.bodies[i][12:18], row, strict=True):
                power = power + u * x
    return Q, power


def unsampled(model: Model) -> Model:
    """The model whose sampled laws act at every time, and whose states follow what each sample would make of them,
    (s' - s)/interval: it rests where samples change nothing. A ScenarioError for one without derivatives."""
    forces = []
    for force in model.forces:
        if force.code is not None and force.code.every is not None:
            if force.code.untraced:
                rule = f"an equilibrium differentiates it, but it calls {force.code.untraced[0]}, which is not traced"
                from lienumba.compiler.foreign.calls import TRACED

                raise ScenarioError.at(f"model.forces.{force.name}", rule, TRACED)
            if force.code.memory:
                rule = "has a memory, and an equilibrium looks for states alone"
                raise ScenarioError.at(f"model.forces.{force.name}.memory", rule, "keep what settles in states")
            force = replace(force, code=_flowing(force.code, force.code.every))
        forces.append(force)
    return replace(model, forces=tuple(forces))


def _flowing(code: Code, every: float) -> Code:
    def function(*given: Any, **named: Any) -> Any:
        old = named.pop("states")
        own = {name: x for name, x in (("states", old), ("interval", every)) if name in code.wants}
        found = code.function(*given, **named, **own)
        if not code.states or not isinstance(found, tuple) or len(found) != 2:
            return found
        new = dict(zip(code.states, _rates(found[1], code.states), strict=True))
        return found[0], {name: (x - getattr(old, name)) / every for name, x in new.items()}

    return replace(code, function=function, wants=(code.wants - {"interval"}) | {"states"}, every=None)


def energy(model: Model, force: Force, now: Instant, view: View) -> Any:
    """What a law that returns a potential energy returns (J)."""
    assert force.code is not None
    return call(model, force.code, force.bodies, force.numbers, view)


def _rows(model: Model, load: laws.Load, now: Instant, view: View) -> list[tuple[int, list[Any]]]:
    """The generalised forces of one load: by body, force in the global and torque in the body's frame."""
    if load.kind == "effort":
        which = Coordinate(load.target, load.coordinate)
        ends = tuple(dict.fromkeys(model.joints[load.target].bodies))
        blocks = [
            (i, kinematics.columns(lambda v: (joints.coordinate(model, which, v),), kinematics.still(now, ends), i)[0])
            for i in ends
            if i != GROUND
        ]
        return [(i, [x * load.value[0] for x in row]) for i, row in blocks]
    if load.target == GROUND:
        return []
    R = view[load.target].R
    globally = so3.rotate(R, load.value) if load.frame == "body" else load.value
    locally = load.value if load.frame == "body" else so3.rotate_back(R, load.value)
    if load.kind == "torque":
        return [(load.target, [0.0, 0.0, 0.0, *locally])]
    return [(load.target, [*globally, *so3.cross(load.at, locally)])]
