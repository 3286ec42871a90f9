"""Events: conditions of quantities that are noticed when they become true, and what happens then."""

from dataclasses import dataclass
from typing import Annotated

from pydantic import AfterValidator, Field

from lienumba.keys.choices import NameOf
from lienumba.keys.formulas import condition
from lienumba.keys.registry import Registry
from lienumba.keys.types import NAME_RULE, Name, Section
from lienumba.mechanics.mechanism import model
from lienumba.numerics.expressions import Formula


@dataclass(frozen=True)
class Action:
    """What happens at an event; ends_run: whether it is the end of the run, and a success."""

    name: str
    words: str
    ends_run: bool = False


ACTIONS: Registry[Action] = Registry("action", lambda action: action.name)
RECORD = ACTIONS.add(Action("record", "its time and how often"))
ACTIONS.add(Action("stop", "the run ends there, as a success", ends_run=True))


def described() -> str:
    """The actions, in words."""
    return " or ".join(f'"{action.name}" ({action.words})' for action in ACTIONS.values())


def ends_run(action: object) -> bool:
    """Whether an action, by its name, ends runs."""
    return isinstance(action, str) and action in ACTIONS and ACTIONS[action].ends_run


class Event(Section):
    """An event, as a scenario describes it."""

    name: Name = Field(description=NAME_RULE)
    when: Annotated[str, AfterValidator(condition)] = Field(
        description='a condition of quantities, parameters and t, such as "pointing.angle > 20*deg"'
    )
    action: Annotated[str, NameOf(ACTIONS)] = Field(default=RECORD.name, description=described())

    def to_model(self) -> model.Event:
        """The event of the model."""
        when = self.when if callable(self.when) else Formula(self.when, condition=True)
        return model.Event(self.name, when, ends_run(self.action))
