"""Where a long row of operations is cut into segments, so that equal parts of a mechanism give equal segments.

A cut depends only on the few operations before it, as backup programs cut files: the operations of every link of a
chain are then cut in the same places, whatever came before, and the machine code of one serves them all. Code that is
read again and again stays in the nearest cache, which is what long mechanisms wait for.
"""

from zlib import crc32

from lienumba.compiler.symbols import Symbol

SHORTEST, LONGEST = 100, 400  # operations of a segment
MEAN = 100  # operations from SHORTEST on until a cut is found, on average
WINDOW = 12  # operations that decide about a cut


def cut(order: list[Symbol]) -> list[list[Symbol]]:
    """Operations in the order in which they are computed, cut into segments; at least one."""
    segments: list[list[Symbol]] = [[]]
    window = b""
    for node in order:
        segments[-1].append(node)
        window = (window + _kind(node))[-4 * WINDOW :]
        size = len(segments[-1])
        if (size >= SHORTEST and crc32(window) % MEAN == 0) or size >= LONGEST:
            segments.append([])
    return segments if segments[-1] or len(segments) == 1 else segments[:-1]


def _kind(node: Symbol) -> bytes:
    """The operation and what it reads, but not which: four bytes."""
    read = [
        repr(x) if not isinstance(x, Symbol) else x.args[0] if x.op == "input" else str(x.invariant) for x in node.args
    ]
    return crc32(" ".join([node.op, *read]).encode()).to_bytes(4, "little")
