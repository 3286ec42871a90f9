"""Scenarios of what the oracles know: small mechanisms whose modes change."""

from typing import Any

import numpy as np

from tests.oracles.changing.panels import Chain
from tests.rigs import parts
from tests.rigs.parts import AT_REST, table

G = 9.81
__all__ = ["AT_REST", "G", "ball", "block", "eight", "kinds", "panels", "scenario", "settings", "statuses", "table"]


def settings(end: float, tolerance: float = 1e-12, **integrator: Any) -> dict[str, Any]:
    """dop853 with a tolerance, or as told."""
    return {"method": "dop853", "tolerance": tolerance, "end_time": end} | integrator


def scenario(title: str, model: dict[str, Any], end: float, tolerance: float = 1e-12, **integrator: Any) -> Any:
    """A mechanism with these settings, stored at the start and the end."""
    return {
        "title": title, "model": model, "integrator": settings(end, tolerance, **integrator),
        "output": {"times": [0, end]},
    }  # fmt: skip


def ball(radius: float, J: float, end: float, **contact: Any) -> dict[str, Any]:
    """A ball of 1 kg on a plane; everything about it is for a sweep to vary."""
    body = parts.resting("ball", 1, J, [0, 0, radius])
    floor = {
        "name": "floor", "type": "sphere_plane", "bodies": ["ball", "ground"], "radius": radius,
        "restitution": 0.5, "friction": 0.3, "rest_speed": 0.05,
    }  # fmt: skip
    return scenario("A ball", {"gravity": [0, 0, -G], "bodies": [body], "contacts": [floor | contact]}, end)


def kinds(ds: Any, kind: str) -> Any:
    """Which of the changes are of this kind."""
    names = ds.change_kind.flag_meanings.split()
    return ds.change_kind.values == ds.change_kind.flag_values[names.index(kind)]


def statuses(ds: Any) -> list[str]:
    """Of all runs."""
    names = dict(zip(ds.status.flag_values.tolist(), ds.status.flag_meanings.split(), strict=True))
    return [names[x] for x in ds.status.values.tolist()]


def panels(chain: Chain, q: np.ndarray, latch: np.ndarray, let_go: list[float], end: float) -> dict[str, Any]:
    """The oracle's chain: z axes, hinge i held until let_go[i], latched where its angle reaches latch[i]."""
    free = bool(chain.base)
    bodies, joints, forces, quantities, events = [], [], [], [], []
    if free:
        bodies.append(parts.resting("hub", chain.hub[0], chain.hub[1]))
        quantities.append({"name": "momentum", "type": "momentum"})
    before, end_point = ("hub", chain.hub[2]) if free else ("ground", 0.0)
    for i, (m, length, J) in enumerate(zip(chain.m, chain.l, chain.J, strict=True)):
        bodies.append(parts.body(f"panel_{i}", m, J))
        start = {"angle": q[chain.base + i], "rate": 0}
        turns = parts.frames(parts.Z, [end_point, 0, 0], [-0.5 * length, 0, 0]) | start
        joints.append(parts.joint(f"hinge_{i}", "revolute", f"panel_{i}", before, **turns))
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
    model = {
        "gravity": [0, 0, -G],
        "bodies": [parts.body("block")],
        "joints": [parts.slide("slide", "block", displacement=0, speed=0)],
        "forces": [parts.dry("slide", 3.0, 4.0) | force],
    }
    return scenario("A block", model, end)
