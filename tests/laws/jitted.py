"""Laws that call functions by `lienumba.jit`, each beside the same law as it is traced."""

import numpy as np

import lienumba
from lienumba.laws import clip, where

THROTTLES, CLIMBS = np.linspace(0, 1, 5), np.linspace(-6, 6, 7)
FACTORS = np.array([[0.9 + 0.2 * u - 0.03 * v + 0.02 * u * v for v in CLIMBS] for u in THROTTLES])
MOST, HOVER = 30.0, 0.35  # N, and of that what carries the weight


@lienumba.jit
def controller(angle, rate, integral, kp, ki, kd, target, limit, interval):
    """PID; the integral rests while the motor saturates."""
    error = target - angle
    wanted = kp * error + ki * integral - kd * rate
    if wanted > limit:
        return limit, integral
    if wanted < -limit:
        return -limit, integral
    return wanted, integral + interval * error


def pid(joint, *, kp, ki, kd, target, limit, states, interval):
    torque, integral = controller(joint.angle, joint.rate, states.integral, kp, ki, kd, target, limit, interval)
    return joint.effort(torque), {"integral": integral}


def traced_pid(joint, *, kp, ki, kd, target, limit, states, interval):
    error = target - joint.angle
    wanted = kp * error + ki * states.integral - kd * joint.rate
    given = clip(wanted, -limit, limit)
    return joint.effort(given), {"integral": states.integral + where(wanted == given, interval * error, 0.0)}


@lienumba.jit
def limited(angle, rate, limit):
    """A motor that raises beyond its limit."""
    if angle > limit:
        raise ValueError("too far")
    return -2.0 * angle - rate


def motor(joint, *, limit):
    return joint.effort(limited(joint.angle, joint.rate, limit))


def energy(joint, *, limit):
    return limited(joint.angle, 0.0, limit)


def turns(body, *, limit):
    return limited(body.position.x, 0.0, limit)


@lienumba.jit
def factor(throttle, climb):
    """How much of its thrust a rotor has: bilinear in the table FACTORS."""
    i = min(max(np.searchsorted(THROTTLES, throttle) - 1, 0), len(THROTTLES) - 2)
    j = 0
    while j < len(CLIMBS) - 2 and climb > CLIMBS[j + 1]:
        j += 1
    a = (throttle - THROTTLES[i]) / (THROTTLES[i + 1] - THROTTLES[i])
    b = (climb - CLIMBS[j]) / (CLIMBS[j + 1] - CLIMBS[j])
    low = (1.0 - b) * FACTORS[i, j] + b * FACTORS[i, j + 1]
    return (1.0 - a) * low + a * ((1.0 - b) * FACTORS[i + 1, j] + b * FACTORS[i + 1, j + 1])


@lienumba.jit
def autopilot(height, climb, up, rates, states, interval):
    """Climbs to 1 m, waits there for 0.2 s, and sinks: thrust, torques, and the phase, the wait and the integral."""
    phase, waited, integral = states
    if phase == 0.0:
        phase = 1.0 if height > 0.9 else 0.0
    elif phase == 1.0:
        waited += interval
        phase = 2.0 if waited > 0.19 else 1.0
    error = (0.0 if phase == 2.0 else 1.0) - height
    wanted = HOVER + 0.8 * error + 0.3 * integral - 0.3 * climb
    throttle = min(max(wanted, 0.05), 1.0)
    if throttle == wanted:
        integral += interval * error
    thrust = MOST * throttle * factor(throttle, climb)
    pitch, roll, yaw = -0.4 * up[1] - 0.1 * rates[0], 0.4 * up[0] - 0.1 * rates[1], -0.1 * rates[2]
    return thrust, pitch, roll, yaw, phase, waited, integral


def fly(body, *, states, interval):
    up = body.to_body((0, 0, 1))
    given = states.phase, states.waited, states.integral
    found = autopilot(body.position.z, body.velocity.z, up, body.angular_velocity, given, interval)
    thrust, *torques = found[:4]
    loads = [body.force((0, 0, thrust), frame="body"), body.torque(torques, frame="body")]
    return loads, dict(zip(("phase", "waited", "integral"), found[4:], strict=True))


def traced_fly(body, *, states, interval):
    height, climb, up, w = body.position.z, body.velocity.z, body.to_body((0, 0, 1)), body.angular_velocity
    waited = states.waited + where(states.phase == 1.0, interval, 0.0)
    late = where(waited > 0.19, 2.0, 1.0)
    phase = where(states.phase == 0.0, where(height > 0.9, 1.0, 0.0), where(states.phase == 1.0, late, 2.0))
    error = where(phase == 2.0, 0.0, 1.0) - height
    wanted = HOVER + 0.8 * error + 0.3 * states.integral - 0.3 * climb
    throttle = clip(wanted, 0.05, 1.0)
    integral = states.integral + where(throttle == wanted, interval * error, 0.0)
    thrust = MOST * throttle * (0.9 + 0.2 * throttle - 0.03 * climb + 0.02 * throttle * climb)
    torque = (-0.4 * up.y - 0.1 * w.x, 0.4 * up.x - 0.1 * w.y, -0.1 * w.z)
    loads = [body.force((0, 0, thrust), frame="body"), body.torque(torque, frame="body")]
    return loads, {"phase": phase, "waited": waited, "integral": integral}
