"""The same samples by MuJoCo: accelerations at the start, which have no error of integration, and the motion of some
steps. Trees of joints under gravity have an equivalent there."""

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from lienumba.batch.execute import usable_cores
from lienumba.batch.statuses import GOOD, SUCCESS
from lienumba.engine.checks.engines import (
    AGREE,
    Check,
    Difference,
    counted,
    first_failure,
    first_runs,
    read,
    shortened,
)
from lienumba.errors import ScenarioError
from lienumba.groups import so3
from lienumba.groups.state import ELEMENT
from lienumba.mechanics.mechanism.kinematics import Instant
from lienumba.mechanics.mechanism.model import GROUND, Joint, Model
from lienumba.mechanics.mechanism.model_numbers import map_numbers
from lienumba.mechanics.system import dynamics
from lienumba.mechanics.system.kkt import Structure
from lienumba.words import listed

if TYPE_CHECKING:
    from lienumba.engine.simulate import Tell

JOINTS = ("revolute", "prismatic", "cylindrical", "universal", "spherical", "fixed")  # that MuJoCo has
NOWHERE = "MuJoCo has no equivalent; leave it out, or check --with numba"
HINGED = ("revolute", "prismatic", "cylindrical", "universal")
Bodies = tuple[tuple[float, ...], ...]  # 18 numbers of each
ALONG = 1e-4  # relative: in other coordinates the same method has other errors
Z = 2  # the axis of a joint's frame


def check(
    source: object, runs: int, steps: int, tell: "Tell", overrides: Mapping[str, object] | None = None,
    allow_code: bool = False,
) -> Check:  # fmt: skip
    """Compare the first runs of a scenario or a dataset with MuJoCo, for so many steps at most."""
    from lienumba.engine.results import Results
    from lienumba.engine.runner import in_memory
    from lienumba.engine.simulate import Threads
    from lienumba.scenario.start.prepare import check_initial, prepare

    try:
        import mujoco
    except ImportError:
        raise ScenarioError('MuJoCo is not installed; pip install "lienumba[import]"') from None
    whole, samples = read(source, overrides, allow_code)
    scenario = shortened(whole, steps, None)
    results = Results(scenario, check_initial(scenario))
    wanted = first_runs(results, samples, runs)
    labels = wanted.labels.tolist()
    prepared = prepare(scenario, labels, wanted.samples, wanted.nominal, len(labels) + 1)
    starts = [tuple(tuple(x) for x in state.reshape(-1, ELEMENT).tolist()) for state in prepared.states]
    models = [_of_run(prepared.model, n) for n in range(len(labels))]
    h, count, end = scenario.data.integrator.step or 0.0, scenario.steps or 0, scenario.data.integrator.end_time
    able = np.flatnonzero(prepared.codes == SUCCESS).tolist()  # to begin
    theirs = {n: _Theirs(mujoco, models[n], starts[n], h) for n in able}  # refused before anything runs
    ours = in_memory(results, wanted, Threads(results, usable_cores()), tell).isel(time=-1)
    good = np.isin(ours["status"].values, GOOD)
    worst: dict[str, Difference] = {}
    for n in np.flatnonzero(good).tolist():
        linear, angular = theirs[n].accelerations()
        own = np.array(dynamics.accelerations(models[n], Structure.of(models[n]), Instant(starts[n])).x, float)
        own = own.reshape(-1, 6)
        position, rotation = theirs[n].after(count)
        found = (
            ("acceleration", "m s-2", linear, own[:, :3], 0.0),
            ("angular_acceleration", "rad s-2", angular, own[:, 3:], 0.0),
            ("position", "m", position, ours["position"].values[n], end),
            ("rotation", "1", rotation, ours["rotation"].values[n], end),
        )
        for name, units, a, b, time in found:
            size = float(np.nan_to_num(np.abs(a - b), nan=np.inf).max())
            if name not in worst or size > worst[name].size:
                worst[name] = Difference(name, units, size, float(np.abs(b).max()), labels[n], time)
    differences = list(worst.values())
    headline = f"{counted(good * count, count)}, by MuJoCo of RK4"
    if failure := first_failure(ours):
        failed = f"{failure}, and only what succeeds is compared with MuJoCo; give a smaller integrator.step"
        return Check(headline, differences, False, failed)
    decisive = max(differences, key=lambda x: x.relative / (AGREE if x.time == 0.0 else ALONG))
    limit = AGREE if decisive.time == 0.0 else ALONG
    agrees = decisive.relative <= limit
    verdict = f"the engine {'agrees' if agrees else 'does not agree'} with MuJoCo {mujoco.__version__}"
    sentence = f"{verdict}: {decisive.name} differs by {decisive.relative:.1e} of its size, {limit:g} is allowed"
    return Check(headline, differences, agrees, sentence)


