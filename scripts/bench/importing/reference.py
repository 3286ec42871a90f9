"""What MuJoCo says of a model, as independently of the importer as can be: accelerations where its constraints are
rigid, motions, and where bodies are.

Contacts, limits and dry friction are off. MuJoCo softens equalities; here their rigid limit is solved for from MuJoCo's
own M, forces and Jacobian J of the equalities: M q'' = f + J^T lambda, J q'' = -J' q', by least squares where rows of J
are redundant. All about links: a moving body and all that is welded to it, known by its mass centre.
"""

import copy
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np

Array = np.ndarray
NEGLIGIBLE = 1e-9  # singular values of J below this fraction of the largest count as zero
CLOSED = 1e-13  # m, or of a quaternion: equalities hold within this
SLIDE_SPREAD, RATE = 0.3, 2.0  # m; rad/s and m/s
REFINED = 3  # times
STENCIL = {1: 4 / 5, 2: -1 / 5, 3: 4 / 105, 4: -1 / 280}  # weights of central differences of order 8
OFF = ("CONTACT", "LIMIT", "FRICTIONLOSS", "SENSOR", "AUTORESET")


def flag(*names: str) -> int:
    """Of options that are switched off."""
    return sum(int(getattr(mujoco.mjtDisableBit, f"mjDSBL_{name}")) for name in names)


def comparable(model: Any) -> Any:
    """A copy without contacts, limits and dry friction, whose Jacobians are dense."""
    own = copy.copy(model)
    own.opt.disableflags |= flag(*OFF)
    own.opt.jacobian = mujoco.mjtJacobian.mjJAC_DENSE
    own.opt.enableflags = 0
    return own


@dataclass(frozen=True)
class States:
    """Of a model: q (n, nq), v (n, nv), controls (n, nu)."""

    q: Array
    v: Array
    ctrl: Array

    def __len__(self) -> int:
        return len(self.q)


