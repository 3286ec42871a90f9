"""Random mechanisms, of tests/oracles/mechanisms, to which changes are added: what happens is chosen from how they move
without, so that most of it does happen."""

from typing import Any

import numpy as np

from tests.oracles.mechanisms import joints as held
from tests.oracles.mechanisms.drawing import Drawing, Table, drawn
from tests.oracles.mechanisms.engine import Mechanism, Motion, SingularError
from tests.oracles.mechanisms.places import Array
from tests.oracles.mechanisms.quantities import SEEN
from tests.oracles.switching.engine import Changing
from tests.oracles.switching.laws import ContradictingError, UnlikeError, complementary

END = 0.4  # s
SAMPLES = 81  # of the motion that is to be changed
LOCKED = ("revolute", "prismatic", "cylindrical", "spherical", "universal")
RATES = {"angle": "rate", "displacement": "speed", "first_angle": "first_rate", "second_angle": "second_rate"}
ROUGH = 0.8  # of mechanisms in which something may stick
APART = 2e-3  # m or rad, from what a mechanism begins


def changing(seed: int) -> Table:
    """The scenario of a seed: the first drawing of it that moves, far enough from singular positions."""
    for attempt in range(100):
        d = Drawing(100 * seed + attempt + 1_000_000)
        data = drawn(d)
        if data is not None:
            try:
                return Changes(d, data, np.random.default_rng([20261, seed, attempt])).data
            except SingularError:
                continue
    raise AssertionError(f"no mechanism of seed {seed}")


