"""What is safe of a sweep that is not finished: a folder of tables beside the dataset that it will be.

A shard is a NumPy file of records, one for each run; its name has the labels and a checksum against damage, which costs
next to nothing, and it has its name only when all of it is on the disk. What a shard of runs says is complete: the
courses of its runs were written before.
"""

from __future__ import annotations

import io
import json
import os
import re
import time
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from lienumba.errors import ScenarioError
from lienumba.store.deflate import checksum
from lienumba.store.layout import LABEL as LABEL
from lienumba.store.outputs import LostError, Output, WriteError, folder_of, remedy, stamp_of, to_disk
from lienumba.sweep.design import NOMINAL_RUN
from lienumba.words import option

if TYPE_CHECKING:
    from lienumba.store.stream import Source

Json = dict[str, Any]
MANIFEST = "sweep.json"
NAME = re.compile(r"(?P<table>\w+)-(?P<first>-?\d+)-(?P<last>-?\d+)-(?P<sum>[0-9a-f]{8})\.npy")
PAUSE = 1.0  # s: so much work at most is not yet on the disk
SHARD_BYTES = 16 * 2**20  # a shard is written when there is so much of it


class Shard:
    """A table of some runs: labels (runs,), and its records, which begin at a byte of the file."""

    def __init__(self, path: Path, labels: np.ndarray, dtype: np.dtype[np.void], offset: int) -> None:
        self.path, self.labels, self.dtype, self.offset = path, labels, dtype, offset
        self.stamp = stamp_of(path)

    def read(self, part: slice) -> Any:
        first = self.offset + part.start * self.dtype.itemsize
        with self._as_it_was():
            return np.fromfile(self.path, self.dtype, part.stop - part.start, offset=first)

    def column(self, name: str) -> np.ndarray:
        """One field of all records, and no more of the file than that."""
        with self._as_it_was():
            records = np.memmap(self.path, self.dtype, "r", self.offset, len(self.labels))
            return np.array(records[name])

    @contextmanager
    def _as_it_was(self) -> Iterator[None]:
        """While it is read, a file that nobody has touched since it was written or checked."""
        try:
            if stamp_of(self.path) != self.stamp:
                raise OSError
            yield
        except (OSError, ValueError):
            raise LostError(
                f"{self.path}: has been removed or changed while the sweep was running; its runs are lost, others are "
                f"not: go on with {option('resume')}, which simulates them again"
            ) from None


class InMemory:
    """A table of some runs that is in memory."""

    def __init__(self, records: np.ndarray) -> None:
        self.records, self.labels = records, records[LABEL]

    def read(self, part: slice) -> Any:
        return self.records[part]

    def column(self, name: str) -> np.ndarray:
        return self.records[name]


