"""Whether a file may be written, asked before anything is computed."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

from lienumba.errors import ScenarioError
from lienumba.store.files import folder_of, partial_of
from lienumba.words import listed

CHOOSE = "choose another name"
DATASET_STARTS = (b"\x89HDF", b"CDF")


def check_target(
    path: str | os.PathLike[str],
    what: str,
    endings: Sequence[str] = (),
    existing: str = "",
    replaceable: Sequence[bytes] = (),
) -> None:
    """Refuse a file that is to be `what` and could not be written, or must not be replaced.

    endings: of which its name must have one, if it matters; existing: the remedy where the file exists and must not be
    replaced; replaceable: with which of these a file begins that may be, if not any.
    """
    target = Path(path)
    folder = target.parent
    try:
        target.stat()
    except (FileNotFoundError, NotADirectoryError):  # which is told below
        pass
    except OSError as error:
        raise ScenarioError(f"output = {target}: cannot be ({error.strerror}); {CHOOSE}") from error
    if endings and target.suffix.lower() not in endings:
        raise ScenarioError(f"output = {target}: is no {what}; give a name that ends in {listed(endings, 'or')}")
    if target.is_dir():
        example = target / f"out{target.suffix or '.nc'}"
        raise ScenarioError(f"output = {target}: is a folder; give the name of a file in it, like {example}")
    if not folder.exists():
        raise ScenarioError(f"output = {target}: its folder {folder} does not exist; create it or choose another")
    if not folder.is_dir():
        raise ScenarioError(f"output = {target}: {folder} is not a folder; choose another")
    if target.exists() and not target.is_file():
        raise ScenarioError(f"output = {target}: is not a regular file; {CHOOSE}")
    if target.exists() and existing:
        raise ScenarioError(f"output = {target}: exists already; {existing}")
    if target.exists() and replaceable and not _begins(target, replaceable):
        raise ScenarioError(f"output = {target}: is a file of another kind, no {what} to be replaced; {CHOOSE}")
    probe = partial_of(target.resolve())
    try:
        probe.open("xb").close()  # asking for permissions is not enough: root has them all, on a read-only disk too
        probe.unlink()
    except OSError as error:
        raise ScenarioError(
            f"output = {target}: cannot be written to {folder} ({error.strerror});"
            " change its permissions or choose another folder"
        ) from error


def check_dataset_target(
    path: str | os.PathLike[str], overwrite: bool, resume: bool = False, resumable: bool = True
) -> None:
    """Refuse what could not be written or must not be replaced as a dataset; resumable: whether runs can be added."""
    if overwrite and resume:
        raise ScenarioError("--resume goes on with what is there, and --overwrite starts again; give one of them")
    others = ", replace it with --overwrite, or add runs to it with --resume"
    remedy = CHOOSE + (others if resumable else ", or replace it with --overwrite")
    check_target(path, "dataset", (), "" if overwrite or resume else remedy, DATASET_STARTS)
    shards = folder_of(Path(path))
    if shards.exists() and not (overwrite or resume):
        raise ScenarioError(
            f"output = {path}: an interrupted sweep has left its runs in {shards}; go on with --resume, or start again "
            "with --overwrite"
        )


def _begins(path: Path, starts: Sequence[bytes]) -> bool:
    """Whether a file begins with one of these, or is empty, or cannot be read."""
    try:
        with path.open("rb") as file:
            first = file.read(max(map(len, starts)))
    except OSError:
        return True
    return not first or first.startswith(tuple(starts))
