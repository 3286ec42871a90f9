"""Laws as a user writes them: the tests read this file as scenarios do, by its text."""

from lienumba.laws import Vector, clip, cos, sin, sqrt, where


# ---------------------------------------------------------------- loads
def spring(a, b, *, stiffness, damping, length):
    """A spring-damper between (0.1, 0, -0.2) of a and (0, 0.05, 0.15) of b."""
    p, q = (0.1, 0.0, -0.2), (0.0, 0.05, 0.15)
    d = b.point(q) - a.point(p)
    n = d / d.norm()
    pull = stiffness * (d.norm() - length) + damping * n.dot(b.velocity_of(q) - a.velocity_of(p))
    return a.force(pull * n, at=p), b.force(-pull * n, at=q)


def gust(body, *, t, x):
    return body.force((x, -2 * sin(5 * t), 1.0), at=(0.0, 0.05, 0.15))


def thrust(body, *, t, x):
    return [body.force(Vector(x, -2 * sin(5 * t), 1.0), at=(0.0, 0.05, 0.15), frame="body")]


def twist(body, *, t, x):
    return body.torque([x, 0.2, -0.5 * t])


def twist_along(body, *, t, x):
    return body.torque([x, 0.2, -0.5 * t], frame="body")


def nothing(body):
    """A law may do nothing, if it says so."""
    return []


def servo(joint, *, kp, kd, target, rate, limit):
    c, dc = (joint.angle, joint.rate) if hasattr(joint, "angle") else (joint.displacement, joint.speed)
    return joint.effort(clip(kp * (target - c) + kd * (rate - dc), -limit, limit))


def two_servos(joint, *, kp, limit):
    """Both coordinates of a cylindrical joint."""
    return [
        joint.effort(clip(-kp * joint.displacement, -limit, limit), "displacement"),
        joint.effort(clip(-kp * joint.angle, -limit, limit), "angle"),
    ]


def damped_drive(ball, joint, *, t, drive, drag):
    """Works and takes work, and jumps nowhere."""
    v = ball.velocity
    return [joint.effort(drive * sin(4 * t) - 0.1 * joint.rate), ball.force(-drag * sqrt(v.dot(v) + 0.01) * v)]


def pointing_servo(body, *, pointing, turning, kp, kd):
    """A torque that quantities decide."""
    return body.torque((0.0, -kp * pointing.y - kd * turning.y, 0.0))


# ---------------------------------------------------------------- potentials
def spring_energy(a, b, *, stiffness, length):
    x = (b.point((0.0, 0.05, 0.15)) - a.point((0.1, 0.0, -0.2))).norm() - length
    return 0.5 * stiffness * x * x


def coil_energy(joint, *, stiffness, rest):
    return 0.5 * stiffness * (joint.angle - rest) ** 2


# ---------------------------------------------------------------- states
def pd(joint, *, kp, kd, target):
    return joint.effort(kp * (target - joint.angle) - kd * joint.rate)


def pid(joint, *, kp, ki, kd, target, states):
    e = target - joint.angle
    return joint.effort(kp * e + ki * states.integral - kd * joint.rate), {"integral": e}


def motor(joint, *, t, volts, lag, states):
    """The torque follows the voltage late, and the speed lowers it."""
    return joint.effort(states.torque), (volts * sin(3 * t) - 0.2 * joint.rate - states.torque) / lag


def low_pass(joint, *, states, lag, gain):
    """Four filters in a row, the last of which drives."""
    inputs = (joint.angle, states.a, states.b, states.c)
    outputs = (states.a, states.b, states.c, states.d)
    return joint.effort(-gain * states.d), [(x - y) / lag for x, y in zip(inputs, outputs, strict=True)]


def rail_motor(joint, *, t, volts, lag, states):
    return joint.effort(states.torque), (volts * sin(3 * t) - 0.2 * joint.speed - states.torque) / lag