class Reference:
    """A model and what it says. links: the bodies (ids) of each that moves, its own joints first."""

    def __init__(self, model: Any) -> None:
        self.model, self.data = comparable(model), mujoco.MjData(model)
        weld = model.body_weldid
        roots = [b for b in range(1, model.nbody) if weld[b] == b and model.body_dofnum[b]]
        self.links = {b: np.flatnonzero(weld == b) for b in roots if model.body_mass[weld == b].sum() > 0.0}
        self.masses = np.array([model.body_mass[own].sum() for own in self.links.values()])
        self.looped = bool(model.eq_active0.any())
        self.act = np.zeros(model.na)  # the states of actuators

    # ------------------------------------------------------------ states
    def put(self, q: Array, v: Array, ctrl: Array | None = None) -> Any:
        """Everything that follows from a state, without constraints' forces."""
        d = self.data
        d.qpos[:], d.qvel[:] = q, v
        d.ctrl[:], d.act[:] = (0.0 if ctrl is None else ctrl), self.act
        d.eq_active[:] = self.model.eq_active0
        mujoco.mj_forward(self.model, d)
        return d

    def random_states(self, count: int, seed: int = 18) -> States:
        """Anywhere within the ranges of joints, if they have any; in loops near the reference, and closed."""
        random, found = np.random.default_rng(seed), []
        spread = 1.0
        for _ in range(20 * count):
            state = self.closed(self._any_place(random, spread), RATE * random.standard_normal(self.model.nv))
            if state is not None:
                found.append((*state, self.any_controls(random)))
            elif self.looped:
                spread = max(0.8 * spread, 1e-3)
            if len(found) == count:
                return States(*(np.array(x) for x in zip(*found, strict=True)))
        raise ValueError("its loops do not close")

    def _any_place(self, random: np.random.Generator, spread: float) -> Array:
        m, q = self.model, self.model.qpos0.copy()
        if self.looped:
            mujoco.mj_integratePos(m, q, 0.3 * spread * random.standard_normal(m.nv), 1.0)
            return q
        for j in range(m.njnt):
            at, kind = m.jnt_qposadr[j], m.jnt_type[j]
            if kind == mujoco.mjtJoint.mjJNT_FREE:
                q[at : at + 7] = random.standard_normal(7)
            elif kind == mujoco.mjtJoint.mjJNT_BALL:
                q[at : at + 4] = random.standard_normal(4)
            elif m.jnt_limited[j] and m.jnt_range[j, 0] < m.jnt_range[j, 1]:
                q[at] = random.uniform(*np.clip(m.jnt_range[j], q[at] - np.pi, q[at] + np.pi))
            else:
                slides = kind == mujoco.mjtJoint.mjJNT_SLIDE
                q[at] += SLIDE_SPREAD * random.standard_normal() if slides else random.uniform(-2.0, 2.0)
        mujoco.mj_normalizeQuat(m, q)
        return q

    def any_controls(self, random: np.random.Generator) -> Array:
        """Also beyond their ranges."""
        m = self.model
        ranges = np.where(m.actuator_ctrllimited[:, None] > 0, m.actuator_ctrlrange, [-1.0, 1.0])
        middle, half = ranges.mean(axis=1), 0.5 * np.ptp(ranges, axis=1)
        found: Array = middle + 1.2 * half * random.uniform(-1.0, 1.0, m.nu)
        return found

    def closed(self, q: Array, v: Array) -> tuple[Array, Array] | None:
        """The state nearby in which equalities hold; None where Newton's method finds none."""
        done = not self.looped
        for _ in range(40):
            d = self.put(q, v)
            if done or not d.nefc:
                break
            done = bool(np.abs(d.efc_pos).max() < CLOSED)  # and once more, for the rounding
            mujoco.mj_integratePos(self.model, q, -_least(self.jacobian(d), d.efc_pos), 1.0)
        d = self.put(q, v)
        if not d.nefc:
            return q, v
        if not np.abs(d.efc_pos).max() < CLOSED:
            return None
        J = self.jacobian(d)
        return q, v - _least(J, J @ v)

    # ------------------------------------------------------------ accelerations
    def jacobian(self, d: Any) -> Array:
        """Of the equalities that are active, (rows, nv)."""
        if d.nefc and (d.efc_type[: d.nefc] != mujoco.mjtConstraint.mjCNSTR_EQUALITY).any():
            raise ValueError("another constraint than an equality is active")
        J: Array = d.efc_J[: d.nefc * self.model.nv].reshape(d.nefc, self.model.nv).copy()
        return J

    def accelerations(self, states: States) -> Array:
        """q'' (n, nv), equalities rigid."""
        return np.array([self.acceleration(*x) for x in zip(states.q, states.v, states.ctrl, strict=True)])

    def refined(self, states: States, a: Array) -> Array:
        """The same, where nothing closes loops and tendons have no rotors: what MuJoCo's inverse dynamics misses of the
        forces is taken back."""
        m, found, balance = self.model, a.copy(), np.zeros(self.model.nv)
        rotors = m.dof_armature + self._of_actuators()
        for x, q, v, ctrl in zip(found, states.q, states.v, states.ctrl, strict=True):
            d, M = self.put(q, v, ctrl), np.zeros((m.nv, m.nv))
            mujoco.mj_fullM(m, d, M)
            for _ in range(REFINED):
                d.qacc[:] = x
                mujoco.mj_rne(m, d, 1, balance)
                x += np.linalg.solve(M, d.qfrc_passive + d.qfrc_actuator - balance - rotors * x)
        return found

    def _of_actuators(self) -> Array:
        """The rotors of actuators at joints, as these feel them."""
        m, found = self.model, np.zeros(self.model.nv)
        for a in np.flatnonzero(m.actuator_armature):
            found[m.jnt_dofadr[m.actuator_trnid[a, 0]]] += m.actuator_gear[a, 0] ** 2 * m.actuator_armature[a]
        return found

    def acceleration(self, q: Array, v: Array, ctrl: Array) -> Array:
        d = self.put(q, v, ctrl)
        free: Array = d.qacc_smooth.copy()
        if not d.nefc:
            return free
        J, M = self.jacobian(d), np.zeros((self.model.nv, self.model.nv))
        mujoco.mj_fullM(self.model, d, M)
        L = np.linalg.cholesky(M)
        wanted = -self._bias(q, v) - J @ free
        return free + np.linalg.solve(L.T, _least(np.linalg.solve(L, J.T).T, wanted))

    def _bias(self, q: Array, v: Array) -> Array:
        """J' q'."""
        step = 0.02 / max(1.0, float(np.abs(v).max()))
        total: Any = 0.0
        for n, weight in STENCIL.items():
            for sign in (1, -1):
                there = q.copy()
                mujoco.mj_integratePos(self.model, there, v, sign * n * step)
                total = total + sign * weight * (self.jacobian(self.put(there, v)) @ v)
        return total / step

    # ------------------------------------------------------------ links
    def centres(self, states: States) -> tuple[Array, Array]:
        """Mass centres (n, links, 3) and rotations (n, links, 3, 3) of the links."""
        places, turns = [], []
        for q, v in zip(states.q, states.v, strict=True):
            d = self.data
            d.qpos[:], d.qvel[:] = q, v
            mujoco.mj_kinematics(self.model, d)
            places.append([self._mean(own, d.xipos) for own in self.links.values()])
            turns.append([d.xmat[b].reshape(3, 3).copy() for b in self.links])
        return np.array(places), np.array(turns)

    def link_accelerations(self, states: States, a: Array) -> tuple[Array, Array]:
        """Of the mass centres, and angular (n, links, 3), global axes, where q'' = a."""
        linear, angular, six = [], [], np.zeros(6)
        g = self.model.opt.gravity * (self.model.opt.disableflags & flag("GRAVITY") == 0)
        for q, v, x in zip(states.q, states.v, a, strict=True):
            d = self.put(q, v)
            d.qacc[:] = x
            mujoco.mj_rnePostConstraint(self.model, d)
            every = np.zeros((self.model.nbody, 6))
            for b in range(1, self.model.nbody):
                mujoco.mj_objectAcceleration(self.model, d, mujoco.mjtObj.mjOBJ_BODY, b, six, 0)
                every[b] = six
            linear.append([self._mean(own, every[:, 3:]) + g for own in self.links.values()])
            angular.append([every[b, :3] for b in self.links])
        return np.array(linear), np.array(angular)

    def _mean(self, own: Array, of_bodies: Array) -> Array:
        weights = self.model.body_mass[own]
        mean: Array = weights @ of_bodies[own] / weights.sum()
        return mean

    # ------------------------------------------------------------ motions
    def motion(self, state: States, step: float, times: Array) -> States:
        """From one state, at these times: MuJoCo's RK4, or, where there are loops, RK4 along the rigid limit."""
        m, d = copy.copy(self.model), self.data
        m.opt.timestep, m.opt.integrator = step, mujoco.mjtIntegrator.mjINT_RK4
        q, v, ctrl = state.q[0].copy(), state.v[0].copy(), state.ctrl[0]
        mujoco.mj_resetData(m, d)
        found, done, self.act = [], 0, np.zeros(m.na)
        for t in times:
            for _ in range(round(t / step) - done):
                q, v = self._rigid_step(q, v, ctrl, step) if self.looped else _free_step(m, d, q, v, ctrl)
                done += 1
            found.append((q, v, ctrl))
        return States(*(np.array(x) for x in zip(*found, strict=True)))

    def _rigid_step(self, q: Array, v: Array, ctrl: Array, h: float) -> tuple[Array, Array]:
        """The same tableau in MuJoCo's coordinates, and back onto the equalities."""

        def along(k: Array, part: float) -> Array:
            there = q.copy()
            mujoco.mj_integratePos(self.model, there, k, part)
            return there

        def slopes(place: Array, rates: Array, act: Array) -> tuple[Array, Array]:
            self.act = act
            found = self.acceleration(place, rates, ctrl)
            return found, self.put(place, rates, ctrl).act_dot.copy()

        act = self.act
        a1, b1 = slopes(q, v, act)
        v2 = v + 0.5 * h * a1
        a2, b2 = slopes(along(v, 0.5 * h), v2, act + 0.5 * h * b1)
        v3 = v + 0.5 * h * a2
        a3, b3 = slopes(along(v2, 0.5 * h), v3, act + 0.5 * h * b2)
        v4 = v + h * a3
        a4, b4 = slopes(along(v3, h), v4, act + h * b3)
        self.act = act + h * (b1 + 2 * b2 + 2 * b3 + b4) / 6
        done = self.closed(along((v + 2 * v2 + 2 * v3 + v4) / 6, h), v + h * (a1 + 2 * a2 + 2 * a3 + a4) / 6)
        if done is None:
            raise ValueError("its loops open on the way")
        return done


def _free_step(m: Any, d: Any, q: Array, v: Array, ctrl: Array) -> tuple[Array, Array]:
    d.qpos[:], d.qvel[:], d.ctrl[:] = q, v, ctrl
    mujoco.mj_step(m, d)
    return d.qpos.copy(), d.qvel.copy()


def _least(A: Array, b: Array) -> Array:
    """The x of least norm with A x = b; rows of A count alike."""
    size = np.linalg.norm(A, axis=1)
    size = np.where(size > 1e-14, size, 1.0)
    found: Array = np.linalg.lstsq(A / size[:, None], b / size, rcond=NEGLIGIBLE)[0]
    return found
