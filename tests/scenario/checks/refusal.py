"""A small mechanism as TOML, additions to it, and what the command line answers where they are wrong."""

from pathlib import Path

from typer.testing import CliRunner

from lienumba.engine.progress import STAGES
from tests.facade import app

RIG = """\
[model]

[[model.bodies]]
name = "arm"
mass = 2
inertia = [0.06, 0.06, 0.001]
position = [0, 0, -0.3]
rotation = [1, 0, 0, 0]

[[model.bodies]]
name = "block"
mass = 1
inertia = [0.01, 0.01, 0.01]
position = [1, 0, 0]
rotation = [1, 0, 0, 0]

[[model.joints]]
name = "pivot"
type = "revolute"
bodies = ["ground", "arm"]
points = [[0, 0, 0], [0, 0, 0.3]]
axes = [[0, 1, 0], [0, 1, 0]]

[[model.joints]]
name = "rail"
type = "prismatic"
bodies = ["ground", "block"]
points = [[0, 0, 0], [0, 0, 0]]
axes = [[1, 0, 0], [1, 0, 0]]

[integrator]
step = 1e-3
end_time = 0.01
"""
ARM, BLOCK = "position = [0, 0, -0.3]\nrotation = [1, 0, 0, 0]\n", "position = [1, 0, 0]\nrotation = [1, 0, 0, 0]\n"
PIVOT, RAIL = "axes = [[0, 1, 0], [0, 1, 0]]", "axes = [[1, 0, 0], [1, 0, 0]]"
REFERENCES = "references = [[1, 0, 0], [1, 0, 0]]"
FREE = '[[model.bodies]]\nname = "free"\nmass = 1\ninertia = [1, 1, 1]\n'
VARY = '[sweep]\nruns = 2\n[sweep.vary]\n"{}" = {{ distribution = "uniform", low = {}, high = 2 }}\n'


def rig(*tables: str, **changes: str) -> str:
    """The mechanism with further tables; changes: of ARM, BLOCK, PIVOT, RAIL, or of the line "model"."""
    text = RIG
    for name, new in changes.items():
        old = {"arm": ARM, "block": BLOCK, "pivot": PIVOT, "rail": RAIL, "model": "[model]\n"}[name]
        assert text.count(old) == 1
        text = text.replace(old, new)
    start, end = text.index("[integrator]"), len(text)
    sweeps = [table for table in tables if table.startswith("[sweep]")]
    others = [table for table in tables if not table.startswith("[sweep]")]
    return "\n".join([text[:start], *others, text[start:end], *sweeps])


def joint(*lines: str, name: str = "extra", ends: str = 'bodies = ["arm", "block"]') -> str:
    return "\n".join(["[[model.joints]]", f'name = "{name}"', ends, *lines]) + "\n"


def driver(*lines: str, name: str = 'name = "drive"') -> str:
    return "\n".join(["[[model.drivers]]", name, *lines]) + "\n"


def force(*lines: str, name: str = 'name = "push"') -> str:
    return "\n".join(["[[model.forces]]", name, *lines]) + "\n"


def refused(folder: Path, text: str, *options: str, output: str = "out.nc", command: str = "run") -> list[str]:
    """The message's lines of a run that must be refused and must leave nothing behind."""
    scenario = folder / "case.toml"
    scenario.write_text(text, encoding="utf-8")
    before = sorted(folder.rglob("*"))
    target = () if command == "validate" else ("-o", str(folder / output))
    result = CliRunner().invoke(app, [command, str(scenario), *target, *options])
    assert result.exit_code == 2, result.output
    assert sorted(folder.rglob("*")) == before
    lines = [line for line in result.stderr.splitlines() if line != STAGES["prepare"]]  # on a busy machine
    assert all(line.startswith(("error: ", "warning: ")) for line in lines)
    return [line.removeprefix("error: ") for line in lines if line.startswith("error: ")]


def refused_by_both(folder: Path, text: str) -> list[str]:
    """The message's lines, which `validate` and `run` must share."""
    lines = refused(folder, text)
    assert refused(folder, text, command="validate") == lines
    return lines


def check_refused(folder: Path, text: str, *wanted: str) -> None:
    """A whole sentence, which has a remedy behind "; ", is that of both commands; of others a place and words are."""
    whole = all("; " in x for x in wanted)
    lines = refused_by_both(folder, text) if whole else refused(folder, text, command="validate")
    assert len(lines) == len(wanted), lines
    for line, sentence in zip(lines, wanted, strict=True):
        place, _, words = sentence.partition(": ")
        assert line == sentence if whole else line.startswith((f"{place}:", f"{place} ")) and words in line, line


def accepted(folder: Path, text: str) -> list[str]:
    """The warnings of a scenario that is valid."""
    scenario = folder / "case.toml"
    scenario.write_text(text, encoding="utf-8")
    result = CliRunner().invoke(app, ["validate", str(scenario)])
    assert result.exit_code == 0, result.output
    return [line.removeprefix("warning: ") for line in result.stderr.splitlines()]
