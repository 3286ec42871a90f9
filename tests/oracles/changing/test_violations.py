"""What a contact, a stop or friction cannot do ends a run: work that is done by none of it is in no book."""

from typing import Any

import numpy as np
import pytest

import lienumba
from lienumba.mechanics.mechanism.kinematics import OFF, STICK
from lienumba.mechanics.system.switched import turning
from lienumba.numerics.operations import where
from tests.oracles.changing import scenarios
from tests.rigs import parts

G, UNIT = 9.81, 1e-4


def standing(height: float, **contact: Any) -> dict[str, Any]:
    """A point of 1 kg; what a floor gives back of impacts is a number of each run."""
    floor = parts.foot("floor", "b", restitution=0.5, **contact)
    model = {"gravity": [0.1, 0.2, -G], "bodies": [parts.resting("b", 1.0, 0.1, [0, 0, height])], "contacts": [floor]}
    data = {"model": model, "integrator": scenarios.settings(0.1, 1e-9)}
    return data | {"sweep": scenarios.table({"contacts.floor.restitution": [0.05, 0.2]})}


@pytest.mark.parametrize(
    ("data", "which", "on"),
    [
        (standing(0.0), 0, 2.0),
        (standing(1.0, type="sphere_plane", radius=0.1), 0, OFF),
        (standing(0.0, friction=0.5), 1, STICK),
    ],
    ids=["pulls", "overlaps", "holds"],
)
def test_what_only_pushes_does_nothing_else(
    monkeypatch: pytest.MonkeyPatch, data: dict[str, Any], which: int, on: float
) -> None:
    """Made up: a condition that is true from the start, so that no change is found, by 5e-7 of the weight or of the
    length in the first run, and by four times as much in the second."""
    real = turning.contact_guards
    scale = UNIT if on == OFF else UNIT * G

    def conditions(model: Any, now: Any, *rest: Any) -> list[Any]:
        found, (mode,) = real(model, now, *rest), now.modes.values()
        found[which] = where(mode.on == on, 0.1 * scale * model.contacts[0].restitution, found[which])
        return found

    monkeypatch.setattr(turning, "contact_guards", conditions)
    assert scenarios.statuses(lienumba.run(data, progress=False)) == ["success", "contact_law_violated"]


@pytest.mark.parametrize("first", ["plane", "ball"])
def test_what_is_closed_does_not_move(first: str) -> None:
    """Where a plane touches the top of a ball a point rests on both, which say the same. As it is pushed along the
    plane they do no longer, and one of the two is not used: it would sink into the plane, or the ball follow it."""
    plane = parts.foot("plane", "b", normal=[0, 0, 1])
    ball = parts.foot("ball", "b", on=[0, 0, -1], type="sphere_sphere", radii=[0.3, 0.7])
    both = [plane, ball] if first == "plane" else [ball, plane]
    model = {"gravity": [0.5, 0, -G], "bodies": [parts.resting("b", 1.3, [0.1, 0.2, 0.3])], "contacts": both}
    ds = lienumba.run({"model": model, "integrator": scenarios.settings(0.5, 1e-9)}, progress=False)
    assert scenarios.statuses(ds) == ["contact_law_violated"]
    assert np.isnan(ds.energy.values[0, -1])
