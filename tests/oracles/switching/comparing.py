"""A scenario with changes by lienumba, in several ways, and by the engine here; and what holds of any run."""

import copy
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

import lienumba
from tests.oracles.mechanisms import joints
from tests.oracles.mechanisms.engine import SingularError
from tests.oracles.switching.drawing import END
from tests.oracles.switching.engine import BESIDE, Changing, Course
from tests.oracles.switching.laws import ContradictingError, UnlikeError

Settings = dict[str, Any]
WAYS: dict[str, tuple[Settings, float]] = {  # settings, and how far apart results may be
    "dop853": ({"method": "dop853", "tolerance": 1e-10, "coordinates": "lie"}, 1e-6),
    "dop853 joint": ({"method": "dop853", "tolerance": 1e-10, "coordinates": "joint"}, 1e-6),
    "rk4": ({"method": "rk4", "step": END / 1000, "coordinates": "lie"}, 2e-4),
    "rk4 joint": ({"method": "rk4", "step": END / 1000, "coordinates": "joint"}, 2e-4),
    "taylor": ({"method": "taylor", "tolerance": 1e-10, "coordinates": "lie"}, 1e-6),
    "radau5": ({"method": "radau5", "tolerance": 1e-9, "coordinates": "joint"}, 1e-5),
    "SE3": ({"method": "dop853", "tolerance": 1e-10, "group": "SE3"}, 1e-6),
}
RICH = 2  # bodies, of which series and implicit stages take long to compile
RESIDUAL = 100.0  # of the energy, in tolerances
SUNK = 1e-7  # m or rad


@dataclass
class Verdict:
    """what: "compared"; "delicate" where shorter steps agree, but not these; "refused", or why there is nothing to
    compare with; status: of the run; changes: kinds of all that happened; deviations by what they are of; problems in
    words."""

    what: str = "compared"
    status: str = ""
    changes: list[str] = field(default_factory=list)
    deviations: dict[str, float] = field(default_factory=dict)
    problems: list[str] = field(default_factory=list)


def way_of(seed: int) -> str:
    """In which way a seed is run."""
    return list(WAYS)[seed % len(WAYS)]


def judge(data: dict[str, Any], way: str) -> Verdict:
    """One way, against the engine here where that knows the answer; against what holds of any run where it does not."""
    if len(data["model"]["bodies"]) >= RICH and way in ("taylor", "radau5"):
        way = "dop853 joint"
    try:
        ds = run(data, way)
    except lienumba.ScenarioError as error:
        return Verdict(f"refused: {error.problems[0].rule}")
    try:
        found = compare(data, oracle(data), ds, way)
        if not found.problems:
            return found
        again = compare(data, oracle(data, 3.0), run(data, way, 4.0), way)
        return again if again.problems else replace(again, what="delicate")
    except SingularError:
        why = "comes near a singular position"
    except ContradictingError:
        odd = (
            []
            if status(ds) == "inconsistent_constraints"
            else [f"status {status(ds)} where equations contradict each other"]
        )
        return Verdict("contradicting", status(ds), problems=odd)
    except UnlikeError as error:
        why = str(error)
    return Verdict(f"not known: {why}", status(ds), problems=invariants(data, ds, way))


def settled(data: dict[str, Any], way: str, finer: float = 1.0) -> dict[str, Any]:
    """The scenario, integrated in this way."""
    data = copy.deepcopy(data)
    data["integrator"] = {"end_time": END} | WAYS[way][0]
    if "step" in data["integrator"]:
        data["integrator"]["step"] /= finer
    else:
        data["integrator"]["max_step"] = END / (40 * finer)
    watch(data)
    return data


def watch(data: dict[str, Any]) -> None:
    """How far apart everything is that may touch, at many times."""
    model = data["model"]
    seen = [{"name": f"g_{c['name']}", "type": "contact", "contact": c["name"]} for c in model.get("contacts", [])]
    seen += [{"name": f"g_{c['name']}", "type": "limit", "limit": c["name"]} for c in model.get("limits", [])]
    if seen:
        model["quantities"] = [*model.get("quantities", []), *seen]


def run(data: dict[str, Any], way: str, finer: float = 1.0) -> Any:
    """One run's dataset."""
    return lienumba.run(settled(data, way, finer), workers=1, progress=False).isel(run=0)


