"""Whether all that moves has a mass, and moments of inertia that a rigid body has."""

from collections import Counter
from pathlib import Path

import numpy as np

from lienumba.errors import ScenarioError
from lienumba.importing.mapping.source import Link, Source
from lienumba.importing.notes import Note
from lienumba.importing.urdf.robot import Array
from lienumba.importing.urdf.tree import Tree
from lienumba.words import option

SMALLEST = 1e-15  # moment of inertia in kg m², below which it is none
LEAST = 1e-14  # of the largest moment of inertia: smaller ones are none
MOMENTS_RTOL = 1e-9  # of moments of inertia, relative to the largest
BROKEN = "no rigid body has its principal moments of inertia"


def check_masses(tree: Tree, source: Source, bodies: dict[str, int], file: Path, notes: list[Note]) -> frozenset[str]:
    """The links that move and have no mass, with all that is welded to them; a ScenarioError where that cannot move.

    Parameters
    ----------
    tree : Tree
        As the file has it.
    source : Source
        The compiled model, with the masses of the file.
    bodies : dict
        The bodies of the model by the names of links.
    file : Path
        Of the robot.
    notes : list of Note
        What is noted is added.

    Returns
    -------
    frozenset of str
        Their names.
    """
    links, names = tree.robot.links, {body: name for name, body in bodies.items()}
    carried = np.array(source.model.body_mass)
    for body in reversed(range(1, len(carried))):
        carried[source.model.body_parentid[body]] += carried[body]
    idle = [names[body] for body in source.links if carried[body] <= 0]
    if idle:
        first = links[idle[0]]
        moving = {joint.child: joint for joint in tree.joints if joint.type != "fixed"}
        more = f"; likewise {_listed(idle[1:])}" if idle[1:] else ""
        shapes = any(not shape.drawn for shape in first.shapes)
        collides = f", or give the density of its collision shapes ({option('density', 1000)})" if shapes else ""
        how = f'moves by joint "{moving[first.name].name}"' if first.name in moving else "is a free base"
        raise ScenarioError.at(
            f'{file}, line {first.line}: link "{first.name}"',
            f"{how}, and neither it nor what it carries has mass{more}",
            f"give it an <inertial>, or make the joint fixed{collides}",
        )
    for body in source.links:
        welded = [name for name, other in bodies.items() if source.link_of(other) == body != other]
        _check_inertia(f"{file}, line {links[names[body]].line}", names[body], source.composites[body], welded, notes)
    given = {  # by the name of a link: its inertial, and the body that it moves with (0: the ground)
        name: (inertial, source.link_of(body))
        for name, body in bodies.items()
        if (inertial := links[name].inertial) is not None
    }
    inertials_of = Counter(body for _, body in given.values())
    for name, (inertial, body) in given.items():
        if not body or inertials_of[body] == 1:
            continue
        moments = _moments(inertial.tensor)
        if moments[0] < -MOMENTS_RTOL * abs(moments).max() or _too_long(moments):
            what = f"{BROKEN} {_three(moments)}: counted with what it is welded to"
            notes.append(Note(what, (f'link "{name}"',), lost=False))
    return frozenset(names[body] for body in source.links if source.composites[body].mass <= 0)


def _check_inertia(line: str, name: str, body: Link, welded: list[str], notes: list[Note]) -> None:
    """Of what moves as one body."""
    at, whose = f'{line}: link "{name}"', f" (with {_listed(welded)}, welded to it)" if welded else ""
    moments = _moments(body.inertia)
    largest = float(np.abs(moments).max())
    if body.mass <= 0:
        if largest > 0:
            rule = f"has moments of inertia {_three(moments)} kg m² and a mass of 0{whose}"
            raise ScenarioError.at(at, rule, "give its mass, or no <inertial> for a frame without mass")
        return
    if largest < SMALLEST:
        rule = f"has a mass of {body.mass:g} kg and moments of inertia of 0{whose}"
        raise ScenarioError.at(at, rule, "give the <inertia> of a body of that size in kg m²")
    if moments[0] <= LEAST * largest:
        rule = f"has principal moments of inertia {_three(moments)} kg m²{whose}, and all must be above 0"
        raise ScenarioError.at(at, rule, "check the signs of <inertia>, and that it is about the mass centre")
    if _too_long(moments):
        what = f"{BROKEN} {_three(moments)}: one exceeds the sum of the others"
        notes.append(Note(what, (f'link "{name}"',), lost=False))


def _moments(tensor: Array) -> Array:
    """The principal ones (3,) in kg m², least first; roundoff is 0."""
    found = np.linalg.eigvalsh(tensor)
    return np.where(abs(found) > LEAST * abs(found).max(), found, 0.0)


def _too_long(moments: Array) -> bool:
    return bool(moments[2] > (moments[0] + moments[1]) * (1 + MOMENTS_RTOL))


def _three(moments: Array) -> str:
    return ", ".join(f"{x:.4g}" for x in moments)


def _listed(names: list[str]) -> str:
    shown = ", ".join(f'"{name}"' for name in names[:6])
    return f"{shown} and {len(names) - 6} others" if len(names) > 6 else shown
