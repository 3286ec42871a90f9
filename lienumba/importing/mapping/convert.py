"""A compiled model, and where it starts, as a scenario."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from lienumba.errors import Problem, ScenarioError
from lienumba.importing.imported import Imported
from lienumba.importing.mapping.actuators import add_actuators
from lienumba.importing.mapping.draft import LAWS, Draft
from lienumba.importing.mapping.equalities import add_equalities, looped
from lienumba.importing.mapping.flags import with_flags
from lienumba.importing.mapping.fluid import add_fluid
from lienumba.importing.mapping.frames import tidy
from lienumba.importing.mapping.left_out import note_left_out
from lienumba.importing.mapping.loop_starts import note_moved
from lienumba.importing.mapping.passive import add_passive
from lienumba.importing.mapping.readings import Readings
from lienumba.importing.mapping.shapes import add_shapes
from lienumba.importing.mapping.source import LETTERS, Source
from lienumba.importing.mapping.step import stable_step
from lienumba.importing.mapping.tendons import add_tendons
from lienumba.importing.mapping.tree import add_tree
from lienumba.importing.notes import Note, gathered
from lienumba.words import listed, option, plural, show, suggestion

if TYPE_CHECKING:
    import mujoco

END_TIME = 1.0  # s
UNNAMED = "MuJoCo Model"


def convert(
    model: "mujoco.MjModel",
    *,
    qpos: Sequence[float] | None = None,
    keyframe: str | None = None,
    keep_limits: bool = False,
    strict: bool = False,
    title: str,
    origin: str,
    licence: str = "",
    notes: Sequence[Note] = (),
    massless: frozenset[str] = frozenset(),
) -> Imported:
    """The scenario of a compiled model; see `lienumba.importing.from_mujoco`."""
    if model.nv == 0:
        remedy = (
            f"give its root a free joint ({option('base', 'free')})"
            if model.nbody > 1
            else "give a model with bodies and joints"
        )
        raise ScenarioError(Problem(origin, "has nothing that moves", remedy))
    model = with_flags(model)
    source = Source(model, *_start(model, qpos, keyframe), massless)
    draft = Draft(notes=list(notes))
    in_loops = looped(source)
    tree = add_tree(source, draft, in_loops)
    readings = Readings(source, draft, tree)
    step = stable_step(source)
    add_passive(source, draft, tree, readings, step, keep_limits)
    add_fluid(source, draft, tree)
    add_tendons(source, draft, tree, readings)
    add_actuators(source, draft, tree, readings)
    add_equalities(source, draft, tree)
    add_shapes(source, draft, tree)
    note_left_out(source, draft)
    for kind, names in (("body", draft.body_names), ("joint", draft.joint_names), ("input", draft.input_names)):
        for old, new in names.renamed.items():
            draft.note('names are letters, digits and "_", each once', f'{kind} "{old}" is {new} here', lost=False)
    data = _data(source, draft, title, step, bool(tree.joints))
    note_moved(source, draft, tree, in_loops, data)
    found = gathered(draft.notes)
    if strict and (lost := [note for note in found if note.lost]):
        raise ScenarioError(
            *(
                Problem(
                    origin, note.what, f"import it without {option('strict')}, or take it out", within=note.places[:1]
                )
                for note in lost
            )
        )
    return Imported(data, found, origin, licence)


def _data(source: Source, draft: Draft, title: str, step: float, joints: bool) -> dict[str, Any]:
    model: dict[str, Any] = {"gravity": tidy(source.model.opt.gravity), "bodies": draft.bodies, "joints": draft.joints}
    model |= {kind: found for kind in ("drivers", "forces") if (found := getattr(draft, kind))}
    data: dict[str, Any] = {"title": title}
    data |= {kind: found for kind in ("parameters", "inputs") if (found := getattr(draft, kind))}
    if draft.ground_shapes:
        model["ground_shapes"] = draft.ground_shapes
    if draft.quantities:
        model["quantities"] = draft.quantities
    data["model"] = model
    way = {"coordinates": "joint"} if joints else {}
    data["integrator"] = {"method": "rk4", "step": step, "end_time": END_TIME, **way}
    if joints:
        data["output"] = {"joint_coordinates": True}
    if draft.laws:
        data["files"] = {LAWS: draft.file}
    return data


def _start(
    model: "mujoco.MjModel", qpos: Sequence[float] | None, keyframe: str | None
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """qpos, qvel, ctrl and act at the start."""
    if qpos is not None and keyframe is not None:
        raise ScenarioError(Problem("keyframe", "there is qpos already", "give one of them", keyframe))
    zero = model.qpos0.copy(), np.zeros(model.nv), np.zeros(model.nu), np.zeros(model.na)
    if qpos is not None:
        given = np.asarray(qpos, float)
        if given.shape != (model.nq,) or not np.isfinite(given).all():
            rule = f"must be {plural(model.nq, 'finite number', 'finite numbers')}, as MuJoCo's qpos has them"
            raise ScenarioError(Problem("qpos", rule, _layout(model), given.tolist()))
        return given, *zero[1:]
    if keyframe is None:
        return zero
    names = [model.key(k).name for k in range(model.nkey)]
    if keyframe not in names:
        remedy = suggestion(keyframe, names) if any(names) else "leave it out, or give qpos"
        raise ScenarioError(Problem("keyframe", "is not in the model", remedy, keyframe))
    k = names.index(keyframe)
    return tuple(x[k].copy() for x in (model.key_qpos, model.key_qvel, model.key_ctrl, model.key_act))


def named(model: "mujoco.MjModel") -> str:
    """The name of a model, if it has been given one."""
    name = bytes(model.names).split(b"\0", 1)[0].decode()
    return "" if name == UNNAMED else name


def _layout(model: "mujoco.MjModel") -> str:
    """What qpos consists of."""
    parts = [
        f"{LETTERS[int(model.jnt_type[j])]} of {show(model.joint(j).name or f'joint_{j}')}" for j in range(model.njnt)
    ]
    return f"give {listed(parts, 'and')}"
