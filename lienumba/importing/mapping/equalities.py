"""Equalities: what closes loops, and what ties coordinates. MuJoCo holds them by stiff springs, here they are exact."""

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from lienumba.importing.mapping.draft import Draft
from lienumba.importing.mapping.frames import Frame, neat, rotation, tidy
from lienumba.importing.mapping.readings import product, total
from lienumba.importing.mapping.source import BALL, FREE, HINGE, Source
from lienumba.importing.mapping.tendons import fixed
from lienumba.importing.mapping.tree import Tree

CONNECT, WELD, JOINT, TENDON = range(4)  # mjtEq
OTHERWISE = "equalities of tendons that wrap, of distances and of flexible bodies are left out"


def active(source: Source) -> Iterator[int]:
    """The equalities that hold."""
    return (e for e in range(source.model.neq) if source.model.eq_active0[e])


def looped(source: Source) -> set[int]:
    """The joints whose coordinates equalities tie: those between the links of a loop, and all that follow others."""
    found: set[int] = set()
    for e in active(source):
        m = source.model
        kind, first, second = int(m.eq_type[e]), int(m.eq_obj1id[e]), int(m.eq_obj2id[e])
        if kind in (CONNECT, WELD):
            a, b = (set(_path(source, _body(source, e, x))) for x in (first, second))
            found |= a ^ b
        elif kind == JOINT:
            found.add(first)
        elif kind == TENDON:
            for tendon in (first, second):
                if tendon >= 0 and (along := fixed(source, tendon)):
                    found |= set(along)
    return found


def add_equalities(source: Source, draft: Draft, tree: Tree) -> None:
    """Add a joint, coupling or driver for each equality."""
    m = source.model
    for e in range(m.neq):
        kind, place = int(m.eq_type[e]), source.place("equality", e)
        if not m.eq_active0[e]:
            draft.note("equalities that are switched off are left out", place, lost=False)
        elif kind in (CONNECT, WELD):
            _close(source, draft, tree, e)
        elif kind == JOINT and m.jnt_type[m.eq_obj1id[e]] in (FREE, BALL):
            draft.note("equalities of ball and free joints are left out", place)
        elif kind == JOINT:
            other = int(m.eq_obj2id[e])
            _tie(source, draft, tree, e, {int(m.eq_obj1id[e]): 1.0}, {other: 1.0} if other >= 0 else {})
        elif kind == TENDON and all(fixed(source, t) for t in (m.eq_obj1id[e], m.eq_obj2id[e]) if t >= 0):
            first, second = (fixed(source, int(t)) if t >= 0 else None for t in (m.eq_obj1id[e], m.eq_obj2id[e]))
            assert first is not None
            _tie(source, draft, tree, e, first, second or {})
        else:
            draft.note(OTHERWISE, place)


def _path(source: Source, body: int) -> Iterator[int]:
    """The joints between the ground and a body."""
    link = source.link_of(body)
    while link:
        yield from source.joints_of(link)
        link = source.parent(link)


def _is_site(source: Source, equality: int) -> bool:
    import mujoco

    return bool(source.model.eq_objtype[equality] == mujoco.mjtObj.mjOBJ_SITE)


def _body(source: Source, equality: int, index: int) -> int:
    return int(source.model.site_bodyid[index]) if _is_site(source, equality) else index


def _ends(source: Source, e: int) -> tuple[Frame, Frame]:
    """The frames that an equality brings together, each in the frame of its MuJoCo body."""
    m, data = source.model, source.model.eq_data[e]
    if _is_site(source, e):
        first, second = (Frame.of(m.site_pos[s], m.site_quat[s]) for s in (m.eq_obj1id[e], m.eq_obj2id[e]))
        return first, second
    if m.eq_type[e] == CONNECT:
        return Frame(data[:3].copy(), np.eye(3)), Frame(data[3:6].copy(), np.eye(3))
    R = rotation(data[6:10])  # of the second body in the first; the point is given in both
    return Frame(data[3:6].copy(), R), Frame(data[:3].copy(), np.eye(3))


