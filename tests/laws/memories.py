"""Laws with a memory: a command that comes late, as it is traced, for Numba, and of arrays; and a ring of numbers."""

import lienumba


def late(joint, *, gain, memory):
    line = memory.line
    torque = -gain * line[0]
    line[:] = [*line[1:], joint.angle]
    return joint.effort(torque)


@lienumba.jit
def shifted(angle, gain, line):
    torque = -gain * line[0]
    for n in range(len(line) - 1):
        line[n] = line[n + 1]
    line[len(line) - 1] = angle
    return torque


def late_jitted(joint, *, gain, memory):
    return joint.effort(shifted(joint.angle, gain, memory.line))


@lienumba.batched(outputs=1)
def rolled(angle, gain, line):
    torque = -gain * line[0]
    line[:-1] = line[1:].copy()
    line[-1] = angle
    return torque


def late_batched(joint, *, gain, memory):
    return joint.effort(rolled(joint.angle, gain, memory.line))


@lienumba.jit
def stored(angle, limit, ring, places, count):
    """The sum of the last numbers; `ring` is larger than what `states` are for. Raises beyond a limit."""
    n = int(places[0])
    ring[n] = angle
    places[0] = (n + 1) % len(ring)
    if angle > limit:
        raise ValueError("too far")
    total = 0.0
    for x in ring:
        total += x
    return -total / len(ring), count + 1


def ring(joint, *, limit, memory, states):
    torque, count = stored(joint.angle, limit, memory.ring, memory.places, states.count)
    return joint.effort(torque), {"count": count}


@lienumba.jit
def counted(first, second):
    first[0] += 1.0
    return second[0]


def twice(joint, *, gain, memory):
    return joint.effort(gain * counted(memory.line, memory.line))


def set_state(joint, *, limit, memory, states):
    states.count = states.count + 1
    return joint.effort(limit), {"count": states.count}


def late_by_name(joint, *, gain, memory):
    torque = -gain * memory.line[0]
    memory.line = [*memory.line[1:], joint.angle]
    return joint.effort(torque)


def longer(joint, *, gain, memory):
    memory.line[:] = [*memory.line, joint.angle]
    return joint.effort(gain)


def wordy(joint, *, gain, memory):
    memory.line[0] = "late"
    return joint.effort(gain)


def absent(joint, *, gain, memory):
    return joint.effort(gain * memory.lines[0])


def outside(joint, *, gain, memory):
    return joint.effort(gain * memory.line[60])
