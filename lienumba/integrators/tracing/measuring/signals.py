"""What signals are where a stage has found accelerations and multipliers."""

from dataclasses import dataclass
from functools import cached_property

from lienumba.integrators.tracing.observed import reads_observed, said
from lienumba.integrators.tracing.tracer import Dynamics, Posture, Tracer
from lienumba.mechanics.elements import quantities
from lienumba.mechanics.mechanism import kinematics
from lienumba.mechanics.mechanism.kinematics import View
from lienumba.mechanics.mechanism.model import Model, Timed
from lienumba.numerics.jets import lift
from lienumba.numerics.number import Number


@dataclass
class Signals:
    """What signals are at a state, of which `Tracer.moving` has found so much."""

    tracer: Tracer
    model: Model
    posture: Posture
    mask: list[Number]
    expected: list[Number] | None
    found: Dynamics

    @cached_property
    def _known(self) -> tuple[list[Number], list[Number]]:
        return self.tracer.reported(self.model, self.posture, self.mask, self.expected, self.found)

    @cached_property
    def _observed(self) -> quantities.Observed:
        return said(self.tracer.whole, self.model, self.posture.now, *self._known)[0]

    @cached_property
    def _still(self) -> View:
        return kinematics.still(self.posture.now, tuple(range(len(self.model.bodies))))

    def value(self, x: Timed) -> Number:
        observed = self._observed if reads_observed(self.model, [x]) else None
        return quantities.evaluate(self.model, x, self._still, observed)

    def rate(self, x: Timed) -> Number:
        view = self._still
        moving = kinematics.moving(view, None if quantities.moves(self.model, x) else self._known[0])
        return lift(quantities.evaluate(self.model, x, moving)).b

    @cached_property
    def integrands(self) -> list[Number]:
        every = quantities.signals(self.model)
        return [self.value(every[n]) for n in self.tracer.integrands]

    @cached_property
    def seen(self) -> dict[int, Number]:
        """What is said of signals at the end of a step (`layout.said`), by its place there."""
        found: dict[int, Number] = {}
        every, model = quantities.signals(self.model), self.model
        for n in sorted(quantities.followed(model) | quantities.lasting(model)) if self.tracer.sizes.seen else ():
            if quantities.has_rate(model, every[n]):
                found[n] = self.rate(every[n])
            if said_itself(model, every[n]):
                found[len(every) + n] = self.value(every[n])
        return found


def said_itself(model: Model, x: Timed) -> bool:
    """Whether F at the end of a step says what a signal is there, with what it is of anyway: accelerations, or its
    rate, where it is the same on both sides of a jump."""
    return reads_observed(model, [x]) or (quantities.has_rate(model, x) and not quantities.leaps(model, x))
