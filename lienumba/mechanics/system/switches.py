"""Switched constraints: rows of C that a run may turn on and off.

They stand behind the permanent rows, switch by switch: joints that events release or engage, locks of coordinates,
rigid stops, contacts, and joint friction that sticks. What is on is a number in the state of a run.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

from lienumba.mechanics.elements.joints import JOINTS
from lienumba.mechanics.elements.locks import BALL
from lienumba.mechanics.mechanism.kinematics import OFF, Mode, Modes
from lienumba.mechanics.mechanism.model import Force, Lock, Model, once_per_model
from lienumba.numerics.number import Number
from lienumba.numerics.operations import is_zero

JOINT, LOCK, LIMIT, CONTACT, FRICTION = "joint", "lock", "limit", "contact", "friction"  # what a switch is
KINDS = {JOINT: 0, LOCK: 0, LIMIT: 1, CONTACT: 1, FRICTION: 2}  # BILATERAL, UNILATERAL, FRICTION of `layout`
MATRIX = 9
RIGID = (0.0, 0.0, 1.0)  # how a contact compliant that nothing else holds: see `laws.compliance`


@dataclass(frozen=True)
class Switch:
    """what: one of the above; index: of the joint, lock, limit, contact or force; first: of its rows among all switched
    ones; tangents: how many of them, the last ones, are along the sliding; memory: its first number of those of all,
    and how many; on: as it starts, before anything touches or sticks; shares: whether it shares what it carries with
    others that say the same: contacts do where any of them has friction; compliant: whether it remembers how, as it
    does with friction beside others."""

    what: str
    name: str
    index: int
    first: int
    rows: int
    tangents: int
    memory: int
    memories: int
    on: int
    shares: bool = False
    compliant: bool = False

    @property
    def key(self) -> tuple[str, str]:
        """By which modes know it."""
        return self.what, self.name

    @property
    def unilateral(self) -> bool:
        """Whether it is a stop or a contact."""
        return self.what in (LIMIT, CONTACT)

    @property
    def numbers(self) -> tuple[int, ...]:
        """The numbers of the switch for drivers: see `lienumba.integrators.layout`."""
        grip = self.memory + self.memories - len(RIGID) if self.compliant else -1
        shape = self.first, self.rows, self.tangents, self.memory, self.memories
        return KINDS[self.what], *shape, int(self.shares), grip


def unforced(switches: Sequence[Switch]) -> bool:
    """Whether no force turns one of them on or off: all are joints and locks."""
    return all(switch.what in (JOINT, LOCK) for switch in switches)


@once_per_model
def switches_of(model: Model) -> tuple[Switch, ...]:
    """All switches in the order of their rows: joints, locks, limits, contacts, friction."""
    found: list[Switch] = []
    row, memory, described = 0, 0, tuple(_described(model))
    rough = any(switch.what == CONTACT and switch.tangents for switch in described)
    beside = sum(switch.what == CONTACT for switch in described) > 1
    for switch in described:
        shares = rough and switch.what == CONTACT
        compliant = shares and beside and switch.tangents > 0
        memories = switch.memories + (len(RIGID) if compliant else 0)
        found.append(replace(switch, first=row, memory=memory, memories=memories, shares=shares, compliant=compliant))
        row, memory = row + switch.rows, memory + memories
    return tuple(found)


def switch_names(model: Model) -> tuple[str, ...]:
    """What each switch is called: by its name, with what it is where several have that."""
    every = switches_of(model)
    names = [switch.name for switch in every]
    return tuple(x.name if names.count(x.name) == 1 else f"{x.name} ({x.what})" for x in every)


def _described(model: Model) -> Iterator[Switch]:
    def of(what: str, name: str, index: int, rows: int, tangents: int = 0, memories: int = 0, on: int = 0) -> Switch:
        return Switch(what, name, index, 0, rows, tangents, 0, memories, on)

    for n, joint in enumerate(model.joints):
        if joint.switched:
            kinds = JOINTS[joint.type].kinds(joint) if joint.code is None else joint.code.returns
            yield of(JOINT, joint.name, n, len(kinds), on=int(joint.active))
    for n, lock in enumerate(model.locks):
        rows = len(lock.coordinates)
        memories = MATRIX if is_ball(lock) else rows
        yield of(LOCK, lock.name, n, rows, memories=memories, on=int(lock.on))
    for n, limit in enumerate(model.limits):
        yield of(LIMIT, limit.name, n, 1)
    for n, contact in enumerate(model.contacts):
        tangents = 0 if is_zero(contact.static) and is_zero(contact.kinetic) else 2
        memories = tangents + 1 if tangents and contact.normal is None else tangents  # whose tangents these are
        yield of(CONTACT, contact.name, n, 1 + tangents, tangents, memories)
    for n, force in enumerate(model.forces):
        if sticks(force):
            yield of(FRICTION, force.name, n, 1, 1, 1)


def is_ball(lock: Lock) -> bool:
    """Whether it holds a relative rotation as a whole."""
    return lock.coordinates == BALL


def sticks(force: Force) -> bool:
    """Whether it is friction of a joint that sticks."""
    return force.type == "friction" and "static" in force.numbers


def modes_of(model: Model, on: Sequence[Number], memory: Sequence[Number]) -> Modes:
    """The modes of all switches, from how each is on, and all their memory."""
    return {
        switch.key: Mode(x, tuple(memory[switch.memory : switch.memory + switch.memories]))
        for switch, x in zip(switches_of(model), on, strict=True)
    }


def resting(modes: Modes) -> Modes:
    """Modes with no joint sliding with friction."""
    return {key: mode._replace(on=OFF) if key[0] == FRICTION else mode for key, mode in modes.items()}


def permanent(model: Model) -> Model:
    """The model without its switched constraints and friction that sticks; joints keep their numbers."""
    joints = tuple(replace(j, active=j.active and not j.switched, switched=False) for j in model.joints)
    return at_start(replace(model, joints=joints))


def at_start(model: Model) -> Model:
    """The model with the joints that hold at the start as permanent ones, without other switched constraints and
    friction that sticks."""
    joints = tuple(replace(joint, switched=False) for joint in model.joints)
    forces = tuple(force for force in model.forces if not sticks(force))
    return replace(model, joints=joints, forces=forces, locks=(), limits=(), contacts=())
