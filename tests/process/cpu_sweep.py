"""Run by test_cpus.py in processes of their own, with names of sweeps: hashes of every variable's bits, as JSON; of
"modes" eigenvalues.
In the environment LEVEL: of code generation; LANES: how many a row has."""

import hashlib
import json
import os
import struct
import sys
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parents[2]))


def hashes(dataset: Any) -> dict[str, str]:
    return {str(name): hashlib.sha256(dataset[name].values.tobytes()).hexdigest() for name in dataset.variables
            if dataset[name].dtype.kind != "U"}  # fmt: skip


def rotations() -> str:
    """The hash of many rotations as a scenario may give them, in numbers that do not vary."""
    from lienumba.keys.conversions import rotation_of
    from lienumba.keys.types import AxisAngle, Euler

    numbers = []
    for i in range(2000):
        angle = 0.003 * i - 2.0
        numbers += rotation_of(Euler(euler="ZYX", angles=[angle, 1.7 * angle, -0.3 * angle]))
        numbers += rotation_of(AxisAngle(axis=[1, 2, -1], angle=5.0 * angle))
    return hashlib.sha256(struct.pack(f"{len(numbers)}d", *numbers)).hexdigest()


def modes() -> dict[str, list[float]]:
    """Eigenvalues of redundant loops and of bodies that turn about all axes; LAPACK's bits depend on the CPU."""
    import lienumba
    from tests.rigs import sweeps

    found = {name: lienumba.modes(sweeps.SWEEPS[name](runs=12)) for name in ("loop", "links", "top")}
    parts = ("growth", "angular_frequency")
    return {f"{sweep} {part}": ds[part].values.ravel().tolist() for sweep, ds in found.items() for part in parts}


def main(names: list[str]) -> None:
    from lienumba.compiler import rows

    rows.W = int(os.environ.get("LANES", rows.W))  # before any other module takes it from there
    rows.ROW = 8 * rows.W

    from lienumba.compiler import native
    from tests.rigs import sweeps

    native.LEVEL = int(os.environ.get("LEVEL", native.LEVEL))
    every = sweeps.SWEEPS | {"paced": sweeps.paced, "bounces": sweeps.bounces}
    found = {name: hashes(sweeps.run(every[name](runs=12))) for name in names if name in every}
    if "rotations" in names:
        found["rotations"] = {"given": rotations()}
    numbers = modes() if "modes" in names else {}
    json.dump({"cpu": native.cpu(), "hashes": found, "modes": numbers}, sys.stdout)


if __name__ == "__main__":
    main(sys.argv[1:])
