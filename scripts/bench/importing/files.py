"""The robots and mechanisms that come with Python packages, by where these are installed."""

from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, files
from pathlib import Path

PACKAGES = ("dm_control", "gymnasium", "example-robot-data", "mujoco", "mujoco-core")
ENDINGS = (".xml", ".urdf")
ROOTS = (b"<mujoco", b"<robot")  # one of them in a file that is a model
NONE = ("schema", "package.xml", "msh.xml")


@dataclass(frozen=True)
class File:
    """name: package and path within it, as the table has it."""

    package: str
    name: str
    path: Path

    @property
    def kind(self) -> str:
        return "urdf" if self.path.suffix == ".urdf" else "mjcf"


def every() -> list[File]:
    """All of them, package by package."""
    found = []
    for package in PACKAGES:
        try:
            listed = files(package) or []
        except PackageNotFoundError:
            continue
        for file in sorted(listed, key=str):
            path = Path(str(file.locate()))
            if path.suffix in ENDINGS and not path.name.endswith(NONE) and _is_model(path):
                found.append(File(package, _short(file.parts), path.resolve()))
    return found


def _is_model(path: Path) -> bool:
    text = path.read_bytes() if path.exists() else b""
    return any(root in text for root in ROOTS)


def _short(parts: tuple[str, ...]) -> str:
    """The path, without the folders that all share."""
    shown = [part for part in parts if part not in ("..", "cmeel.prefix", "share", "example-robot-data", "robots")]
    return "/".join(shown)
