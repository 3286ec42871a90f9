"""What a call costs beside its steps: `lienumba.run` in a loop, `Prepared.run`, and a whole process."""

import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from statistics import median
from typing import Any

import lienumba

ROOT = Path(__file__).resolve().parents[2]
STEPS = 100
COMMAND = "import sys; from lienumba.cli import main; sys.argv[0] = 'lienumba'; main()"


def top(**more: Any) -> dict[str, Any]:
    """The heavy top of the gallery, one run of a hundred steps."""
    data = lienumba.System.from_toml(ROOT / "scenarios" / "heavy_top.toml").to_dict()
    return data | {"integrator": data["integrator"] | {"end_time": STEPS * data["integrator"]["step"]}, **more}


def chain(links: int = 8) -> dict[str, Any]:
    """Links on hinges, let go from rest."""
    system, last = lienumba.System("Chain"), "ground"
    for n in range(links):
        name = f"link{n}"
        system.body(name, mass=1.0 + 0.1 * n, inertia=[0.1, 0.2, 0.3], position=[n + 0.5, 0, 0])
        system.joint(f"hinge{n}", "revolute", [last, name], at=[n, 0, 0], axis=[0, 1, 0])
        last = name
    return system.integrator(step=1e-3, end_time=STEPS * 1e-3).to_dict()


def times(call: Callable[[int], object], repeats: int) -> dict[str, float]:
    """Milliseconds on the clock and of the cores; the first calls compile."""
    wall, core = [], []
    for n in range(repeats + 3):
        before = time.perf_counter(), time.process_time()
        call(n)
        wall.append(1e3 * (time.perf_counter() - before[0]))
        core.append(1e3 * (time.process_time() - before[1]))
    return {"wall_min": min(wall[3:]), "wall_median": median(wall[3:]), "core_min": min(core[3:])}


def process(repeats: int) -> dict[str, float]:
    """Milliseconds of `lienumba run scenarios/heavy_top.toml`, from the start of the process to its end."""
    with tempfile.TemporaryDirectory() as folder:
        words = ["run", "scenarios/heavy_top.toml", "--overwrite", "-q", "-o", f"{folder}/top.nc"]

        def call(_: int) -> None:
            subprocess.run([sys.executable, "-c", COMMAND, *words], cwd=ROOT, check=True)

        found = times(call, repeats)
    return {name: x for name, x in found.items() if name != "core_min"}


def measured(repeats: int) -> dict[str, dict[str, float]]:
    """The four figures; every call has other numbers than those before it."""
    first, many = top(), chain()
    ready = lienumba.prepare(first)

    def mass(body: str, n: int) -> dict[str, float]:
        return {f"bodies.{body}.mass": 10.0 + 0.01 * n}

    return {
        "run, heavy top": times(lambda n: lienumba.run(first, overrides=mass("top", n)), repeats),
        "run, chain of 8": times(lambda n: lienumba.run(many, overrides=mass("link3", n)), max(repeats // 3, 3)),
        "prepared.run, heavy top": times(lambda n: ready.run(mass("top", n)), repeats),
        "a whole process, heavy top": process(max(repeats // 10, 3)),
    }