class _Theirs:
    """A run in MuJoCo, at its start."""

    def __init__(self, mujoco: Any, model: Model, bodies: Bodies, h: float) -> None:
        try:
            self.model = mujoco.MjModel.from_xml_string(mjcf(model, bodies, h))
        except ValueError as error:
            raise ScenarioError(f"MuJoCo does not take the mechanism: {error}") from None
        self.mujoco, self.data, k, states = mujoco, mujoco.MjData(self.model), len(bodies), np.array(bodies)
        self.gravity, self.R = np.array(model.gravity, float), states[:, 3:12].reshape(k, 3, 3)
        mujoco.mj_forward(self.model, self.data)
        J = np.zeros((k, 6, self.model.nv))
        v, w = states[:, 12:15], np.einsum("ijk,ik->ij", self.R, states[:, 15:18])
        velocities = np.concatenate([v, w], axis=1).reshape(-1)
        kind = mujoco.mjtObj.mjOBJ_BODY  # of which MuJoCo has the order of its tree
        self.order = [mujoco.mj_name2id(self.model, kind, f"body {i}") for i in range(k)]
        for n, i in enumerate(self.order):
            mujoco.mj_jacBodyCom(self.model, self.data, J[n, :3], J[n, 3:], i)
        self.data.qvel[:] = np.linalg.lstsq(J.reshape(6 * k, -1), velocities, rcond=None)[0]

    def accelerations(self) -> tuple[np.ndarray, np.ndarray]:
        """v' (global) and w' (body frame) of every body (k, 3) at the start."""
        self.mujoco.mj_forward(self.model, self.data)
        self.mujoco.mj_rnePostConstraint(self.model, self.data)
        found, kind = np.zeros((len(self.order), 6)), self.mujoco.mjtObj.mjOBJ_BODY
        for n, i in enumerate(self.order):
            self.mujoco.mj_objectAcceleration(self.model, self.data, kind, i, found[n], 0)
        return found[:, 3:] + self.gravity, np.einsum("ikj,ik->ij", self.R, found[:, :3])

    def after(self, steps: int) -> tuple[np.ndarray, np.ndarray]:
        """r (k, 3) and R (k, 3, 3) of every body after so many steps."""
        for _ in range(steps):
            self.mujoco.mj_step(self.model, self.data)
        self.mujoco.mj_forward(self.model, self.data)
        return self.data.xpos[self.order], self.data.xmat[self.order].reshape(-1, 3, 3)


