"""What contacts do at a change that no formula of a whole run shows: what sticks, slides, opens, or has only rocked."""

from typing import Any

import numpy as np
import pytest

from lienumba.integrators import layout
from lienumba.integrators.drivers.switching import impacts, modes, problem, reactions
from lienumba.integrators.drivers.switching.force_distribution import Distribution
from lienumba.integrators.drivers.switching.reactions import Reactions
from lienumba.integrators.layout import KINETIC, OFF, SLIDE, STATIC, STICK, UNILATERAL
from lienumba.integrators.sizes import Sizes

PLANE = 3  # rows of a contact with friction


class Lane:
    """One run whose contacts are given by S and their rates or accelerations; all touch."""

    def __init__(self, S: Any, tangents: list[int]) -> None:
        S, switches = np.array(S, float), np.zeros((len(tangents), layout.SWITCH_NUMBERS), np.int64)
        memory = row = 0
        for s, n in enumerate(tangents):
            grips = 3 if n > 0 and len(tangents) > 1 else 0
            switches[s] = UNILATERAL, row, 1 + n, n, memory, n + grips, any(tangents), memory + n if grips else -1
            row, memory = row + 1 + n, memory + n + grips
        self.sizes = Sizes(0, 99, 0, 0, 0, 0, 1, 2, 0, 0, switched=row, switches=len(tangents), memory=memory)
        self.first = layout.workspace(self.sizes)
        self.rows = np.zeros((self.first.work, 1))
        self.rows[self.first.lanes + layout.T] = 1.0  # no condition has come true now
        self.put(layout.border_numbers, layout.CONTACT_NUMBERS * np.arange(len(tangents)) + layout.SIZE, 1.0)
        self.put(layout.change_speeds, np.arange(len(tangents)), 1.0)
        for i in range(row):
            for j in range(i + 1):
                self.put(lambda sizes: 0, layout.border_place(i, j), S[i, j])
        v = [np.zeros(row) for _ in range(19)]
        law, friction, bound, least, begins, paces, static, lent = (np.zeros(len(tangents)) for _ in range(8))
        p = problem.Problem(
            np.zeros_like(S), v[0], switches, law, friction, bound, *v[1:9], np.zeros((row, row + 1)), least,
            np.zeros((4 * row, 4 * row + 2)), np.zeros((4 * row, 7)), np.zeros((2, 4 * row + 1)),
        )  # fmt: skip
        grip = Distribution(np.zeros_like(S), v[13], v[18], static, *v[14:18])
        self.r = Reactions(p, *v[9:13], begins, paces, lent, grip)

    def put(self, where: Any, which: Any, values: Any) -> None:
        """Into what `border` writes."""
        self.rows[self.first.change + where(self.sizes) + np.asarray(which), 0] = values

    def friction(self, *coefficients: float) -> None:
        for s, mu in enumerate(coefficients):
            self.put(layout.border_numbers, layout.CONTACT_NUMBERS * s + np.array([STATIC, KINETIC]), mu)

    def modes(self) -> int:
        reactions.read(self.r, *self.place)
        return modes.decide(self.r, *self.place)

    @property
    def place(self) -> tuple[Any, ...]:
        return self.rows, self.first, self.sizes, 0

    @property
    def memory(self) -> Any:
        start = self.first.state + layout.memory_row(self.sizes)
        return self.rows[start : start + self.sizes.memory, 0].copy()

    @property
    def on(self) -> list[float]:
        start = self.first.state + layout.on_row(self.sizes)
        return list(self.rows[start : start + self.sizes.switches, 0])


def pushed(push: float, *friction: float) -> Lane:
    """Two feet of a body of 1 kg that only shifts, pushed along x (N) under a load of 10 N: they say the same."""
    lane = Lane(np.tile(np.eye(PLANE), (2, 2)), [2, 2])
    lane.friction(*friction)
    lane.put(layout.border_accelerations, np.arange(6), np.tile([-10.0, push, 0.0], 2))
    assert lane.modes() == problem.SOLVED
    return lane