def _close(source: Source, draft: Draft, tree: Tree, e: int) -> None:
    m = source.model
    bodies = [_body(source, e, int(x)) for x in (m.eq_obj1id[e], m.eq_obj2id[e])]
    (a, A), (b, B) = (tree.on(source, body) for body in bodies)
    first, second = A @ _ends(source, e)[0], B @ _ends(source, e)[1]
    name = draft.joint_names.new(source.name("equality", e))
    keys = {"bodies": [a, b], "points": [tidy(first.p), tidy(second.p)]}
    if m.eq_type[e] == CONNECT:
        draft.joints.append({"name": name, "type": "spherical", **keys})
    else:
        axes, references = ([tidy(first.R[:, i]), tidy(second.R[:, i])] for i in (2, 0))
        draft.joints.append({"name": name, "type": "fixed", **keys, "axes": axes, "references": references})


def _tie(
    source: Source, draft: Draft, tree: Tree, e: int, first: Mapping[int, float], second: Mapping[int, float]
) -> None:
    """first - first0 = c0 + c1 (second - second0) + ..., of sums of coordinates, where 0 is the reference."""
    m, name = source.model, source.name("equality", e)
    c = np.array(m.eq_data[e][:5])
    if (second and c[2:].any()) or len({**first, **second}) > 2:
        _law(source, draft, tree, name, (first, second), c)
        return
    zeros = [_at_zero(source, terms) for terms in (first, second)]
    terms = dict(first)  # linear: all on one side
    for joint, a in second.items():
        terms[joint] = terms.get(joint, 0.0) - c[1] * a
    terms = {joint: a for joint, a in terms.items() if a}
    rest = zeros[0] + c[0] - (c[1] * zeros[1] if second else 0.0)
    if len(terms) == 1:
        ((joint, a),) = terms.items()
        name = draft.force_names.new(name)
        draft.drivers.append({"name": name, "joint": tree.joints[joint], "value": neat(rest / a)})
        return
    (follower, a), (leader, b) = terms.items()
    hinges = [m.jnt_type[joint] == HINGE for joint in (leader, follower)]
    keys = {"type": "gear" if all(hinges) else "coupler", "joints": [tree.joints[leader], tree.joints[follower]]}
    numbers = {"ratio": neat(-b / a), "offset": neat(rest / a)}
    draft.joints.append({"name": draft.joint_names.new(name), **keys, **numbers})


def _at_zero(source: Source, terms: Mapping[int, float]) -> float:
    return sum(a * source.zero(joint) for joint, a in terms.items())


def _law(
    source: Source, draft: Draft, tree: Tree, name: str, sums: Sequence[Mapping[int, float]], c: np.ndarray
) -> None:
    """The same as a constraint in Python."""
    listed = list(dict.fromkeys(joint for terms in sums for joint in terms))
    names = {joint: f"joint{n}" for n, joint in enumerate(listed, start=1)}

    def length(terms: Mapping[int, float]) -> str:
        kinds = {joint: "angle" if source.model.jnt_type[joint] == HINGE else "displacement" for joint in terms}
        parts = [product(a, f"{names[joint]}.{kinds[joint]}") for joint, a in terms.items()]
        zero = _at_zero(source, terms)
        return total([*parts, repr(neat(-zero)) if zero else ""])

    parameters = {f"c{n}": neat(x) for n, x in enumerate(c if sums[1] else c[:1]) if x}
    powers = [key if key == "c0" else f"{key}*x**{key[1:]}" for key in parameters]
    new = draft.joint_names.new(name)
    arguments = ", ".join([*names.values(), *(["*", *parameters] if parameters else [])])
    text = [f"def {new}({arguments}):", '    """Coordinates of joints that go together."""']
    text += [f"    x = {length(sums[1])}"] if sums[1] else []
    text += [f"    return {length(sums[0])}" + "".join(f" - {power}" for power in powers), ""]
    unit = "rad" if source.model.jnt_type[listed[0]] == HINGE else "m"
    keys = {"joints": [tree.joints[joint] for joint in listed], "rows": [unit], "parameters": parameters}
    function = draft.law("\n".join(text))
    draft.joints.append({"name": new, "type": "python", "function": function, **keys})
