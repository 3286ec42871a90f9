"""What measures cost: core time of runs with them against the same runs without, medians of interleaved rounds.

Usage: .venv/bin/python scripts/measures.py [ROUNDS]    (some 2 minutes by 25 rounds; prints a table)
"""

import sys
from typing import Any

import numpy as np

from lienumba.batch.integrate import Batch, integrate
from lienumba.engine.programs import batch_of, compiled_of
from lienumba.scenario.reading.loading import load
from lienumba.scenario.resolve import resolve
from lienumba.scenario.start.prepare import prepare

RUNS, BODIES = 64, 6
FIXED, TOLERANCE = {"method": "rk4", "step": 1e-3}, {"method": "dop853", "tolerance": 1e-9}
ASKED = {
    "none": [],
    "max": ["max(tip.z)"],
    "integral": ["integral(tip.z)"],
    "four": ["max(tip.z)", "rms(tip.x)", "last_time(tip.z > 0.1)", "final(tip.y)"],
    "speed": ["max(speed.z)"],
    "load": ["max(load.force.z)"],
    "mean load": ["rms(load.force.z)"],
}


def quantities(body: str, point: list[float], joint: str) -> list[dict[str, Any]]:
    """The tip of a body, its speed, and what the joint carries that holds all."""
    tip = {"name": "tip", "type": "point", "body": body, "point": point}
    return [tip, tip | {"name": "speed", "derivative": 1}, {"name": "load", "type": "reaction", "joint": joint}]


def top() -> dict[str, Any]:
    """The heavy top, whose spin is scattered."""
    return load("scenarios/heavy_top.toml") | {
        "quantities": quantities("top", [0, 0.2, 0], "pivot"),
        "sweep": {"runs": RUNS, "vary": {"bodies.top.mass": {"distribution": "normal", "std": 0.1}}},
    }


def chain() -> dict[str, Any]:
    """Bodies in a row, by hinges with axes that are not parallel."""
    bodies: list[dict[str, Any]] = []
    joints: list[dict[str, Any]] = []
    for n in range(BODIES):
        bodies.append(
            {"name": f"b{n}", "mass": 1 + 0.1 * n, "inertia": [0.02, 0.01, 0.03], "position": [n + 0.5, 0, 0]}
        )
        ends, axis = [bodies[n - 1]["name"] if n else "ground", f"b{n}"], [0, 1, 0] if n % 2 else [0, 0.6, 0.8]
        joints.append({"name": f"j{n}", "type": "revolute", "bodies": ends, "at": [n, 0, 0], "axis": axis})
    return {
        "model": {"gravity": [0, 0, -9.81], "bodies": bodies, "joints": joints},
        "quantities": quantities(f"b{BODIES - 1}", [0.5, 0, 0], "j0"),
        "sweep": {"runs": RUNS, "vary": {"bodies.b0.mass": {"distribution": "normal", "std": 0.1}}},
    }


CASES = {
    "heavy top, rk4, 1 ms": (top, FIXED, 2.0),
    "heavy top, dop853, 1e-9": (top, TOLERANCE, 6.0),
    "chain of six, rk4, 1 ms": (chain, FIXED, 0.6),
    "chain of six, dop853, 1e-9": (chain, TOLERANCE, 2.0),
}


def ready(raw: dict[str, Any], integrator: dict[str, Any], end: float, asked: list[str]) -> Batch:
    """The runs of a scenario that stores nothing but its ends."""
    measures = [{"name": f"m{n}", "value": text} for n, text in enumerate(asked)]
    more = {"integrator": integrator | {"end_time": end}, "output": {"every": end}, "measures": measures}
    scenario = resolve(raw | more)
    prepared = prepare(scenario, range(RUNS))
    return batch_of(scenario, prepared, *compiled_of(scenario, prepared, True))


def main(rounds: int) -> None:
    print("| |", " | ".join(f"`{', '.join(asked)}`" for asked in ASKED.values() if asked), "|")
    for what, (of, integrator, end) in CASES.items():
        batches = {name: ready(of(), integrator, end, asked) for name, asked in ASKED.items()}
        seconds: dict[str, list[float]] = {name: [] for name in batches}
        for _ in range(rounds + 1):
            for name, batch in batches.items():
                done = integrate(batch, slice(0, RUNS), np.zeros(1, np.int64), np.zeros(1, np.int64))
                seconds[name].append(done.seconds)
        typical = {name: float(np.median(np.divide(x, seconds["none"])[1:])) for name, x in seconds.items()}
        print(f"| {what} |", " | ".join(f"{x:.2f}" for name, x in typical.items() if name != "none"), "|", flush=True)


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 25)
