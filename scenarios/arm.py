"""Control of an arm: a law with a memory, written in Python and compiled like the laws that are built in."""

from lienumba.laws import clip


def pd(elbow, *, kp, kd, target, limit):
    """Torque of a motor that draws the joint to its target (rad) and is limited (N m)."""
    return elbow.effort(clip(kp * (target - elbow.angle) - kd * elbow.rate, -limit, limit))


def pid(elbow, *, kp, ki, kd, target, limit, states, interval):
    """The same with an integral of the error, added up from sample to sample; it rests while the motor saturates.

    It asks for its states and for the interval at which it is sampled by their names.
    """
    error = target - elbow.angle
    wanted = kp * error + ki * states.integral - kd * elbow.rate
    given = clip(wanted, -limit, limit)
    share = 1.0 - clip(abs(wanted - given), 0.0, 1.0)
    return elbow.effort(given), {"integral": states.integral + share * interval * error}
