"""What acts on joints by itself: springs, dampers, friction, stops; and what floats against gravity."""

import numpy as np

from lienumba.importing.mapping.draft import GROUND, Draft
from lienumba.importing.mapping.frames import neat, tidy
from lienumba.importing.mapping.readings import Readings, product, total
from lienumba.importing.mapping.source import BALL, FREE, HINGE, Source
from lienumba.importing.mapping.tree import Tree
from lienumba.words import option

SLOW = 1e-2  # rad/s or m/s, at which sliding sets in, or above

BALL_DAMPER = '''def ball_damper(child, parent, *, damping):
    """Against the relative angular velocity."""
    w = child.to_global(child.angular_velocity) - parent.to_global(parent.angular_velocity)
    return [child.torque(-damping * w), parent.torque(damping * w)]
'''


def add_passive(source: Source, draft: Draft, tree: Tree, readings: Readings, step: float, keep_limits: bool) -> None:
    """Add the forces of joints. step: of the integrator in s; keep_limits: stops, else a note."""
    for joint, name in tree.joints.items():
        kind = int(source.model.jnt_type[joint])
        if kind == BALL:
            _ball(source, draft, tree, joint, name)
        else:
            _spring(source, draft, joint, name, kind)
            _friction(source, draft, joint, name, step)
            _polynomials(source, draft, readings, joint, name)
        _limits(source, draft, joint, name, kind, keep_limits)
    _floating(source, draft)
    _gravity_compensation(source, draft, tree)


def _dof(source: Source, joint: int) -> int:
    return int(source.model.jnt_dofadr[joint])


def _place(source: Source, joint: int) -> str:
    return source.place("joint", joint)


def _spring(source: Source, draft: Draft, joint: int, name: str, kind: int) -> None:
    m = source.model
    stiffness, damping = float(m.jnt_stiffness[joint]), source.damping(joint)
    rest = float(m.qpos_spring[m.jnt_qposadr[joint]])
    if not stiffness:
        return
    keys = {"stiffness": tidy(stiffness)[0], "damping": tidy(damping)[0] if damping else None}
    if kind == HINGE:
        draft.force(f"{name}_spring", "torsion_spring", joint=name, **keys, free_angle=tidy(rest)[0] if rest else None)
    else:
        draft.force(f"{name}_spring", "actuator", joint=name, **keys, target=tidy(rest)[0])


def _friction(source: Source, draft: Draft, joint: int, name: str, step: float) -> None:
    m, dof = source.model, _dof(source, joint)
    viscous = 0.0 if m.jnt_stiffness[joint] else source.damping(joint)
    coulomb = float(m.dof_frictionloss[dof])
    keys: dict[str, float] = {}
    if viscous:
        keys["viscous"] = tidy(viscous)[0]
    if coulomb:
        keys["coulomb"] = tidy(coulomb)[0]
        keys["velocity"] = float(f"{max(SLOW, 2.0 * coulomb * m.dof_invweight0[dof] * step):.2g}")
        draft.note(
            "dry friction (frictionloss) is the friction `coulomb`, smooth below `velocity`: nothing sticks",
            _place(source, joint), lost=False,
        )  # fmt: skip
    if keys:
        draft.force(f"{name}_friction", "friction", joint=name, **keys)


def _polynomials(source: Source, draft: Draft, readings: Readings, joint: int, name: str) -> None:
    """-x (k1 |x| + k2 x^2), of the coordinate from its rest or of the rate: newer models have it."""
    m = source.model
    rest = float(m.qpos_spring[m.jnt_qposadr[joint]])
    for field, index, what in (
        ("jnt_stiffnesspoly", joint, "stiffening"), ("dof_dampingpoly", _dof(source, joint), "damping"),
    ):  # fmt: skip
        numbers = getattr(m, field, None)
        if numbers is None or not np.any(numbers[index]):
            continue
        x = readings.coordinate(joint) if what == "stiffening" else readings.rate(joint)
        x = f"({x} - {neat(rest)!r})" if rest and what == "stiffening" else x
        terms = [product(float(k), f"abs({x})**{n}") for n, k in enumerate(numbers[index], start=1)]
        draft.force(f"{name}_{what}", "actuator", joint=name, value=f"-{x}*({total(terms)})")


def _ball(source: Source, draft: Draft, tree: Tree, joint: int, name: str) -> None:
    m, dof = source.model, _dof(source, joint)
    parent, child = tree.ends[joint]
    if damping := float(m.dof_damping[dof]):
        keys = {"bodies": [child.name, parent.name], "parameters": {"damping": tidy(damping)[0]}}
        draft.force(f"{name}_damper", "python", function=draft.law(BALL_DAMPER), **keys)
    for what, value in (
        ("stiffness", m.jnt_stiffness[joint]),
        ("armature", m.dof_armature[dof]),
        ("frictionloss", m.dof_frictionloss[dof]),
    ):
        if value:
            draft.note(f"the {what} of ball joints is left out", _place(source, joint))


def _limits(source: Source, draft: Draft, joint: int, name: str, kind: int, keep: bool) -> None:
    """MuJoCo's limits are soft; in contact a joint comes back like a mass on a damped spring, whose effective mass is
    that at the reference: k = 1 / (w dmax^2 timeconst^2 dampratio^2), b = 2 / (w dmax timeconst), w = dof_invweight0.
    """
    m = source.model
    if not m.jnt_limited[joint]:
        return
    if kind == BALL or not keep:
        draft.note(
            "limits of joints are left out"
            + ("" if kind == BALL else f"; {option('keep_limits')} makes stops of them"),
            _place(source, joint),
        )
        return
    low, high = map(float, m.jnt_range[joint])
    timeconst, dampratio = map(float, m.jnt_solref[joint])
    width, weight = float(m.jnt_solimp[joint][1]), float(m.dof_invweight0[_dof(source, joint)])
    if timeconst > 0.0:
        stiffness = 1.0 / (width**2 * timeconst**2 * dampratio**2)
        damping = 2.0 / (width * timeconst)
    else:  # given as -stiffness, -damping
        stiffness, damping = -timeconst / width**2, -dampratio / width
    keys = {"stiffness": float(f"{stiffness / weight:.3g}"), "damping": float(f"{damping / weight:.3g}")}
    draft.force(f"{name}_stop", "end_stop", joint=name, lower=tidy(low)[0], upper=tidy(high)[0], **keys)
    draft.note(
        "limits are stops with springs and dampers, as stiff as MuJoCo's at the reference",
        _place(source, joint),
        lost=False,
    )


def _floating(source: Source, draft: Draft) -> None:
    m = source.model
    for joint in range(m.njnt):
        if m.jnt_type[joint] == FREE:
            dofs = slice(_dof(source, joint), _dof(source, joint) + 6)
            for what, values in (
                ("damping", m.dof_damping),
                ("armature", m.dof_armature),
                ("frictionloss", m.dof_frictionloss),
            ):
                if np.any(values[dofs]):
                    draft.note(f"the {what} of free joints is left out", _place(source, joint))


def _gravity_compensation(source: Source, draft: Draft, tree: Tree) -> None:
    m = source.model
    for body in np.flatnonzero(m.body_gravcomp):
        name, frame = tree.on(source, int(body))
        if name != GROUND and m.body_mass[body]:
            up = -m.opt.gravity * m.body_mass[body] * m.body_gravcomp[body]
            point = tidy(frame.point(m.body_ipos[body]))
            draft.force(f"{name}_floats", "force", body=name, point=point, value=tidy(up))
