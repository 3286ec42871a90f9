"""States of runs as a dataset holds them, where it holds all of them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from lienumba.groups.state import ELEMENT
from lienumba.integrators.tracing.linear.freedoms import FreedomTracer
from lienumba.mechanics.elements import joints, quantities
from lienumba.mechanics.mechanism.model import HELD, Coordinate, Counted, Model, coordinate_of
from lienumba.mechanics.system import joint_coordinates
from lienumba.mechanics.system.output_variables import OUTPUT_VARIABLES
from lienumba.scenario.resolve import Scenario
from lienumba.scenario.start.prepare import Prepared
from lienumba.words import listed

if TYPE_CHECKING:
    import xarray as xr

BODIES = ("position", "rotation", "velocity", "angular_velocity")
ALONG = "q"  # the variable of the coordinates of joints
SAME = 1e-12  # of the end: what is stored within it of a time is stored at this time
WHOLE = "float64"


@dataclass(frozen=True)
class Stored:
    """what (name: times, runs, ...): the variables at some times (s); lacking: why these do not say the states, if they
    do not."""

    times: list[float]
    what: Mapping[str, np.ndarray]
    lacking: str = ""

    @staticmethod
    def of(ds: "xr.Dataset", scenario: Scenario, labels: Sequence[int], times: Sequence[float]) -> "Stored":
        """What a dataset has of these runs at those of these times at which it has something."""
        end = scenario.data.integrator.end_time
        kept = ds["time"].values if "time" in ds.coords else np.zeros(0)
        places = [(t, int(abs(kept - t).argmin())) for t in times if t > 0.0 and len(kept)]
        places = [(t, n) for t, n in places if abs(kept[n] - t) <= SAME * end]
        lacking = next((name for name in BODIES if name not in ds or "time" not in ds[name].dims), "")
        if lacking:
            return Stored([], {}, f"it does not store {lacking}")
        dim = str(ds["position"].dims[0])
        names = [body.name for body in scenario.data.model.bodies]
        whole = ds["body"].values.tolist() == names and all(ds.sizes[x] == 3 for x in ("axis", "body_axis"))
        if not whole or not set(labels) <= set(ds[dim].values.tolist()):
            return Stored([], {}, "it does not store all bodies of all these runs")
        rounded = [name for name in BODIES if ds[name].dtype != WHOLE or "precision" in ds[name].attrs]
        if rounded:
            return Stored([], {}, f"it stores {rounded[0]} rounded")
        if not places:
            return Stored([], {})
        some = ds.isel(time=[n for _, n in places]).sel({dim: list(labels)})
        also = [str(x) for x in some.data_vars if some[x].dims == (dim, "time") and some[x].dtype == WHOLE]
        also += [ALONG] if ALONG in some and some[ALONG].dims[:2] == (dim, "time") else []
        exact = [name for name in also if "precision" not in some[name].attrs]
        what = {name: np.moveaxis(some[name].values, 1, 0) for name in (*BODIES, *exact)}
        return Stored([t for t, _ in places], what)

    def lacks(self, tracer: FreedomTracer, model: Model) -> str:
        """Why the states are not known, if they are not; model: the nominal one."""
        if self.lacking or not self.times:
            return self.lacking
        if tracer.augmented.switches:
            return "it does not store how what is locked or closed holds"
        for name, states in tracer.law_states.sizes.items():
            known = next((list(x.initial) for x in model.forces if x.name == name), [])
            if name == HELD or len(known) != states or not {f"{name}.{x}" for x in known} <= self.what.keys():
                return (
                    "it does not store what sampled laws hold" if name != HELD else "it does not store what laws hold"
                )
        lost = [x for x in tracer.augmented.angles if self._angle(model, x) is None]
        if lost:
            turning = listed(model.joints[coordinate_of(x).joint].name for x in lost)
            return f"it does not store how often {turning} turned (output.joint_coordinates)"
        return ""

    def rows(self, tracer: FreedomTracer, prepared: Prepared, t: float) -> tuple[list[Any], np.ndarray]:
        """The rows of the state at one of the times, and which runs are there."""
        n, model = self.times.index(t), prepared.nominal.model
        runs = self.what["position"].shape[1]
        bodies = np.empty((runs, len(model.bodies), ELEMENT))
        for name in BODIES:
            place = OUTPUT_VARIABLES[name].state
            assert place is not None
            bodies[:, :, slice(*place)] = self.what[name][n].reshape(runs, len(model.bodies), -1)
        laws = {
            name: [self.what[f"{name}.{x}"][n] for x in force.initial]
            for name in tracer.law_states.sizes
            for force in model.forces
            if force.name == name
        }
        augmented: list[Any] = list(np.zeros((tracer.augmented.rows, runs)))
        for row, which in enumerate(tracer.augmented.angles):
            angle = self._angle(model, which)
            assert angle is not None, "looked at before"
            augmented[row] = angle[n]
        good = np.asarray(np.isfinite(bodies).all(axis=(1, 2)))
        return tracer.rows(prepared.model, bodies.reshape(runs, -1), laws, augmented), good

    def _angle(self, model: Model, which: Counted) -> np.ndarray | None:
        """The counted angle (times, runs): among the coordinates of joints, or a quantity."""
        own = coordinate_of(which)
        along = joints.coordinates(model)
        if ALONG in self.what and own in along and self.what[ALONG].shape[2] == len(joint_coordinates.units(model)):
            angle: np.ndarray = self.what[ALONG][:, :, along.index(own)]
            return angle
        names = [quantities.joined(x.name, own.kind) for x in model.quantities if _of_joint(x, own)]
        return next((self.what[name] for name in names if name in self.what), None)


def _of_joint(x: Any, own: Coordinate) -> bool:
    return bool(x.type == "joint" and x.joint == own.joint)
