"""A scenario written in Python instead of TOML: the same keys, the same checks, the same file."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any, Self

from lienumba.scenario import html_repr
from lienumba.scenario.base import toml
from lienumba.scenario.reading.loading import load
from lienumba.scenario.schema.scenario import BESIDE

Numbers = Sequence[Any] | Any  # lists, tuples or arrays


class System:
    """Collects the keys of a scenario; `lienumba.run(system)` checks and runs it. `ground` is the fixed world.

    >>> top = System("Heavy top")
    >>> top.body("top", mass=15, inertia=[0.234375, 0.46875, 0.234375], position=[0, 1, 0])
    >>> top.joint("pivot", "spherical", ["ground", "top"], points=[[0, 0, 0], [0, -1, 0]])
    >>> top.integrator(step=1e-3, end_time=2.0)
    """

    ground = "ground"

    def __init__(self, title: str = "") -> None:
        self._data: dict[str, Any] = {"title": title, "model": {"bodies": [], "joints": []}}

    @classmethod
    def from_toml(cls, path: str | Path) -> Self:
        """The scenario of a TOML file, to be changed further."""
        system = cls()
        system._data = load(path)
        return system

    def __repr__(self) -> str:
        return html_repr.as_text(str(self._data.get("title", "")), list(html_repr.rows(self._data, self)))

    def _repr_html_(self) -> str:
        """As notebooks show it."""
        return html_repr.as_html(str(self._data.get("title", "")), list(html_repr.rows(self._data, self)))

    @property
    def gravity(self) -> Any:
        """The acceleration of gravity in m/s^2, global frame."""
        return self._data["model"].get("gravity", [0.0, 0.0, -9.81])

    @gravity.setter
    def gravity(self, value: Numbers) -> None:
        self._data["model"]["gravity"] = value

    def body(
        self,
        name: str,
        *,
        mass: float,
        inertia: Numbers,
        position: Numbers | None = None,
        rotation: Numbers | dict[str, Any] | None = None,
        velocity: Numbers | None = None,
        angular_velocity: Numbers | None = None,
        relative_to: str | None = None,
        guess: dict[str, Any] | None = None,
    ) -> Self:
        """Add a body; what is omitted of its initial state is solved for from the joints."""
        keys = {
            "position": position,
            "rotation": rotation,
            "velocity": velocity,
            "angular_velocity": angular_velocity,
            "relative_to": relative_to,
            "guess": guess,
        }
        return self._add("bodies", {"name": name, "mass": mass, "inertia": inertia, **keys})

    def joint(self, name: str, type: str, bodies: Sequence[str] | None = None, **keys: Any) -> Self:
        """Add a joint between two bodies, or a body and "ground": points and axes in the bodies' own frames, or at and
        axis in the global frame at the start. A gear or coupler has joints and ratio instead of bodies."""
        return self._add("joints", {"name": name, "type": type, "bodies": bodies, **keys})

    def driver(self, name: str | None = None, **keys: Any) -> Self:
        """Prescribe a motion: joint with value or rate, or body with motion and value; numbers or formulas of t."""
        return self._add("drivers", {"name": name, **keys})

    def force(self, name: str | None = None, *, type: str, **keys: Any) -> Self:
        """Add a force law, such as type="spring_damper" with bodies, points, stiffness and damping; or type="python"
        with a function of your own (see `lienumba.laws`), its bodies, joints and parameters."""
        return self._add("forces", {"name": name, "type": type, **keys})

    def quantity(self, name: str, type: str, **keys: Any) -> Self:
        """Name what is to be stored and may be read by formulas: type="point" with body and point, "joint" with joint,
        "rotation_error", "angular_velocity", "reaction", "driver_effort", "momentum" or "expression"."""
        return self._add("quantities", {"name": name, "type": type, **keys})

    def event(self, name: str, when: str, action: str = "record") -> Self:
        """Notice when a condition of quantities becomes true, such as "pointing.angle > 20*deg"; action="stop" ends the
        run there."""
        return self._add("events", {"name": name, "when": when, "action": action})

    def table(self, name: str, **keys: Any) -> Self:
        """Name a function that is known at points: file, time and value, or times and values; interpolation."""
        self._data.setdefault("tables", {})[name] = keys
        return self

    def parameter(self, name: str, value: float | str) -> Self:
        """Give a number a name, by which formulas know it: a number, or a formula of other parameters."""
        self._data.setdefault("parameters", {})[name] = value
        return self

    def integrator(self, *, end_time: float, **keys: Any) -> Self:
        """Choose the simulated time in s, step (s) or tolerance, method, and other keys of the section [integrator]."""
        self._data["integrator"] = {**keys, "end_time": end_time}
        return self

    def projection(self, **keys: Any) -> Self:
        """Set keys of the section [projection]: position, velocity, tolerance, max_iterations, chord, baumgarte."""
        return self._update("projection", keys)

    def output(self, **keys: Any) -> Self:
        """Set keys of the section [output]: every or times, variables."""
        return self._update("output", keys)

    def sweep(self, *, runs: int | None = None, **keys: Any) -> Self:
        """Set the number of runs (omitted: the rows of a table) and other keys of the section [sweep]: seed, sampler,
        nominal, table={"file": "design.csv"} or table={"columns": {path: numbers}}."""
        return self._update("sweep", keys if runs is None else {"runs": runs, **keys})

    def vary(self, path: str, distribution: str | None = None, **keys: Any) -> Self:
        """Vary an input from run to run, such as "bodies.top.mass", by a distribution with a plain name, or by
        scipy="lognorm", expression="2*parameters.kp" or column="m" instead."""
        vary = self._data.setdefault("sweep", {}).setdefault("vary", {})
        vary[path] = keys if distribution is None else {"distribution": distribution, **keys}
        return self

    def correlate(self, paths: Sequence[str], matrix: Numbers) -> Self:
        """Give varied paths correlations, those of the normal numbers behind their samples: a Gaussian copula."""
        groups = self._data.setdefault("sweep", {}).setdefault("correlate", [])
        groups.append({"paths": list(paths), "matrix": matrix})
        return self

    def study(self, *, reference: dict[str, Any], grid: Sequence[dict[str, Sequence[Any]]], **keys: Any) -> Self:
        """Make it a study: a reference, such as {"method": "dop853", "step": 1e-4}, and grids, such as
        {"integrator.step": [1e-2, 5e-3]}; repeats."""
        return self._update("study", {"reference": reference, "grid": grid, **keys})

    def to_dict(self) -> dict[str, Any]:
        """The keys and values, as a TOML file would give them, with what the files hold that they name."""
        data = load(self._data)
        model = dict(data["model"])
        beside = {kind: listed for kind in BESIDE if (listed := model.pop(kind, []))}
        return {**data, **beside, "model": model}

    def to_toml(self) -> str:
        """The scenario as a TOML file."""
        return toml.dumps(self.to_dict())

    def _add(self, kind: str, keys: dict[str, Any]) -> Self:
        given = {key: value for key, value in keys.items() if value is not None}
        self._data["model"].setdefault(kind, []).append(given)
        return self

    def _update(self, section: str, keys: dict[str, Any]) -> Self:
        self._data.setdefault(section, {}).update(keys)
        return self
