"""How the links of a tree move: from the state of the moves to every link, and to the bodies in the ground's axes.

Everything of a link is along its own axes, its origin is where its joint is. The acceleration of a link that moves
against a turning one is  E^T (a + w' x q + w x (w x q)) + 2 E^T (w x q') + E^T q''.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from lienumba.groups import so3
from lienumba.groups.state import State
from lienumba.mechanics.mechanism.model import GROUND, Model
from lienumba.mechanics.mechanism.moves import ZERO, Relative, cycled
from lienumba.mechanics.tree.links import Link, Tree, moves_of
from lienumba.numerics.number import Matrix, Number, Vector


@dataclass(frozen=True)
class Moving:
    """A link: R (own axes to global) and r (origin, global); v and w of the link. turns: rotations whose product
    has its axes as columns along the parent's; q: its origin from the parent's, along the parent's axes; bias: its
    acceleration, and angular acceleration, where its parent and its rates do not accelerate."""

    R: Any
    r: Any
    v: Any
    w: Any
    turns: tuple[Matrix, ...]
    q: Any
    bias: Any


def up(turns: Sequence[Matrix], a: Vector) -> Any:
    """Components along a link's axes to those along the parent's."""
    for E in reversed(turns):
        a = so3.rotate(E, a)
    return a


def down(turns: Sequence[Matrix], a: Vector) -> Any:
    """The reverse."""
    for E in turns:
        a = so3.rotate_back(E, a)
    return a


GROUNDED = Moving(so3.IDENTITY, ZERO, ZERO, ZERO, (), ZERO, (*ZERO, *ZERO))


def moving_links(tree: Tree, z: Vector) -> list[Moving]:
    """The motion of every link, at this state of its moves."""
    found: list[Moving] = []
    for link in tree.links:
        found.append(_moving(link, GROUNDED if link.parent == GROUND else found[link.parent], state_of(link, z)))
    return found


def state_of(link: Link, z: Vector) -> Any:
    """The state of one link's move."""
    return tuple(z[link.first_state : link.first_state + link.move.state])


def _moving(link: Link, parent: Moving, z: Vector) -> Moving:
    own = link.move.relative(z, link.pitch)
    turns = (*link.turns, own.E)
    q = so3.add(link.offset, up(link.turns, own.d))
    w = so3.add(down(turns, parent.w), own.w)
    carried = so3.cross(parent.w, q)
    along = so3.rotate_back(own.E, own.rate)
    v = so3.add(down(turns, so3.add(parent.v, carried)), along)
    coriolis = so3.scale(2.0, so3.cross(so3.subtract(w, own.w), along))
    bias = so3.add(down(turns, so3.cross(parent.w, carried)), coriolis) + so3.cross(w, own.w)
    R = parent.R
    for E in turns:
        R = so3.multiply(R, E)
    return Moving(R, so3.add(parent.r, so3.rotate(parent.R, q)), v, w, turns, q, bias)


def bodies_at(tree: Tree, links: Sequence[Moving]) -> tuple[State, ...]:
    """The bodies as the links carry them."""
    found = []
    for body in range(len(tree.ties)):
        place = tree.of_body[body]
        frame, link = tree.links[place].frame, links[place]
        assert frame is not None
        c = centre(tree.links[place])
        R = so3.multiply(link.R, so3.transpose(frame.axes))
        v = so3.rotate(link.R, so3.add(link.v, so3.cross(link.w, c)))
        found.append((*so3.add(link.r, so3.rotate(link.R, c)), *R, *v, *so3.rotate(frame.axes, link.w)))
    return tuple(found)


def centre(link: Link) -> Any:
    """The mass centre of a link's body, from the link's origin along the link's axes."""
    assert link.frame is not None
    return so3.scale(-1.0, so3.rotate_back(link.frame.axes, link.frame.origin))


def read_state(model: Model, tree: Tree, bodies: Sequence[State]) -> list[Number]:
    """The state of all moves that puts the bodies where they are."""
    z: list[Number] = []
    places = {body: link for body, link in tree.of_body.items() if body != GROUND}
    for tie, start in zip(tree.ties, tree.starts, strict=True):
        end = tree.links[places[tie.body]].frame
        assert end is not None
        left, moves = _relative(bodies, tie.parent, start, tie.body, end), moves_of(model, tie)
        links = [link for link in tree.links if link.joint == tie.joint and link.joint is not None]
        pitch = links[0].pitch if links else 0.0
        for n, move in enumerate(moves):
            left = cycled(left) if move.cycled else left
            own, left = move.read(left, n == len(moves) - 1, pitch)
            z += own
    return z


def _relative(bodies: Sequence[State], parent: int, start: Any, body: int, end: Any) -> Relative:
    """Of the frame `end` of a body to the frame `start` of its parent, w along the axes of `start`."""
    r0, R0, v0, w0 = _frame(bodies, parent, start)
    r1, R1, v1, w1 = _frame(bodies, body, end)
    E = so3.multiply(so3.transpose(R0), R1)
    d = so3.rotate_back(R0, so3.subtract(r1, r0))
    w = so3.subtract(so3.rotate_back(R0, w1), so3.rotate_back(R0, w0))
    carried = so3.add(v0, so3.cross(w0, so3.subtract(r1, r0)))
    return Relative(E, d, w, so3.rotate_back(R0, so3.subtract(v1, carried)))


def _frame(bodies: Sequence[State], body: int, frame: Any) -> tuple[Any, Any, Any, Any]:
    """Of a frame in a body: origin, axes, velocity, angular velocity, all global."""
    if body == GROUND:
        return frame.origin, frame.axes, ZERO, ZERO
    x = bodies[body]
    R, arm = x[3:12], so3.rotate(x[3:12], frame.origin)
    w = so3.rotate(R, x[15:18])
    return so3.add(x[0:3], arm), so3.multiply(R, frame.axes), so3.add(x[12:15], so3.cross(w, arm)), w
