"""Random mechanisms as tables of scenarios, in which everything is given: poses first, then joints that fit them.

Types are drawn from the registries: each of them has to be drawn by something here, or to be in ELSEWHERE.
"""

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from lienumba.mechanics.elements.drivers import DRIVERS
from lienumba.mechanics.elements.forces import FORCES
from lienumba.mechanics.elements.quantities import QUANTITIES
from tests.facade import JOINTS
from tests.oracles.mechanisms import joints as held
from tests.oracles.mechanisms.engine import Mechanism
from tests.oracles.mechanisms.forces import ALONG_JOINTS, ON_BODIES
from tests.oracles.mechanisms.places import Array, exp, log
from tests.oracles.mechanisms.quantities import SEEN

Table = dict[str, Any]
END = 0.3  # s
ELSEWHERE = {  # laws of one's own, and what switches: tests of their own
    "joints": {"python"},
    "forces": {"python"},
    "quantities": {"limit", "lock", "contact", "distance"},
    "drivers": set(),
}
LEAST = 0.02  # of the singular values of C at the start: nearer to a singular position errors grow
ROWS = {  # how many a joint has
    "spherical": 3, "revolute": 5, "universal": 4, "cylindrical": 4, "prismatic": 5, "fixed": 6, "planar": 3,
    "point_on_line": 2, "point_in_plane": 1, "distance": 1, "parallel_axes": 2, "perpendicular_axes": 1, "screw": 5,
}  # fmt: skip
FORMS = ("value", "rate", "point", "orientation", "angular_velocity")  # of drivers
LOOSE = ("distance", "point_in_plane", "point_on_line", "perpendicular_axes", "parallel_axes", "spherical", "universal")


def unknown() -> dict[str, set[str]]:
    """What registries have that the engine here does not know."""
    forms = {motion for kind in DRIVERS.values() for motion in kind.motions}
    known = {
        "joints": (set(JOINTS), {*held.HELD, *held.COUPLED}),
        "forces": (set(FORCES), {*ON_BODIES, *ALONG_JOINTS}),
        "quantities": (set(QUANTITIES), set(SEEN)),
        "drivers": (forms, set(FORMS)),
    }
    return {what: found for what, (every, here) in known.items() if (found := every - here - ELSEWHERE[what])}


