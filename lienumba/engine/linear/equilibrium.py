"""`lienumba.equilibrium`: the equilibrium of every run of a scenario, and its stability."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from lienumba.batch.statuses import SUCCESS
from lienumba.engine.linear.linearise import turning
from lienumba.engine.linear.states import Asked
from lienumba.groups.state import ELEMENT
from lienumba.integrators import codes
from lienumba.integrators.tracing.linear.outputs import visible
from lienumba.integrators.tracing.linear.systems import STILL
from lienumba.mechanics.elements import quantities
from lienumba.mechanics.mechanism.kinematics import still
from lienumba.scenario.start.resting import resting
from lienumba.store.linear_layout import EQUILIBRIA

if TYPE_CHECKING:
    import os

    import xarray as xr

TURNING = {"units": "rad s-1", "frame": "global", "long_name": "angular velocity of the axes against which all rests"}


def equilibrium(
    scenario: "Any | xr.Dataset | str | os.PathLike[str]",
    *,
    rotation: Sequence[float] | None = None,
    runs: Sequence[int] | None = None,
    overrides: Mapping[str, Any] | None = None,
    allow_code: bool = False,
) -> "xr.Dataset":
    """Find the equilibrium that every run comes to from its start, when motion is damped: at rest, or turning.

    Velocities are 0, time is 0 (drivers and formulas of time stand), and states of laws have come to rest, too; sampled
    laws are where samples change nothing. The search leads downhill, away from unstable equilibria, but stays where
    forces vanish from the first moment on. Rigid stops and contacts hold what they can: what touches, or is met on the
    way, sticks as far as static friction goes. Growth is that of the motion there, with the velocities that drivers ask
    for, and as if sampled laws were sampled all the time.

    With a rotation the mechanism turns uniformly: positions are those in which it rests against axes that turn with it,
    and velocities are of this turning, with what drivers ask for beside it.

    Parameters
    ----------
    scenario, runs, overrides, allow_code
        As for `lienumba.linearise`.
    rotation : three floats
        The angular velocity in rad/s, global frame, about an axis through the origin. Bodies that nothing holds, balls
        on the ground and hinges along this axis, wherever they stand, turn, and all that hangs on them. By default that
        of the start of the scenario, if it has one.

    Returns
    -------
    xarray.Dataset
        On run: `status` (0 found, 1 none found: there is none, it is too far, or it would not last while it turns; 2
        unstable: a mode grows), `position` (m, global) and `rotation` (to global) of
        all bodies, `turning` (rad/s, global: of the axes against which they rest), all quantities of positions and
        velocities, `force` (the largest force left along a coordinate, N m for angles and N times the size of the
        mechanism for shifts), `growth` (1/s: the largest real part of the eigenvalues that `lienumba.modes` shows).

    Raises
    ------
    ScenarioError
        For bad input, with a sentence for each problem.
    """
    asked = Asked.of(scenario, 0.0, runs, overrides, allow_code)
    prepared = asked.prepared()
    axes = (prepared.rotation or STILL) if rotation is None else turning(rotation)
    rested = resting(prepared.model, np.asarray(prepared.states), prepared.angles, axes, driven=False)
    status = np.where(prepared.codes == SUCCESS, rested.status, codes.NONE_FOUND)
    good = status != codes.NONE_FOUND

    def of_found(x: Any) -> np.ndarray:
        return np.where(good.reshape(-1, *[1] * (np.ndim(x) - 1)), x, np.nan)

    bodies = of_found(rested.states).reshape(len(good), -1, ELEMENT)
    view, units = still(rested.now, tuple(range(bodies.shape[1]))), quantities.units(prepared.nominal.model)
    variables: dict[str, Any] = {
        "status": (
            "run",
            status.astype(np.int8),
            {
                "long_name": "what kind of equilibrium it is",
                "flag_meanings": " ".join(codes.EQUILIBRIA),
                "flag_values": np.arange(len(codes.EQUILIBRIA), dtype=np.int8),
            },
        ),
        "position": (("run", "body", "axis"), bodies[:, :, :3], {"units": "m", "frame": "global"}),
        "rotation": (
            ("run", "body", "axis", "body_axis"),
            bodies[:, :, 3:12].reshape(*bodies.shape[:2], 3, 3),
            {"units": "1", "frame": "body to global"},
        ),
        "turning": (("run", "axis"), np.stack([np.broadcast_to(x, good.shape) for x in axes], axis=1), TURNING),
        "force": ("run", rested.force, {"long_name": "the largest force left along a coordinate"}),
        "growth": ("run", of_found(rested.growth), {"units": "s-1", "long_name": "largest real part of an eigenvalue"}),
    }
    with np.errstate(all="ignore"):
        for name in visible(prepared.nominal.model, None):
            x = np.broadcast_to(quantities.component(rested.flowing, name, view), good.shape)
            variables[name] = ("run", of_found(x), {"units": units.get(name, "1")})
    names = [body.name for body in prepared.nominal.model.bodies]
    return asked.dataset(EQUILIBRIA, variables, {"body": names, "axis": list("xyz"), "body_axis": list("xyz")})
