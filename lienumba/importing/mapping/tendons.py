"""Tendons that are sums of coordinates of joints, or straight lines between two sites."""

import numpy as np

from lienumba.importing.mapping.draft import Draft
from lienumba.importing.mapping.frames import neat
from lienumba.importing.mapping.readings import Readings, product, total
from lienumba.importing.mapping.source import Source
from lienumba.importing.mapping.tree import Tree

JOINT, PULLEY, SITE = 1, 2, 3  # mjtWrap


def fixed(source: Source, tendon: int) -> dict[int, float] | None:
    """The coefficients of a tendon whose length is a sum of coordinates, by joints of MuJoCo; None of any other."""
    m = source.model
    wraps = range(m.tendon_adr[tendon], m.tendon_adr[tendon] + m.tendon_num[tendon])
    if any(m.wrap_type[w] != JOINT for w in wraps):
        return None
    found: dict[int, float] = {}
    for w in wraps:
        joint = int(m.wrap_objid[w])
        found[joint] = found.get(joint, 0.0) + float(m.wrap_prm[w])
    return {joint: c for joint, c in found.items() if c}


def add_tendons(source: Source, draft: Draft, tree: Tree, readings: Readings) -> None:
    """Springs and dampers of tendons."""
    m = source.model
    for tendon in range(m.ntendon):
        place = source.place("tendon", tendon)
        for what, lost in (
            ("limits", m.tendon_limited[tendon]),
            ("frictionloss", m.tendon_frictionloss[tendon]),
            ("armature", getattr(m, "tendon_armature", np.zeros(m.ntendon))[tendon]),
            ("polynomials", _polynomials(source, tendon)),
        ):
            if lost:
                draft.note(f"{what} of tendons are left out", place)
        k, d = float(m.tendon_stiffness[tendon]), float(m.tendon_damping[tendon])
        if not k and not d:
            continue
        low, high = map(float, m.tendon_lengthspring[tendon])
        if (coefficients := fixed(source, tendon)) is not None:
            _along_joints(source, draft, tree, readings, tendon, coefficients, (k, d, low, high))
        elif (ends := _sites(source, tendon)) and low == high:
            places = [tree.on(source, int(m.site_bodyid[s])) for s in ends]
            draft.force(
                source.name("tendon", tendon), "spring_damper", bodies=[name for name, _ in places],
                points=[[*map(neat, frame.point(m.site_pos[s]))] for s, (_, frame) in zip(ends, places, strict=True)],
                stiffness=neat(k), damping=neat(d), free_length=neat(low),
            )  # fmt: skip
        else:
            draft.note("springs and dampers of tendons that wrap, branch or slacken are left out", place)


def _polynomials(source: Source, tendon: int) -> bool:
    fields = (getattr(source.model, f"tendon_{x}poly", None) for x in ("stiffness", "damping"))
    return any(field is not None and bool(np.any(field[tendon])) for field in fields)


def _sites(source: Source, tendon: int) -> tuple[int, int] | None:
    m = source.model
    wraps = range(m.tendon_adr[tendon], m.tendon_adr[tendon] + m.tendon_num[tendon])
    ends = [int(m.wrap_objid[w]) for w in wraps]
    straight = len(ends) == 2 and all(m.wrap_type[w] == SITE for w in wraps)
    return (ends[0], ends[1]) if straight else None


def _along_joints(
    source: Source, draft: Draft, tree: Tree, readings: Readings, tendon: int, coefficients: dict[int, float],
    spring: tuple[float, float, float, float],
) -> None:  # fmt: skip
    k, d, low, high = spring
    name = source.name("tendon", tendon)
    length, speed = readings.lengths(coefficients), readings.rates(coefficients)
    if low == high:
        slack = total([product(-k, f"({length})"), repr(neat(k * low)) if k * low else ""])
    else:  # nothing acts between the two lengths
        slack = f"{neat(k)!r}*(max({neat(low)!r} - ({length}), 0) - max(({length}) - {neat(high)!r}, 0))"
    force = readings.named(f"{name}_force", total([slack if k else "", product(-d, f"({speed})")]))
    for joint, c in coefficients.items():
        draft.force(f"{name}_{tree.joints[joint]}", "actuator", joint=tree.joints[joint], value=product(c, force))
