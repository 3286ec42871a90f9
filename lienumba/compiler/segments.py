"""Where a long row of operations is cut into segments.

`by_content`: a cut depends only on the few operations before it, as backup programs cut files. The operations of every
link of a chain are then cut in the same places, whatever came before, and the machine code of one serves them all.
Code that is read again and again stays in the nearest cache, which is what long mechanisms wait for.
`by_size`: for what does not repeat itself.
"""

from zlib import crc32

from lienumba.compiler.symbols import Symbol

SIZE = 300  # operations and loads of inputs of a segment, where cut by size; half as many where it passes over lanes
SHORTEST, LONGEST = 100, 400  # operations of a segment, where cut by content
MEAN = 100  # operations from SHORTEST on until a cut is found, on average
WINDOW = 12  # operations that decide about a cut

Segments = list[list[Symbol]]


def by_size(order: list[Symbol], passes: bool = False) -> Segments:
    """Operations in the order in which they are computed; at least one segment. passes: whether each is passed more
    than once, so that one pass is still under way where the next begins."""
    segments: Segments = [[]]
    size, most = 0, SIZE // 2 if passes else SIZE
    for node in order:
        cost = 1 + sum([x.__class__ is Symbol and x.op == "input" for x in node.args])
        if size + cost > most and segments[-1] and node.op != "part":
            segments.append([])
            size = 0
        size += cost
        segments[-1].append(node)
    return segments


def by_content(order: list[Symbol]) -> Segments:
    """The same; equal parts are cut in equal places."""
    segments: Segments = [[]]
    window, full = b"", False
    for node in order:
        if full and node.op != "part":
            segments.append([])
        segments[-1].append(node)
        window = (window + _kind(node))[-4 * WINDOW :]
        size = len(segments[-1])
        full = (size >= SHORTEST and crc32(window) % MEAN == 0) or size >= LONGEST
    return segments


def with_parts(order: list[Symbol]) -> list[Symbol]:
    """The operations with the outputs of each call directly behind it, where its memory is."""
    parts: dict[int, list[Symbol]] = {}
    for node in order:
        if node.op == "part":
            parts.setdefault(node.args[0].id, []).append(node)
    if not parts:
        return order
    return [x for node in order if node.op != "part" for x in (node, *parts.get(node.id, ()))]


def _kind(node: Symbol) -> bytes:
    """The operation and what it reads, but not which: four bytes."""
    read = [
        repr(x) if not isinstance(x, Symbol) else x.args[0] if x.op == "input" else str(x.invariant) for x in node.args
    ]
    return crc32(" ".join([node.op, *read]).encode()).to_bytes(4, "little")
