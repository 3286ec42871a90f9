"""What the examples of some pages say is so, beyond that they run."""

import re
from itertools import zip_longest
from pathlib import Path

import pytest

import lienumba
from lienumba.engine.runner import check_initial
from lienumba.keys.units import factors
from lienumba.mechanics.system.joint_coordinates import JOINT_COORDINATES
from lienumba.mechanics.system.output_variables import OUTPUT_VARIABLES
from lienumba.store.layout import VARIABLES, course
from tests.documents.pages import ROOT, blocks
from tests.documents.player import COMMANDS
from tests.facade import JOINTS, METHODS, resolve

SYMBOLS = {"m", "kg", "s", "rad", "N", "J"}


def files(page: str) -> dict[str, str]:
    """The files that stand on a page."""
    found = blocks((ROOT / "docs" / page).read_text(encoding="utf-8"))
    return {block.name: block.text for block in found if block.name}


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    for name, text in (files("your_own_laws.md") | files("studies.md")).items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    return tmp_path


def test_the_motion_is_as_known(folder):
    found = lienumba.run(folder / "known.toml")
    assert (found["position_error"] < 1e-5).all()
    order = lienumba.analysis.orders(found)["order"].sel(error="position")
    assert float(order) == pytest.approx(4.0, abs=0.2)


@pytest.mark.parametrize(
    ("function", "more"),
    [
        ("rope", {"bodies": ["ground", "b"], "parameters": {"stiffness": 10, "length": 0.5}}),
        ("well", {"bodies": ["b"], "parameters": {"depth": 3}, "returns": "potential"}),
    ],
)
def test_laws_of_forces_work(folder, function, more, monkeypatch):
    monkeypatch.chdir(folder)
    force = {"name": "law", "type": "python", "function": f"arm.py:{function}", **more}
    check_initial(resolve(scenario(forces=[force])))


@pytest.mark.parametrize(
    ("function", "more"),
    [("on_a_sphere", {"parameters": {"radius": 1.0}}), ("skate", {"level": "velocity"})],
)
def test_laws_of_joints_work(folder, function, more, monkeypatch):
    monkeypatch.chdir(folder)
    joint = {"name": "law", "type": "python", "function": f"arm.py:{function}", "bodies": ["b"], **more}
    check_initial(resolve(scenario(joints=[joint])))


def scenario(**model):
    body = {"name": "b", "mass": 1.0, "inertia": [1.0, 1.0, 1.0], "position": [1.0, 0.0, 0.0], "rotation": [1, 0, 0, 0]}
    return {"model": {"bodies": [body], **model}, "integrator": {"step": 1e-3, "end_time": 0.1}}


def joint_rows() -> list[tuple[list[str], int, str, str]]:
    """Types of joints that say the same of themselves, how many equations they have, and what they say."""
    rows: dict[str, list[str]] = {}
    for name, kind in JOINTS.items():
        assert kind.leaves, f"{name} does not say what it leaves free"
        rows.setdefault(kind.leaves, []).append(name)
    kinds = {leaves: JOINTS[names[0]] for leaves, names in rows.items()}
    return [(names, len(kinds[leaves].row_kinds), kinds[leaves].words, leaves) for leaves, names in rows.items()]


def test_the_readme_has_every_joint() -> None:
    every = [(", ".join(f"`{name}`" for name in names), rows, words) for names, rows, words, _ in joint_rows() if rows]
    cells = [f"{names} | {rows} | {words}" for names, rows, words in every]
    half = (len(cells) + 1) // 2
    lines = [f"| {left} | {right} |" for left, right in zip_longest(cells[:half], cells[half:], fillvalue=" | | ")]
    table = ["| joint | equations | | joint | equations | |", "|---|---|---|---|---|---|", *lines]
    assert "\n".join(table) in (ROOT / "README.md").read_text(encoding="utf-8")


def test_the_template_has_every_joint() -> None:
    lines = [f"#     {', '.join(names):<22}{rows or '':>3}  {leaves}" for names, rows, _, leaves in joint_rows()]
    table = ["#     type                 rows  leaves free", *lines]
    assert "\n".join(table) in (ROOT / "scenarios" / "template.toml").read_text(encoding="utf-8")


def test_every_method_stands_beside_its_order() -> None:
    page = (ROOT / "docs" / "choose_a_method.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| (\d) \| (`.*?) \|", page, re.MULTILINE)
    assert {name: int(order) for order, names in rows for name in re.findall(r"`(\w+)`", names)} == {
        name: tableau.order for name, tableau in METHODS.items()
    }


def test_every_command_is_listed() -> None:
    page = (ROOT / "docs" / "commands.md").read_text(encoding="utf-8")
    assert [name for name in COMMANDS.commands if f"\nlienumba {name}" not in page] == []


def test_every_variable_is_in_the_table() -> None:
    page = (ROOT / "docs" / "read_the_dataset.md").read_text(encoding="utf-8")
    assert [name for name in VARIABLES if f"`{name}`" not in page] == []
    rows = re.findall(r"^\| ((?:`\w+`(?:, )?)+) \| ([\w, ]+) \| (.*) \|$", page, re.MULTILINE)
    described = {name: (dims, text) for names, dims, text in rows for name in re.findall(r"`(\w+)`", names)}
    every = VARIABLES | {name: course(x) for name, x in JOINT_COORDINATES.items()}
    assert described.keys() >= {*OUTPUT_VARIABLES, *JOINT_COORDINATES}
    assert [name for name, (dims, _) in described.items() if dims != ", ".join(every[name].dims)] == []
    for names, _, text in rows:
        said = [x for x in re.split(r"[,;] ", text) if {symbol for symbol, _ in factors(x) or [(x, 1)]} <= SYMBOLS]
        specs = dict.fromkeys(every[name].units for name in re.findall(r"`(\w+)`", names))
        assert said == [x for x in specs if x != "1"] or [*specs] == ["1"], names
