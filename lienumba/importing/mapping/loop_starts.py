"""By how much the coordinates of joints in loops move from the given start, so that their loops close."""

from collections.abc import Collection
from typing import Any

from lienumba.errors import ScenarioError
from lienumba.importing.mapping.draft import Draft
from lienumba.importing.mapping.source import HINGE, SLIDE, Source
from lienumba.importing.mapping.tree import Tree
from lienumba.mechanics.elements import joints
from lienumba.mechanics.mechanism.kinematics import still
from lienumba.mechanics.mechanism.model import Coordinate
from lienumba.scenario.resolve import resolve
from lienumba.scenario.start.prepare import check_initial

MOVED = 1e-6  # rad or m: less is the tolerance of a closed loop


def note_moved(source: Source, draft: Draft, tree: Tree, looped: Collection[int], data: dict[str, Any]) -> None:
    """Note each hinge and slide in a loop that starts elsewhere than it is said; nothing where loops do not close,
    which `lienumba validate` explains."""
    kinds = {HINGE: ("angle", "rad"), SLIDE: ("displacement", "m")}
    named = {tree.joints[j]: j for j in looped if j in tree.joints and source.model.jnt_type[j] in kinds}
    if not named:
        return
    try:
        start = check_initial(resolve(data, allow_code=True))
    except ScenarioError:
        return
    view = still(start.now, tuple(range(len(start.model.bodies))))
    for n, joint in enumerate(start.model.joints):
        if joint.name in named:
            index = named[joint.name]
            kind, unit = kinds[int(source.model.jnt_type[index])]
            x = joints.coordinate(start.model, Coordinate(n, kind), view)
            by = float(x) - float(source.coordinates(index)[0])
            if abs(by) > MOVED:
                what = f"starts by {by:+.3g} {unit} away from the given start, so that its loop closes"
                draft.note(what, source.place("joint", index), lost=False)
