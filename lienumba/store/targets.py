"""Whether a file may be written, asked before anything is computed."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path

from lienumba.errors import ScenarioError
from lienumba.store.opening import check_at_hand
from lienumba.store.outputs import AnyPath, Output, folder_of, owned
from lienumba.words import listed, option, printable

CHOOSE = "choose another name"
DATASET_STARTS = (b"\x89HDF", b"CDF")
OF_OTHERS = {  # endings of what other commands write
    ".csv": "table", ".parquet": "table", ".mat": "table", ".png": "plot", ".svg": "plot", ".pdf": "plot",
    ".gif": "animate", ".mp4": "animate", ".html": "report", ".toml": "import",
}  # fmt: skip


def check_target(
    path: AnyPath,
    what: str,
    endings: Sequence[str] = (),
    existing: str = "",
    replaceable: Sequence[bytes] = (),
) -> None:
    """Refuse a file that is to be `what` and has no place, or must not be replaced.

    endings: of which its name must have one, if it matters; existing: the remedy where the file exists and must not be
    replaced; replaceable: with which of these a file begins that may be, if not any.
    """
    if not isinstance(path, str | os.PathLike):
        raise ScenarioError(f"output = {path!r}: is no path; give the name of a file")
    target = Path(path)
    folder = target.parent
    try:
        target.stat()
    except ValueError:  # of Python: no file can have such a name
        raise ScenarioError(f"output = {printable(str(target))}: cannot be; {CHOOSE}") from None
    except (FileNotFoundError, NotADirectoryError):  # which is told below
        pass
    except OSError as error:
        raise ScenarioError(f"output = {target}: cannot be looked up ({error.strerror}); {CHOOSE}") from error
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


@contextmanager
def claimed(
    path: AnyPath,
    what: str,
    endings: Sequence[str] = (),
    overwrite: bool = True,
    replaceable: Sequence[bytes] = (),
    remedy: str = "",
) -> Iterator[Output]:
    """Own a file that is to be `what`, from now on; a ScenarioError as `check_target`, and where another owns it.
    remedy: where the file exists and must not be replaced; another name or `overwrite` by default."""
    existing = "" if overwrite else remedy or f"{CHOOSE}, or replace it with {option('overwrite')}"
    check_target(path, what, endings, existing, replaceable)
    with ExitStack() as stack:
        try:  # asking for permissions is not enough: root has them all, on a read-only disk too
            output = stack.enter_context(owned(path))
        except OSError as error:
            raise ScenarioError(
                f"output = {path}: cannot be written to {Path(path).parent} ({error.strerror});"
                " change its permissions or choose another folder"
            ) from error
        check_target(path, what, endings, existing, replaceable)  # whoever had it may just have written it
        yield output


@contextmanager
def claimed_dataset(path: AnyPath, overwrite: bool, resume: bool = False, resumable: bool = True) -> Iterator[Output]:
    """Own a dataset that is to be written, from now on; resumable: whether runs can be added."""
    if overwrite and resume:
        raise ScenarioError(
            f"{option('resume')} goes on with what is there, and {option('overwrite')} starts again; give one of them"
        )
    ending = Path(path).suffix.lower() if isinstance(path, str | os.PathLike) else ""
    if ending in OF_OTHERS and not Path(path).is_file():
        rule = f"is no dataset, but what lienumba {OF_OTHERS[ending]} writes"
        raise ScenarioError(f"output = {printable(str(path))}: {rule}; give a name that ends in .nc")
    more = f"{CHOOSE}, replace it with {option('overwrite')}, or add runs to it with {option('resume')}"
    check_at_hand(f"output = {path}")
    with claimed(path, "dataset", (), overwrite or resume, DATASET_STARTS, more if resumable else "") as output:
        _check_folder(output, overwrite or resume)
        yield output


def _check_folder(output: Output, replaceable: bool) -> None:
    """Of runs that an interrupted sweep has left."""
    named = folder_of(output.path)
    if output.folder.is_symlink() or (output.folder.exists() and not output.folder.is_dir()):
        raise ScenarioError(f"output = {output.path}: {named} is no folder; remove it, or choose another name")
    try:
        left = not replaceable and output.folder.is_dir() and any(output.folder.iterdir())
    except OSError as error:
        raise ScenarioError(
            f"output = {output.path}: {named} cannot be read ({error.strerror}); remove it, or choose another name"
        ) from None
    if left:
        raise ScenarioError(
            f"output = {output.path}: an interrupted sweep has left its runs in {named}; go on with "
            f"{option('resume')}, or start again with {option('overwrite')}"
        )


def _begins(path: Path, starts: Sequence[bytes]) -> bool:
    """Whether a file begins with one of these, or is empty, or cannot be read."""
    try:
        with path.open("rb") as file:
            first = file.read(max(map(len, starts)))
    except OSError:
        return True
    return not first or first.startswith(tuple(starts))
