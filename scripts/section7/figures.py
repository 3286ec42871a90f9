"""The figures of section 7, by their numbers."""

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from document import text
from section7 import measures
from section7.numbers import shoulder_errors, state, top_errors
from section7.runs import simulated

WIDE, TALL = 7.5, 4.2  # inches
NEAR = 0.5  # s: the top turns twelve times
LEAST = 1e-18  # where zeros are drawn on logarithmic axes
POSITION, VELOCITY = "relative position error (31)", "relative velocity error (31)"
WEIGHTS = (("identity", "W = I"), ("mass", "W = M"))
ONE, PLAIN = (("mass", ""),), (("identity", ""),)  # where there is nothing to compare


def _axes(rows: int = 1, label: str = "") -> tuple[Figure, Any]:
    """Axes over time, one below the other."""
    figure, axes = plt.subplots(rows, 1, sharex=True, figsize=(WIDE, TALL + 1.6 * (rows - 1)), layout="constrained")
    (axes if rows == 1 else axes[-1]).set_xlabel("t, s")
    if label:
        axes.set_ylabel(label)
    return figure, axes


def _lines(axes: Axes, t: np.ndarray, curves: Iterable[tuple[str, np.ndarray]]) -> None:
    for name, values in curves:
        axes.plot(t, values, linewidth=0.9, label=name)
    _legend(axes)


def _violations(axes: Axes, t: np.ndarray, curves: Iterable[tuple[str, np.ndarray]], tolerance: float = 0.0) -> None:
    """On a logarithmic axis, with the tolerance."""
    axes.set_yscale("log")
    zeros = False
    for n, (name, values) in enumerate(curves):
        zeros = zeros or bool((values[1:] == 0.0).any())
        axes.plot(t[1:], np.maximum(values[1:], LEAST), ".", markersize=2.5 - n % 2, label=name)
    if tolerance:
        axes.axhline(tolerance, color="black", linewidth=0.8, linestyle="--", label=f"Tol = {text(tolerance)}")
    if zeros:
        note = f"drawn at {text(LEAST)}: exactly 0"
        axes.text(0.99, 0.02, note, transform=axes.transAxes, ha="right", fontsize="x-small")
    axes.set_ylim(bottom=LEAST / 10)
    _legend(axes)


def _legend(axes: Axes) -> None:
    axes.grid(alpha=0.3)
    axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), fontsize="small", markerscale=4.0)


def _time(run: Any) -> np.ndarray:
    return np.asarray(run["time"].values, float)


# ---------------------------------------------------------------- the heavy top, not stabilised, h = 1e-4
def _free() -> tuple[np.ndarray, Any]:
    run = simulated("heavy_top", 1e-4)
    return _time(run), state(run, "top")


def mass_centre() -> Figure:
    t, (r, _, _, _) = _free()
    figure, axes = _axes(label="mass centre, m")
    _lines(axes, t, [(name, r[:, i]) for i, name in enumerate("xyz")])
    return figure


def rotation_matrix() -> Figure:
    t, (_, R, _, _) = _free()
    figure, rows = _axes(3)
    for i, axes in enumerate(rows):
        axes.set_ylabel(f"row {i + 1} of R")
        _lines(axes, t, [(f"$R_{{{i + 1}{j + 1}}}$", R[:, i, j]) for j in range(3)])
    return figure


def rotation_vector_y() -> Figure:
    t, (_, R, _, _) = _free()
    figure, axes = _axes(label=r"$\Psi_y$, rad")
    _near(axes, t, [(r"$\Psi_y$", measures.rotation_vector(R)[:, 1])])
    return figure


def rotation_vector_norm() -> Figure:
    t, (_, R, _, _) = _free()
    figure, axes = _axes(label=r"$\|\Psi\|$, rad")
    _near(axes, t, [(r"$\|\Psi\|$", measures.norm(measures.rotation_vector(R)))])
    return figure


def tait_bryan_angles() -> Figure:
    t, (_, R, _, _) = _free()
    figure, rows = _axes(3)
    names = (r"$\varphi$ (about x)", r"$\theta$ (about y)", r"$\psi$ (about z)")
    for axes, name, angle in zip(rows, names, measures.tait_bryan(R), strict=True):
        axes.set_ylabel("rad")
        _near(axes, t, [(name, angle)])
    return figure


def _near(axes: Axes, t: np.ndarray, curves: Iterable[tuple[str, np.ndarray]]) -> None:
    """The first turns alone, else the curves run into one another."""
    shown = t <= NEAR
    _lines(axes, t[shown], [(name, values[shown]) for name, values in curves])


def orthogonality() -> Figure:
    t, (_, R, _, _) = _free()
    figure, axes = _axes(label="difference")
    gram = measures.gram(R)
    curves = [(f"$(RR^T)_{{{i + 1}{i + 1}}} - 1$", gram[:, i, i] - 1.0) for i in range(3)]
    _lines(axes, t, [*curves, (r"$\det R - 1$", measures.determinant(R) - 1.0)])
    return figure