def two_filters(joint, *, states, lag, gain):
    """Six in a row, of which the third and the last drive."""
    outputs = [getattr(states, f"s{i}") for i in range(6)]
    rates = tuple((x - y) / lag for x, y in zip([joint.angle, *outputs[:5]], outputs, strict=True))
    return joint.effort(-gain * (outputs[2] + outputs[5])), rates


def decay(joint, *, states, lag):
    return [], {"x": -states.x / lag}


def memory(body, *, states, lag, gain):
    """A torque against the turning as it was a while ago: three filters."""
    w = body.angular_velocity
    rates = {n: (x - getattr(states, n)) / lag for n, x in zip("xyz", w, strict=True)}
    return body.torque((-gain * states.x, -gain * states.y, -gain * states.z), frame="body"), rates


# ---------------------------------------------------------------- samples
def held_pd(joint, *, kp, kd, target):
    return joint.effort(kp * (target - joint.angle) - kd * joint.rate)


def held_pid(joint, *, kp, ki, kd, target, states):
    e = target - joint.angle
    return joint.effort(kp * e + ki * states.integral - kd * joint.rate), {"integral": states.integral + e}


def counter(joint, *, t, states):
    """How often it was asked, and when last."""
    return None, {"count": states.count + 1, "last": t}


def puff(body, *, thrust):
    """A force across and a torque along the body, as they are at the sample: a jet that is held."""
    w = body.angular_velocity
    return [
        body.force((0.0, thrust * w.x, 1.0), at=(0.2, 0.1 * w.y, 0.0), frame="body"),
        body.torque((0.3, -0.2 * w.z, 0.1), frame="body"),
        body.force((0.1, 0.2, thrust * w.y)),
    ]


def bang(joint, *, size):
    """Full torque against the angle, of either sign."""
    return joint.effort(where(joint.angle > 0, -size, size))


def coil(joint, *, stiffness):
    return joint.effort(-stiffness * joint.angle)


# ---------------------------------------------------------------- constraints
def rolling(disc, *, radius):
    """The lowest point of the disc, which turns about its z axis, rests on the ground."""
    n = disc.to_global((0, 0, 1))
    down = Vector(n.x * n.z, n.y * n.z, n.z * n.z - 1.0)
    return disc.velocity + disc.to_global(disc.angular_velocity).cross(radius * down / down.norm())


def knife(body, *, behind):
    """The blade behind the mass centre does not move sideways."""
    return body.to_body(body.velocity_of((-behind, 0, 0))).y


def roller(cam, follower, *, distance):
    """A roller on a round disc: the distance of their mass centres."""
    return (follower.position - cam.position).norm() - distance


def ball(a, b, *, reach):
    return b.point((0.02, 0, 0.2)) - a.point((0, 0.01, -reach))


def pin_in_plane(a, b, *, height):
    """A point of b in a plane of a, and two axes at right angles."""
    up = a.to_global((0, 0, 1))
    return up.dot(b.point((0.1, 0, 0.2)) - a.position) - height, up.dot(b.to_global((1, 0, 0)))


def no_lift(body):
    return body.velocity.z


def belt(a, b, *, t, pointing, ratio):
    """A velocity that a position of others and the time decide."""
    return b.velocity.x - ratio * pointing.y - 0.1 * sin(3 * t)


def moved(body, *, t, size):
    return body.position.x - 1 - size * sin(3 * t)


def sped(body, *, t, size):
    return body.velocity.x - 3 * size * cos(3 * t)


def commands(joint, *, kp, target, states):
    """A controller that does nothing by itself."""
    return [], {"command": kp * (target - joint.angle)}


def follows(joint, *, controller, tau, states):
    """A motor that follows the command of another law with a lag."""
    return joint.effort(states.torque), {"torque": (controller.command - states.torque) / tau}


def adds_up(joint, *, states, interval):
    """The time, sample by sample."""
    return [], {"elapsed": states.elapsed + interval}
