"""Names of internal modules that most tests import: when a module moves, only this file changes."""

from lienumba.cli import app as app
from lienumba.errors import ScenarioError as ScenarioError
from lienumba.integrators.methods import METHODS as METHODS
from lienumba.mechanics.elements.joints import JOINTS as JOINTS
from lienumba.mechanics.mechanism.kinematics import Instant as Instant
from lienumba.mechanics.mechanism.model import GROUND as GROUND
from lienumba.mechanics.mechanism.model import Body as Body
from lienumba.mechanics.mechanism.model import Joint as Joint
from lienumba.mechanics.mechanism.model import Model as Model
from lienumba.scenario.resolve import resolve as resolve
