"""Random mechanisms of every topology that matters to the elimination, and states for them."""

from typing import Any

import numpy as np

from lienumba.groups import so3
from tests.facade import GROUND, JOINTS, Body, Joint, Model

GRAVITY = (0.3, -0.2, -9.81)
Ends = list[tuple[str, int, int]]
State = tuple[tuple[float, ...], ...]
S, D = "spherical", "distance"


def chain(k: int) -> Ends:
    return [(S, i - 1, i) for i in range(k)]


def free_chain(k: int) -> Ends:
    return [(S, i - 1, i) for i in range(1, k)]


def star(k: int) -> Ends:
    """Body 0 in the middle, all others on it, nothing on the ground."""
    return [(S, 0, i) for i in range(1, k)]


def ladder(rungs: int) -> Ends:
    """Two chains from the ground, tied by rods."""
    sides: Ends = [(S, i - 2 if i > 1 else GROUND, i) for i in range(2 * rungs)]
    return sides + [(D, 2 * i, 2 * i + 1) for i in range(rungs)]


def ring(k: int) -> Ends:
    return [(S, i, (i + 1) % k) for i in range(k)]


def arch(k: int) -> Ends:
    """A chain with both ends on the ground."""
    return [*chain(k), (S, k - 1, GROUND)]


def hexapod() -> Ends:
    """A platform on six legs; they are bodies, with spherical joints on the ground and at the platform."""
    return [joint for leg in range(1, 7) for joint in ((S, GROUND, leg), (S, leg, 0))]


def suspended() -> Ends:
    """A platform on six rods without mass."""
    return [(D, GROUND, 0)] * 6


TOPOLOGIES: dict[str, tuple[int, Ends]] = {
    "free body": (1, []),
    "top": (1, [(S, GROUND, 0)]),
    "two free bodies": (2, [(S, 0, 1)]),
    "rod between": (2, [(D, 1, 0)]),
    "chain": (5, chain(5)),
    "free chain": (5, free_chain(5)),
    "chain with its ground last": (4, [(S, 1, 0), (S, 2, 1), (S, 3, 2), (S, 3, GROUND)]),
    "star": (7, star(7)),
    "star on the ground": (6, [*star(6), (S, 2, GROUND)]),
    "star of rods": (6, [(D, 0, i) for i in range(1, 6)]),
    "ladder": (8, ladder(4)),
    "ring": (3, ring(3)),
    "ring on the ground": (4, [*ring(4), (S, 1, GROUND)]),
    "arch": (4, arch(4)),
    "twice the same pair": (2, [(S, 0, 1), (D, 1, 0), (D, 0, 1)]),
    "hexapod": (7, hexapod()),
    "platform on rods": (1, suspended()),
    "tetrahedron of rods": (4, [(D, i, j) for i in range(4) for j in range(i)]),
    "parts that do not touch": (5, [(S, GROUND, 0), (S, 1, 2), (D, 3, 4), (D, 4, 3)]),
    "two rings": (5, [*ring(3), (S, 2, 3), (S, 3, 4), (D, 4, 2)]),
}


def random_network(seed: int) -> tuple[int, Ends]:
    """A random tree with a few rods and joints more, as many as leave every row independent."""
    rng = np.random.default_rng(seed)
    k = int(rng.integers(2, 9))
    ends: Ends = [(S if rng.random() < 0.7 else D, int(rng.integers(GROUND, i)), i) for i in range(k)]
    for _ in range(int(rng.integers(0, k))):
        a, b = rng.choice(np.arange(GROUND, k), 2, replace=False)
        ends.append((S if rng.random() < 0.3 else D, int(a), int(b)))
    return k, [ends[i] for i in rng.permutation(len(ends))]


def body(rng: np.random.Generator, name: str) -> Body:
    X = rng.standard_normal((3, 3))
    J = X @ X.T + 2.0 * np.eye(3)
    tensor = [J[0, 0], J[1, 1], J[2, 2], J[0, 1], J[0, 2], J[1, 2]]
    return Body(name, float(rng.uniform(0.5, 4.0)), tuple(map(float, tensor)))


def vector(rng: np.random.Generator, scale: float = 1.0) -> tuple[float, ...]:
    return tuple((scale * rng.standard_normal(3)).tolist())


def model(k: int, ends: Ends, seed: int = 0) -> Model:
    rng = np.random.default_rng(seed)
    joints = tuple(
        Joint(
            f"j{n}",
            kind,
            (a, b),
            (vector(rng), vector(rng)),
            numbers={"length": float(rng.uniform(0.5, 2.0))} if kind == D else {},
        )
        for n, (kind, a, b) in enumerate(ends)
    )
    return Model(GRAVITY, tuple(body(rng, f"b{i}") for i in range(k)), joints)


def state(k: int, seed: int = 0) -> State:
    """Positions, rotations and velocities at random: the equations of motion hold off the constraints too."""
    rng = np.random.default_rng(1000 + seed)
    return tuple(vector(rng, 2.0) + so3.exp(vector(rng, 1.5)) + vector(rng) + vector(rng) for _ in range(k))


def arrays(x: Any) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """r (k,3), R (k,3,3), v (k,3), w (k,3) of a state, as the naive twin wants them."""
    x = np.array(x, float)
    return x[:, 0:3], x[:, 3:12].reshape(-1, 3, 3), x[:, 12:15], x[:, 15:18]


def rows(m: Model) -> int:
    return sum(len(JOINTS[joint.type].kinds(joint)) for joint in m.joints)


def dense(entries: dict[tuple[int, int], Any], shape: tuple[int, int]) -> np.ndarray:
    A = np.zeros(shape)
    for key, value in entries.items():
        A[key] = value
    return A
