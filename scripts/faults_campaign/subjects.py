"""What is attacked: small datasets of every kind that lienumba writes, a sweep that was interrupted, parts of one."""

import contextlib
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

TOP = {
    "title": "pendulum", "model": {
        "bodies": [{"name": "bob", "mass": 1.0, "inertia": [0.1, 0.1, 0.1], "position": [1, 0, 0]}],
        "joints": [{"name": "pivot", "type": "revolute", "bodies": ["ground", "bob"], "at": [0, 0, 0],
                    "axis": [0, 1, 0]}],
    },
    "quantities": [{"name": "tip", "type": "point", "body": "bob", "point": [1, 0, 0]}],
    "events": [{"name": "low", "when": "tip.z < -0.02"}],
    "integrator": {"method": "rk4", "step": 0.02, "end_time": 0.2},
}  # fmt: skip
SWEEP = {"runs": 4, "vary": {"bodies.bob.mass": {"distribution": "normal", "mean": 1.0, "std": 0.1}}}
WANTED = [{"name": "not too low", "value": "lowest", "above": -0.363, "probability": 0.9}]
SUMMARY = {"every": 0.02, "mode": "summary", "full_runs": "1:3", "summary": {"tip": ["max", "rms"]}}
LOW = {"sweep": SWEEP, "measures": [{"name": "lowest", "value": "min(tip.z)"}], "requirements": WANTED}
KINDS: dict[str, dict[str, Any]] = {
    "full": {"sweep": SWEEP, "output": {"every": 0.02, "joint_coordinates": True}},
    "summary": {"sweep": SWEEP, "output": SUMMARY},
    "study": {"sweep": {"runs": 2, "vary": SWEEP["vary"]}, "study": {
        "reference": {"step": 0.002}, "grid": [{"integrator.step": [0.02, 0.01]}]}},
    "changes": {**LOW, "events": [{"name": "low", "when": "tip.z < -0.02", "action": "lock", "joint": "pivot"}],
                "noise": [{"name": "gust", "type": "white", "std": 0.1, "every": 0.05}]},
    "modes": {"sweep": SWEEP},
    "rare": LOW,
}  # fmt: skip
LONG = {"sweep": {**SWEEP, "runs": 64}, "output": {**SUMMARY, "full_runs": "1:9,40"}}  # some shards
PARTS = 3


def scenario(kind: str) -> dict[str, Any]:
    return {**TOP, **KINDS[kind]}


def prepared(folder: Path) -> dict[str, Path]:
    """Datasets as they should be."""
    import lienumba

    found = {name: folder / f"{name}.nc" for name in KINDS}
    with _quiet():
        for name, path in found.items():
            if name == "modes":
                lienumba.modes(scenario(name)).to_netcdf(path, engine="netcdf4")
            elif name == "rare":
                lienumba.rare(scenario(name), method="form", workers=1).to_netcdf(path, engine="netcdf4")
            else:
                lienumba.run(scenario(name), output=path, workers=1).close()
    return found


def interrupted(folder: Path) -> tuple[Path, Path]:
    """A sweep that nobody disturbed, and one of which only some shards are there."""
    import lienumba
    from lienumba.store import shards

    whole, begun, pause = folder / "long.nc", folder / "begun.nc", shards.PAUSE

    def stop(event: Any) -> None:
        if event.done:
            raise KeyboardInterrupt

    shards.PAUSE = 0.0
    try:
        with _quiet():
            lienumba.run({**TOP, **LONG}, output=whole, workers=1).close()
            with contextlib.suppress(KeyboardInterrupt):
                lienumba.run({**TOP, **LONG}, output=begun, workers=1, progress=stop)
    finally:
        shards.PAUSE = pause
    return whole, begun


def parts(folder: Path) -> list[Path]:
    """The parts of a sweep, of which the last is of another one."""
    import lienumba

    found = [folder / f"part{n}.nc" for n in range(PARTS + 1)]
    with _quiet():
        for n, path in enumerate(found):
            data = {**TOP, **LONG, **({"title": "another"} if n == PARTS else {})}
            part = f"{min(n + 1, PARTS)}/{PARTS}"
            lienumba.run(data, output=path, part=part, workers=1, seed=7 if n == PARTS else None).close()
    return found


@contextlib.contextmanager
def _quiet() -> Iterator[None]:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        yield
