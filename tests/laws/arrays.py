"""Laws that call functions by `lienumba.batched`, as those of jitted.py."""

import numpy as np

import lienumba


@lienumba.batched(outputs=2)
def controller(angle, rate, integral, kp, ki, kd, target, limit, interval):
    error = target - angle
    wanted = kp * error + ki * integral - kd * rate
    given = np.clip(wanted, -limit, limit)
    return given, integral + np.where(wanted == given, interval * error, 0.0)


def pid(joint, *, kp, ki, kd, target, limit, states, interval):
    torque, integral = controller(joint.angle, joint.rate, states.integral, kp, ki, kd, target, limit, interval)
    return joint.effort(torque), {"integral": integral}


@lienumba.batched(outputs=1)
def limited(angle, rate, limit):
    if (angle > limit).any():
        raise ValueError("too far")
    return -2.0 * angle - rate


def motor(joint, *, limit):
    return joint.effort(limited(joint.angle, joint.rate, limit))


@lienumba.batched(outputs=1)
def first(angle):
    """Of the first run, for all of them."""
    return angle[:1] + 0.0 * angle


@lienumba.batched(outputs=2)
def single(angle):
    return angle


@lienumba.batched(outputs=1)
def raising(angle):
    raise KeyError("no such layer")


WEIGHTS = np.array([2.0, 0.5])


def weighted(angle):
    return WEIGHTS[0] * angle


@lienumba.batched(outputs=1)
def policy(angle):
    return weighted(angle) - WEIGHTS[1]


def by_first(joint, *, limit):
    return joint.effort(first(joint.angle))


def by_single(joint, *, limit):
    return joint.effort(single(joint.angle)[0])


def by_raising(joint, *, limit):
    return joint.effort(raising(joint.angle))


def by_policy(joint, *, limit):
    return joint.effort(policy(joint.angle))


def by_gust(joint, *, gain, gust):
    return joint.effort(gain * policy(gust))


def by_gust_traced(joint, *, gain, gust):
    return joint.effort(gain * (2.0 * gust - 0.5))


@lienumba.batched(outputs=1)
def mean(angle):
    return angle - angle.mean()


def by_mean(joint, *, limit):
    return joint.effort(mean(joint.angle))


@lienumba.batched(outputs=1)
def of_first(limit):
    return np.full(8, limit[0])


def by_limits(joint, *, limit):
    return joint.effort(of_first(limit))


@lienumba.batched(outputs=1)
def complex_torque(angle):
    return 1j * angle


def by_complex(joint, *, limit):
    return joint.effort(complex_torque(joint.angle))