class Drawing:
    """One mechanism, the same for the same seed."""

    def __init__(self, seed: int) -> None:
        self.rng = np.random.default_rng([20260, seed])
        self.bodies: list[Table] = []
        self.joints: list[Table] = []
        self.drivers: list[Table] = []
        self.forces: list[Table] = []
        self.quantities: list[Table] = []
        self.tied: set[tuple[str, str]] = set()  # coordinates that something prescribes
        self.freedom = 0

    # ------------------------------------------------------------ numbers
    def number(self, low: float, high: float) -> float:
        return float(self.rng.uniform(low, high))

    def vector(self, size: float = 1.0) -> list[float]:
        return [float(x) for x in self.rng.uniform(-size, size, 3)]

    def unit(self) -> Array:
        v = self.rng.normal(size=3)
        return np.asarray(v / np.linalg.norm(v))

    def beside(self, z: Array) -> Array:
        x = np.cross(z, self.unit())
        return np.asarray(x / np.linalg.norm(x))

    def one(self, choices: Any) -> Any:
        listed = list(choices)
        return listed[int(self.rng.integers(len(listed)))]

    def chance(self, p: float) -> bool:
        return bool(self.rng.random() < p)

    def timed(self, low: float, high: float, part: float = 0.5) -> Any:
        """A number, or a formula of time that stays within the limits."""
        middle, swing = 0.5 * (low + high), 0.5 * (high - low)
        if self.chance(part):
            return self.number(low, high)
        return f"{middle!r} + {self.number(0.2, 0.9) * swing!r}*sin({self.number(1.0, 8.0)!r}*t)"

    # ------------------------------------------------------------ bodies
    def body(self, name: str) -> Table:
        m, X = float(10.0 ** self.rng.uniform(-0.7, 0.7)), self.rng.normal(size=(3, 3))
        mass_points = 0.02 * m * (X @ X.T + 0.3 * np.eye(3))
        J = np.trace(mass_points) * np.eye(3) - mass_points
        R = exp(np.array(self.vector(1.5)))
        return {
            "name": name, "mass": m, "inertia": (0.5 * (J + J.T)).tolist(), "position": self.vector(0.8),
            "rotation": R.tolist(), "velocity": self.vector(), "angular_velocity": self.vector(2.0),
        }  # fmt: skip

    def pose(self, name: str) -> tuple[Array, Array]:
        if name == "ground":
            return np.zeros(3), np.eye(3)
        body = next(b for b in self.bodies if b["name"] == name)
        return np.array(body["position"]), np.array(body["rotation"])

    def within(self, name: str, point: Array) -> list[float]:
        r, R = self.pose(name)
        return [float(x) for x in R.T @ (point - r)]

    def axis(self, name: str, direction: Array) -> list[float]:
        return [float(x) for x in self.pose(name)[1].T @ direction]

    # ------------------------------------------------------------ joints
    def joint(self, kind: str, ends: tuple[str, str]) -> Table:
        """One that holds where the bodies are."""
        a, b = ends
        z, p = self.unit(), np.array(self.vector(0.4)) + self.pose(b)[0]
        x = self.beside(z)
        z2, x2, q = z, x, p
        if kind in ("universal", "perpendicular_axes"):
            z2 = self.beside(z)
            x2 = self.beside(z2)
        elif kind in ("revolute", "cylindrical", "screw", "planar"):
            x2 = exp(self.number(-1.2, 1.2) * z) @ x
        if kind in ("cylindrical", "prismatic", "screw", "point_on_line"):
            q = p + self.number(-0.5, 0.5) * z
        if kind in ("planar", "point_in_plane"):
            q = p + self.number(-0.5, 0.5) * x + self.number(-0.5, 0.5) * np.cross(z, x)
        table: Table = {"name": f"j{len(self.joints)}", "type": kind, "bodies": list(ends)}
        if kind == "distance":
            table["length"] = self.number(0.3, 1.0)
            q = p + table["length"] * z
        if kind not in ("parallel_axes", "perpendicular_axes"):
            table["points"] = [self.within(a, p), self.within(b, q)]
        if kind not in ("spherical", "distance"):
            table["axes"] = [self.axis(a, z), self.axis(b, z2)]
        if kind in ("revolute", "cylindrical", "screw", "planar", "prismatic", "fixed", "universal"):
            table["references"] = [self.axis(a, x), self.axis(b, x2)]
        if kind == "screw":
            table["pitch"] = self.number(0.1, 0.5) * self.one((-1, 1))
        if kind in held.ROTOR and self.chance(0.3):
            table["armature"] = self.number(0.01, 0.3)
        return table

    def twin(self, joint: Table) -> Table:
        """Another hinge on the same line: all of its rows are redundant."""
        a, b = joint["bodies"]
        move = [0.3 * np.array(z) for z in joint["axes"]]
        points = [(np.array(p) + d).tolist() for p, d in zip(joint["points"], move, strict=True)]
        turned = {key: joint[key] for key in ("axes", "references")}
        return {"name": f"j{len(self.joints)}", "type": "revolute", "bodies": [a, b], "points": points, **turned}

    def coordinates(self, *types: str) -> Iterator[tuple[str, str]]:
        """Angles and displacements of joints that nothing prescribes yet."""
        for j in self.joints:
            if j["type"] in held.COORDINATES and (not types or j["type"] in types):
                kinds = JOINTS[j["type"]].coordinate_kinds
                yield from ((j["name"], kind) for kind in kinds if (j["name"], kind) not in self.tied)

    def now(self, name: str, kind: str) -> float:
        joint = next(j for j in self.joints if j["name"] == name)
        start = Mechanism({"bodies": self.bodies}).start
        return float(held.coordinate(joint, kind)(start.places(), 0.0)[0, 0].real)

    def coupling(self) -> None:
        free = [c for c in self.coordinates() if c[0] not in {name for name, _ in self.tied}]
        if len({name for name, _ in free}) < 2 or self.freedom < 3:
            return
        first = self.one(free)
        second = self.one(c for c in free if c[0] != first[0])
        ratio = self.number(0.5, 2.0) * self.one((-1, 1))
        self.joints.append({
            "name": f"j{len(self.joints)}", "type": self.one(held.COUPLED), "joints": [first[0], second[0]],
            "coordinates": [first[1], second[1]], "ratio": ratio,
            "offset": self.now(*second) - ratio * self.now(*first),
        })  # fmt: skip
        self.tied |= {first, second}
        self.freedom -= 1

    # ------------------------------------------------------------ drivers
    def driver(self) -> None:
        every = [motion for kind in DRIVERS.values() for motion in kind.motions]
        form, name = self.one(x for x in every if x in FORMS), f"d{len(self.drivers)}"
        free = list(self.coordinates())
        if form in ("value", "rate") and free and self.freedom > 1:
            joint, kind = self.one(free)
            a, b, w = self.number(-0.5, 0.5), self.number(-0.2, 0.2), self.number(1.0, 6.0)
            law = (
                f"{a!r} + {b!r}*sin({w!r}*t)"
                if form == "rate"
                else f"{self.now(joint, kind)!r} + {a!r}*t + {b!r}*sin({w!r}*t)"
            )
            self.drivers.append({"name": name, "joint": joint, "coordinate": kind, form: law})
            self.tied.add((joint, kind))
            self.freedom -= 1
        elif form in ("point", "orientation", "angular_velocity") and self.freedom > 3:
            body = self.one(self.bodies)["name"]
            r, R = self.pose(body)
            point = self.vector(0.3)
            start = {"point": r + R @ np.array(point), "orientation": log(R), "angular_velocity": np.zeros(3)}[form]
            laws = [
                f"{x!r} + {self.number(-0.5, 0.5)!r}*t + {self.number(-0.1, 0.1)!r}*sin(4.0*t)" for x in start.tolist()
            ]
            more = (
                {"point": point}
                if form == "point"
                else {"frame": self.one(("body", "global"))}
                if form == "angular_velocity"
                else {}
            )
            self.drivers.append({"name": name, "body": body, "motion": form, "value": laws, **more})
            self.freedom -= 3

    # ------------------------------------------------------------ forces
    def force(self, kind: str) -> Table | None:
        table: Table = {"name": f"f{len(self.forces)}", "type": kind}
        names = [b["name"] for b in self.bodies]
        if kind in ALONG_JOINTS:
            types = [n for n, j in JOINTS.items() if kind != "torsion_spring" or "angle" in j.coordinate_kinds]
            saved, self.tied = self.tied, set()
            free = [c for c in self.coordinates(*types) if kind != "torsion_spring" or c[1] == "angle"]
            self.tied = saved
            if not free:
                return None
            joint, which = self.one(free)
            table |= {"joint": joint, "coordinate": which} | self.along(kind, self.now(joint, which))
            return table
        if kind in ("force", "torque", "drag"):
            table |= {"body": self.one(names)}
            table |= {} if kind == "torque" else {"point": self.vector(0.3)}
        else:
            table |= {
                "bodies": [a := self.one(["ground", *names]), self.one(n for n in names if n != a)]
                if len(names) > 1
                else ["ground", names[0]]
            }
            table |= {"points": [self.vector(0.4), self.vector(0.4)]}
        drawn: dict[str, Callable[[], Table]] = {
            "force": lambda: {"frame": self.one(("body", "global")), "value": [self.timed(-3, 3) for _ in range(3)]},
            "torque": lambda: {"frame": self.one(("body", "global")), "value": [self.timed(-1, 1) for _ in range(3)]},
            "drag": lambda: {"linear": self.timed(0.1, 1), "quadratic": self.timed(0.1, 1)},
            "spring_damper": lambda: {
                "stiffness": self.timed(5, 40),
                "damping": self.timed(0, 2),
                **({"free_length": self.timed(0.2, 0.8)} if self.chance(0.6) else {}),
            },
            "bushing": lambda: {
                key: [self.timed(0.2 * size, size, 0.8) for _ in range(3)]
                for key, size in (
                    ("stiffness", 40),
                    ("damping", 2),
                    ("rotational_stiffness", 5),
                    ("rotational_damping", 0.3),
                )
            },
            "point_mass_gravity": lambda: {"mu": self.timed(0.2, 2)},
        }
        return table | drawn[kind]()

    def along(self, kind: str, q: float) -> Table:
        drawn: dict[str, Callable[[], Table]] = {
            "torsion_spring": lambda: {
                "stiffness": self.timed(1, 9),
                "damping": self.timed(0, 0.5),
                "free_angle": self.timed(-0.5, 0.5),
            },
            "actuator": lambda: {
                "value": self.timed(-1, 1),
                "stiffness": self.timed(1, 9),
                "damping": self.timed(0, 0.5),
                "target": self.timed(-0.5, 0.5),
                **self.one(
                    ({}, {"limit": self.number(0.5, 2)}, {"limits": [self.number(-2, -0.5), self.number(0.5, 2)]})
                ),
            },
            "friction": lambda: {
                "viscous": self.timed(0, 1),
                "coulomb": self.timed(0, 1),
                "velocity": self.number(0.1, 0.5),
            },
            "end_stop": lambda: {
                "lower": q - self.number(0.02, 0.2),
                "upper": q + self.number(0.02, 0.2),
                "stiffness": self.number(20, 200),
                "damping": self.number(0, 2),
            },
        }
        return drawn[kind]()

    # ------------------------------------------------------------ quantities
    def quantity(self, kind: str) -> Table | None:
        names = [b["name"] for b in self.bodies]
        body = self.one(names)
        base = self.one(["ground", *[n for n in names if n != body]])
        around = [base] if base != "ground" else []
        table: Table = {"name": f"q{len(self.quantities)}", "type": kind}
        seen = [j["name"] for j in self.joints if j["type"] in held.COORDINATES or j["type"] == "spherical"]
        loaded = [j["name"] for j in self.joints if j["type"] not in held.COUPLED]
        known: dict[str, Callable[[], Table | None]] = {
            "point": lambda: {
                "body": body,
                "relative_to": base,
                "point": self.vector(0.4),
                "derivative": self.one((0, 1, 2)),
                "frame": self.one(("global", "body", *around)),
            },
            "joint": lambda: {"joint": self.one(seen)} if seen else None,
            "rotation_error": lambda: {
                "body": body,
                "relative_to": base,
                "target": {"rotation_vector": self.near(body, base)},
            },
            "angular_velocity": lambda: {
                "body": body,
                "relative_to": base,
                "frame": self.one(("global", "body", *around)),
            },
            "reaction": lambda: (
                {"joint": self.one(loaded), "frame": self.one(("first", "second", "global"))} if loaded else None
            ),
            "driver_effort": lambda: {"driver": self.one(self.drivers)["name"]} if self.drivers else None,
            "momentum": lambda: (
                self.one(({}, {"bodies": [body]})) | self.one(({}, {"about": "mass_centre"}, {"about": self.vector()}))
            ),
            "expression": lambda: {"value": f"{self.number(-1, 1)!r}*t + cos({self.number(1, 5)!r}*t)"},
        }
        more = known[kind]()
        return None if more is None else table | more

    def near(self, body: str, base: str) -> list[float]:
        """A rotation vector not half a turn away."""
        R = self.pose(base)[1].T @ self.pose(body)[1] @ exp(np.array(self.vector(0.8)))
        v = log(R)
        return [float(x) for x in v]


