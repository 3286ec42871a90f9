"""From the elements of a URDF file to MuJoCo's compiled model."""

from pathlib import Path
from typing import TYPE_CHECKING, Literal

from lienumba.importing.markup import Element
from lienumba.importing.notes import Note
from lienumba.importing.urdf.density import with_density
from lienumba.importing.urdf.parse import parse
from lienumba.importing.urdf.spec import Builder
from lienumba.importing.urdf.tree import check_masses, tree_of

if TYPE_CHECKING:
    import mujoco


def urdf(
    root: Element, file: Path, base: Literal["fixed", "free"] | None, density: float | None = None
) -> tuple["mujoco.MjModel", list[Note], frozenset[str]]:
    """The model, what was changed or left out, and the bodies without mass that move."""
    robot, notes = parse(root, file)
    if density is not None:
        robot = with_density(robot, file, density, notes)
    tree = tree_of(robot, file, base, notes)
    massless = check_masses(tree, file, notes)
    builder = Builder(tree, file)
    model = builder.build()
    return model, [*notes, *builder.notes], frozenset(builder.names[name] for name in massless)
