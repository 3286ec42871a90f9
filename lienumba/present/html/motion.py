"""The data of the moving mechanism: some runs, each with its solids, the marks of its joints, and frames of its course.
Runs that look alike share their figure.

A frame is the positions of the bodies and, as quaternions of 16-bit integers, their attitudes. The page turns bodies
between frames by slerp, so frames need not be dense, but close enough to tell which way a body turns; and it moves them
along cubics, so that joints hold between frames too.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from lienumba.errors import ScenarioError
from lienumba.present.html import changes
from lienumba.present.html.chart import Json, Section, color, packed, section
from lienumba.present.html.clipping import within
from lienumba.present.html.markup import Markup, element, sentence
from lienumba.present.html.time_series import MarkedRun
from lienumba.scene import MovingRun, Scene, scene
from lienumba.scene.mechanism import Mechanism
from lienumba.scene.scene import ROOM, reach
from lienumba.scene.solids import SHAPES, Solid

if TYPE_CHECKING:
    from lienumba.engine.simulate import Tell

BYTES = 3_000_000  # of all frames
MOST_FRAMES = 600  # of a run that turns slowly
LARGEST_TURN = 0.4  # rad between frames, where the course has such times
MOST_RUNS = 8
CYCLE = 2.0  # s that a mode takes
UNIT = 32767  # of the integers of a quaternion
WHITE = 0.3  # in the lighter half of a body that spins
POSE = 3 * 4 + 4 * 2  # bytes of a body in a frame
VIEW = (0.9, 1.7, 0.75)  # to the right, to the front and up: from where one looks
FLAT = 0.45  # of the largest extent: where a mechanism extends less than this, one looks along that axis
FLAT_VIEW = (0.45, 1.85, 0.4)


def seen(ds: xr.Dataset, name: str, allow_code: bool, tell: Tell) -> Scene | str:
    """The runs to be shown, or the sentence that says why there are none; name: of the file of the dataset."""
    bodies = ds.sizes.get("body", 1)
    count = max(2, min(MOST_RUNS, BYTES // (MOST_FRAMES * bodies * POSE)))
    try:
        return within(scene(ds, name, count=count, allow_code=allow_code, tell=tell))
    except ScenarioError as error:
        return str(error)


def marked(found: Scene | str) -> list[MarkedRun]:
    """The runs that are worth a line in other charts."""
    return [] if isinstance(found, str) else [MarkedRun(run.run, run.label) for run in found.runs[:2] if run.why]


def section_of(found: Scene | str) -> Section:
    """The place of the mechanism, or why it is not there."""
    if isinstance(found, str):
        return section("motion", "The mechanism", element("p", sentence(found), class_="quiet"))
    return section("motion", "The mechanism", *_stage(found))


def _stage(found: Scene) -> list[Markup]:
    play = element("button", "Play", id="play", type="button")
    slider = element("input", id="time", type="range", min="0", max="1000", value="0", step="1", aria_label="time")
    track = element("div", play, slider, element("output", id="clock"), class_="controls")
    speed = element("label", "speed ", element("select", id="speed"))
    run = element("label", "mode " if found.cycles else "run ", element("select", id="run"))
    other = [element("label", "beside ", element("select", id="beside"))] if len(found.runs) > 1 else []
    place = element("div", class_="plot", id="stage", role="img", aria_label="the mechanism, moving")
    mechanism = found.runs[0].mechanism
    clad = [mechanism.solids[n].kind == SHAPES for n in mechanism.seen]
    which = "Each body without shapes of its own" if any(clad) else "Each body"
    words = [] if all(clad) else [f"{which} is the box or cylinder that has its mass and its moments of inertia"]
    words += ["the view travels with the mechanism, and the numbers at its axes pass by"] if found.followed else []
    return [
        element("figure", place, track,
                element("div", run, *other, speed, class_="controls")),
        *changes.key(found),
        *([element("p", sentence("; ".join(words)), class_="quiet")] if words else []),
        *(element("p", sentence(remark), class_="quiet") for remark in found.remarks),
    ]  # fmt: skip


def data(found: Scene, gravity: Sequence[float | str]) -> Json:
    """What the page needs to draw the runs of a scene, of which modes take equally long; gravity: three numbers or
    formulas."""
    if found.cycles:
        runs = (replace(run, times=CYCLE * (run.times / run.times[-1])) for run in found.runs)
        found = replace(found, runs=tuple(runs))
    low, high = found.low, found.high
    margin = 0.04 * float((high - low).max())
    per_run = BYTES // len(found.runs)
    looks = [_figure(run.mechanism) for run in found.runs]
    keys = [json.dumps(look) for look in looks]
    figures = dict(zip(keys, looks, strict=True))
    eye, up = _view(np.ones(3) if found.followed else high - low, gravity)
    return {
        "low": (low - margin).tolist(),
        "high": (high + margin).tolist(),
        "eye": eye.tolist(),
        "up": up.tolist(),
        "bodies": list(found.runs[0].mechanism.bodies),
        "compared": _compared(found),
        "figures": [*figures.values()],
        "runs": [
            _run(run, per_run) | {"figure": [*figures].index(key), **_followed(found, run)}
            for run, key in zip(found.runs, keys, strict=True)
        ],
        "duration": float(max(run.times[-1] for run in found.runs)),
        **({"cycles": True} if found.cycles else {}),
    }


def _run(run: MovingRun, most: int) -> Json:
    kept = frames(run.times, run.rotations, max(most // (run.positions.shape[1] * POSE), 2))
    return {
        "label": run.label,
        "good": run.good,
        "times": packed(run.times[kept]),
        "positions": packed(run.positions[kept].ravel(), "f4"),
        "quaternions": packed(np.rint(UNIT * quaternions(run.rotations[kept])).ravel(), "i2"),
        **_switching(run, kept),
    }


def _compared(found: Scene) -> int:
    """The run beside the first when the page opens: the farthest, unless a view that has both would make them small."""
    farthest = (n for n, run in enumerate(found.runs) if n and run.why.startswith("farthest"))
    return 0 if found.followed else next(farthest, 0)


def _followed(found: Scene, run: MovingRun) -> Json:
    """What a view that travels needs: shares of bodies in the mass, and half the edge of the view (m)."""
    masses = np.array(run.mechanism.masses)
    return {"shares": (masses / masses.sum()).tolist(), "half": ROOM * reach(run)} if found.followed else {}


def _switching(run: MovingRun, kept: np.ndarray) -> Json:
    """What is locked, open or closed in these frames, and what was hit when."""
    found = run.switching
    if found is None or not found.names:
        return {}
    looks = found.at(run.times[kept])
    places = [[x.body, *map(float, x.point)] for x in found.places]
    return {"places": places, "looks": packed(looks.ravel(), "u2"), "hits": [[time, n] for time, n in found.hits]}


def _figure(mechanism: Mechanism) -> Json:
    """What moves in a run: corners as 16-bit integers, of the radius of each body, triangles of these
    corners, counts of both; what stands still comes last."""
    solids = [*mechanism.solids, mechanism.ground]
    radii = [solid.radius or 1.0 for solid in solids]
    corners = [UNIT / radius * solid.vertices for solid, radius in zip(solids, radii, strict=True)]
    triangles = [np.array(solid.triangles(), int).reshape(-1, 3) for solid in solids]
    colors = [color for n, solid in enumerate(solids) for color in _colors(n, solid)]
    palette = list(dict.fromkeys(colors))
    return {
        "radii": radii,
        "vertices": packed(np.rint(np.concatenate(corners)).ravel(), "i2"),
        "counts": [[len(v), len(f)] for v, f in zip(corners, triangles, strict=True)],
        "triangles": packed(np.concatenate(triangles).ravel(), "u4"),
        "palette": palette,
        "painted": packed(np.array([palette.index(color) for color in colors]), "u2"),
        "seen": mechanism.seen,
        "segments": [
            {"kind": x.kind, "ends": [[end.body, *map(float, end.point)] for end in x.ends]} for x in mechanism.segments
        ],
        "marks": [[x.place.body, *map(float, x.place.point)] for x in mechanism.marks],
    }


def _colors(body: int, solid: Solid) -> list[str]:
    """Of each triangle: its own, or that of the body, lighter in shapes, where shadows tell more, and in one half of a
    cylinder."""
    if solid.colours:
        return [own or _light(body) for own in solid.colours]
    return [_light(body) if half else color(body) for half in _halves(solid)]


def _light(body: int) -> str:
    """The colour of a body with some white."""
    parts = (int(color(body)[n : n + 2], 16) for n in (1, 3, 5))
    return "#" + "".join(f"{round((1.0 - WHITE) * part + WHITE * 255):02x}" for part in parts)


def _halves(solid: Solid) -> list[int]:
    """Of each triangle, whether it is in the lighter half of a cylinder, which is there so that one sees it spin."""
    if solid.kind != "cylinder":
        return [0] * len(solid.triangles())
    sides = len(solid.faces) - 2
    around = [int(2 * k < sides) for k in range(sides) for _ in range(2)]
    end = [int(2 * k < sides - 2) for k in range(sides - 2)]
    return [*around, *end[::-1], *end]  # the vertices of the first end run the other way


def frames(times: np.ndarray, rotations: np.ndarray, most: int) -> np.ndarray:
    """The indices of at most `most` times, first and last among them: evenly spread, and more of them where bodies turn
    fast; rotations (T, k, 3, 3)."""
    if len(times) <= 2:
        return np.arange(len(times))
    relative = np.einsum("...ij,...ij->...", rotations[1:], rotations[:-1])  # the trace of R_n^T R_n+1
    turns = np.arccos(np.clip(0.5 * (relative - 1.0), -1.0, 1.0)).max(axis=1)
    evenly = np.diff(times) * (MOST_FRAMES - 1) / (times[-1] - times[0])
    passed = np.concatenate([[0.0], np.cumsum(np.maximum(evenly, turns / LARGEST_TURN))])
    wanted = np.linspace(0.0, passed[-1], max(min(int(passed[-1]) + 2, most, len(times)), 2))
    return np.unique(np.searchsorted(passed, wanted * (1.0 - 1e-12)).clip(0, len(times) - 1))


def quaternions(rotations: np.ndarray) -> np.ndarray:
    """The quaternions w x y z (..., 4) of rotations (..., 3, 3), the largest element positive."""
    from scipy.spatial.transform import Rotation

    xyzw = Rotation.from_matrix(rotations.reshape(-1, 3, 3)).as_quat()
    largest = np.take_along_axis(xyzw, abs(xyzw).argmax(axis=1)[:, None], axis=1)
    return np.roll(xyzw * np.sign(largest), 1, axis=1).reshape(*rotations.shape[:-2], 4)


def _view(extent: np.ndarray, gravity: Sequence[float | str]) -> tuple[np.ndarray, np.ndarray]:
    """From where one looks at a box of this extent, and what is up: against gravity, else z."""
    pull = np.array([x if isinstance(x, int | float) else 0.0 for x in gravity])
    vertical = int(abs(pull).argmax()) if pull.any() else 2
    up = np.zeros(3)
    up[vertical] = -1.0 if pull[vertical] > 0.0 else 1.0
    level = [axis for axis in range(3) if axis != vertical]
    thin = min(level, key=lambda axis: extent[axis])
    flat = extent[thin] < FLAT * extent.max()
    front = thin if flat else level[1]
    side = level[0] if front == level[1] else level[1]
    eye = np.zeros(3)
    eye[[side, front, vertical]] = FLAT_VIEW if flat else VIEW
    eye[front] *= np.cross(up, np.eye(3)[front])[side]  # so that the axis at the side points to the right
    eye[vertical] *= up[vertical]
    return eye, up
