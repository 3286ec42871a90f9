"""Robots of other formats, MJCF and URDF, as scenarios. Needs the extra `import`."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from lienumba.errors import ScenarioError
from lienumba.importing.imported import Imported as Imported
from lienumba.importing.notes import Note as Note

if TYPE_CHECKING:
    import mujoco

Base = Literal["fixed", "free"]


def from_file(
    path: str | Path,
    *,
    base: Base | None = None,
    qpos: Sequence[float] | None = None,
    keyframe: str | None = None,
    keep_limits: bool = False,
    strict: bool = False,
    density: float | None = None,
) -> Imported:
    """A robot of a URDF or MJCF file, whichever it is, as a scenario.

    Parameters
    ----------
    path : path
        The file.
    base : str, optional
        "fixed": its root is welded to the ground, "free": it floats; omitted: as the file has it (a URDF: fixed).
    qpos : sequence of float, optional
        Where it starts, as MuJoCo orders coordinates; omitted: at the reference.
    keyframe : str, optional
        The name of a keyframe of the file, where it starts.
    keep_limits : bool
        Make stops of the limits of joints; else they are left out.
    strict : bool
        Refuse what has no counterpart or is not known, instead of leaving it out.
    density : float, optional
        In kg/m³: links of URDF without mass get that of their collision shapes; omitted: they are frames.

    Returns
    -------
    Imported
        A `lienumba.System` with `notes` on what was left out, and a `summary`.

    Raises
    ------
    ScenarioError
        Where the file cannot be read, or is no robot that could move; each problem is a sentence.
    """
    from lienumba.importing.mapping.convert import convert, named
    from lienumba.importing.reading import read

    loaded = read(path, base=base, density=density)
    more: dict[str, Any] = {"notes": loaded.notes, "massless": loaded.massless}
    return convert(
        loaded.model, qpos=qpos, keyframe=keyframe, keep_limits=keep_limits, strict=strict,
        title=named(loaded.model) or Path(path).stem, origin=loaded.source, licence=loaded.licence, **more,
    )  # fmt: skip


def _of(kind: str, path: str | Path, options: dict[str, Any]) -> Imported:
    found = from_file(path, **options)
    if not found.origin.startswith(kind):
        raise ScenarioError(f"{path}: is {found.origin.split()[0]}, not {kind}; use from_file, which takes both")
    return found


def from_urdf(path: str | Path, **options: Any) -> Imported:
    """A robot of a URDF file as a scenario.

    Parameters
    ----------
    path : path
        The file.
    **options
        Those of `from_file`.

    Returns
    -------
    Imported
        A `lienumba.System`.

    Raises
    ------
    ScenarioError
        Where the file is of another format, or for what `from_file` refuses.
    """
    return _of("URDF", path, options)


def from_mjcf(path: str | Path, **options: Any) -> Imported:
    """A mechanism of an MJCF file as a scenario.

    Parameters
    ----------
    path : path
        The file.
    **options
        Those of `from_file`.

    Returns
    -------
    Imported
        A `lienumba.System`.

    Raises
    ------
    ScenarioError
        Where the file is of another format, or for what `from_file` refuses.
    """
    return _of("MJCF", path, options)


def from_mujoco(
    model: "mujoco.MjModel",
    *,
    title: str = "",
    qpos: Sequence[float] | None = None,
    keyframe: str | None = None,
    keep_limits: bool = False,
    strict: bool = False,
) -> Imported:
    """A compiled model of MuJoCo as a scenario.

    Parameters
    ----------
    model : mujoco.MjModel
        As MuJoCo has compiled it.
    title : str
        What the scenario is called; omitted: the name of the model.
    qpos, keyframe, keep_limits, strict
        As for `from_file`.

    Returns
    -------
    Imported
        A `lienumba.System`.
    """
    from lienumba.importing.mapping.convert import convert, named

    title = title or named(model) or "imported"
    return convert(
        model, qpos=qpos, keyframe=keyframe, keep_limits=keep_limits, strict=strict, title=title,
        origin=f"the MuJoCo model {title}",
    )  # fmt: skip
