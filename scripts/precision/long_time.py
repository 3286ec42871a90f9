"""A million steps of the heavy top and of a free body: what should stay as it is, and how far it goes."""

from functools import cache
from typing import Any

import numpy as np

from document import markdown, text
from precision.cases import FREE, gallery, simulated

METHODS = ("euler", "heun", "kutta3", "rk4", "dop853")
STEPS = 1_000_000
STORED = 200  # intervals in which the state is looked at
MOMENTUM = {"quantities": [{"name": "momentum", "type": "momentum"}]}  # about the origin, where the pivot is
CASES = {"heavy top": ("heavy_top", 1e-3), "free body": ("dzhanibekov", 1e-2)}  # s: 0.15 and 0.1 rad in a step
FORMS: dict[str, dict[str, Any]] = {
    "R^3 x SO(3)": {},
    "projected": {},
    "not projected": FREE,
    "SE(3)": {"integrator.group": "SE3"},
    "SE(3), not projected": {"integrator.group": "SE3", **FREE},
    "nine elements": {"integrator.coordinates": "matrix"},
    "quaternion": {"integrator.coordinates": "quaternion"},
}
AS_VECTORS = ("nine elements", "quaternion")  # of one method, to compare with


@cache
def run(name: str, method: str, form: str) -> Any:
    scenario, step = CASES[name]
    end = STEPS * step
    overrides = {"integrator.method": method, "integrator.step": step, "integrator.end_time": end}
    overrides |= {"output": {"every": end / STORED}, **FORMS[form]}
    return simulated(gallery(scenario, **MOMENTUM), overrides).isel(run=0)


def row(name: str, method: str, form: str) -> list[str]:
    """The largest changes, by the initial kinetic energy, momentum and spin; of a run that failed, when."""
    ds = run(name, method, form)
    if int(ds["status"]) != 0:
        step = round(float(ds["end_time"]) / CASES[name][1])
        return [method, form, f"fails in step {step + 1:,}", *[""] * (len(head(name)) - 3)]
    E, L = ds["energy"].values, ds["momentum.angular"].values
    R = ds["rotation"].values[:, 0]
    largest = float(np.sqrt((L[0] ** 2).sum()))
    found = [float(np.abs(E - E[0]).max() / ds["kinetic_energy"].values[0])]
    if name == "heavy top":
        spin = ds["angular_velocity"].values[:, 0, 1]
        found += [float(np.abs(L[:, 2] - L[0, 2]).max()) / largest, float(np.abs(spin / spin[0] - 1.0).max())]
    else:
        found.append(float(np.sqrt(((L - L[0]) ** 2).sum(axis=1)).max()) / largest)
    gram = (R[:, :, None, :] * R[:, None, :, :]).sum(axis=3)
    found.append(float(np.abs(gram - np.eye(3)).max()))
    if name == "heavy top":
        found += [float(ds[f"max_{kind}_violation"]) for kind in ("position", "velocity")]
    return [method, form, *(text(x, rounding=True, digits=2) for x in found)]


def head(name: str) -> list[str]:
    if name == "heavy top":
        kept = ["vertical momentum", "spin", "R R^T - I", "position, m", "velocity, m/s"]
    else:
        kept = ["momentum", "R R^T - I"]
    return ["", "", "energy", *kept]


def rows(name: str) -> list[tuple[str, str]]:
    """Methods and forms; a free body has nothing to project."""
    forms = ["R^3 x SO(3)", "SE(3)"]
    if name == "heavy top":
        forms = ["projected", "not projected", "SE(3)", "SE(3), not projected"]
    return [(method, form) for method in METHODS for form in forms] + [("rk4", form) for form in AS_VECTORS]


def table(name: str) -> str:
    return markdown(head(name), [row(name, method, form) for method, form in rows(name)])