# ---------------------------------------------------------------- the heavy top, stabilised
def _top(kind: str, step: float, tolerance: float, free: bool = False, weights: Any = ONE) -> Figure:
    figure, axes = _axes(label=POSITION if kind == "position" else VELOCITY)
    t, curves = np.zeros(0), []
    if free:
        run = simulated("heavy_top", step)
        t, curves = _time(run), [("without", top_errors(run)[kind])]
    for weight, name in weights:
        run = simulated("heavy_top", step, "local", weight, tolerance)
        t = _time(run)
        curves.append((f"stabilised\n{name}".strip(), top_errors(run)[kind]))
    _violations(axes, t, curves, tolerance)
    return figure


def iterations() -> Figure:
    figure, rows = _axes(2)
    cases = {
        "position": [(1e-3, 1e-7, "mass"), (1e-4, 1e-11, "mass")],
        "velocity": [(1e-3, 5e-4, "mass"), (1e-3, 1e-7, "mass"), (1e-3, 1e-7, "identity")],
    }
    for axes, (kind, runs) in zip(rows, cases.items(), strict=True):
        for n, (step, tolerance, weight) in enumerate(runs):
            run = simulated("heavy_top", step, "local", weight, tolerance, every=step)
            weighted = "" if kind == "position" else f"\n{dict(WEIGHTS)[weight]}"
            label = f"h = {text(step)}, Tol = {text(tolerance)}{weighted}"
            axes.plot(_time(run)[1:], run[f"{kind}_iterations"].values[1:] + 0.04 * n, linewidth=1.2, label=label)
        axes.set(ylim=(0.0, 3.2), yticks=range(4), ylabel=f"iterations, {kind}")
        _legend(axes)
    return figure


# ---------------------------------------------------------------- the satellite
def _shoulder(kind: str) -> Figure:
    run = simulated("satellite", 1e-5, "local", "identity", 1e-14)
    figure, axes = _axes(label=POSITION if kind == "position" else VELOCITY)
    _violations(axes, _time(run), [("shoulder", shoulder_errors(run)[kind])], 1e-14)
    return figure


def _satellite(kind: str, step: float, tolerance: float, weights: Any) -> Figure:
    unit = "m" if kind == "position" else "m/s"
    figure, axes = _axes(label=f"largest {kind} violation, {unit}")
    free = simulated("satellite", step)
    curves = [("without", free[f"{kind}_violation"].values)]
    for weight, name in weights:
        run = simulated("satellite", step, "local", weight, tolerance)
        curves.append((f"stabilised\n{name}".strip(), run[f"{kind}_violation"].values))
    _violations(axes, _time(free), curves, tolerance)
    return figure


FIGURES: dict[str, tuple[str, Callable[[], Figure]]] = {
    "03": ("Heavy top: mass centre, h = 1e-4", mass_centre),
    "04": ("Heavy top: elements of R, h = 1e-4", rotation_matrix),
    "05": (r"Heavy top: component of the rotation vector, $\|\Psi\| \leq \pi$", rotation_vector_y),
    "06": ("Heavy top: norm of the rotation vector", rotation_vector_norm),
    "07": ("Heavy top: Tait-Bryan angles, rotations 3-2-1", tait_bryan_angles),
    "08": ("Heavy top: how well R stays a rotation, h = 1e-4", orthogonality),
    "09": ("Heavy top: positions, h = 1e-3", lambda: _top("position", 1e-3, 1e-7, free=True)),
    "10": ("Heavy top: positions stabilised, h = 1e-3", lambda: _top("position", 1e-3, 1e-7)),
    "11": ("Heavy top: positions stabilised, h = 1e-4", lambda: _top("position", 1e-4, 1e-11)),
    "12": ("Heavy top: velocities, h = 1e-3", lambda: _top("velocity", 1e-3, 1e-7, free=True)),
    "13": ("Heavy top: velocities stabilised, h = 1e-3", lambda: _top("velocity", 1e-3, 5e-4, weights=WEIGHTS)),
    "14": ("Heavy top: velocities stabilised, h = 1e-3", lambda: _top("velocity", 1e-3, 1e-7, weights=WEIGHTS)),
    "15": ("Heavy top: iterations in each step (curves moved apart a little)", iterations),
    "18": ("Satellite: positions of the shoulder, h = 1e-5", lambda: _shoulder("position")),
    "19": ("Heavy top: positions, h = 1e-5", lambda: _top("position", 1e-5, 1e-14, weights=PLAIN)),
    "20": ("Satellite: velocities of the shoulder, h = 1e-5, W = I", lambda: _shoulder("velocity")),
    "21": ("Heavy top: velocities, h = 1e-5, W = I", lambda: _top("velocity", 1e-5, 1e-14, weights=PLAIN)),
    "22": ("Satellite: positions, h = 1e-2", lambda: _satellite("position", 1e-2, 1e-10, ONE)),
    "23": ("Satellite: positions, h = 1e-3", lambda: _satellite("position", 1e-3, 1e-11, ONE)),
    "24": ("Satellite: velocities, h = 1e-2", lambda: _satellite("velocity", 1e-2, 1e-10, WEIGHTS)),
    "25": ("Satellite: velocities, h = 1e-3", lambda: _satellite("velocity", 1e-3, 1e-11, WEIGHTS)),
}


def draw(folder: Path, number: str) -> Path:
    """One figure as PNG; its file."""
    title, make = FIGURES[number]
    figure = make()
    figure.suptitle(f"Fig. {int(number)}.  {title}", fontsize="medium")
    file = folder / f"figure_{number}.png"
    figure.savefig(file, dpi=130)
    plt.close(figure)
    return file
