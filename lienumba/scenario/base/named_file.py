"""What is in a file that somebody names; what is wrong where there is none, as sentences."""

from collections.abc import Collection
from pathlib import Path

from lienumba.errors import ScenarioError
from lienumba.words import absence, printable


def content(path: Path, kind: str, endings: Collection[str], largest: int, instead: str) -> bytes:
    """All bytes of a file; a ScenarioError if it cannot be read, or has more than the largest.

    kind: of the file that is wanted, such as "TOML"; endings: of the names of such files; instead: the remedy where it
    is too large.
    """
    shown = printable(str(path))
    try:
        if path.is_dir():
            raise ScenarioError.at("", f"{shown} is a folder", f"give the path of a {kind} file in it")
        if not path.exists():
            rule, remedy = absence(path, endings)
            raise ScenarioError.at("", f"{shown} {rule}", remedy)
        with path.open("rb") as file:
            found = file.read(largest + 1)
    except OSError as error:
        remedy = "check its permissions" if isinstance(error, PermissionError) else "check the path"
        raise ScenarioError.at(f"{shown} cannot be read", str(error.strerror), remedy) from None
    if len(found) > largest:
        raise ScenarioError.at(shown, f"is larger than {largest >> 20} MiB", instead)
    return found
