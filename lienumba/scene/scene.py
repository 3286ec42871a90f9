"""Some runs of a dataset in motion, for whoever draws them."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from lienumba.batch.statuses import GOOD
from lienumba.engine.compare_runs import of_run
from lienumba.engine.replay import again, scenario_of
from lienumba.errors import ScenarioError
from lienumba.mechanics.elements.joints.base import ROD
from lienumba.mechanics.mechanism.model import GROUND
from lienumba.scenario.resolve import Scenario
from lienumba.scene.mechanism import Mechanism, Place, mechanism
from lienumba.scene.runs import NOMINAL, POSE, ShownRun, has_bodies, shown_runs
from lienumba.scene.solids import Solid
from lienumba.scene.switching import Switching, switching
from lienumba.store.form import check_form
from lienumba.store.study_layout import is_study
from lienumba.words import settings

if TYPE_CHECKING:
    from lienumba.engine.simulate import Tell

TURN = 2.0  # rad between two stored times, beyond which nobody can tell how a body got from one to the other
SHEARED = 0.01  # by how much a volume may change where bodies turn
FAR = 12.0  # of its own size: in a box this large a mechanism is too small to see, and the view travels with it
ROOM = 3.0  # how large the view that travels is, of the same size
MOST_CORNERS = 48  # of a solid, beyond which those of its box stand for it


@dataclass(frozen=True)
class MovingRun:
    """One run in motion.

    Attributes
    ----------
    run : int
        Its label.
    why : str
        Why it is shown.
    good : bool
        Whether it reached its end.
    mechanism : Mechanism
        Solids, axes, rods and marks.
    times : numpy.ndarray
        (T,) in s.
    positions : numpy.ndarray
        (T, k, 3) of the mass centres in m, global frame.
    rotations : numpy.ndarray
        (T, k, 3, 3), body to global.
    switching : Switching, optional
        What is locked, open or closed, of a mechanism that changes.
    name : str
        What it is called, where it is no run but a mode of one.
    """

    run: int
    why: str
    good: bool
    mechanism: Mechanism
    times: np.ndarray
    positions: np.ndarray
    rotations: np.ndarray
    switching: Switching | None = None
    name: str = ""

    @property
    def label(self) -> str:
        """What the run is called."""
        if self.name:
            return self.name
        if self.why == NOMINAL:
            return "nominal run"
        return f"run {self.run}" + (f" ({self.why})" if self.why else "")

    def at(self, places: Sequence[Place]) -> np.ndarray:
        """Places as the run has them.

        Parameters
        ----------
        places : sequence of Place
            Points of bodies, each in the frame of its body.

        Returns
        -------
        numpy.ndarray
            (T, places, 3) in m, global frame.
        """
        found = np.empty((len(self.times), len(places), 3))
        for n, place in enumerate(places):
            found[:, n] = place.point
            if place.body != GROUND:
                found[:, n] = self.positions[:, place.body] + self.rotations[:, place.body] @ np.array(place.point)
        return found


@dataclass(frozen=True)
class Scene:
    """Some runs in motion.

    Attributes
    ----------
    runs : tuple of MovingRun
        The first is the one to look at first.
    low, high : numpy.ndarray
        (3,) in m, global frame: the box in which all that reached their end move.
    followed : bool
        Whether the view travels with the mechanism (see `window`), which is small in the box in which it moves.
    remarks : tuple of str
        Sentences on runs that were simulated again and came out otherwise, or on how modes are drawn.
    cycles : bool
        Whether its runs are modes, which begin again where they end.
    """

    runs: tuple[MovingRun, ...]
    low: np.ndarray
    high: np.ndarray
    followed: bool
    remarks: tuple[str, ...]
    cycles: bool = False


def scene(
    ds: "xr.Dataset",
    where: str = "the dataset",
    *,
    count: int = 1,
    runs: Sequence[int] = (),
    worst: str | None = None,
    allow_code: bool = False,
    tell: "Tell" = lambda event: None,
) -> Scene:
    """Some runs of a dataset in motion, for whoever draws them.

    A run whose course is not stored from the start on, or at times that lie too far apart to see how it turns, is
    simulated again.

    Parameters
    ----------
    ds : xarray.Dataset
        What `lienumba.run` returned.
    where : str
        What the dataset is called in messages.
    count : int
        At most so many runs: the nominal or a typical one, the worst, failed ones.
    runs : sequence of int
        The labels of these runs instead.
    worst : str, optional
        The name of what it is worst in: a requirement, or a number whose size counts.
    allow_code : bool
        Run the Python code that the dataset brings, if runs must be simulated again.
    tell : callable
        Called with a `Progress` while runs are simulated again.

    Returns
    -------
    Scene
        The runs, and the box in which they move.

    Raises
    ------
    ScenarioError
        Where the dataset has no such runs, or nothing that could be drawn.
    """
    check_form(ds, where, ("status", "end_time"))
    if is_study(ds):
        raise ScenarioError(
            f"{where}: is of a study, which has many settings for each run; run the scenario with those of the point "
            f"({settings()}) and without [study], and look at that"
        )
    scenario = scenario_of(ds, where)
    found = shown_runs(ds, scenario, where, count, runs=runs, name=worst)
    if not found:
        raise ScenarioError(f"{where}: no run has moved, so there is nothing to see; lienumba info says why")
    told = [_moving(ds, where, scenario, choice, allow_code, tell) for choice in found]
    return framed([run for run, _ in told], [remark for _, remark in told if remark])


def framed(runs: Sequence[MovingRun], remarks: Sequence[str], cycles: bool = False) -> Scene:
    """These runs with the box in which all that reached their end move, and how one looks at them."""
    shown = [run for run in runs if run.good] or runs
    low, high = box(shown)
    followed = float((high - low).max()) > FAR * 2.0 * max(map(reach, shown))
    return Scene(tuple(runs), low, high, followed, tuple(remarks), cycles)


def _moving(
    ds: "xr.Dataset", where: str, scenario: Scenario, choice: ShownRun, allow_code: bool, tell: "Tell"
) -> tuple[MovingRun, str]:
    """A run, and what is to be said of its course."""
    there = of_run(ds, choice.run)
    poses, remark = _stored_poses(there) if has_bodies(there, scenario) else None, ""
    if poses is None or (_coarse(there) and (allow_code or not scenario.data.files)):
        try:
            done = again(ds, where, choice.run, None, allow_code, tell)
        except ScenarioError:  # a file that it needs may be gone
            if poses is None:
                raise
        else:
            there = of_run(done.dataset, choice.run)
            poses, remark = _stored_poses(there), "" if done.same else done.sentence
    assert poses is not None, "a replay stores all from the start on"
    times, positions, rotations = (x[np.isfinite(poses[1]).all(axis=(1, 2))] for x in poses)
    if not len(times):
        raise ScenarioError(f"{where}: run {choice.run} has not moved ({choice.why}); choose another")
    samples = {str(name): x.item() for name, x in there.coords.items() if x.attrs.get("role") == "input"}
    built = mechanism(scenario, samples, positions[0], rotations[0])
    good = there["status"].item() in GOOD
    found = MovingRun(choice.run, choice.why, good, built, times, positions, rotations, switching(there, built))
    return found, remark


def _along_time(there: "xr.Dataset", name: str) -> np.ndarray | None:
    """The values (T, ...) of a variable of the one run that a dataset has, if its course is stored."""
    if name not in there or there[name].dims[1:2] != ("time",) or not there[name].shape[0]:
        return None
    values: np.ndarray = there[name].values[0]
    return values


def _stored_poses(there: "xr.Dataset") -> tuple[np.ndarray, ...] | None:
    """Times, positions and rotations from the start on, if they are stored, and are rotations."""
    position, rotation = (_along_time(there, name) for name in POSE)
    if position is None or rotation is None or there["time"].values[0] != 0.0:
        return None
    with np.errstate(all="ignore"):
        volumes = np.linalg.det(np.where(np.isfinite(rotation), rotation, np.eye(3)))
    if not (abs(volumes - 1.0) < SHEARED).all():
        return None
    return there["time"].values, position, rotation


def _coarse(there: "xr.Dataset") -> bool:
    """Whether a body turns too far between two stored times, as far as is known."""
    rates = _along_time(there, "angular_velocity")
    if rates is None:
        return False
    speed = np.sqrt((rates**2).sum(axis=-1)).max(axis=-1)
    return bool(np.nanmax(np.diff(there["time"].values) * np.fmax(speed[:-1], speed[1:]), initial=0.0) > TURN)


def centre(run: MovingRun) -> np.ndarray:
    """The mass centre of the mechanism (T, 3) in m."""
    return np.average(run.positions, axis=1, weights=run.mechanism.masses)


def reach(run: MovingRun) -> float:
    """The largest distance (m) of anything that moves from the mass centre of the mechanism."""
    middle = centre(run)[:, None]
    radii = np.array([solid.radius for solid in run.mechanism.solids])
    places = [mark.place for mark in run.mechanism.marks if mark.place.body != GROUND]
    places += [end for line in run.mechanism.segments if line.kind == ROD for end in line.ends]
    bodies = np.linalg.norm(run.positions - middle, axis=-1) + radii
    joints = np.linalg.norm(run.at(places) - middle, axis=-1)
    return float(max(bodies.max(), joints.max(initial=0.0)))


def window(runs: Sequence[MovingRun]) -> tuple[np.ndarray, np.ndarray]:
    """The cube that travels with runs, all at the same times.

    Parameters
    ----------
    runs : sequence of MovingRun
        Runs in motion.

    Returns
    -------
    middle : numpy.ndarray
        (T, 3) in m, global frame: halfway between the mass centres of the runs.
    half : numpy.ndarray
        (T, 1) in m: half its edge, larger where runs are apart.
    """
    paths = np.stack([centre(run) for run in runs])
    middle = 0.5 * (paths.min(axis=0) + paths.max(axis=0))
    return middle, abs(paths - middle).max(axis=(0, 2))[:, None] + ROOM * max(map(reach, runs))


def box(runs: Sequence[MovingRun]) -> tuple[np.ndarray, np.ndarray]:
    """The box in which bodies and joints of these runs are.

    Parameters
    ----------
    runs : sequence of MovingRun
        Runs in motion.

    Returns
    -------
    low, high : numpy.ndarray
        Its corners, (3,) in m, global frame.
    """
    low, high = [], []
    for run in runs:
        parts = [run.mechanism.ground.vertices, run.at([mark.place for mark in run.mechanism.marks])]
        for n, solid in enumerate(run.mechanism.solids):
            r, R = run.positions[:, n, None], run.rotations[:, n]
            parts += [r, r + _corners(solid) @ np.swapaxes(R, 1, 2)]
        points = np.concatenate([part.reshape(-1, 3) for part in parts])
        points = points[np.isfinite(points).all(axis=1)]
        low.append(points.min(axis=0))
        high.append(points.max(axis=0))
    return np.min(low, axis=0), np.max(high, axis=0)


def _corners(solid: Solid) -> np.ndarray:
    """Points (n, 3) that enclose a solid, in the frame of its body."""
    if len(solid.vertices) <= MOST_CORNERS:
        return solid.vertices
    return np.array([*product(*zip(solid.vertices.min(axis=0), solid.vertices.max(axis=0), strict=True))])
