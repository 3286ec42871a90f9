"""A scenario written in Python instead of TOML: the same keys, the same checks, the same file."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, Self

from lienumba.scenario import html_repr
from lienumba.scenario.base import toml
from lienumba.scenario.base.paths import BESIDE
from lienumba.scenario.base.toml import table_in
from lienumba.scenario.reading.loading import load

Numbers = Sequence[Any] | Any  # lists, tuples or arrays


class System:
    """Collects the keys of a scenario; `lienumba.run(system)` checks and runs it.

    Every method adds to it and returns it. Keys are those of the TOML file; numbers may be formulas of parameters.

    Parameters
    ----------
    title : str
        What the scenario is called.

    Attributes
    ----------
    ground : str
        The name of the fixed world.

    Examples
    --------
    >>> top = lienumba.System("Heavy top")
    >>> top.body("top", mass=15, inertia=[0.234375, 0.46875, 0.234375], position=[0, 1, 0])
    >>> top.joint("pivot", "spherical", ["ground", "top"], points=[[0, 0, 0], [0, -1, 0]])
    >>> top.integrator(step=1e-3, end_time=2.0)
    """

    ground = "ground"

    def __init__(self, title: str = "") -> None:
        self._data: dict[str, Any] = {"title": title, "model": {"bodies": [], "joints": []}}

    @classmethod
    def from_toml(cls, path: str | Path, *, allow_code: bool = False) -> Self:
        """The scenario of a TOML file, to be changed further.

        Parameters
        ----------
        path : path
            The file.
        allow_code : bool
            Take also the Python code that the file brings in itself, or names outside its folder.

        Returns
        -------
        System
            With the keys of the file and of those that it extends.
        """
        system = cls()
        system._data = load(path, allow_code)
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
        inertia: Numbers | None = None,
        position: Numbers | None = None,
        rotation: Numbers | dict[str, Any] | None = None,
        velocity: Numbers | None = None,
        angular_velocity: Numbers | None = None,
        relative_to: str | None = None,
        guess: dict[str, Any] | None = None,
        shapes: Sequence[dict[str, Any]] | None = None,
    ) -> Self:
        """Add a body.

        Parameters
        ----------
        name : str
            A letter, then letters, digits or "_".
        mass : float
            In kg, above 0; or 0 of a body between joints, with coordinates = "joint".
        inertia : array, optional
            In kg m^2 about the mass centre, body frame: 3 principal moments, the 6 elements xx yy zz xy xz yz of the
            tensor, or its 3x3 matrix. Only a body without mass has none.
        position : array, optional
            The mass centre in m, global frame: 3 numbers. What is omitted of the start is solved for from the joints.
        rotation : array or dict, optional
            Body to global: a quaternion [w, x, y, z], a 3x3 matrix, or {"axis", "angle"}, {"euler", "angles"},
            {"rotation_vector"}, in rad.
        velocity : array, optional
            Of the mass centre in m/s, global frame: 3 numbers.
        angular_velocity : array, optional
            In rad/s, body frame: 3 numbers.
        relative_to : str, optional
            The body in whose frame position, rotation and velocities are given.
        guess : dict, optional
            Where to start for what is omitted: position, rotation, velocity, angular_velocity, not held.
        shapes : sequence of dict, optional
            How it looks: {"type": "capsule", "radius": 0.05, "length": 0.3, "position": [0, 0, 0.1]}, ...; in m, body
            frame. They change no number.
        """
        keys = {
            "position": position,
            "rotation": rotation,
            "velocity": velocity,
            "angular_velocity": angular_velocity,
            "relative_to": relative_to,
            "guess": guess,
            "shapes": shapes,
        }
        return self._add("bodies", {"name": name, "mass": mass, "inertia": inertia, **keys})

    def ground_shape(self, type: str, **keys: object) -> Self:
        """Add a shape that stands still.

        Parameters
        ----------
        type : str
            "box", "sphere", "ellipsoid", "cylinder", "capsule" or "mesh".
        **keys
            Those of the type, position, rotation and colour; in m, global frame.
        """
        return self._add("ground_shapes", {"type": type, **keys})

    def joint(self, name: str, type: str, bodies: Sequence[str] | None = None, **keys: object) -> Self:
        """Add a joint between two bodies, or a body and "ground".

        Parameters
        ----------
        name : str
            A letter, then letters, digits or "_".
        type : str
            Such as "revolute"; `lienumba schema` lists them with their keys.
        bodies : sequence of str, optional
            The two bodies. A gear or coupler has `joints` and `ratio` instead.
        **keys
            points and axes in the bodies' own frames (m), or at and axis in the global frame at the start, and others.
        """
        return self._add("joints", {"name": name, "type": type, "bodies": bodies, **keys})

    def driver(self, name: str | None = None, **keys: object) -> Self:
        """Prescribe a motion.

        Parameters
        ----------
        name : str, optional
            By which messages know it.
        **keys
            joint with value or rate, or body with motion and value: numbers or formulas of t, in m, rad and s.
        """
        return self._add("drivers", {"name": name, **keys})

    def force(self, name: str | None = None, *, type: str, **keys: object) -> Self:
        """Add a force law.

        Parameters
        ----------
        name : str, optional
            By which quantities and messages know it.
        type : str
            Such as "spring_damper"; `lienumba schema` lists them. "python" for a function of your own (see
            `lienumba.laws`).
        **keys
            Those of the type, such as bodies, points, stiffness and damping; numbers or formulas of t and quantities.
        """
        return self._add("forces", {"name": name, "type": type, **keys})

    def quantity(self, name: str, type: str, **keys: object) -> Self:
        """Name what is to be stored and may be read by formulas.

        Parameters
        ----------
        name : str
            By which formulas and the dataset know it.
        type : str
            "point", "joint", "rotation_error", "angular_velocity", "reaction", "driver_effort", "momentum",
            "expression", ...
        **keys
            Those of the type, such as body and point.
        """
        return self._add("quantities", {"name": name, "type": type, **keys})

    def noise(self, name: str, type: str, **keys: object) -> Self:
        """Add a random course that each run has of its own.

        Parameters
        ----------
        name : str
            By which formulas and the dataset know it.
        type : str
            "white", "band", "dryden", "walk" or "bias".
        **keys
            Those of the type, such as std and every.
        """
        return self._add("noise", {"name": name, "type": type, **keys})

    def limit(self, joint: str, **keys: object) -> Self:
        """Add rigid stops to a coordinate of a joint.

        Parameters
        ----------
        joint : str
            The name of the joint.
        **keys
            low and high (rad or m), restitution (0 to 1), coordinate where it has several, name, rest_speed.
        """
        return self._add("limits", {"joint": joint, **keys})

    def contact(self, name: str, type: str, bodies: Sequence[str], **keys: object) -> Self:
        """Let two bodies touch: they push, and stick or slide.

        Parameters
        ----------
        name : str
            A letter, then letters, digits or "_".
        type : str
            "point_plane", "sphere_plane", "sphere_sphere", "cylinder_plane" or "capsule_plane".
        bodies : sequence of str
            The two bodies; a plane is of the second.
        **keys
            points (m) in the bodies' own frames, normal, radius and others of the type; restitution (0 to 1), friction
            (a number or {"static", "kinetic"}), or stiffness (N/m) and dissipation (s/m) of one that yields.
        """
        return self._add("contacts", {"name": name, "type": type, "bodies": bodies, **keys})

    def event(self, name: str, when: str, action: str = "record", **keys: object) -> Self:
        """Notice when a condition becomes true, and what happens then.

        Parameters
        ----------
        name : str
            The dataset has `event_time` under this name.
        when : str
            Such as "pointing.angle > 20*deg", of quantities, parameters and t.
        action : str
            "record"; "stop", which ends the run there; or "lock", "unlock", "release", "engage" or "set".
        **keys
            Those of the action: joint, coordinate, closing (m or rad), parameters (by name), once; and delay (s).
        """
        return self._add("events", {"name": name, "when": when, "action": action, **keys})

    def measure(
        self,
        name: str,
        value: str | None = None,
        units: str | None = None,
        function: Callable[..., float] | str | None = None,
    ) -> Self:
        """Ask each run for a number of the whole of it.

        Parameters
        ----------
        name : str
            Of the variable of the dataset: words.
        value : str, optional
            A formula with reducers, such as "last_time(pointing.angle > 0.1*deg)".
        units : str, optional
            Of the number; by default they follow from the formula.
        function : callable or str, optional
            Instead of `value`, a function of the courses at the times of the output, or "reducers.py:roughness". Its
            arguments are `t` (times,) and names of quantities, with "_" for a point: (times,), or (times, 3) of
            vectors.
        """
        given = {"value": value, "units": units, "function": function}
        return self._add("measures", {"name": name, **{key: x for key, x in given.items() if x is not None}})

    def requirement(self, name: str, value: str, probability: float, **keys: object) -> Self:
        """Say what a run shall do, and in which part of all runs.

        Parameters
        ----------
        name : str
            Words, such as "pointing stays fine".
        value : str
            A number that the dataset has for each run, such as "pointing.angle_max".
        probability : float
            The part of all runs that shall meet it, between 0 and 1.
        **keys
            below, above (in the unit of the value) or between=[low, high]; confidence, failed.
        """
        return self._add("requirements", {"name": name, "value": value, "probability": probability, **keys})

    def table(self, name: str, **keys: object) -> Self:
        """Name a function that is known at points.

        Parameters
        ----------
        name : str
            By which formulas call it.
        **keys
            file, time and value, or times and values; interpolation.
        """
        self._data.setdefault("tables", {})[name] = keys
        return self

    def input(self, name: str, value: float | str | None = None, **keys: object) -> Self:
        """Give what comes from outside a name, such as the command of a motor, by which formulas know it: inputs.name.

        Parameters
        ----------
        name : str
            A letter, then letters, digits or "_".
        value : float or str, optional
            A number, or a formula of t, quantities, parameters, tables and other inputs.
        **keys
            Instead: file, time and value, or times and values (a recording); joint, kp, kd and target (what draws a
            joint to a reference); rate and start (a state). Besides: limit or limits, filter (s), units.
        """
        given = keys if value is None else {"value": value, **keys}
        self._data.setdefault("inputs", {})[name] = value if not keys and value is not None else given
        return self

    def parameter(self, name: str, value: float | str | Sequence[float | str]) -> Self:
        """Give a number a name, by which formulas know it.

        Parameters
        ----------
        name : str
            A letter, then letters, digits or "_".
        value : float, str or sequence of these
            A number, a formula of other parameters, or several of such: formulas read them as `k[0]`.
        """
        self._data.setdefault("parameters", {})[name] = [*value] if isinstance(value, list | tuple) else value
        return self

    def integrator(self, *, end_time: float, **keys: object) -> Self:
        """Set keys of the section [integrator].

        Parameters
        ----------
        end_time : float
            The simulated time in s.
        **keys
            step (s) or tolerance, method, and others.
        """
        self._data["integrator"] = {**keys, "end_time": end_time}
        return self

    def start(
        self,
        *,
        q: dict[str, Any] | None = None,
        qd: dict[str, Any] | None = None,
        file: str | None = None,
        run: int | None = None,
        time: float | None = None,
        equilibrium: bool = False,
        rotation: list[Any] | None = None,
    ) -> Self:
        """Say where the joints start, over what they say themselves.

        Parameters
        ----------
        q : dict, optional
            Coordinates by their names in rad or m, such as {"elbow": 0.3, "piston.angle": 0.1}, or all of a joint in a
            list.
        qd : dict, optional
            Their rates in rad/s or m/s, likewise.
        file : str, optional
            A dataset with q and qd, from which those are taken that are not given here.
        run : int, optional
            The label of its run; omitted: the first.
        time : float, optional
            A stored time of it in s; omitted: the last.
        equilibrium : bool
            Whether each run starts in its equilibrium, to which it comes from there.
        rotation : list, optional
            The angular velocity in rad/s, global frame, with which all turns in equilibrium; omitted: all rests.
        """
        keys = {"q": q, "qd": qd, "file": file, "run": run, "time": time, "rotation": rotation}
        keys["from"] = "equilibrium" if equilibrium else None
        return self._update("start", {key: x for key, x in keys.items() if x is not None})

    def projection(self, **keys: object) -> Self:
        """Set keys of the section [projection].

        Parameters
        ----------
        **keys
            position, velocity, tolerance (m), max_iterations, chord, baumgarte (1/s).
        """
        return self._update("projection", keys)

    def output(self, **keys: object) -> Self:
        """Set keys of the section [output].

        Parameters
        ----------
        **keys
            every (s) or times (s), variables, mode, and others.
        """
        return self._update("output", keys)

    def sweep(self, *, runs: int | None = None, **keys: object) -> Self:
        """Set keys of the section [sweep].

        Parameters
        ----------
        runs : int, optional
            How many; omitted: the rows of a table.
        **keys
            seed, sampler, nominal, table={"file": "design.csv"} or table={"columns": {path: numbers}}.
        """
        return self._update("sweep", keys if runs is None else {"runs": runs, **keys})

    def vary(self, path: str, distribution: str | None = None, **keys: object) -> Self:
        """Vary an input from run to run.

        Parameters
        ----------
        path : str
            Such as "bodies.top.mass" or "parameters.kp".
        distribution : str, optional
            One with a plain name; or give scipy="lognorm", expression="2*parameters.kp" or column="m" instead.
        **keys
            The numbers of the distribution.
        """
        vary = self._data.setdefault("sweep", {}).setdefault("vary", {})
        vary[path] = keys if distribution is None else {"distribution": distribution, **keys}
        return self

    def correlate(self, paths: Sequence[str], matrix: Numbers) -> Self:
        """Give varied paths correlations: a Gaussian copula.

        Parameters
        ----------
        paths : sequence of str
            At least two varied paths.
        matrix : array
            The correlations of the normal numbers behind their samples: symmetric, with ones on the diagonal.
        """
        groups = self._data.setdefault("sweep", {}).setdefault("correlate", [])
        groups.append({"paths": list(paths), "matrix": matrix})
        return self

    def study(self, *, reference: dict[str, Any], grid: Sequence[dict[str, Sequence[Any]]], **keys: object) -> Self:
        """Make it a study: a grid of settings instead of samples, compared with a reference.

        Parameters
        ----------
        reference : dict
            Settings such as {"method": "dop853", "step": 1e-4}, formulas, or a file.
        grid : sequence of dict
            Paths with lists of values, such as {"integrator.step": [1e-2, 5e-3]}.
        **keys
            repeats.
        """
        return self._update("study", {"reference": reference, "grid": grid, **keys})

    def to_dict(self) -> dict[str, Any]:
        """The keys and values, as a TOML file would give them, with what the files hold that they name.

        Returns
        -------
        dict
            Of plain numbers, texts, lists and dicts.
        """
        data = load(self._data)
        model = {**table_in(data, "model")}
        beside = {kind: found for kind in BESIDE if (found := model.pop(kind, None))}
        return {**data, **beside, "model": model}

    def to_toml(self) -> str:
        """The scenario as the text of a TOML file.

        Returns
        -------
        str
            What `lienumba run` reads.
        """
        return toml.dumps(self.to_dict())

    def _add(self, kind: str, keys: dict[str, Any]) -> Self:
        given = {key: value for key, value in keys.items() if value is not None}
        self._data["model"].setdefault(kind, []).append(given)
        return self

    def _update(self, section: str, keys: dict[str, Any]) -> Self:
        self._data.setdefault(section, {}).update(keys)
        return self