@pytest.mark.parametrize(("push", "on"), [(1.0, [STICK, STICK]), (2.5, [SLIDE, SLIDE])])
def test_what_says_the_same_sticks_or_slides_together(push: float, on: list[int]) -> None:
    assert pushed(push, 0.2, 0.2).on == on


@pytest.mark.parametrize("push", [0.1, 1.0, 1.8, 1.999])
def test_each_foot_gives_as_large_a_part_of_its_friction_as_the_other(push: float) -> None:
    lane = pushed(push, 0.1, 0.3)
    assert lane.on == [STICK, STICK]
    kept = lane.memory.reshape(2, -1)
    pressed = 5.0  # of each foot
    c, g, w = kept[:, :2], kept[:, 2:4], kept[:, 4]
    np.testing.assert_allclose(c, [[-0.1 * push / 2, 0], [-0.3 * push / 2, 0]], atol=1e-12)
    np.testing.assert_allclose(c[:, 0] * pressed, [-0.25 * push, -0.75 * push], rtol=1e-10)
    np.testing.assert_allclose(np.linalg.norm(g, axis=1), push / 2, rtol=1e-6)
    assert w[0] / w[1] == pytest.approx(1 / 3)


def test_what_presses_with_nothing_opens() -> None:
    lane = Lane(np.eye(PLANE), [2])
    lane.friction(0.5)
    lane.put(layout.border_accelerations, np.arange(3), [1.0, 0.0, 0.0])
    assert lane.modes() == problem.SOLVED
    assert lane.on == [OFF]


def rocked(leaves: float) -> Lane:
    """A bar without friction on two feet: the first is hit, and the other one would leave at a speed (m/s)."""
    lane = Lane([[2.0, -leaves], [-leaves, 2.0]], [0, 0])
    lane.put(layout.border_rates, [0, 1], [-1.0, 1.5 * leaves])
    reactions.read(lane.r, *lane.place)
    assert impacts.impulses(lane.r, *lane.place) == problem.SOLVED
    return lane


def after(lane: Lane) -> Any:
    return lane.r.rates + lane.r.problem.S @ lane.r.problem.x


def test_what_has_only_rocked_stays() -> None:
    np.testing.assert_allclose(after(rocked(1e-7)), 0.0, atol=1e-18)


def test_what_leaves_faster_does() -> None:
    np.testing.assert_allclose(after(rocked(1e-5)), [0.0, 1e-5], atol=1e-15)


@pytest.mark.parametrize(("rest_speed", "speed"), [(0.0, 1.8), (1.79, 1.8), (1.81, 0.0)])
def test_what_is_hit_comes_back_with_newtons_restitution(rest_speed: float, speed: float) -> None:
    """A ball of 2 kg at 3 m/s, unless it would come back slower than the speed of rest."""
    lane = Lane([[0.5]], [0])
    lane.put(layout.border_numbers, [layout.RESTITUTION, layout.REST_SPEED], [0.6, rest_speed])
    lane.put(layout.border_rates, 0, -3.0)
    reactions.read(lane.r, *lane.place)
    assert impacts.impulses(lane.r, *lane.place) == problem.SOLVED
    np.testing.assert_allclose(lane.r.problem.x, 2.0 * (3.0 + speed), rtol=1e-14)
    np.testing.assert_allclose(after(lane), speed, atol=1e-14)
    assert impacts.energy_lost(lane.r, 0) == pytest.approx(3.0**2 - speed**2)


def test_sliding_that_friction_leaves_no_acceleration_is_a_paradox() -> None:
    """S_nn - mu S_nt < 0 with a load: no normal force of at least 0 keeps the gap."""
    lane = Lane([[1.0, 0.8, 0.0], [0.8, 1.0, 0.0], [0.0, 0.0, 1.0]], [2])
    lane.friction(2.0)
    lane.put(layout.border_rates, np.arange(PLANE), [0.0, 1e-5, 0.0])
    lane.put(layout.border_accelerations, np.arange(PLANE), [-10.0, 0.0, 0.0])
    assert lane.modes() == problem.PARADOX
    lane.put(layout.border_rates, np.arange(PLANE), [0.0, -1e-5, 0.0])  # the other way friction lifts it
    assert lane.modes() == problem.SOLVED
    assert lane.on == [SLIDE]
