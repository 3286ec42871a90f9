"""The numbers that the paper prints in section 7, and what lienumba gives for each."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from section7 import measures
from section7.runs import simulated

State = tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]  # r, R, v, w over time


@dataclass(frozen=True)
class Row:
    """paper: as printed, or in words; here: what a run gives; note: the letter of a remark."""

    figure: str
    what: str
    step: float
    tolerance: float | None
    paper: float | str
    here: float
    note: str = ""


def state(run: Any, body: str) -> State:
    here = run.sel(body=body)
    r, R, v, w = (here[name].values for name in ("position", "rotation", "velocity", "angular_velocity"))
    return r, R, v, w


def top_errors(run: Any) -> dict[str, np.ndarray]:
    """(31) at all times, of the heavy top's pivot."""
    r, R, v, w = state(run, "top")
    return {"position": measures.top_positions(r, R), "velocity": measures.top_velocities(R, v, w)}


def shoulder_errors(run: Any) -> dict[str, np.ndarray]:
    """(31) at all times, of the satellite's spherical joint."""
    (_, R1, _, w1), (r2, R2, v2, w2) = state(run, "satellite"), state(run, "base_rod")
    return {
        "position": measures.shoulder_positions(r2, R1, R2),
        "velocity": measures.shoulder_velocities(v2, R1, w1, R2, w2),
    }


def heavy_top_free() -> list[Row]:
    """Not stabilised."""
    R = state(simulated("heavy_top", 1e-4), "top")[1]
    orthogonality = float(np.abs(measures.gram(R) - np.eye(3)).max())
    determinant = float(np.abs(measures.determinant(R) - 1.0).max())
    rows = [
        Row("8", "orthogonality: largest element of R R^T - I", 1e-4, None, "rounding", orthogonality),
        Row("8", "largest det R - 1", 1e-4, None, "rounding", determinant),
    ]
    for figure, kind, printed, note in (
        ("9", "position", {1e-4: 7.393e-8, 1e-5: 7.359e-12}, "a"),
        ("12", "velocity", {1e-4: 7.196e-8, 1e-5: 7.199e-12}, ""),
    ):
        for step, value in printed.items():
            here = float(top_errors(simulated("heavy_top", step))[kind][-1])
            rows.append(Row(figure, f"{kind} error (31) after 2 s, not stabilised", step, None, value, here, note))
    return rows


def heavy_top_stabilised() -> list[Row]:
    rows: list[Row] = []
    for figure, step, tolerance in (("10", 1e-3, 1e-7), ("11", 1e-4, 1e-11)):
        run = simulated("heavy_top", step, "local", "mass", tolerance)
        rows += _largest(figure, "position", top_errors(run), step, tolerance)
        rows.append(_iterations("15", "position", run, step, tolerance, 2))
    for figure, tolerance in (("13", 5e-4), ("14", 1e-7)):
        for weight, name in (("identity", "W = I"), ("mass", "W = M")):
            run = simulated("heavy_top", 1e-3, "local", weight, tolerance)
            rows += _largest(figure, "velocity", top_errors(run), 1e-3, tolerance, f", {name}")
            rows.append(_iterations("15", "velocity", run, 1e-3, tolerance, 2, f", {name}"))
    finest = top_errors(simulated("heavy_top", 1e-5, "local", "identity", 1e-14))
    largest = float(finest["position"].max())
    rows.append(Row("19", "largest position error (31), the paper's in the end", 1e-5, 1e-14, 1e-24, largest, "c"))
    return rows + _largest("21", "velocity", finest, 1e-5, 1e-14, ", W = I")


def satellite() -> list[Row]:
    rows: list[Row] = []
    for figures, step, tolerance in ((("22", "24"), 1e-2, 1e-10), (("23", "25"), 1e-3, 1e-11)):
        for weight, name in (("identity", "W = I"), ("mass", "W = M")):
            run = simulated("satellite", step, "local", weight, tolerance)
            for figure, kind, more in zip(figures, ("position", "velocity"), ("", f", {name}"), strict=True):
                if kind == "velocity" or weight == "mass":
                    here = float(run[f"{kind}_violation"].max())
                    what = f"largest {kind} violation of all joints{more}"
                    rows.append(Row(figure, what, step, tolerance, tolerance, here, "b"))
                    rows.append(_iterations(figure, kind, run, step, tolerance, 3, more))
    return sorted(rows, key=lambda row: int(row.figure))


def satellite_finely() -> list[Row]:
    """A million steps."""
    errors = shoulder_errors(simulated("satellite", 1e-5, "local", "identity", 1e-14))
    last = Row(
        "18", "position error (31) of the shoulder, in the end", 1e-5, 1e-14, 1e-16, float(errors["position"][-1])
    )
    return [last, *_largest("20", "velocity", errors, 1e-5, 1e-14, " of the shoulder, W = I")]


def _largest(
    figure: str, kind: str, errors: dict[str, np.ndarray], step: float, tolerance: float, more: str = ""
) -> list[Row]:
    what = f"largest {kind} error (31){more}"
    return [Row(figure, what, step, tolerance, tolerance, float(errors[kind].max()), "b")]


def _iterations(figure: str, kind: str, run: Any, step: float, tolerance: float, limit: int, more: str = "") -> Row:
    here = float(run[f"{kind}_iterations"].max())
    return Row(figure, f"most iterations for the {kind}{more}", step, tolerance, f"at most {limit}", here)
