"""Scenarios of what the oracles know: small mechanisms whose modes change."""

from typing import Any

import numpy as np

from tests.oracles.changing.panels import Chain

G = 9.81
AT_REST = {"velocity": [0, 0, 0], "angular_velocity": [0, 0, 0]}


def settings(end: float, tolerance: float = 1e-12, **integrator: Any) -> dict[str, Any]:
    """dop853 with a tolerance, or as told."""
    return {"method": "dop853", "tolerance": tolerance, "end_time": end} | integrator


def ball(radius: float, J: float, end: float, **contact: Any) -> dict[str, Any]:
    """A ball of 1 kg on a plane; everything about it is for a sweep to vary."""
    body = {"name": "ball", "mass": 1, "inertia": [J] * 3, "position": [0, 0, radius], "rotation": [1, 0, 0, 0]}
    floor = {
        "name": "floor", "type": "sphere_plane", "bodies": ["ball", "ground"], "radius": radius,
        "restitution": 0.5, "friction": 0.3, "rest_speed": 0.05,
    }  # fmt: skip
    model = {"gravity": [0, 0, -G], "bodies": [body | AT_REST], "contacts": [floor | contact]}
    return {"title": "A ball", "model": model, "integrator": settings(end), "output": {"times": [0, end]}}


def kinds(ds: Any, kind: str) -> Any:
    """Which of the changes are of this kind."""
    names = ds.change_kind.flag_meanings.split()
    return ds.change_kind.values == ds.change_kind.flag_values[names.index(kind)]


def table(columns: dict[str, Any]) -> dict[str, Any]:
    """A sweep over these numbers."""
    return {"sampler": "table", "table": {"columns": columns}}


def panels(chain: Chain, q: np.ndarray, latch: np.ndarray, let_go: list[float], end: float) -> dict[str, Any]:
    """The oracle's chain: z axes, hinge i held until let_go[i], latched where its angle reaches latch[i]."""
    free = bool(chain.base)
    bodies, joints, forces, quantities, events = [], [], [], [], []
    if free:
        hub = {"name": "hub", "mass": chain.hub[0], "inertia": [chain.hub[1]] * 3, "position": [0, 0, 0]}
        bodies.append(hub | {"rotation": [1, 0, 0, 0]} | AT_REST)
        quantities.append({"name": "momentum", "type": "momentum"})
    before, end_point = ("hub", chain.hub[2]) if free else ("ground", 0.0)
    for i, (m, length, J) in enumerate(zip(chain.m, chain.l, chain.J, strict=True)):
        bodies.append({"name": f"panel_{i}", "mass": m, "inertia": [J, J, J]})
        joints.append({
            "name": f"hinge_{i}", "type": "revolute", "bodies": [before, f"panel_{i}"],
            "points": [[end_point, 0, 0], [-0.5 * length, 0, 0]], "axes": [[0, 0, 1]] * 2,
            "references": [[1, 0, 0]] * 2,
            "angle": q[chain.base + i], "rate": 0,
        })  # fmt: skip
        before, end_point = f"panel_{i}", 0.5 * length
        forces.append({
            "name": f"spring_{i}", "type": "torsion_spring", "joint": f"hinge_{i}", "stiffness": chain.stiffness[i],
            "damping": chain.damping[i], "free_angle": chain.free[i],
        })  # fmt: skip
        quantities.append({"name": f"at_{i}", "type": "joint", "joint": f"hinge_{i}"})
        side = ">" if latch[i] > q[chain.base + i] else "<"
        latches = {"name": f"latch_{i}", "when": f"at_{i}.angle {side} {float(latch[i])!r}", "action": "lock"}
        events.append(latches | {"joint": f"hinge_{i}"})
        if let_go[i] > 0:
            joints[-1]["locked"] = True
            events.append({
                "name": f"let_go_{i}", "when": f"t > {let_go[i]!r}", "action": "unlock", "joint": f"hinge_{i}",
            })  # fmt: skip
    return {
        "title": "Panels", "model": {"gravity": [0, 0, 0], "bodies": bodies, "joints": joints, "forces": forces},
        "quantities": quantities, "events": events, "integrator": settings(end, coordinates="joint"),
        "output": {"times": [0, end], "max_changes": 2 * len(chain.m)},
    }  # fmt: skip


def eight(seed: int = 1) -> tuple[Chain, np.ndarray, np.ndarray, list[float], float]:
    """Eight panels, folded to and fro, on a free hub: each is let go and latches, 16 changes."""
    n, scatter = 8, np.random.default_rng(seed)
    m, length = np.full(n, 5.0), np.ones(n)
    turn = np.where(np.arange(n) % 2 == 0, -1.0, 1.0)
    q = np.concatenate([np.zeros(3), turn * np.pi])
    q[3] = -np.pi / 2
    chain = Chain(
        m, length, m * length**2 / 12, scatter.uniform(2, 4, n), -0.5 * turn, np.full(n, 0.5), (200.0, 80.0, 1.0)
    )  # fmt: skip
    return chain, q, np.zeros(n), [0.1 + 0.2 * i for i in range(n)], 8.0


def block(end: float, **force: Any) -> dict[str, Any]:
    """A block of 1 kg on a slide along x with dry friction that sticks, on a spring."""
    friction = {"name": "dry", "type": "friction", "joint": "slide", "static": 4.0, "coulomb": 3.0}
    return {
        "title": "A block",
        "model": {
            "gravity": [0, 0, -G],
            "bodies": [{"name": "block", "mass": 1, "inertia": [0.1] * 3}],
            "joints": [
                {
                    "name": "slide", "type": "prismatic", "bodies": ["ground", "block"], "points": [[0, 0, 0]] * 2,
                    "axes": [[1, 0, 0]] * 2, "references": [[0, 1, 0]] * 2, "displacement": 0, "speed": 0,
                }
            ],
            "forces": [friction | force],
        },
        "integrator": settings(end),
        "output": {"times": [0, end]},
    }  # fmt: skip
