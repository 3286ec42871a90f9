"""Before anything runs: the samples, the model with its numbers, the initial states, and whether they fit together."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from lienumba.batch.statuses import INVALID, NOT_ASSEMBLED, SUCCESS
from lienumba.errors import ScenarioError
from lienumba.mechanics import assembly
from lienumba.mechanics.joints import rows_of
from lienumba.mechanics.model import Model
from lienumba.scenario.build import build, unphysical
from lienumba.scenario.resolve import Scenario
from lienumba.sweep.design import design_table

if TYPE_CHECKING:
    import numpy as np


@dataclass(frozen=True)
class Prepared:
    """labels (runs,), samples by path (runs,), the model with arrays where it varies, states (runs, 18 k), codes."""

    labels: list[int]
    samples: "dict[str, np.ndarray]"
    model: Model
    states: "np.ndarray"
    codes: "np.ndarray"


def check_initial(scenario: Scenario) -> None:
    """Raise a ScenarioError if the nominal initial state does not fit the joints, or the joints each other."""
    model, poses = build(scenario, {})
    done = assembly.assemble(model, poses, 1)
    problems = [
        f"model.joints.{joint.name}: its two points coincide at the start, so its length is 0 and it must be above 0; "
        "move a point or a body, or use a spherical joint"
        for joint in done.model.joints
        if joint.length is not None and not joint.length > 0.0
    ] or _violations(done, 0)
    if not problems and (found := assembly.dependent_joint(done.model, done.state[0])):
        name, rank, rows = found
        problems.append(
            f"model.joints.{name}: its constraints depend on those of the joints before it (rank {rank} of {rows} "
            "equations); remove a joint that adds nothing, or replace it by one with fewer equations"
        )
    if problems:
        raise ScenarioError("\n".join(problems))


def _violations(done: assembly.Assembly, run: int) -> list[str]:
    """One sentence for every joint that the initial state of this run does not fulfil."""
    problems = []
    for joint, rows in zip(done.model.joints, rows_of(done.model), strict=True):
        gap = float(done.position_violations[run, rows].max())
        rate = float(done.velocity_violations[run, rows].max())
        limit, speed = float(done.position_limits[run, rows.start]), float(done.velocity_limits[run, rows.start])
        where = f"model.joints.{joint.name}"
        bodies = " and ".join(done.model.bodies[i].name for i in joint.bodies if i >= 0)
        if not gap <= limit:
            what = "its points do not meet" if joint.type == "spherical" else "its points are not at its length"
            problems.append(
                f"{where}: {what} at t = 0: they miss by {gap:.3g} m, at most {limit:.1g} m is allowed; correct the "
                f"points or the position and rotation of {bodies}, or omit those that shall be solved for; where "
                "all are omitted, give a position near the joints"
            )
        elif not rate <= speed:
            problems.append(
                f"{where}: the initial velocities contradict it: its points separate at {rate:.3g} m/s, at most "
                f"{speed:.1g} m/s is allowed; correct velocity and angular_velocity of {bodies}, or omit one so that "
                "it is solved for"
            )
    return problems


def prepare(scenario: Scenario, labels: Sequence[int]) -> Prepared:
    """Sample, build and assemble these runs. A run that does not fit is marked; if none of a sweep fits, that is an
    error of the scenario."""
    import numpy as np

    check_initial(scenario)
    data: Any = scenario.data
    samples = design_table(data.sweep.vary, scenario.nominal(), labels, data.sweep.seed)
    model, poses = build(scenario, samples)
    runs = len(labels)
    done = assembly.assemble(model, poses, runs)
    bad = unphysical(model, poses, runs)
    codes = np.where(bad, INVALID, np.where(done.good, SUCCESS, NOT_ASSEMBLED)).astype(np.int8)
    if runs > 1 and runs == data.sweep.runs and np.all(codes == NOT_ASSEMBLED):
        varied = ", ".join(samples)
        reasons = "\n".join(_violations(done, 0))
        raise ScenarioError(
            f"sweep.vary: no sampled run can be assembled with {varied} varied; give fewer initial values, so that the "
            f"joints can decide them. The first run: {reasons or 'its state is not finite'}"
        )
    states = np.where(np.isfinite(done.state), done.state, 0.0).reshape(runs, -1)
    return Prepared(list(labels), samples, done.model, states, codes)
