"""Small robots, as text."""

from pathlib import Path

ROD = '<inertial><origin xyz="0.2 0 0"/><mass value="2"/><inertia ixx="0.01" iyy="0.08" izz="0.08"/></inertial>'


def link(name: str, inside: str = ROD) -> str:
    """A link of URDF, by itself a rod of 2 kg."""
    return f'<link name="{name}">{inside}</link>\n'


def joint(name: str, parent: str, child: str, inside: str = '<axis xyz="0 0 1"/>', type: str = "continuous") -> str:
    """A joint of URDF, by itself a hinge about z."""
    return f'<joint name="{name}" type="{type}"><parent link="{parent}"/><child link="{child}"/>{inside}</joint>\n'


def urdf(folder: Path, *parts: str, name: str = "robot.urdf") -> Path:
    """The file of a robot of these parts, of which the first stands on line 2."""
    file = folder / name
    file.write_text('<robot name="r">\n' + "".join(parts) + "</robot>\n")
    return file


def mjcf(folder: Path, inside: str, name: str = "robot.xml") -> Path:
    """A file of MJCF with these elements, of which the first stands on line 2."""
    file = folder / name
    file.write_text(f"<mujoco>\n{inside}\n</mujoco>\n")
    return file
