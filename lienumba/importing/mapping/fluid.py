"""The drag of a surrounding fluid, by MuJoCo's model of the box that has the inertia of a body.

With edges a, b, c of the box: a force -3 pi d viscosity v and a torque -pi d^3 viscosity w, d being their mean, and
along each axis -density b c |v| v / 2 and -density a (b^4 + c^4) |w| w / 64. v is that of the mass centre, relative to
the wind.
"""

import numpy as np

from lienumba.importing.mapping.draft import GROUND, Draft
from lienumba.importing.mapping.frames import Frame, neat, rotation, tidy
from lienumba.importing.mapping.source import Source
from lienumba.importing.mapping.tree import Tree

DRAG = '''def drag(
    body, *, density, viscosity, a, b, c, px=0, py=0, pz=0, wind_x=0, wind_y=0, wind_z=0,
    xx=1, xy=0, xz=0, yx=0, yy=1, yz=0, zx=0, zy=0, zz=1,
):
    """Of a box with edges a, b, c along the axes x, y, z of the body at the point p."""
    at, axes = Vector(px, py, pz), [Vector(xx, xy, xz), Vector(yx, yy, yz), Vector(zx, zy, zz)]
    v = body.to_body(body.velocity_of(at) - Vector(wind_x, wind_y, wind_z))
    w, mean = body.angular_velocity, (a + b + c) / 3
    force, torque = Vector(0, 0, 0), Vector(0, 0, 0)
    for e, (own, one, other) in zip(axes, [(a, b, c), (b, c, a), (c, a, b)]):
        slip, turn = v.dot(e), w.dot(e)
        push = 3 * pi * mean * viscosity + 0.5 * density * one * other * absolute(slip)
        twist = pi * mean**3 * viscosity + density * own * (one**4 + other**4) * absolute(turn) / 64
        force, torque = force - push * slip * e, torque - twist * turn * e
    return [body.force(force, at=at, frame="body"), body.torque(torque, frame="body")]
'''
USES = ("Vector", "absolute", "pi")


def add_fluid(source: Source, draft: Draft, tree: Tree) -> None:
    """Add the drag of each body."""
    m = source.model
    if not (m.opt.density or m.opt.viscosity):
        return
    shaped = [b for b in range(1, m.nbody) if _has_own_model(source, b)]
    if shaped:
        what = "forces of the fluid are left out, since some bodies have them by ellipsoids (fluidshape)"
        draft.note(what, *(source.place("body", b) for b in shaped))
        return
    fluid = {
        "density": draft.parameter("fluid_density", neat(m.opt.density)),
        "viscosity": draft.parameter("fluid_viscosity", neat(m.opt.viscosity)),
    }
    wind = {f"wind_{x}": v for x, v in zip("xyz", tidy(m.opt.wind), strict=True) if v}
    function = draft.law(DRAG, USES)
    for body in range(1, m.nbody):
        name, frame = tree.on(source, body)
        if name == GROUND or not m.body_mass[body]:
            continue
        there = frame @ Frame(np.array(m.body_ipos[body]), rotation(m.body_iquat[body]))
        numbers: dict[str, object] = {**fluid, **dict(zip("abc", _box(source, body), strict=True)), **wind}
        numbers |= {f"p{x}": v for x, v in zip("xyz", tidy(there.p), strict=True) if v}
        if np.any(np.eye(3) != there.R):
            columns = [tidy(column) for column in there.R.T]
            numbers |= {
                f"{e}{x}": v for e, c in zip("xyz", columns, strict=True) for x, v in zip("xyz", c, strict=True)
            }
        of = source.name("body", body)
        draft.force(f"{of}_drag", "python", function=function, bodies=[name], parameters=numbers)


def _has_own_model(source: Source, body: int) -> bool:
    m = source.model
    first = int(m.body_geomadr[body])
    return bool(m.body_geomnum[body] and np.any(m.geom_fluid[first : first + m.body_geomnum[body], 0] > 0.0))


def _box(source: Source, body: int) -> list[float]:
    """Edges of the homogeneous box with the mass and the principal moments of a body."""
    moments, mass = source.model.body_inertia[body], source.model.body_mass[body]
    squares = 6.0 * (np.roll(moments, -1) + np.roll(moments, -2) - moments) / mass
    return [neat(x) for x in np.sqrt(np.maximum(squares, 1e-15))]
