"""What of a mechanism is linearised beside its equations: rates of constraints, how bodies move, quantities, and inputs
that are added to numbers of forces and drivers.

An input u(t) is known at one time by its value and two derivatives: u + u' (t' - t) + u'' (t' - t)^2 / 2. A force sees
the value alone; what a driver prescribes moves with all three.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

from lienumba.errors import ScenarioError
from lienumba.groups import so3
from lienumba.integrators.tracing.linear.equations import More
from lienumba.integrators.tracing.tracer import Posture as Still
from lienumba.mechanics.elements import quantities
from lienumba.mechanics.elements.quantities import joined
from lienumba.mechanics.mechanism import kinematics
from lienumba.mechanics.mechanism.model import GROUND, Law, Model, at_time
from lienumba.mechanics.mechanism.moves import Ball, Free
from lienumba.mechanics.tree.links import Link, Tree
from lienumba.mechanics.tree.motion import state_of
from lienumba.mechanics.tree.posture import Posture
from lienumba.numerics.number import Number

DERIVATIVES = ("", ".rate", ".acceleration")  # of an input, behind its name
DRIVEN = "value"  # what the model calls what a driver prescribes


@dataclass(frozen=True)
class Input:
    """A number of a force or driver (index), at a key, and its component there."""

    name: str
    kind: str
    index: int
    key: str
    component: int

    def added(self, model: Model, number: Any) -> Model:
        """The model with something added to it."""
        if self.kind == "drivers":
            driver = model.drivers[self.index]
            value = tuple(_sum(x, number) if n == self.component else x for n, x in enumerate(driver.value))
            drivers = [replace(driver, value=value) if n == self.index else x for n, x in enumerate(model.drivers)]
            return replace(model, drivers=tuple(drivers))
        force = model.forces[self.index]
        own = force.numbers[self.key]
        if isinstance(own, tuple):
            new: Any = tuple(_sum(x, number) if n == self.component else x for n, x in enumerate(own))
        else:
            new = _sum(own, number)
        changed = replace(force, numbers={**force.numbers, self.key: new})
        forces = [changed if n == self.index else x for n, x in enumerate(model.forces)]
        return replace(model, forces=tuple(forces))


def inputs_of(model: Model, names: Sequence[str] | None) -> list[Input]:
    """The inputs of some names, such as "forces.motor.value", "drivers.crank" or "forces.push.value[2]"; by default
    every formula of a force and everything that is driven."""
    every = {x.name: x for x in _every(model)}
    if names is None:
        return [x for x in every.values() if x.kind == "drivers" or callable(_number(model, x))]
    inputs = []
    for name in names:
        own = [x for x in every.values() if x.name == name or x.name.partition("[")[0] == name]
        if not own:
            choice = f"choose from {', '.join(every)}" if every else "give [[model.forces]] or [[model.drivers]]"
            raise ScenarioError.at("inputs", "must name numbers of forces and drivers", choice, name)
        inputs += own
    return inputs


def _number(model: Model, x: Input) -> Any:
    own = model.forces[x.index].numbers[x.key]
    return own[x.component] if isinstance(own, tuple) else own


def _every(model: Model) -> list[Input]:
    inputs: list[Input] = []
    for index, force in enumerate(model.forces):
        for key, own in force.numbers.items() if force.code is None else ():
            inputs += _components(f"forces.{force.name}.{key}", "forces", index, key, own)
    for index, driver in enumerate(model.drivers):
        own = driver.value if len(driver.value) > 1 else driver.value[0]
        inputs += _components(f"drivers.{driver.name}", "drivers", index, DRIVEN, own)
    return inputs


def _components(name: str, kind: str, index: int, key: str, own: Any) -> list[Input]:
    if isinstance(own, tuple):
        return [Input(f"{name}[{n}]", kind, index, key, n) for n in range(len(own))]
    return [Input(name, kind, index, key, 0)]


def _sum(x: Any, more: Any) -> Any:
    """A number, function of time, or law, with a function of time added."""
    if isinstance(x, Law):
        return replace(x, function=lambda t, **named: x.function(t, **named) + more(t))
    return lambda t: at_time(x, t) + more(t)


@dataclass(frozen=True)
class LinearOutputs(More):
    """inputs: those that are added; seen: names of components of quantities."""

    added: tuple[Input, ...]
    seen: tuple[str, ...]

    @property
    def inputs(self) -> int:
        return len(DERIVATIVES) * len(self.added)

    def model(self, model: Model, t: Any, inputs: Sequence[Any]) -> Model:
        for n, x in enumerate(self.added):
            u, rate, bend = inputs[len(DERIVATIVES) * n : len(DERIVATIVES) * (n + 1)]

            def course(now: Any, u: Any = u, rate: Any = rate, bend: Any = bend) -> Any:
                later = now - t
                return u + later * (rate + 0.5 * (later * bend))

            model = x.added(model, course)
        return model

    def outputs(self, model: Model, posture: Still, mask: list[Any], used: Sequence[int]) -> dict[str, list[Any]]:
        assert isinstance(posture, Posture)
        now = posture.now
        view = kinematics.still(now, tuple(range(len(now.bodies))))
        return {
            **super().outputs(model, posture, mask, used),
            "bodies": [x for body in now.bodies for x in (*body[12:15], *so3.rotate(body[3:12], body[15:18]))],
            "axes": [x for link in turning_links(posture.tree) for x in _axes(posture, link)],
            "seen": [quantities.component(model, name, view) for name in self.seen],
        }


def turning_links(tree: Tree) -> list[Link]:
    """The links of balls and free bodies, whose last three coordinates turn about own axes."""
    return [link for link in tree.links if isinstance(link.move, Ball | Free)]


def _axes(posture: Posture, link: Link) -> tuple[Number, ...]:
    """The own axes of a link as columns along those of what it hangs on, and its angular velocity against that, along
    them."""
    parent = so3.IDENTITY if link.parent == GROUND else posture.links[link.parent].R
    E = so3.multiply(so3.transpose(parent), posture.links[posture.tree.links.index(link)].R)
    w = state_of(link, tuple(posture.z))[-3:]
    return (*E, *so3.rotate(E, w))


def visible(model: Model, names: Sequence[str] | None) -> list[str]:
    """The components of some quantities; by default of all that need no more than positions and velocities."""
    every = {q.name: [joined(q.name, x) for x in quantities.components(model, q)] for q in model.quantities}
    known = [x for own in every.values() for x in own if quantities.level(model, x) < quantities.OBSERVED]
    if names is None:
        return known
    components: list[str] = []
    for name in names:
        own = [x for x in known if x == name or x in every.get(name, ())]
        if not own:
            choice = f"choose from {', '.join(known)}" if known else "give [[model.quantities]]"
            rule = "must name quantities of positions and velocities"
            raise ScenarioError.at("outputs", rule, choice, name)
        components += own
    return components
