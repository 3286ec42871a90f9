"""Why a tolerance made steps short, where it is not the motion: stiffness, or a force that chatters."""

from lienumba.engine.linear import chattering, stiffness
from lienumba.engine.linear.course import Column
from lienumba.engine.simulate import Runs
from lienumba.scenario.resolve import Scenario


def attributes(resolved: Scenario, runs: Runs, column: Column) -> dict[str, str]:
    """What the dataset says of it."""
    return stiffness.attributes(resolved, runs, column) | chattering.attributes(resolved, runs, column)
