"""The courses of a noise: of each run its own, from the stream of its seed, its label and the noise's name.

A course is the same whatever the number of runs, steps or workers, and a longer run only adds to it.
"""

from dataclasses import dataclass, fields, replace
from functools import lru_cache
from hashlib import file_digest, sha256
from os.path import isfile
from pathlib import Path
from typing import Any

import numpy as np

from lienumba.errors import ScenarioError
from lienumba.mechanics.mechanism.courses import Recorded, Recursion
from lienumba.mechanics.mechanism.tables import RunNumbers
from lienumba.sweep.design import NOMINAL_RUN
from lienumba.sweep.normal import inverse
from lienumba.sweep.samplers.streams import SMALLEST

AT_ONCE = 256  # runs whose courses are in memory to read single numbers of them


@dataclass(frozen=True)
class Courses(RunNumbers):
    """name: of the stream; labels (runs,): of the nominal run all samples are 0; count: of samples of each."""

    name: str
    seed: int
    labels: np.ndarray
    count: int
    recursion: Recursion

    def part(self, runs: Any) -> "Courses":
        return replace(self, labels=self.labels[runs], recursion=_part(self.recursion, runs))

    def rows(self) -> np.ndarray:
        normal = self._normal()
        own = self.recursion
        x = _times(own.start, normal[:, 0])
        found = np.empty((self.count, len(self.labels)))
        for k in range(self.count):
            if k:
                moved, kicked = _times(own.move, x), _times(own.kick, normal[:, k])
                x = [a + b for a, b in zip(moved, kicked, strict=True)]
            found[k] = sum(c * a for c, a in zip(own.out, x, strict=True))
        return np.ascontiguousarray(np.where(self.labels == NOMINAL_RUN, 0.0, found).T)

    def gather(self, index: Any) -> Any:
        return _gathered(self, index)

    def _normal(self) -> np.ndarray:
        """Normal numbers (states, samples, runs)."""
        digest = sha256(self.name.encode()).digest()
        words = [int.from_bytes(digest[k : k + 4], "little") for k in range(0, len(digest), 4)]
        states = len(self.recursion.out)
        raw = np.empty((len(self.labels), self.count * states), np.uint64)
        for row, label in zip(raw, self.labels.tolist(), strict=True):
            key = (max(label, 0), *words)
            row[:] = np.random.PCG64(np.random.SeedSequence(self.seed, spawn_key=key)).random_raw(len(row))
        uniform = np.maximum((raw >> np.uint64(11)) * 2.0**-53, SMALLEST)
        return inverse(uniform).reshape(len(raw), self.count, states).T


@dataclass(frozen=True)
class RecordedCourses(RunNumbers):
    """Courses that stand in a file, of which those of some runs are read when they are needed; labels (runs,): rows of
    the file, of the nominal run all samples are 0; count: of samples of each, behind its end the last one."""

    source: Recorded
    labels: np.ndarray
    count: int

    @staticmethod
    def of(name: str, source: Recorded, labels: np.ndarray, count: int) -> "RecordedCourses":
        """A ScenarioError if the file is not there, or is another one."""
        if not isfile(source.file):
            remedy = f"put the file there on every machine that computes, or {Path(source.file).name} beside a dataset"
            raise ScenarioError.at(f"{name}.table", "there is no such file", remedy, source.file)
        if not is_file(source.file, source.checksum):
            rule, remedy = "is not the file with which this was written", "give that file"
            raise ScenarioError.at(f"{name}.table", rule, f"{remedy}, whose SHA-256 is {source.checksum}", source.file)
        return RecordedCourses(source, labels, count)

    def part(self, runs: Any) -> "RecordedCourses":
        return replace(self, labels=self.labels[runs])

    def rows(self) -> np.ndarray:
        import h5py

        drawn = np.flatnonzero(self.labels != NOMINAL_RUN)
        found = np.zeros((len(self.labels), self.count))
        known = min(self.count, self.source.samples)
        own, places = np.unique(self.labels[drawn], return_inverse=True)
        if len(own):
            with h5py.File(self.source.file, "r") as file:
                found[drawn, :known] = file[self.source.variable][own, :known][places]
            found[drawn, known:] = found[drawn, known - 1 : known]
        return found

    def gather(self, index: Any) -> Any:
        return _gathered(self, index)


def is_file(path: str, checksum: str | None) -> bool:
    """Whether a file is there that has this checksum."""
    return isfile(path) and checksum_of(Path(path)) == checksum


def checksum_of(path: Path) -> str:
    """The SHA-256 of a file."""
    seen = path.stat()
    return _checksum(path, seen.st_size, seen.st_mtime_ns)


@lru_cache(maxsize=64)
def _checksum(path: Path, size: int, changed: int) -> str:
    """Of a file that has had this size and time of change before: nobody reads it twice."""
    with open(path, "rb") as file:
        return file_digest(file, "sha256").hexdigest()


def _gathered(courses: Courses | RecordedCourses, index: Any) -> np.ndarray:
    """Of each run the sample with its own index (runs,), with few whole courses in memory."""
    labels = courses.labels
    index = np.broadcast_to(np.asarray(index), labels.shape).astype(np.int64)
    found = np.zeros(len(labels))
    for first in range(0, len(labels), AT_ONCE):
        some = slice(first, first + AT_ONCE)
        part = replace(courses.part(some), count=int(index[some].max()) + 1)
        found[some] = part.rows()[np.arange(len(part.labels)), index[some]]
    return found


def _times(matrix: Any, x: Any) -> list[Any]:
    """A lower or full square matrix times a vector, elementwise, so that no library decides on its bits."""
    return [sum((a * b for a, b in zip(row[1:], x[1:], strict=True)), start=row[0] * x[0]) for row in matrix]


def _part(recursion: Recursion, runs: Any) -> Recursion:
    def of(x: Any) -> Any:
        return tuple(map(of, x)) if isinstance(x, tuple) else x[runs] if np.ndim(x) else x

    return Recursion(*(of(getattr(recursion, f.name)) for f in fields(recursion)))
