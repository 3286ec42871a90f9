"""A tree of links in MuJoCo and in Pinocchio: accelerations, and the core time of their steps and evaluations."""

from typing import Any

import numpy as np

from bench.clock import Spent, Stopwatch
from bench.trees import SIZES, Tree, quaternions, rotations
from lienumba.mechanics.mechanism.model import GROUND


def _text(numbers: Any) -> str:
    return " ".join(map(repr, np.ravel(numbers).tolist()))


def mjcf(tree: Tree, h: float) -> str:
    """The tree for MuJoCo: each body's frame is that of ours, so that coordinates and rates mean the same."""
    inside: dict[int, list[int]] = {}
    for i, link in enumerate(tree.links):
        inside.setdefault(link.parent, []).append(i)

    def body(i: int) -> str:
        link = tree.links[i]
        at = link.points[0] - link.place @ link.points[1]
        J = link.inertia
        full = [J[0, 0], J[1, 1], J[2, 2], J[0, 1], J[0, 2], J[1, 2]]
        joint = f'<joint name="{i}" type="{link.kind}" pos="{_text(link.points[1])}" armature="{link.armature!r}"'
        joint += f' axis="{_text(link.axis)}"/>' if link.kind in ("hinge", "slide") else "/>"
        joint = f'<freejoint name="{i}"/>' if link.kind == "free" else joint
        return (
            f'<body pos="{_text(at)}" quat="{_text(quaternions(link.place[None]))}">{joint}'
            f'<inertial pos="0 0 0" mass="{link.mass!r}" fullinertia="{_text(full)}"/>'
            f"{''.join(map(body, inside.get(i, [])))}</body>"
        )

    return f"""
        <mujoco>
          <option integrator="RK4" timestep="{h!r}" gravity="{_text(tree.gravity)}">
            <flag constraint="disable" contact="disable"/>
          </option>
          <worldbody>{"".join(map(body, inside[GROUND]))}</worldbody>
        </mujoco>"""


class Mujoco:
    """q, v, a: as `Tree` has them; MuJoCo's own order of joints is theirs if the tree goes branch by branch."""

    def __init__(self, tree: Tree, h: float, threads: int = 2) -> None:
        import mujoco

        self.tree, self.version = tree, str(mujoco.__version__)
        self.model = mujoco.MjModel.from_xml_string(mjcf(tree, h))
        self.data = [mujoco.MjData(self.model) for _ in range(threads)]
        joints = [self.model.joint(str(i)) for i in range(len(tree.links))]
        sizes = [SIZES[link.kind] for link in tree.links]
        pairs = list(zip(joints, sizes, strict=True))
        self.q_at = np.concatenate([joint.qposadr[0] + np.arange(size[0]) for joint, size in pairs])
        self.v_at = np.concatenate([joint.dofadr[0] + np.arange(size[1]) for joint, size in pairs])

    def accelerations(self, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        import mujoco

        found, data = np.empty_like(v), self.data[0]
        for n in range(len(q)):
            data.qpos[self.q_at], data.qvel[self.v_at] = q[n], v[n]
            mujoco.mj_forward(self.model, data)
            found[n] = data.qacc[self.v_at]
        return found

    def run(self, q: np.ndarray, v: np.ndarray, steps: int) -> tuple[np.ndarray, np.ndarray, Spent]:
        """q and v at the end, and what that took."""
        import mujoco
        from mujoco import rollout

        size = mujoco.mj_stateSize(self.model, mujoco.mjtState.mjSTATE_FULLPHYSICS)
        initial = np.zeros((len(q), size))
        initial[:, 1 + self.q_at], initial[:, 1 + self.tree.nq + self.v_at] = q, v
        states = np.full((len(q), steps, size), 0.0)  # memory that is already there, as in a second call
        watch = Stopwatch()
        rollout.rollout(self.model, self.data, initial, nstep=steps, state=states)
        spent = watch.spent()
        return states[:, -1, 1 + self.q_at], states[:, -1, 1 + self.tree.nq + self.v_at], spent

    def run_batch(self, q: np.ndarray, v: np.ndarray, steps: int) -> tuple[np.ndarray, np.ndarray, Spent]:
        """The same by `mujoco.batch`, which stores nothing on the way; each simulation reads masses of its own."""
        from mujoco.batch import Batch

        batch = Batch(self.model, len(q), len(self.data))
        batch.expand("body_mass")
        at, rates = batch.bind("qpos"), batch.bind("qvel")
        at[:, self.q_at], rates[:, self.v_at] = q, v
        watch = Stopwatch()
        batch.step(nstep=steps)
        spent = watch.spent()
        return at[:, self.q_at], rates[:, self.v_at], spent


class Pinocchio:
    """Its aba alone: it integrates nothing by itself."""

    def __init__(self, tree: Tree) -> None:
        import pinocchio as pin

        self.tree, self.version = tree, str(pin.__version__)
        self.model = pin.Model()
        self.model.gravity.linear = tree.gravity
        ids: list[int] = []
        for link in tree.links:
            up = np.zeros(3) if link.parent == GROUND else tree.links[link.parent].points[1]
            joint = {
                "free": pin.JointModelFreeFlyer, "ball": pin.JointModelSpherical,
                "hinge": lambda: pin.JointModelRevoluteUnaligned(link.axis),  # noqa: B023
                "slide": lambda: pin.JointModelPrismaticUnaligned(link.axis),  # noqa: B023
            }[link.kind]()  # fmt: skip
            above = 0 if link.parent == GROUND else ids[link.parent]
            ids.append(self.model.addJoint(above, joint, pin.SE3(link.place, link.points[0] - up), link.name))
            inertia = pin.Inertia(link.mass, -link.points[1], link.inertia)
            self.model.appendBodyToJoint(ids[-1], inertia, pin.SE3.Identity())
        self.model.armature = np.concatenate([np.full(SIZES[x.kind][1], x.armature) for x in tree.links])
        self.data = self.model.createData()

    def _own(self, q: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Its quaternions end with w, its velocities of a free body are in the body's axes."""
        q, v = q.copy(), v.copy()
        for link in self.tree.links:
            if link.kind in ("ball", "free"):
                first = link.q + (3 if link.kind == "free" else 0)
                if link.kind == "free":
                    R = rotations(q[:, first : first + 4])
                    v[:, link.v : link.v + 3] = np.einsum("nji,nj->ni", R, v[:, link.v : link.v + 3])
                q[:, first : first + 4] = np.roll(q[:, first : first + 4], -1, axis=1)
        return q, v

    def accelerations(self, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        import pinocchio as pin

        own_q, own_v = self._own(q, v)
        none, pairs = np.zeros(self.tree.nv), zip(own_q, own_v, strict=True)
        found = np.array([pin.aba(self.model, self.data, x, y, none) for x, y in pairs])
        for link in self.tree.links:
            if link.kind == "free":  # the rate of the velocity's components in turning axes
                R, at = rotations(q[:, link.q + 3 : link.q + 7]), slice(link.v, link.v + 3)
                turning = np.cross(own_v[:, link.v + 3 : link.v + 6], own_v[:, at])
                found[:, at] = np.einsum("nij,nj->ni", R, found[:, at] + turning)
        return found

    def spend(self, q: np.ndarray, v: np.ndarray, rounds: int) -> Spent:
        """On aba at every one of these, so many rounds."""
        import pinocchio as pin

        states, none = list(zip(*self._own(q, v), strict=True)), np.zeros(self.tree.nv)
        watch = Stopwatch()
        for _ in range(rounds):
            for x, y in states:
                pin.aba(self.model, self.data, x, y, none)
        return watch.spent()