def mjcf(model: Model, bodies: Bodies, h: float) -> str:
    """The mechanism in MuJoCo's format, its joints at zero where the bodies are at the start (18 numbers of each); a
    ScenarioError if there is no equivalent."""
    acting = [x for x in model.events if x.acts or x.stop], [x for x in model.locks if x.on]
    kinds = (model.forces, model.drivers, model.contacts, model.limits, *acting)
    names = [x.name for elements in kinds for x in elements] + ["gravity"] * any(map(callable, model.gravity))
    if names:
        raise ScenarioError(f"model: {listed(names)}: {NOWHERE}")
    children: dict[int, list[tuple[int, Joint | None]]] = {}
    placed, left = {GROUND}, list(model.joints)
    while True:
        tie = next((x for x in left if len({*x.bodies} & placed) == 1), None)
        if tie is None:
            free = next((i for i in range(len(bodies)) if i not in placed), None)
            if free is None:
                break
            children.setdefault(GROUND, []).append((free, None))
            placed.add(free)
            continue
        left.remove(tie)
        parent, child = tie.bodies if tie.bodies[0] in placed else tie.bodies[::-1]
        children.setdefault(parent, []).append((child, tie))
        placed.add(child)
    odd = [x.name for x in model.joints if x.type not in JOINTS or x in left or not x.active]
    if odd:
        raise ScenarioError(f"model.joints: {listed(odd)}: {NOWHERE}")
    content = "".join(_body(model, bodies, GROUND, child, tie, children) for child, tie in children.get(GROUND, []))
    flags = '<flag constraint="disable" contact="disable"/>'
    option = f'<option integrator="RK4" timestep="{h!r}" gravity="{_text(model.gravity)}">{flags}</option>'
    return f"<mujoco>{option}<worldbody>{content}</worldbody></mujoco>"


def _of_run(model: Model, n: int) -> Model:
    """The model with the numbers of one run."""
    return map_numbers(model, lambda x, _: float(x[n]) if np.ndim(x) else x)


def _body(
    model: Model, bodies: Bodies, parent: int, child: int, tie: Joint | None,
    children: dict[int, list[tuple[int, Joint | None]]],
) -> str:  # fmt: skip
    body, x = model.bodies[child], bodies[child]
    origin = (0.0, 0.0, 0.0, *so3.IDENTITY) if parent == GROUND else bodies[parent]
    place = so3.rotate_back(origin[3:12], so3.subtract(x[0:3], origin[0:3]))
    E = so3.multiply(so3.transpose(origin[3:12]), x[3:12])
    below = "".join(_body(model, bodies, child, n, joint, children) for n, joint in children.get(child, []))
    joints = "".join(_joints(tie, parent, child, E))
    principal = not any(body.inertia[3:])  # MuJoCo checks what its own diagonalisation has rounded
    inertia = f'diaginertia="{_text(body.inertia[:3])}"' if principal else f'fullinertia="{_text(body.inertia)}"'
    inertial = f'<inertial pos="0 0 0" mass="{float(body.mass)!r}" {inertia}/>'
    pose = f'pos="{_text(place)}" quat="{_text(so3.to_quaternion(E))}"'
    return f'<body name="body {child}" {pose}>{joints}{inertial}{below}</body>'


def _joints(tie: Joint | None, parent: int, child: int, E: so3.Matrix3) -> Iterator[str]:
    """Those between a body and its parent, in its own frame; E: of the body against its parent."""
    if tie is None:
        yield "<freejoint/>"
        return
    side = tie.bodies.index(child)
    at = f'pos="{_text((tie.points or ((0.0, 0.0, 0.0),) * 2)[side])}"'
    if tie.type == "spherical":
        yield f'<joint type="ball" {at}/>'
    if tie.frames is None or tie.type not in HINGED:
        return
    own, other = tie.frames[side][Z], so3.rotate_back(E, tie.frames[1 - side][Z])
    kinds = {"prismatic": ("slide",), "cylindrical": ("slide", "hinge")}
    if tie.type == "universal":
        yield f'<joint type="hinge" {at} axis="{_text(other)}"/>'
    for kind in kinds.get(tie.type, ("hinge",)):
        yield f'<joint type="{kind}" {at} axis="{_text(own)}" armature="{float(tie.armature)!r}"/>'


def _text(numbers: Any) -> str:
    return " ".join(repr(float(x)) for x in numbers)