class Changes:
    """What is added to a mechanism, as far as it fits."""

    def __init__(self, d: Drawing, data: Table, rough: np.random.Generator) -> None:
        self.d, self.data, self.model = d, data, data["model"]
        self.joints: list[Table] = self.model.setdefault("joints", [])
        self.quantities: list[Table] = self.model.setdefault("quantities", [])
        self.events: list[Table] = []
        self.times = np.linspace(0.0, END, SAMPLES)
        self.m = Mechanism(self.model)
        self.course = self.m.run(self.times.tolist())
        self.rub(rough)
        self.shared = [d.number(0.05, 0.9) * END for _ in range(2)]
        prescribed = {name for name, _ in d.tied}
        self.free = [j for j in self.joints if j["name"] not in prescribed]
        along = {f["joint"] for f in self.model.get("forces", []) if "joint" in f}
        seen = {q["joint"] for q in self.quantities if "joint" in q}
        coupled = {name for j in self.joints for name in j.get("joints", [])}
        kept = along | seen | coupled | {j["name"] for j in self.joints if j.get("armature")}
        self.loose = [j for j in self.free if j["name"] not in kept and "bodies" in j]
        for _ in range(int(d.rng.integers(2, 6))):
            d.one((self.lock, self.lock, self.release, self.engage, self.set, self.limit, self.limit, self.contact,
                   self.contact, self.record))()  # fmt: skip
        if not self.events and "limits" not in self.model and "contacts" not in self.model:
            self.record()
        self.data["events"] = [self.events[n] for n in d.rng.permutation(len(self.events))]
        data["integrator"] = {"method": "dop853", "tolerance": 1e-10, "end_time": END, "coordinates": "lie"}
        data["integrator"]["max_step"] = END / 40
        data["output"] = {"times": np.linspace(0.0, END, 9).tolist(), "max_changes": 64}
        for key in ("joints", "quantities"):
            if not self.model[key]:
                del self.model[key]

    def rub(self, rng: np.random.Generator) -> None:
        """Friction that sticks, of a joint or two, that may bring them to rest and hold them, by numbers of its own:
        without it all else is as it was."""
        known = [
            (j["name"], kind, held.coordinate(j, kind))
            for j in self.joints
            for kind in ("angle", "displacement")
            if kind in held.COORDINATES.get(j["type"], ())
            and j["type"] != "planar"
            and (j["name"], kind) not in self.d.tied
        ]
        if not known or rng.random() > ROUGH:
            return
        smooth = list(self.model.get("forces", []))
        for n, some in enumerate(rng.permutation(len(known))[: 1 + int(rng.random() < 0.3)]):
            joint, kind, q = known[int(some)]
            try:
                coulomb = rng.uniform(0.1, 1.5) * abs(self._holding(q, self.course[0]))
            except ContradictingError:
                continue
            if coulomb > 1e-3:
                force = {"name": f"dry{n}", "type": "friction", "joint": joint, "coordinate": kind}
                force |= {"coulomb": float(coulomb), "static": float(coulomb * rng.uniform(1.05, 1.8))}
                self.model["forces"] = [*self.model.get("forces", []), force]
        try:
            self.course = Changing(self.data | {"events": []}).run(self.times.tolist()).motions
        except UnlikeError:
            self.model["forces"] = smooth

    def _holding(self, q: Any, now: Motion) -> float:
        """What brings a coordinate to rest within half the time of a run (N or N m)."""
        s = now.state
        B, _, wanted, _ = self.m.constraints(s, now.t)
        M, Q = self.m.forced(s, now.t)
        rate, bias = s.along(q, now.t)
        B, wanted = np.concatenate([B, s.partial(q, now.t)]), np.concatenate([wanted, -bias - 2.0 * rate / END])
        return float(complementary(M, Q, B, wanted, np.zeros((0, s.u.size)), np.zeros(0))[1][-1])

    # ------------------------------------------------------------ conditions
    def when(self, part: tuple[float, float] = (0.05, 0.95)) -> str:
        """A condition; mostly one that becomes true in this part of the time."""
        d = self.d
        pick = d.rng.random()
        if pick < 0.3:
            return f"t > {self.time(part)!r}"
        if pick < 0.4:
            return f"sin({d.number(15, 40)!r}*t) > {d.number(0.2, 0.8)!r}"
        if pick < 0.85:
            return self.seen(part)
        return f"{self.seen(part)} {d.one(('and', 'or'))} {d.one((f't > {self.time(part)!r}', self.seen(part)))}"

    def time(self, part: tuple[float, float]) -> float:
        fitting = [t for t in self.shared if part[0] * END < t < part[1] * END]
        return self.d.one(fitting) if fitting and self.d.chance(0.5) else self.d.number(*part) * END

    def seen(self, part: tuple[float, float]) -> str:
        """Of a quantity, which passes a number of its course."""
        d, name = self.d, f"e{len(self.quantities)}"
        known = [j for j in self.free if j["type"] in held.COORDINATES and "bodies" in j and j["type"] != "planar"]
        unique = [
            j for j in self.joints if "bodies" in j and j.get("active", True) and all(now.unique for now in self.course)
        ]
        pick = d.rng.random()
        if pick < 0.5 and known:
            joint = d.one(known)
            table: Table = {"type": "joint", "joint": joint["name"]}
            parts = [x for kind in held.COORDINATES[joint["type"]] for x in (kind, RATES[kind])]
        elif pick < 0.6 and unique:
            table = {"type": "reaction", "joint": d.one(unique)["name"], "frame": d.one(("first", "second", "global"))}
            parts = ["force.x", "force.y", "force.z"]
        else:
            body = d.one(self.model["bodies"])["name"]
            table = {"type": "point", "body": body, "relative_to": "ground", "point": d.vector(0.3)}
            table |= {"derivative": d.one((0, 1)), "frame": "global"}
            parts = ["x", "y", "z"]
        component = d.one(parts)
        self.quantities.append({"name": name} | table)
        x = [self._seen(table, component, now) for now in self.course]
        n = int(np.clip(d.number(*part) * SAMPLES, 1, SAMPLES - 2))
        side = ">" if x[n] > x[n - 1] else "<"
        return f"{name}.{component} {side} {float(0.5 * (x[n] + x[n - 1]))!r}"

    def _seen(self, table: Table, component: str, now: Motion) -> float:
        found = SEEN[table["type"]](self.m, now, table)
        first, _, last = component.rpartition(".")
        value = found[""] if "" in found else found[first or last]
        return float(np.reshape(value, -1)["xyz".index(last)]) if np.size(value) > 1 else float(value)

    def event(self, action: str, when: str, **keys: Any) -> None:
        if any(e["when"] == when and e.get("joint", "") == keys.get("joint") for e in self.events):
            return  # which contradicts itself, and is refused
        once = {"once": True} if action not in ("record", "stop") and self.d.chance(0.25) else {}
        self.events.append({"name": f"ev{len(self.events)}", "when": when, "action": action} | keys | once)

    # ------------------------------------------------------------ what happens
    def record(self) -> None:
        self.event(self.d.one(("record", "record", "stop")), self.when((0.6, 0.95)))

    def lock(self) -> None:
        """Of a joint or one of its coordinates, and mostly it is freed later."""
        known = [j for j in self.free if j["type"] in LOCKED]
        if not known:
            return
        joint = self.d.one(known)
        kinds = list(held.COORDINATES.get(joint["type"], ()))
        keys = {"joint": joint["name"]} | ({"coordinate": self.d.one(kinds)} if kinds and self.d.chance(0.4) else {})
        self.event("lock", self.when(), **keys)
        if self.d.chance(0.6):
            self.event("unlock", self.when((0.5, 0.95)), **keys)

    def release(self) -> None:
        if self.loose:
            self.event("release", self.when((0.2, 0.9)), joint=self.loose.pop(0)["name"])

    def engage(self) -> None:
        """A joint that closes where its bodies are at a time, or, of a point in a plane, whenever it comes there; what
        a driver moves may contradict it."""
        d, names = self.d, ["ground", *(b["name"] for b in self.model["bodies"])]
        a, b = (names[n] for n in d.rng.permutation(len(names))[:2])
        name = f"w{len(self.joints)}"
        if d.chance(0.5):
            body, point = (b if a == "ground" else a), d.vector(0.3)
            n = int(d.number(0.2, 0.9) * SAMPLES)
            z, before, first = (float(self._point(body, point, self.course[i])[2]) for i in (n, n - 1, 0))
            if (first - z) * (before - z) <= 0.0:
                return  # it would close at once, from afar
            quantity = {"name": f"e{len(self.quantities)}", "type": "point", "body": body, "relative_to": "ground"}
            self.quantities.append(quantity | {"point": point, "derivative": 0, "frame": "global"})
            table: Table = {"name": name, "type": "point_in_plane", "bodies": ["ground", body], "active": False}
            table |= {"points": [[0.3, -0.2, z], point], "axes": [[0.0, 0.0, 1.0]] * 2}
            when = f"{quantity['name']}.z {'>' if z > before else '<'} {z!r}"
        else:
            table = d.joint(d.one(("spherical", "revolute", "fixed", "prismatic", "universal", "distance")), (a, b))
            table |= {"name": name, "active": False}
            table.pop("armature", None)
            when = "t >= 0"
        self.joints.append(table)
        self.event("engage", when, joint=name)
        if d.chance(0.5):
            self.event("release", self.when((0.4, 0.95)), joint=name)

    def set(self) -> None:
        """A number of a new force."""
        d, name = self.d, f"p{len(self.data.setdefault('parameters', {}))}"
        self.data["parameters"][name] = d.number(0.5, 1.5)
        body = d.one(self.model["bodies"])["name"]
        push: Table = {"type": "force", "body": body, "point": d.vector(0.3), "frame": d.one(("body", "global"))}
        push["value"] = [f"{name}*{d.number(-4, 4)!r}", d.number(-2, 2), f"{d.number(-2, 2)!r}*sin({name}*t)"]
        self.model.setdefault("forces", []).append({"name": f"push{name}"} | push)
        to: Any = d.number(-1.0, 3.0) if d.chance(0.7) else f"{d.number(0.1, 1.0)!r} + t"
        self.event("set", self.when(), parameters={name: to})

    def limit(self) -> None:
        known = [j for j in self.free if j["type"] in LOCKED and j["type"] in held.COORDINATES]
        if not known:
            return
        d, joint = self.d, self.d.one(known)
        kind = d.one(held.COORDINATES[joint["type"]])
        q = held.coordinate(joint, kind)
        x = np.array([float(q(now.state.places(), now.t)[0, 0].real) for now in self.course])
        n = int(d.number(0.15, 0.9) * SAMPLES)
        stop = 0.5 * float(x[n] + x[n - 1])
        if np.ptp(x) > 3.0 or abs(stop - x[0]) < APART:
            return
        table = {"name": f"l{len(self.model.get('limits', []))}", "joint": joint["name"], "coordinate": kind}
        table["low" if stop < x[0] else "high"] = stop
        if d.chance(0.5):
            away = float(x[0] + (1 if stop < x[0] else -1) * d.number(0.02, 0.2))
            table["high" if stop < x[0] else "low"] = away
        self.model.setdefault("limits", []).append(table | self.rebounds())

    def rebounds(self) -> Table:
        return {"restitution": self.d.one((0.0, 1.0, *[self.d.number(0.1, 0.9)] * 4)),
                "rest_speed": self.d.number(0.03, 0.2)}  # fmt: skip

    def contact(self) -> None:
        """Points that meet planes, or spheres that meet, where they are at a time; sometimes several of a body."""
        d, names = self.d, ["ground", *(b["name"] for b in self.model["bodies"])]
        a, b = (names[n] for n in d.rng.permutation(len(names))[:2])
        a, b = (b, a) if a == "ground" else (a, b)
        n, start, keys = int(d.number(0.15, 0.9) * SAMPLES), self.course[0], self.rebounds()
        for _ in range(d.one((1, 1, 2, 3))):
            p, table = d.vector(0.4), {"name": f"c{len(self.model.get('contacts', []))}", "bodies": [a, b]} | keys
            seen, first = (self._within(b, self._point(a, p, now), now) for now in (self.course[n], start))
            back = first - seen
            distance = float(np.linalg.norm(back))
            if distance < 10 * APART:
                return
            if d.chance(0.25):
                radii = [d.number(0.05, 0.3), d.number(0.05, 0.3)]
                centre = seen - sum(radii) * back / distance
                table |= {"type": "sphere_sphere", "points": [p, centre.tolist()], "radii": radii}
                apart = float(np.linalg.norm(first - centre)) - sum(radii)
            else:
                normal = back / distance + 0.6 * d.unit()
                normal /= np.linalg.norm(normal)
                radius = d.number(0.02, 0.2) if d.chance(0.5) else 0.0
                plane = seen - radius * normal + np.cross(normal, d.vector())
                table |= {"type": "sphere_plane" if radius else "point_plane", "points": [p, plane.tolist()]}
                table |= {"normal": normal.tolist()} | ({"radius": radius} if radius else {})
                apart = float(normal @ (first - plane)) - radius
            if apart > APART:
                self.model.setdefault("contacts", []).append(table)

    def _pose(self, body: str, now: Motion) -> tuple[Array, Array]:
        if body == "ground":
            return np.zeros(3), np.eye(3)
        i = now.state.names.index(body)
        return now.state.r[i], now.state.R[i]

    def _point(self, body: str, point: Any, now: Motion) -> Array:
        r, R = self._pose(body, now)
        return r + R @ np.asarray(point)

    def _within(self, body: str, point: Array, now: Motion) -> Array:
        r, R = self._pose(body, now)
        return np.asarray(R.T @ (point - r))
