"""What quantities are, from tables of a scenario and a motion: by the name of each component."""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from tests.oracles.mechanisms import joints
from tests.oracles.mechanisms.engine import Mechanism, Motion
from tests.oracles.mechanisms.numbers import number
from tests.oracles.mechanisms.places import Array, Places, exp, log, point_of

Table = Mapping[str, Any]


def frame(m: Mechanism, now: Motion, name: str) -> Array:
    """The rotation of a body, of "ground" or "global"."""
    return np.eye(3) if name in ("ground", "global") else now.state.R[m.index(name).start // 6]


def spin(m: Mechanism, now: Motion, name: str) -> Array:
    return np.zeros(3) if name == "ground" else frame(m, now, name) @ now.state.w[m.index(name).start // 6]


def point(m: Mechanism, now: Motion, table: Table) -> dict[str, Array]:
    base = table["relative_to"]

    def seen(places: Places, t: Any) -> Array:
        r, R = places[base]
        return np.einsum("nji,nj->ni", R, point_of(places, table["body"], table["point"]) - r)

    derivatives = (seen(now.state.places(), now.t)[0].real, *now.state.along(seen, now.t, now.accelerations))
    p = frame(m, now, base) @ derivatives[table["derivative"]]
    along = {"body": table["body"], None: base}.get(table.get("frame"), table.get("frame"))
    return {"": frame(m, now, along).T @ p}


def joint(m: Mechanism, now: Motion, table: Table) -> dict[str, Array]:
    of = m.joints[table["joint"]]
    if of["type"] == "spherical":
        first, second = of["bodies"]
        vector = joints.rotation_vector(of)(now.state.places(), now.t)[0].real
        relative = frame(m, now, second).T @ (spin(m, now, second) - spin(m, now, first))
        return {"rotation_vector": vector, "angular_velocity": relative}
    found = {}
    for kind in joints.COORDINATES[of["type"]]:
        q = joints.coordinate(of, kind)
        rate = {"angle": "rate", "displacement": "speed"}.get(kind, kind.replace("angle", "rate"))
        rate = f"{kind}_rate" if kind in ("x", "y") else rate
        found[kind] = q(now.state.places(), now.t)[0, 0].real
        found[rate] = now.state.along(q, now.t)[0][0]
    return found


def rotation_error(m: Mechanism, now: Motion, table: Table) -> dict[str, Array]:
    target = frame(m, now, table["relative_to"]) @ exp(np.array(table["target"]["rotation_vector"]))
    e = log(target.T @ frame(m, now, table["body"]))
    return {"": e, "angle": np.linalg.norm(e)}


def angular_velocity(m: Mechanism, now: Motion, table: Table) -> dict[str, Array]:
    w = spin(m, now, table["body"]) - spin(m, now, table["relative_to"])
    return {"": frame(m, now, table["body"] if table["frame"] == "body" else table["frame"]).T @ w}


def joint_load(m: Mechanism, now: Motion, of: Table) -> tuple[Array, Array]:
    """On the second body at its point, global."""
    first, second = of["bodies"]
    sign, body = (1.0, second) if second != "ground" else (-1.0, first)
    own, R = m.index(body), frame(m, now, body)
    force, torque = sign * now.loads[of["name"]][own][:3], sign * (R @ now.loads[of["name"]][own][3:])
    r = now.state.r[own.start // 6]
    places = now.state.places()
    at = point_of(places, second, of["points"][1])[0].real if "points" in of else places[second][0][0].real
    return force, torque - np.cross(at - r, force)


def reaction(m: Mechanism, now: Motion, table: Table) -> dict[str, Array]:
    of = m.joints[table["joint"]]
    ends = dict(zip(("first", "second"), of["bodies"], strict=True))
    R = frame(m, now, ends.get(table["frame"], "global"))
    return {name: R.T @ x for name, x in zip(("force", "torque"), joint_load(m, now, of), strict=True)}


def driver_effort(m: Mechanism, now: Motion, table: Table) -> dict[str, Array]:
    """Of a point the force, of an orientation the torque along the axes of the body."""
    driver = m.drivers[table["driver"]]
    if "joint" in driver or joints.form(driver) == "angular_velocity":
        effort = now.efforts[table["driver"]]
        return {"": effort[0] if len(effort) == 1 else effort}
    own = now.loads[table["driver"]][m.index(driver["body"])]
    return {"": own[:3] if driver["motion"] == "point" else own[3:]}


def momentum(m: Mechanism, now: Motion, table: Table) -> dict[str, Array]:
    some = [m.index(name).start // 6 for name in table.get("bodies", m.bodies)]
    s, mass = now.state, m.mass[some]
    p = mass @ s.v[some]
    about, moving = np.array(table.get("about", [0.0] * 3)) if table.get("about") != "mass_centre" else None, 0.0
    if about is None:
        about, moving = mass @ s.r[some] / mass.sum(), p / mass.sum()
    angular = [s.R[i] @ (m.inertia[i] @ s.w[i]) + m.mass[i] * np.cross(s.r[i] - about, s.v[i] - moving) for i in some]
    return {"linear": p, "angular": np.sum(angular, axis=0)}


def expression(m: Mechanism, now: Motion, table: Table) -> dict[str, Array]:
    return {"": np.asarray(number(table["value"])(now.t))}


SEEN: dict[str, Callable[[Mechanism, Motion, Table], dict[str, Array]]] = {
    "point": point,
    "joint": joint,
    "rotation_error": rotation_error,
    "angular_velocity": angular_velocity,
    "reaction": reaction,
    "driver_effort": driver_effort,
    "momentum": momentum,
    "expression": expression,
}
REACTIONS = ("reaction", "driver_effort")  # which are unique only where rows are independent
