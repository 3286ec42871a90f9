"""The mechanism as it is seen: bodies by their shapes, or as solids of equivalent inertia, joints as marks, and how
they move in a run."""

from lienumba.scenario.meshes.files import write_stl as write_stl
from lienumba.scenario.meshes.packing import packed_mesh as packed_mesh
from lienumba.scene.modes import mode_scene as mode_scene
from lienumba.scene.runs import ShownRun as ShownRun
from lienumba.scene.scene import MovingRun as MovingRun
from lienumba.scene.scene import Scene as Scene
from lienumba.scene.scene import box as box
from lienumba.scene.scene import scene as scene
