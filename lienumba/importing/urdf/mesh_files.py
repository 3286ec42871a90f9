"""Where the file of a mesh lies that a URDF file names as ROS does."""

import os
import re
from collections.abc import Iterator
from os.path import isfile
from pathlib import Path
from urllib.parse import unquote

READ = (".stl", ".obj", ".msh")  # formats that MuJoCo reads


def find(name: str, file: Path, folder: str = "") -> Path | None:
    """The file of a mesh, None if there is none.

    Parameters
    ----------
    name : str
        As the robot's file has it: a path, from that file on; `package://robot_description/meshes/arm.stl`; `file://`.
    file : Path
        The robot's file.
    folder : str
        Of meshes, from that file on.

    Returns
    -------
    Path or None
        In the package of that name above the file, in those of ROS_PACKAGE_PATH and AMENT_PREFIX_PATH, or where the
        rest of the path leads from a folder above the file.
    """
    return next((x.resolve() for x in _candidates(name, file.resolve(), folder) if isfile(x)), None)


def _candidates(name: str, file: Path, folder: str) -> Iterator[Path]:
    scheme, _, path = name.rpartition("://")
    path = unquote(path) if scheme else path
    path = path.replace("\\", "/")
    above = list(file.parents)
    if scheme in ("package", "model"):
        package, _, rest = path.partition("/")
        for root in (*above, *_ros()):
            yield root / package / rest
            yield root / "share" / package / rest
            if root.name == package or _is_package(root, package):
                yield root / rest
        yield from (root / rest for root in above)
    elif scheme == "file" or path.startswith("/"):
        yield Path("/" + path.lstrip("/"))
        yield from (root / path.lstrip("/") for root in above)
    else:
        yield file.parent / folder / path
        yield from (root / path for root in above)
    if folder:
        yield file.parent / folder / Path(path).name


def _ros() -> Iterator[Path]:
    """The folders in which ROS looks for packages."""
    for variable, inside in (("ROS_PACKAGE_PATH", ""), ("AMENT_PREFIX_PATH", "share")):
        for text in os.environ.get(variable, "").split(os.pathsep):
            if text:
                yield Path(text) / inside


def _is_package(folder: Path, name: str) -> bool:
    """Whether ROS calls what is in a folder by this name."""
    try:
        text = (folder / "package.xml").read_text(encoding="utf-8", errors="replace")
    except OSError:
        return False
    return re.search(rf"<name>\s*{re.escape(name)}\s*</name>", text) is not None
