"""The mechanism as it is seen: bodies as solids of equivalent inertia, joints as marks, and how they move in a run."""

from lienumba.scene.runs import Choice as Choice
from lienumba.scene.scene import Moving as Moving
from lienumba.scene.scene import Scene as Scene
from lienumba.scene.scene import box as box
from lienumba.scene.scene import scene as scene