def mechanism(seed: int) -> Table:
    """The scenario of a seed: the first drawing of it that can move and is far enough from singular positions."""
    for attempt in range(100):
        data = drawn(Drawing(100 * seed + attempt))
        if data is not None:
            return data
    raise AssertionError(f"no mechanism of seed {seed}")


def drawn(d: Drawing) -> Table | None:
    """A mechanism, or None where it cannot move or is near a singular position."""
    k = int(d.rng.choice([1, 2, 3, 4], p=[0.25, 0.35, 0.25, 0.15]))
    for i in range(k):
        d.bodies.append(d.body(f"b{i}"))
    d.freedom = 6 * k
    every = [name for name in JOINTS if name in held.HELD]
    for i in range(k):
        if d.chance(0.85):
            kind = d.one(every)
            ends = (d.one(["ground", *[f"b{n}" for n in range(i)]]), f"b{i}")
            d.joints.append(d.joint(kind, ends if d.chance(0.7) else ends[::-1]))
            d.freedom -= ROWS[kind]
    for _ in range(int(d.rng.integers(0, 3))):
        kind, some = d.one(LOOSE), ["ground", *(b["name"] for b in d.bodies)]
        if ROWS[kind] < d.freedom:
            a, b = (some[n] for n in d.rng.permutation(len(some))[:2])
            d.joints.append(d.joint(kind, (a, b)))
            d.freedom -= ROWS[kind]
    hinges = [j for j in d.joints if j["type"] == "revolute"]
    redundant = 0
    if hinges and d.chance(0.15):
        d.joints.append(d.twin(d.one(hinges)))
        redundant = ROWS["revolute"]
    for _ in range(int(d.rng.integers(0, 2))):
        d.coupling()
    for _ in range(int(d.rng.integers(0, 3))):
        d.driver()
    for _ in range(int(d.rng.integers(0, 4))):
        if table := d.force(d.one(name for name in FORCES if name in ON_BODIES or name in ALONG_JOINTS)):
            d.forces.append(table)
    for _ in range(int(d.rng.integers(1, 4))):
        if table := d.quantity(d.one(name for name in QUANTITIES if name in SEEN)):
            d.quantities.append(table)
    if d.freedom < 1:
        return None
    model: Table = {"gravity": [0.5, -1.0, -9.0], "bodies": d.bodies}
    for key in ("joints", "drivers", "forces", "quantities"):
        if getattr(d, key):
            model[key] = getattr(d, key)
    m = Mechanism(model)
    state = m.compatible(m.start)
    for body, v, w in zip(d.bodies, state.v, state.w, strict=True):
        body["velocity"], body["angular_velocity"] = v.tolist(), w.tolist()
    if np.abs(state.u).max() > 8.0 or not _sound(Mechanism(model), redundant):
        return None
    way = d.one(("lie", "joint"))
    return {
        "model": model,
        "integrator": {"method": "dop853", "tolerance": 1e-10, "end_time": END, "coordinates": way},
        "output": {"times": [0.0, 0.5 * END, END]},
    }


def _sound(m: Mechanism, redundant: int) -> bool:
    """Whether C has no small singular values but so many that are 0."""
    now = m.motion(m.start, 0.0)
    return now.redundant == redundant and 1.0 / now.condition > LEAST