def compare(data: dict[str, Any], course: Course, ds: Any, way: str) -> Verdict:
    """With what the engine here has found."""
    found, bound = Verdict(changes=[c.kind for c in course.changes]), WAYS[way][1]
    found.status = status(ds)
    found.problems += invariants(data, ds, way)
    wanted = {"capture_failed": "capture_failed", "stopped": "stopped_by_event"}.get(course.status, "success")
    if found.status != wanted:
        found.problems.append(f"status {found.status} instead of {wanted}")
        return found

    def same(name: str, x: Any, y: Any, least: float = 1.0) -> None:
        x, y = np.asarray(x, float), np.asarray(y, float)
        off = float(np.abs(x - y).max() / max(least, float(np.abs(x).max())))
        found.deviations[name] = max(found.deviations.get(name, 0.0), off if np.isfinite(off) else np.inf)

    for n, now in enumerate(course.motions):
        there = ds.isel(time=n)
        s = min(
            (now, course.behind.get(n, now)), key=lambda x: float(np.abs(x.state.v - there.velocity.values).max())
        ).state
        for name, x in (("position", s.r), ("rotation", s.R), ("velocity", s.v), ("angular_velocity", s.w)):
            same(name, x, there[name])
    for event in data["events"]:
        times = course.events.get(event["name"], [])
        count, first = int(ds.event_count.sel(event=event["name"])), float(ds.event_time.sel(event=event["name"]))
        if count != len(times):
            found.problems.append(f"{event['name']} happens {count} times instead of {len(times)}")
        elif times:
            same("event_time", times[0], first)
    if "change_time" not in ds:
        return found
    same("energy_lost", course.lost, ds.energy_lost)
    if course.status == "capture_failed":
        return found
    wanted_changes = sorted((c.what, c.kind, c.t) for c in course.changes if c.what not in course.undecided)
    got = sorted(x for x in told(ds) if x[0] not in course.undecided)
    if [x[:2] for x in wanted_changes] != [x[:2] for x in got]:
        found.problems.append(f"changes {_short(got)} instead of {_short(wanted_changes)}")
    elif got:
        same("change_time", [x[2] for x in wanted_changes], [x[2] for x in got])
    found.problems += modes(data, course, ds)
    found.problems += [f"{name} {x:.1e} apart" for name, x in found.deviations.items() if not x < bound]
    return found


def told(ds: Any) -> list[tuple[str, str, float]]:
    """What changed, as which kind, when: of those that are told."""
    table = lienumba.analysis.changes(ds.expand_dims("run") if "run" not in ds.dims else ds)
    rows = zip(table.what.values, table.kind.values, table.time.values, strict=True)
    return [(str(what), str(kind), float(t)) for what, kind, t in rows]


def _short(changes: list[tuple[str, str, float]]) -> str:
    return "; ".join(f"{what} {kind} {t:.6g}" for what, kind, t in sorted(changes, key=lambda x: x[2])[:12])


def modes(data: dict[str, Any], course: Course, ds: Any) -> list[str]:
    """Where `mode` tells something else of what is on; where an event ends the run at its start nothing is decided."""
    if course.end == 0.0:
        return []
    problems, every = [], {j["name"]: j for j in data["model"].get("joints", [])}
    dry = {f["name"] for f in data["model"].get("forces", []) if "static" in f}
    for n, on in enumerate(course.modes):
        t = float(ds.time[n])
        if any(abs(change.t - t) < BESIDE for change in course.changes):
            continue
        for name in ds.switch.values.tolist() if "switch" in ds else ():
            if name in course.undecided:
                continue
            joint = every.get(name.partition(".")[0])
            locked = name in on
            if name in dry:
                if bool(ds["mode"].sel(switch=name).isel(time=n) == 1) != locked:
                    problems.append(f"{name} {'slides' if locked else 'sticks'} at {t:.3g}")
                continue
            if joint is not None and name.endswith(".lock"):
                part = name.split(".")[1]
                kinds = ["ball"] if joint["type"] == "spherical" else list(joints.COORDINATES[joint["type"]])
                locked = any(f"{joint['name']}.{k}" in on for k in ([part] if part in kinds else kinds))
            if bool(ds["mode"].sel(switch=name).isel(time=n) > 0) != locked:
                problems.append(f"{name} is {'off' if locked else 'on'} at {t:.3g}")
    return problems