class Shards:
    """The folder of a sweep whose dataset this process owns; `damaged`: names of shards that were not what they should
    be, and have been removed."""

    def __init__(self, output: Output) -> None:
        self.folder, self.named = output.folder, folder_of(output.path)
        self.tables: dict[str, list[Shard]] = {}
        self.pending: dict[str, list[np.ndarray]] = {}
        self.bytes, self.since = 0, time.monotonic()
        self.damaged: list[str] = []
        self.manifest: Json = {}
        self._begun = False  # whether all that is in the folder is of this sweep

    @property
    def exists(self) -> bool:
        return (self.folder / MANIFEST).is_file()

    def load(self) -> Json:
        """The manifest of a folder that exists."""
        path = self.folder / MANIFEST
        try:
            manifest = json.loads(path.read_text(encoding="utf-8"))
            if not isinstance(manifest, dict) or not isinstance(manifest.get("scenario"), str):
                raise ValueError("it does not say of which sweep it is")
        except (OSError, ValueError, RecursionError) as error:
            raise ScenarioError(
                f"{self.named / MANIFEST} cannot be read ({error}); remove the folder, or start again with "
                f"{option('overwrite')}"
            ) from None
        self.manifest, self._begun = manifest, True
        return manifest

    def take_over(self, dtypes: Mapping[str, np.dtype[Any]]) -> None:
        """Go on with the shards that are there; those that are not sound tables of these types are removed."""
        for path in sorted(self.folder.iterdir()):
            match = NAME.fullmatch(path.name)
            if match is None:
                if path.suffix == ".partial":
                    _remove(path)
            elif (shard := _sound(path, match["sum"], dtypes.get(match["table"]))) is None:
                self.damaged.append(path.name)
                _remove(path)
            else:
                self.tables.setdefault(match["table"], []).append(shard)

    def begin(self, manifest: Json, fresh: bool) -> None:
        """What the sweep is, which is written with the first shard; fresh: nothing of what is there is kept."""
        self.manifest = manifest
        if fresh:
            self._clear()

    def labels(self) -> np.ndarray:
        """The runs that are there, ascending."""
        return labels_of(self.tables.get("run", []))

    def take(self, tables: dict[str, np.ndarray]) -> bool:
        """Keep finished runs, which are on the disk a second later at most; whether all of them are there."""
        for name, records in tables.items():
            if len(records):
                self.pending.setdefault(name, []).append(records)
                self.bytes += records.nbytes
        return self.look()

    def look(self) -> bool:
        """Write what has waited long enough, or is much; whether it is so."""
        due = self.bytes >= SHARD_BYTES or time.monotonic() - self.since >= PAUSE
        if due:
            self.flush()
        return due

    def flush(self) -> None:
        """Write what is not yet on the disk."""
        try:
            if self.pending and not (self._begun and self.exists):
                if not self._begun:
                    self._clear()
                self.folder.mkdir(exist_ok=True)
                to_disk(self.folder.parent)
                self._write(self.folder / MANIFEST, [json.dumps(self.manifest, indent=1).encode()])
                self._begun = True
            for table in sorted(self.pending, key=lambda name: name == "run"):  # that last: it says what is complete
                shard = self._save(table, sorted(self.pending[table], key=lambda part: int(part[LABEL][0])))
                others = [x for x in self.tables.get(table, []) if x.path != shard.path]  # one may have been replaced
                self.tables[table] = [*others, shard]
        except OSError as error:
            then = f" and go on with {option('resume')}, which needs what is in this folder"
            told = remedy(error, self.folder.parent, then=then)
            raise WriteError(f"{self.named}: could not be written ({error.strerror}){told}") from error
        self.pending, self.bytes, self.since = {}, 0, time.monotonic()

    def sources(self, table: str) -> list[Shard | InMemory]:
        """What there is of a table, what is not yet on the disk too."""
        return [*self.tables.get(table, []), *map(InMemory, self.pending.get(table, []))]

    def remove(self) -> None:
        """The dataset is safe: the folder has done its work."""
        self.pending, self.bytes = {}, 0
        self._clear()

    def _clear(self) -> None:
        """Remove what sweeps leave here, and nothing else: no link is followed, and no file of somebody else goes."""
        if self.folder.is_symlink() or not self.folder.is_dir():
            return
        own = [path for path in self.folder.iterdir() if NAME.fullmatch(path.name) or path.suffix == ".partial"]
        for path in [*own, self.folder / MANIFEST]:  # that last: it says of which sweep the others are
            _remove(path)
        with suppress(OSError):
            self.folder.rmdir()

    def _save(self, table: str, parts: Sequence[np.ndarray]) -> Shard:
        labels, dtype = np.concatenate([part[LABEL] for part in parts]), parts[0].dtype
        header = _header(dtype, len(labels))
        own = [np.ascontiguousarray(part).view(np.uint8).data for part in parts]
        content: list[bytes | memoryview] = [header, *own]
        total = 0
        for piece in content:
            total = checksum(piece, total)
        path = self.folder / f"{table}-{labels[0]}-{labels[-1]}-{total:08x}.npy"
        self._write(path, content)
        return Shard(path, labels, dtype, len(header))

    def _write(self, path: Path, content: Iterable[bytes | memoryview]) -> None:
        """Whole or not at all."""
        partial = path.with_name(f"{path.name}.partial")
        try:
            with partial.open("wb") as file:
                file.writelines(content)
            to_disk(partial)
            os.replace(partial, path)
            to_disk(path.parent)
        except OSError:
            partial.unlink(missing_ok=True)
            raise


def labels_of(sources: Sequence[Source]) -> np.ndarray:
    """The runs that any of these has, ascending."""
    every = [np.empty(0, np.int64), *(source.labels for source in sources)]
    return np.unique(np.concatenate(every))


def _header(dtype: np.dtype[np.void], count: int) -> bytes:
    """What a NumPy file of so many records begins with."""
    head = io.BytesIO()
    described = np.lib.format.dtype_to_descr(dtype)
    np.lib.format.write_array_header_2_0(head, {"descr": described, "fortran_order": False, "shape": (count,)})
    return head.getvalue()


def _sound(path: Path, expected: str, dtype: np.dtype[Any] | None) -> Shard | None:
    """A shard of records of this type; None if it is damaged, or something else."""
    try:
        content = np.fromfile(path, np.uint8)
        if f"{checksum(content.data):08x}" != expected:
            return None
        records = np.load(path, mmap_mode="r", allow_pickle=False)
        if records.dtype != dtype or records.ndim != 1:
            return None
        labels = records[LABEL].copy()
        if not len(labels) or labels.min() < NOMINAL_RUN or len(np.unique(labels)) != len(labels):
            return None
        return Shard(path, labels, records.dtype, records.offset)
    except (OSError, ValueError, KeyError, IndexError, SyntaxError):
        return None


def _remove(path: Path) -> None:
    """A file, or a link, not what this leads to."""
    with suppress(FileNotFoundError, IsADirectoryError, PermissionError):
        path.unlink()
