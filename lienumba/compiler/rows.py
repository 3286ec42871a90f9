"""What kernels read and write: rows of W doubles, one lane per run, in arrays that every kernel gets as pointers."""

from dataclasses import dataclass, field

W = 8  # lanes
ROW = 8 * W  # bytes
ARRAYS = ("state", "parameters", "clock", "extra", "out", "work")
ARGUMENTS = ", ".join(f"ptr %{name}" for name in ARRAYS)


@dataclass
class _Frame:
    """Rows side by side."""

    first: int
    size: int
    needed: int  # values in it that will be read again


@dataclass
class WorkRows:
    """Rows of `work` for the values that one segment computes and later ones read.

    `count`: rows so far; `of`: the row of every value that is kept. What a segment leaves lies side by side and is
    freed together, so that segments that do the same leave and find their values in the same pattern of rows.
    """

    count: int = 0
    of: dict[int, int] = field(default_factory=dict)
    _frames: dict[int, _Frame] = field(default_factory=dict)
    _free: dict[int, list[int]] = field(default_factory=dict)  # first rows of free frames, by size

    def keep(self, values: list[int]) -> None:
        size = len(values)
        free = self._free.setdefault(size, [])
        if not free:
            free.append(self.count)
            self.count += size
        frame = _Frame(free.pop(), size, size)
        for n, value in enumerate(values):
            self.of[value], self._frames[value] = frame.first + n, frame

    def release(self, value: int) -> None:
        frame = self._frames.pop(value)
        frame.needed -= 1
        del self.of[value]
        if not frame.needed:
            self._free[frame.size].append(frame.first)