def invariants(data: dict[str, Any], ds: Any, way: str) -> list[str]:
    """What is wrong with a run, whatever it does."""
    problems: list[str] = []
    if not ended_well(ds):
        return problems
    times = ds.change_time.values if "change_time" in ds else np.zeros(0)
    times = times[np.isfinite(times)]
    if (np.diff(times) < 0).any():
        problems.append("changes are not in the order of time")
    there = np.isfinite(ds.energy_residual.values)
    tolerance = ds.attrs.get("tolerance", WAYS[way][0].get("tolerance", 1e-6))
    size = max(1.0, *(float(np.abs(ds[name].values[there]).max()) for name in ("kinetic_energy", "work")))
    residual = float(np.abs(ds.energy_residual.values[there]).max()) / (tolerance * size)
    if not residual < RESIDUAL:
        problems.append(f"residual {residual:.1e} tolerances")
    for kind in ("contacts", "limits"):
        for table in data["model"].get(kind, []):
            least = float(np.nanmin(ds[f"g_{table['name']}.gap"].values))
            if least < -SUNK * (1 if "tolerance" in WAYS[way][0] else 1e2):
                problems.append(f"{table['name']} sinks by {-least:.1e}")
    driven = bool(data["model"].get("drivers"))
    for kind, lost in zip(_kinds(ds), ds.change_energy.values, strict=False) if len(times) else ():
        if kind not in ("set", "engaged") and not driven and lost < -1e-9 * size:
            problems.append(f"{kind} gives {-lost:.1e} J")
    for name in ("position_violation", "velocity_violation"):
        missed = float(ds[f"max_{name}"])
        if not missed < 1e-8:
            problems.append(f"{name} of {missed:.1e}")
    return problems


def ended_well(ds: Any) -> bool:
    """Whether a run came to its end, or to that which an event made."""
    return status(ds) in ("success", "stopped_by_event")


def status(ds: Any) -> str:
    names = dict(zip(ds.status.flag_values.tolist(), ds.status.flag_meanings.split(), strict=True))
    return str(names[int(ds.status)])


def _kinds(ds: Any) -> list[str]:
    names = dict(zip(ds.change_kind.flag_values.tolist(), ds.change_kind.flag_meanings.split(), strict=True))
    return [names[int(x)] for x in ds.change_kind.values if int(x) >= 0]


def oracle(data: dict[str, Any], finer: float = 1.0) -> Course:
    """By the engine here."""
    return Changing(data).run(data["output"]["times"], most=END / (40 * finer))


# ---------------------------------------------------------------- the same to the bit
LABELS, ALONE = 11, 4  # runs of a sweep, and one of them


def varied(data: dict[str, Any], way: str) -> dict[str, Any]:
    """The scenario as a sweep: the mass of its first body differs, so that its runs change at different times."""
    data = settled(data, way)
    body = data["model"]["bodies"][0]
    heavy = {"distribution": "uniform", "low": 0.97 * body["mass"], "high": 1.03 * body["mass"]}
    return data | {"sweep": {"runs": LABELS, "seed": 7, "vary": {f"bodies.{body['name']}.mass": heavy}}}


def same_bits(data: dict[str, Any], way: str, folder: Path) -> list[str]:
    """Where a run is another one with other neighbours, with more workers, replayed, or in a sweep that went on.
    Where the sweep is refused there are none."""
    data = varied(data, way)
    try:
        every = lienumba.run(data, workers=2, progress=False)
    except lienumba.ScenarioError:
        return []
    alone = lienumba.run(data, workers=1, runs=[ALONE], progress=False)
    lienumba.run(data, output=folder / "some.nc", runs=range(ALONE - 1), progress=False)
    gone_on = lienumba.run(data, output=folder / "some.nc", resume=True, progress=False)
    again = lienumba.replay(every, ALONE, every=END / 8, progress=False)
    own, problems = every.sel(run=ALONE), []
    for what, other in (("alone", alone.sel(run=ALONE)), ("gone on", gone_on.sel(run=ALONE)), ("replayed", again)):
        other = other.isel(run=0) if "run" in other.dims else other
        for name in sorted({*own.data_vars} & {*other.data_vars}):
            x, y = own[name], other[name]
            if (
                x.dtype.kind in "fiu"
                and x.shape == y.shape
                and x.values.tobytes() != y.values.astype(x.dtype).tobytes()
            ):
                problems.append(f"{name} differs {what}")
    gone_on.close()
    return problems
