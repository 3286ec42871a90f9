"""The house: imports point downwards only, files stay short, the mathematics is documented. Read from the source."""

import ast
import functools
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from lienumba.compiler import cache

PACKAGE = Path(__file__).parents[1] / "lienumba"
FILES = sorted(PACKAGE.rglob("*.py"))
TESTS = Path(__file__).parent
APART = {"oracles", "documents", "process"}  # tests of the whole: other ways to the numbers, pages, processes
GROUND_FLOOR = {"errors", "words"}  # may be imported from anywhere
FLOORS = [
    {"numerics"},
    {"groups"},
    {"keys"},
    {"laws"},
    {"compiler"},
    {"mechanics"},
    {"integrators"},
    {"kernels"},
    {"batch"},
    {"reference"},
    {"sweep"},
    {"store"},
    {"scenario"},
    {"importing"},
    {"engine"},
    {"analysis"},
    {"scene"},
    {"figures"},
    {"present"},
    {"cli"},
    {"__init__", "__main__"},
]
INSIDE = {  # the floors of rooms, lowest first
    "mechanics": [{"mechanism", "tolerances"}, {"elements"}, {"system"}, {"tree"}, {"start"}],
    "sweep": [
        {"confidence", "normal"}, {"weighted"}, {"copula", "verdicts"}, {"distributions"},
        {"samplers", "table"}, {"design"}, {"noise"},
    ],
    "store": [
        {"deflate", "layout", "opening", "provenance"}, {"refusals"}, {"linear_layout", "study_layout", "windows"},
        {"form"}, {"files", "names"}, {"outputs"}, {"columns", "finished", "targets"}, {"stream"}, {"shards"},
    ],
    "scenario": [
        {"base", "meshes", "study_errors"}, {"schema"}, {"formulas"}, {"reading"}, {"checks"},
        {"resolve", "study_points"}, {"start"}, {"html_repr", "system"},
    ],
    "importing": [
        {"notes"}, {"base", "imported", "markup", "mujoco_words"}, {"mapping"}, {"mjcf", "urdf"}, {"reading"},
    ],
    "engine": [
        {"chunk_sizes", "compare_runs", "fields", "part", "progress", "requirements", "select_run"},
        {"programs"}, {"sensitivities"}, {"results"}, {"reference"}, {"simulate", "stopping"},
        {"calibration", "kernels", "linear"}, {"quality"},
        {"cluster", "disk", "replay", "study"},
        {"runner", "prepared"}, {"budget", "checks", "rare"},
    ],
    "reference": [
        {"compiling", "mechanism"}, {"rotations"}, {"coordinates", "table"}, {"dynamics"}, {"step"}, {"integrate"},
    ],
    "integrators": [
        {"bounds", "codes", "hysteresis", "selection_table", "sizes"}, {"layout"}, {"methods"}, {"drivers"},
        {"tracing"},
    ],
    "cli": [{"commands", "options"}, {"budget", "checking", "importing", "linear", "rare", "running", "showing"}],
    "analysis": [
        {"changed", "text_table", "weights"}, {"labels", "outcomes"},
        {"mode_runs", "summary", "summary_rows", "summary_text"},
        {"sensitivities", "statistics", "studies"},
        {"requirements"}, {"by_run", "comparison", "folder_index", "mode_rows", "panels"},
    ],
}  # fmt: skip
HEAVY = {"numba", "llvmlite", "xarray", "netCDF4", "h5py", "scipy", "matplotlib"}  # NumPy: `validate` needs it anyway
HELP = [  # what `--help` and `import lienumba` load: not even NumPy
    "__init__.py", "__main__.py", "cli", "engine/__init__.py", "engine/progress.py", "errors.py", "present/__init__.py",
    "present/terminal/__init__.py", "present/terminal/console.py", "words.py",
]  # fmt: skip
VALIDATE = ["groups", "keys", "mechanics", "numerics", "scenario", "sweep/distributions"]
LONGEST = 500  # lines of a file
MOST = 17  # modules of a folder
MOST_ANY = 0.05  # of parameters may be or hold anything
BY_NAME = ("import_module", "__import__")


@functools.cache
def parsed(path: Path) -> ast.Module:
    """The syntax tree of a file, read once."""
    return ast.parse(path.read_text())


def floor(name: str) -> int:
    """The height of a module or package directly below lienumba."""
    for height, names in enumerate(FLOORS):
        if name in names:
            return height
    raise AssertionError(f"lienumba/{name} stands on no floor: add it to FLOORS, where design section 3 wants it")


def part(path: Path) -> str:
    """The name directly below lienumba that a file belongs to."""
    return path.relative_to(PACKAGE).with_suffix("").parts[0]


