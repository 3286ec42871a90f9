"""Events: conditions of quantities that are noticed when they become true, and what happens then."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated

from pydantic import AfterValidator, Field

from lienumba.errors import Problem, missing
from lienumba.keys.choices import NameOf
from lienumba.keys.conversions import timed
from lienumba.keys.formulas import condition
from lienumba.keys.registry import Registry
from lienumba.keys.types import NAME_RULE, OR_FORMULA, Name, Positive, Section, Timed
from lienumba.mechanics.elements.locks import chosen
from lienumba.mechanics.mechanism import model
from lienumba.numerics.expressions import Formula
from lienumba.words import listed

CLOSING = 0.02  # m or rad
JOINT, COORDINATE, PARAMETERS, CLOSES, ONCE = "joint", "coordinate", "parameters", "closing", "once"
CONDITION = "condition"  # behind the name of an event with a delay: the event that its condition is


@dataclass(frozen=True)
class Action:
    """What happens at an event; ends_run: whether it is the end of the run, and a success; needs, takes: the keys that
    it must have, and those that it may have besides; did: what it did to what it acts on, if it acts."""

    name: str
    words: str
    ends_run: bool = False
    needs: tuple[str, ...] = ()
    takes: tuple[str, ...] = ()
    did: str = ""

    @property
    def keys(self) -> tuple[str, ...]:
        """All of its own."""
        return (*self.needs, *self.takes)


ACTIONS: Registry[Action] = Registry("action", lambda action: action.name)
RECORD = ACTIONS.add(Action("record", "its time and how often"))
ACTIONS.add(Action("stop", "the run ends there, as a success", ends_run=True))
LOCK = ACTIONS.add(
    Action("lock", "coordinates of a joint stay as they are", needs=(JOINT,), takes=(COORDINATE, ONCE), did="locked")
)
UNLOCK = ACTIONS.add(Action("unlock", "they are free again", needs=(JOINT,), takes=(COORDINATE, ONCE), did="unlocked"))
RELEASE = ACTIONS.add(Action("release", "a joint is gone", needs=(JOINT,), takes=(ONCE,), did="released"))
ENGAGE = ACTIONS.add(Action("engage", "a joint is there", needs=(JOINT,), takes=(CLOSES, ONCE), did="engaged"))
SET = ACTIONS.add(Action("set", "parameters take other values", needs=(PARAMETERS,), takes=(ONCE,), did="set"))


def described() -> str:
    """The actions, in words."""
    return " or ".join(f'"{action.name}" ({action.words})' for action in ACTIONS.values())


def ends_run(action: object) -> bool:
    """Whether an action, by its name, ends runs."""
    return isinstance(action, str) and action in ACTIONS and ACTIONS[action].ends_run


def time_of(name: str) -> str:
    """How formulas read the latest time of an event."""
    return f"{model.EVENT_TIME}.{name}"


def having(key: str) -> str:
    """The actions that have a key, in words."""
    return listed([f'"{action.name}"' for action in ACTIONS.values() if key in action.keys], "or")


class Event(Section):
    """An event, as a scenario describes it."""

    name: Name = Field(description=NAME_RULE)
    when: Annotated[str, AfterValidator(condition)] = Field(
        description='a condition of quantities, parameters and t, such as "pointing.angle > 20*deg"'
    )
    action: Annotated[str, NameOf(ACTIONS)] = Field(default=RECORD.name, description=described())
    joint: str | None = Field(default=None, description="the name of the joint that is locked, released or engaged")
    coordinate: str | None = Field(
        default=None, description="which of its coordinates is locked or unlocked (or omit it: all)"
    )
    parameters: dict[str, Timed] | None = Field(
        default=None, description=f"parameters by their names with the values that they take {OR_FORMULA}: {{ kp = 0 }}"
    )
    once: Annotated[bool, Field(strict=True)] | None = Field(
        default=None, description="whether it acts only the first time in a run: true or false (or omit it: false)"
    )
    delay: Positive | None = Field(
        default=None,
        description="how many seconds behind its condition it happens, above 0 (or omit it: at once)",
    )
    closing: Positive | None = Field(
        default=None,
        description="how far apart in m or rad a joint may be that it engages, above 0 (or omit it: "
        f"{CLOSING:g}); beyond, the run fails",
    )

    def faults(self) -> Iterator[Problem]:
        action = ACTIONS[self.action]
        for key in action.needs:
            if getattr(self, key) is None:
                yield missing(key, f"give {type(self).model_fields[key].description}")
        for key in (JOINT, COORDINATE, PARAMETERS, CLOSES, ONCE):
            if getattr(self, key) is not None and key not in action.keys:
                verb = f'has no meaning for action = "{action.name}"'
                remedy = f"leave it out, or give action = {having(key)}"
                yield Problem(key, "", remedy, getattr(self, key), verb=verb)
        if self.parameters is not None and not self.parameters:
            yield Problem(PARAMETERS, "names none", "give { name = value }, or leave the event out")

    def to_model(
        self, joints: Mapping[str, int], locks: Sequence[model.Lock], held: Sequence[str]
    ) -> Iterator[model.Event]:
        """The event of the model, behind the one that its delay counts from; held: the names of all held numbers."""

        def clock(name: str) -> int:
            return held.index(time_of(name)) if time_of(name) in held else -1

        when: model.Timed = self.when if callable(self.when) else Formula(self.when, condition=True)
        if self.delay is not None:
            begins = f"{self.name}.{CONDITION}"
            yield model.Event(begins, when, False, clock=clock(begins))
            since = time_of(begins)
            waits = Formula(f"t > {since} + delay", frozenset({"t", since, "delay"}), condition=True)
            when = model.Law(waits, {"delay": self.delay}, (since,))
        joint = -1 if self.joint is None else joints[self.joint]
        acts, closing = self.action in (LOCK.name, UNLOCK.name), CLOSING if self.closing is None else self.closing
        yield model.Event(
            self.name,
            when,
            ends_run(self.action),
            action=self.action,
            joint=joint,
            locks=chosen(locks, joint, self.coordinate) if acts else (),
            values=tuple((held.index(name), timed(x)) for name, x in (self.parameters or {}).items()),
            once=bool(self.once),
            closing=closing if self.action == ENGAGE.name else None,
            clock=clock(self.name),
        )
