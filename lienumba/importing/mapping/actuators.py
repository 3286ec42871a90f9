"""Actuators as forces of named inputs.

In MuJoCo an actuator has a force  f = (g0 + g1 length + g2 speed) u + b0 + b1 length + b2 speed,  kept within its
forcerange, where u is what controls it, kept within its ctrlrange, or a state that follows that; length and speed are
those of its transmission, times its gear, and f acts along it, times its gear.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np

from lienumba.importing.mapping.draft import GROUND, Draft
from lienumba.importing.mapping.frames import neat, rotation, tidy
from lienumba.importing.mapping.readings import Readings, product, total
from lienumba.importing.mapping.source import BALL, FREE, IN_PARENT, JOINT, Source
from lienumba.importing.mapping.tendons import fixed
from lienumba.importing.mapping.tree import Tree

TENDON, SITE = 3, 4  # mjtTrn
NO_STATE, INTEGRATOR, FILTER, FILTER_EXACT = range(4)  # mjtDyn
FIXED, AFFINE = range(2)  # mjtGain
NO_BIAS, LINEAR = range(2)  # mjtBias
OTHERWISE = "actuators that are muscles, motors with electronics, of slider-cranks, bodies or plugins are left out"


def add_actuators(source: Source, draft: Draft, tree: Tree, readings: Readings) -> None:
    """Add an input and a force for each actuator."""
    m = source.model
    for a in range(len(m.actuator_trntype)):
        place = source.place("actuator", a)
        if m.opt.disableactuator >> int(m.actuator_group[a]) & 1:
            draft.note("actuators that are switched off are left out", place, lost=False)
            continue
        kinds = int(m.actuator_trntype[a]), int(m.actuator_dyntype[a])
        if (
            kinds[0] not in (JOINT, IN_PARENT, TENDON, SITE) or kinds[1] > FILTER_EXACT
            or m.actuator_gaintype[a] not in (FIXED, AFFINE) or m.actuator_biastype[a] not in (NO_BIAS, LINEAR)
            or _of_newer(m, "plugin", a, -1) >= 0
        ):  # fmt: skip
            draft.note(OTHERWISE, place)
            continue
        for what in ("dampingpoly", "delay"):
            if np.any(_of_newer(m, what, a)):
                draft.note(f"the {what} of actuators is left out", place)
        for what in ("armature", "damping"):
            if kinds[0] not in (JOINT, IN_PARENT) and np.any(_of_newer(m, what, a)):
                draft.note(f"the {what} of actuators of tendons and sites is left out", place)
        _Actuator(source, draft, tree, readings, a).add()


def _of_newer(model: Any, what: str, actuator: int, default: float = 0.0) -> Any:
    """What older versions of MuJoCo do not know of actuators."""
    known = getattr(model, f"actuator_{what}", None)
    return default if known is None else known[actuator]


class _Actuator:
    def __init__(self, source: Source, draft: Draft, tree: Tree, readings: Readings, index: int) -> None:
        self.source, self.draft, self.tree, self.readings, self.index = source, draft, tree, readings, index
        m = self.model = source.model
        self.name, self.place = source.name("actuator", index), source.place("actuator", index)
        self.gear = np.array(m.actuator_gear[index])
        self.gain, self.bias = np.array(m.actuator_gainprm[index][:3]), np.array(m.actuator_biasprm[index][:3])
        if m.actuator_gaintype[index] == FIXED:
            self.gain[1:] = 0.0
        if m.actuator_biastype[index] == NO_BIAS:
            self.bias[:] = 0.0

    def add(self) -> None:
        m, target = self.model, int(self.model.actuator_trnid[self.index, 0])
        trn = int(m.actuator_trntype[self.index])
        if trn == SITE:
            if int(m.actuator_trnid[self.index, 1]) >= 0:
                self.draft.note("actuators of a site against another are left out", self.place)
            else:
                R = rotation(m.site_quat[target])
                self._wrench(int(m.site_bodyid[target]), m.site_pos[target], R @ self.gear[:3], R @ self.gear[3:])
            return
        if trn != TENDON and m.jnt_type[target] in (BALL, FREE):
            self.draft.note("actuators of ball and free joints are left out", self.place)
            return
        along = fixed(self.source, target) if trn == TENDON else {target: 1.0}
        if along is None:
            self.draft.note("actuators of tendons that wrap are left out", self.place)
            return
        arms = {joint: float(self.gear[0]) * c for joint, c in along.items()}
        if len(arms) == 1:
            ((joint, arm),) = arms.items()
            self._on_joint(joint, arm)
        else:
            force = self._force(arms, self._control())
            for joint, arm in arms.items():
                name = self.tree.joints[joint]
                self.draft.force(f"{self.name}_{name}", "actuator", joint=name, value=product(arm, force))

    def _control(self) -> str:
        """The formula of u."""
        m, a = self.model, self.index
        name = self.draft.input_names.new(self.name)
        self.draft.inputs[name] = neat(float(self.source.ctrl[a]))
        u = f"inputs.{name}"
        if m.actuator_ctrllimited[a]:
            u = clipped(u, m.actuator_ctrlrange[a])
        kind = int(m.actuator_dyntype[a])
        if kind == NO_STATE:
            return u
        if m.actuator_actearly[a]:
            self.draft.note("actearly is left out: forces follow the state as it is", self.place)
        limited = bool(m.actuator_actlimited[a])
        start = float(self.source.act[m.actuator_actadr[a]])
        keys: dict[str, object] = {"start": neat(start)} if start else {}
        if kind == INTEGRATOR:
            limits = {"limits": tidy(m.actuator_actrange[a])} if limited else {}
            keys = {"rate": u, **limits, **keys}
        else:
            keys = {"value": u, "filter": neat(m.actuator_dynprm[a][0]), **keys}
        state = self.draft.input_names.new(f"{name}_act")
        self.draft.inputs[state] = keys
        act = f"inputs.{state}"
        return clipped(act, m.actuator_actrange[a]) if limited and kind != INTEGRATOR else act

    def _on_joint(self, joint: int, arm: float) -> None:
        """Along one coordinate: an actuator that has the gains of a servo."""
        u, limits = self._control(), self._limits(joint, arm)
        if np.any(self.gain[1:]):
            force = product(arm, self._force({joint: arm}, u))
            self.draft.force(self.name, "actuator", joint=self.tree.joints[joint], value=force, **_kept(limits))
            return
        value, gains = self._gains(u, arm)
        keys = {**gains, **_kept(limits)}
        self.draft.force(self.name, "actuator", joint=self.tree.joints[joint], value=value, **keys)

    def _gains(self, u: str, arm: float) -> tuple[str, dict[str, str]]:
        """What u and the bias give along a coordinate, and the parameters that its place and rate are multiplied with,
        by the keys of an actuator."""
        servo = {"stiffness": ("kp", self.bias[1]), "damping": ("kv", self.bias[2])}
        gains = {
            key: self.draft.parameter(f"{self.name}_{letters}", neat(-(arm**2) * bias))
            for key, (letters, bias) in servo.items()
            if bias
        }
        follows = next((key for key in gains if _same(self.gain[0], -servo[key][1])), None)
        if follows:  # kp (u - q), or kv (u - q')
            value = f"{gains[follows]}*{u}" + ("" if arm == 1.0 else f"/{neat(arm)!r}")
        else:
            gain = neat(arm * self.gain[0])
            value = u if gain == 1.0 else f"{self.draft.parameter(f'{self.name}_gain', gain)}*{u}" if gain else ""
        return total([value, repr(neat(arm * self.bias[0])) if self.bias[0] else ""]), gains

    def _limits(self, joint: int, arm: float) -> tuple[float, float] | None:
        """Of the force along a coordinate."""
        m, a = self.model, self.index
        low, high = -np.inf, np.inf
        if m.actuator_forcelimited[a]:
            low, high = sorted(arm * m.actuator_forcerange[a])
        if m.jnt_actfrclimited[joint]:
            others = [
                b for b in range(len(m.actuator_trntype))
                if b != a and m.actuator_trntype[b] in (JOINT, IN_PARENT) and m.actuator_trnid[b, 0] == joint
            ]  # fmt: skip
            if others:
                self.draft.note(
                    "limits of a joint that several actuators share are left out", self.source.place("joint", joint)
                )
            else:
                low, high = max(low, m.jnt_actfrcrange[joint][0]), min(high, m.jnt_actfrcrange[joint][1])
        if (
            m.actuator_ctrllimited[a]
            and not self.bias.any()
            and not self.gain[1:].any()
            and m.actuator_dyntype[a] == NO_STATE
        ):
            least, most = sorted(arm * self.gain[0] * m.actuator_ctrlrange[a])
            if low <= least and most <= high:
                return None  # never met
        return None if (low, high) == (-np.inf, np.inf) else (float(low), float(high))

    def _force(self, arms: Mapping[int, float], u: str) -> str:
        """The name of the actuator's own force, along any coordinates."""
        length, speed = (f"({text})" for text in (self.readings.lengths(arms), self.readings.rates(arms)))
        if np.any(self.gain[1:]):
            gain, bias = (_affine(c, length, speed) for c in (self.gain, self.bias))
            text = total([f"({gain})*{u}", "" if bias == "0" else bias])
        else:
            value, gains = self._gains(u, 1.0)
            read = {"stiffness": length, "damping": speed}
            text = total([value, *(f"-{name}*{read[key]}" for key, name in gains.items())])
        m, a = self.model, self.index
        if m.actuator_forcelimited[a]:
            text = clipped(text, m.actuator_forcerange[a])
        return self.readings.named(f"{self.name}_force", text)

    def _wrench(self, body: int, point: np.ndarray, force: np.ndarray, torque: np.ndarray) -> None:
        """Along axes of a body, at a point of it: a propeller."""
        name, frame = self.tree.on(self.source, body)
        if name == GROUND:
            return
        f = self._force({}, self._control())
        for what, vector, keys in (("force", force, {"point": tidy(frame.point(point))}), ("torque", torque, {})):
            if vector.any():
                value = [product(x, f) or 0.0 for x in tidy(frame.R @ vector)]
                self.draft.force(f"{self.name}_{what}", what, body=name, frame="body", value=value, **keys)


def _same(x: float, y: float) -> bool:
    return bool(np.isclose(x, y, rtol=1e-14, atol=0.0))


def _affine(c: np.ndarray, length: str, speed: str) -> str:
    return total([repr(neat(c[0])) if c[0] else "", product(c[1], length), product(c[2], speed)])


def _kept(limits: tuple[float, float] | None) -> dict[str, object]:
    """The keys of a force that is kept within limits."""
    if limits is None:
        return {}
    low, high = map(neat, limits)
    return {"limit": high} if low == -high else {"limits": [low, high]}


def clipped(text: str, limits: np.ndarray | tuple[float, float]) -> str:
    """Kept within limits, either of which may be infinite."""
    low, high = (float(x) for x in limits)
    if np.isfinite(low) and np.isfinite(high):
        return f"clip({text}, {neat(low)!r}, {neat(high)!r})"
    return f"max({text}, {neat(low)!r})" if np.isfinite(low) else f"min({text}, {neat(high)!r})"