@functools.cache
def file_of(module: str) -> Path | None:
    """The file of a module or package of ours."""
    path = PACKAGE.joinpath(*module.split(".")[1:])
    found = [file for file in (path.with_suffix(".py"), path / "__init__.py") if file.exists()]
    return found[0] if found and module.startswith("lienumba.") else None


def imports(tree: ast.AST, path: Path) -> list[tuple[int, str]]:
    """(line, absolute module) of every import, those inside functions and `if` blocks included."""
    found: list[tuple[int, str]] = []
    package = ["lienumba", *path.relative_to(PACKAGE).parent.parts]
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            found += [(node.lineno, alias.name) for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            base = package[: len(package) - node.level + 1] if node.level else []
            module = ".".join([*base, *([node.module] if node.module else [])])
            for alias in node.names:
                deeper = f"{module}.{alias.name}"  # from lienumba.integrators import codes
                found.append((node.lineno, deeper if module == "lienumba" or file_of(deeper) else module))
        elif isinstance(node, ast.Call) and getattr(node.func, "attr", getattr(node.func, "id", "")) in BY_NAME:
            names = [a.value for a in node.args if isinstance(a, ast.Constant)]
            found += [(node.lineno, name) for name in names if isinstance(name, str)]
    return found


@functools.cache
def target(module: str) -> str | None:
    """The name directly below lienumba that a module belongs to; None for other packages."""
    names = module.split(".")
    if names[0] != "lienumba":
        return None
    inside = len(names) > 1 and ((PACKAGE / names[1]).is_dir() or (PACKAGE / f"{names[1]}.py").exists())
    return names[1] if inside else "__init__"


def upward_imports(path: Path) -> Iterator[str]:
    """Imports of a file from its own floor or a higher one."""
    here = part(path)
    for line, module in [] if here in GROUND_FLOOR else imports(parsed(path), path):
        below = target(module)
        if below is None or below in GROUND_FLOOR | {here}:
            continue
        if below == "__init__" and here != "__init__":
            if module != "lienumba.__version__":
                yield f"{path}:{line} imports lienumba itself, from below"
        elif floor(below) >= floor(here):
            yield f"{path}:{line} imports {module}, which does not stand below {here}"


def test_imports_point_downwards_only():
    assert [fault for path in FILES for fault in upward_imports(path)] == []


def upward_imports_inside(room: str) -> Iterator[str]:
    """Imports of a room's files from a higher floor of the room, and modules that stand on none of its floors."""
    heights = {name: height for height, names in enumerate(INSIDE[room]) for name in names}
    modules = {p.stem for p in (PACKAGE / room).iterdir() if p.stem not in ("__init__", "__pycache__")}
    yield from (f"lienumba/{room}: {name} is a module or stands in INSIDE, not both" for name in modules ^ set(heights))
    for path in (PACKAGE / room).rglob("*.py"):
        here = path.relative_to(PACKAGE / room).with_suffix("").parts[0]
        for line, module in imports(parsed(path), path):
            inside = module.split(".")[2:] if module.startswith(f"lienumba.{room}.") else []
            if here == "__init__" or not inside or inside[0] == here or {here, inside[0]} - set(heights):
                continue
            if heights[inside[0]] > heights[here]:
                yield f"{path}:{line} imports {module}, which stands above it"


def test_imports_inside_a_room_point_downwards_only():
    assert [fault for room in INSIDE for fault in upward_imports_inside(room)] == []


def test_the_drivers_see_neither_mechanics_nor_the_tracer():
    """And what they see is what their cached machine code is known by, with what makes object code of text."""
    seen: set[Path] = set()
    places = ("integrators/drivers", "compiler/routines")
    found = [p for room in places for p in (PACKAGE / room).rglob("*.py")]
    found.append(PACKAGE / "compiler" / "flat.py")
    while found:
        path = found.pop()
        if path not in seen:
            seen.add(path)
            modules = [module for _, module in imports(parsed(path), path)]
            found += [file for module in modules if (file := file_of(module)) is not None]
    rooms = {path.relative_to(PACKAGE).parent.as_posix() for path in seen}
    within = {f"integrators/drivers/{room}" for room in ("events", "measuring", "switching")}
    assert rooms == {"numerics", "groups", "compiler", "integrators", *places, *within}
    assert seen == set(cache.seen())


def test_no_room_is_crowded():
    rooms = [room for room in [PACKAGE, *PACKAGE.rglob("*")] if room.is_dir() and room.name != "__pycache__"]
    crowded = {room: len(list(room.glob("*.py"))) - 1 for room in rooms if len(list(room.glob("*.py"))) > MOST + 1}
    assert crowded == {}


def test_tests_stand_in_the_mirror_of_the_tree():
    """Those of lienumba/a/b.py in tests/a/test_b.py or in the folder tests/a/b; those of a room in its folder."""
    for path in TESTS.rglob("test_*.py"):
        place = path.relative_to(TESTS)
        if place.parts[0] in APART or path == Path(__file__):
            continue
        mirrored = place.parent if len(place.parts) > 1 else Path(place.stem.removeprefix("test_"))
        known = (PACKAGE / mirrored).is_dir() or (PACKAGE / mirrored).with_suffix(".py").exists()
        assert known, f"{path}: there is no lienumba/{mirrored}, and it is in none of the folders {sorted(APART)}"


def test_the_ground_floor_imports_nothing_else_of_ours():
    for name in GROUND_FLOOR:
        path = PACKAGE / f"{name}.py"
        assert {target(m) for _, m in imports(parsed(path), path)} <= GROUND_FLOOR | {None}


def test_the_reader_of_imports_sees_them_all(tmp_path):
    source = (
        "import lienumba.batch.execute\n"
        "from lienumba import sweep\n"
        "from . import emit\n"
        "from ..store.files import write\n"
        "def f():\n    if x:\n        from lienumba.cli import main\n    importlib.import_module('lienumba.analysis')\n"
    )
    found = imports(ast.parse(source), PACKAGE / "compiler" / "x.py")
    assert [target(m) for _, m in sorted(found)] == ["batch", "sweep", "compiler", "store", "cli", "analysis"]


def test_the_documentation_lists_the_same_floors():
    page = (PACKAGE.parent / "docs" / "architecture.md").read_text(encoding="utf-8")
    section = page.partition("## Floors\n")[2].partition("\n## ")[0]
    rows = re.findall(r"^\| (`[^|]*`) \|", section, flags=re.MULTILINE)
    assert [set(re.findall(r"`(\w+)`", row)) for row in rows] == FLOORS


def test_no_file_is_long():
    too_long = [p for p in [*FILES, *TESTS.rglob("*.py")] if len(p.read_text().splitlines()) > LONGEST]
    assert too_long == []


def test_every_module_says_what_it_is():
    assert [path for path in FILES if not ast.get_docstring(parsed(path))] == []


def test_every_public_function_of_the_mathematics_is_documented():
    bare = [
        f"{path}:{node.lineno} {node.name}"
        for path in FILES
        if part(path) in ("groups", "mechanics")
        for node in parsed(path).body
        if isinstance(node, ast.FunctionDef) and not node.name.startswith("_") and not ast.get_docstring(node)
    ]
    assert bare == []


def heavy_imports(path: Path) -> Iterator[str]:
    """Imports of heavy modules at the top of a file that `--help` or `validate` loads."""
    name = str(path.relative_to(PACKAGE))
    light = [kind for kind in (HELP, VALIDATE) if any(name == x or name.startswith(f"{x}/") for x in kind)]
    late = (HEAVY | {"numpy"} if HELP in light else HEAVY) if light else set()
    top = ast.Module([n for n in parsed(path).body if isinstance(n, ast.Import | ast.ImportFrom)], [])
    for line, module in imports(top, path):
        if module.split(".")[0] in late:
            yield f"{path}:{line} imports {module} at its top: import it inside the functions that need it"


def test_what_help_and_validate_touch_imports_heavy_modules_late():
    assert [fault for path in FILES for fault in heavy_imports(path)] == []


@pytest.mark.parametrize("arguments", ["'--help'", "'run', '--help'", "'validate', 'scenarios/heavy_top.toml'"])
def test_commands_that_must_answer_at_once_load_nothing_heavy(arguments):
    code = (
        f"import sys\nfrom lienumba.cli import app\ntry: app([{arguments}])\n"
        "except SystemExit as end: assert not end.code\nprint(sorted(set(sys.modules) & set(sys.argv[1:])))"
    )
    late = HEAVY | ({"lienumba.batch.integrate"} if "validate" in arguments else {"numpy"})  # runs nothing
    done = subprocess.run(
        [sys.executable, "-c", code, *late], cwd=PACKAGE.parent, capture_output=True, text=True, check=True
    )
    assert done.stdout.splitlines()[-1] == "[]"


def test_any_is_rare():
    """Numbers that are floats, arrays, jets or symbols are a `Number`; what is raw is an `object` until it is known."""
    parameters = [x for path in FILES for x in annotated(parsed(path))]
    anything = [x for x in parameters if x is not None and re.search(r"\bAny\b", ast.unparse(x))]
    assert len(anything) <= MOST_ANY * len(parameters)


def annotated(tree: ast.AST) -> list[ast.expr | None]:
    """The annotation of every parameter but self and cls."""
    found = []
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef):
            a = node.args
            given = [*a.posonlyargs, *a.args, *a.kwonlyargs, *(x for x in (a.vararg, a.kwarg) if x is not None)]
            found += [x.annotation for x in given if x.arg not in ("self", "cls")]
    return found
