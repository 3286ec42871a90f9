"""Which number of a force or driver becomes undefined where a run failed.

The last good state moves on with its velocities through one step more; numbers that read it are evaluated on the way.
"""

from collections.abc import Iterator, Mapping
from math import isfinite
from typing import Any

import numpy as np

from lienumba.engine.requirements import Column
from lienumba.engine.simulate import Runs
from lienumba.groups import so3
from lienumba.groups.state import ELEMENT
from lienumba.mechanics.elements.quantities import component, evaluate
from lienumba.mechanics.mechanism import kinematics
from lienumba.mechanics.mechanism.kinematics import Instant
from lienumba.mechanics.mechanism.model import Law, Model
from lienumba.scenario.resolve import Scenario
from lienumba.scenario.start.prepare import prepare
from lienumba.scenario.study_errors import STATE
from lienumba.words import listed, show

PARTS = (0.0, *np.geomspace(1e-6, 1.0, 25).tolist())  # of a step


def first_undefined(resolved: Scenario, runs: Runs, column: Column, label: int) -> str:
    """The law, its formula and arguments, the time and the run; empty where none is found.

    Parameters
    ----------
    resolved : Scenario
        Of the sweep.
    runs : Runs
        All of it.
    column : function
        Of the name of a variable and labels, its values (runs, ...).
    label : int
        A run that ended as it became infinite or undefined.
    """
    which = np.array([label])
    chosen = runs.part(np.isin(runs.labels, which))
    model = prepare(resolved, [label], chosen.samples, nominal=chosen.nominal).model
    parts = [column(f"last_{name}", which)[0].reshape(len(model.bodies), -1) for name in STATE]
    state, end = np.concatenate(parts, axis=1), float(column("end_time", which)[0])
    step = resolved.data.integrator.step or end / max(float(column("steps", which)[0]), 1.0)
    for part in PARTS:
        view = kinematics.still(_moved(state, end, part * step), tuple(range(len(model.bodies))))
        for place, number in _numbers(model):
            if not isfinite(_value(model, number, view)):
                names = number.quantities if isinstance(number, Law) else ()
                values = [f"{name} = {show(_float(component(model, name, view)))}" for name in names]
                told = f" where {listed(values)}" if values else ""
                return (
                    f"{place}: undefined at t = {view.t:.6g} s in run {label}{told}; write it so that it has a value "
                    "everywhere the motion comes to"
                )
    return ""


def _numbers(model: Model) -> Iterator[tuple[str, Any]]:
    """The numbers of forces and drivers that change, with their places."""
    elements: Mapping[str, Any] = {
        **{force.name: force.numbers for force in model.forces},
        **{driver.name: {"value": driver.value} for driver in model.drivers},
    }
    for name, numbers in elements.items():
        for key, number in numbers.items():
            parts = number if isinstance(number, tuple) else (number,)
            yield from ((f"{name}.{key}", x) for x in parts if callable(x))


def _value(model: Model, number: Any, view: kinematics.View) -> float:
    """NaN where it cannot be evaluated by its own fault."""
    try:
        with np.errstate(all="ignore"):
            return _float(evaluate(model, number, view))
    except (ArithmeticError, ValueError):
        return np.nan


def _float(x: Any) -> float:
    return float(np.asarray(x, float).reshape(-1)[0])


def _moved(state: np.ndarray, t: float, duration: float) -> Instant:
    """The bodies (k, 18) after a time with their velocities."""
    bodies = []
    for body in state.reshape(-1, ELEMENT).tolist():
        turned = so3.exp(tuple(duration * w for w in body[15:18]))
        r = [x + duration * v for x, v in zip(body[0:3], body[12:15], strict=True)]
        bodies.append((*r, *so3.multiply(tuple(body[3:12]), turned), *body[12:18]))
    return Instant(tuple(bodies), t + duration)
