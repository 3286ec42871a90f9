"""Programs on disk: later processes do not trace, and whatever decides about a program is part of its entry's name."""

import hashlib
import os
import shutil
import subprocess
import sys
from collections.abc import Iterator
from importlib import import_module, invalidate_caches, reload
from pathlib import Path
from typing import Any

import pytest
import xarray as xr

import lienumba
from lienumba.compiler import cache, flat, native
from lienumba.integrators.tracing import compiled, program, step_kernels
from lienumba.integrators.tracing.compiled import PROGRAMS
from lienumba.keys.registry import Registry
from lienumba.mechanics.elements import joints
from lienumba.mechanics.system.output_variables import OUTPUT_VARIABLES, OutputVariable
from tests.facade import JOINTS

SCENARIOS = Path(lienumba.__file__).resolve().parents[1] / "scenarios"
FIND, KEEP = compiled.find, compiled.keep  # which the other tests are without
TOP: dict[str, Any] = {
    "model": {
        "bodies": [{"name": "top", "mass": 1.5, "inertia": [0.23, 0.46, 0.24], "position": [0.2, 1, 0]}],
        "joints": [{"name": "pivot", "type": "spherical", "bodies": ["ground", "top"],
                    "points": [[0, 0, 0], [-0.2, -1, 0]]}],
    },
    "integrator": {"step": 0.01, "end_time": 0.05},
}  # fmt: skip

RUN = """
import hashlib, sys
import lienumba
from lienumba.integrators.tracing import program

traced = []
build = program.build
program.build = lambda *arguments: traced.append(1) or build(*arguments)
ds = lienumba.run(sys.argv[1], overrides={"integrator.end_time": 0.02, "output.every": 0.01})
print(len(traced), hashlib.sha256(ds.position.values.tobytes() + ds.energy.values.tobytes()).hexdigest())
"""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """Programs are kept in a folder of the test's own; drivers are not."""
    for driver in ("fixed_step", "variable_step"):
        import_module(f"lienumba.integrators.drivers.{driver}")
    monkeypatch.setenv("LIENUMBA_CACHE_DIR", str(tmp_path / "cache"))
    monkeypatch.setattr(compiled, "find", FIND)
    monkeypatch.setattr(compiled, "keep", KEEP)
    cache.folder.cache_clear()
    PROGRAMS.clear()
    yield cache.folder()
    cache.folder.cache_clear()
    PROGRAMS.clear()


@pytest.fixture
def traced(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Grows by one with every program that is traced."""
    found: list[int] = []
    build = program.build

    def counted(*arguments: Any) -> Any:
        found.append(1)
        return build(*arguments)

    monkeypatch.setattr(program, "build", counted)
    return found


def run(scenario: Any = TOP, **settings: Any) -> xr.Dataset:
    """As a process that knows nothing yet."""
    PROGRAMS.clear()
    return lienumba.run(scenario, overrides=settings, progress=False)


def digest(ds: xr.Dataset) -> dict[str, str]:
    values = {str(name): ds[name].values.tobytes() for name in ds.variables if name not in ("run_seconds", "wall_time")}
    return {name: hashlib.sha256(content).hexdigest() for name, content in values.items()}


# ---------------------------------------------------------------- without tracing
def start(folder: Path) -> subprocess.Popen[str]:
    settings = {"LIENUMBA_CACHE_DIR": str(folder), "PYTHONDONTWRITEBYTECODE": "1"}
    command = [sys.executable, "-c", RUN, str(SCENARIOS / "heavy_top.toml")]
    return subprocess.Popen(command, env=os.environ | settings, stdout=subprocess.PIPE, text=True)


def said(process: subprocess.Popen[str]) -> tuple[int, str]:
    out, _ = process.communicate()
    assert process.returncode == 0
    count, of_values = out.split()
    return int(count), of_values


def test_the_second_process_traces_nothing_and_two_at_once_do_each_other_no_harm(tmp_path: Path) -> None:
    lienumba.run(TOP)  # the driver is there
    name = cache.name_of(flat.key_of("lienumba.integrators.drivers.fixed_step.drive"))
    (tmp_path / cache.folder().name).mkdir()
    shutil.copy(cache.folder() / name, tmp_path / cache.folder().name / name)
    both = [start(tmp_path), start(tmp_path)]
    first, second = map(said, both)
    third = said(start(tmp_path))
    assert first[1] == second[1] == third[1]
    assert first[0] + second[0] >= 1
    assert third[0] == 0


EVENT = {
    "quantities": [{"name": "point", "type": "point", "body": "top", "point": [0, 0, 0]}],
    "events": [{"name": "below", "when": "point.z < -0.01"}],
    "integrator": {"tolerance": 1e-6, "end_time": 0.2},
}
CASES: dict[str, tuple[Any, dict[str, Any]]] = {  # with all that an outline can hold
    "loops that select their rows": (SCENARIOS / "four_bar.toml", {"integrator.end_time": 0.05}),
    "tolerance and events": (TOP | EVENT, {}),
    "states of laws": (SCENARIOS / "arm_sampled.toml", {"integrator.end_time": 0.1, "output": {"every": 0.1}}),
    "counted angles": (SCENARIOS / "screw_press.toml", {"integrator.end_time": 0.1}),
}


@pytest.mark.parametrize("name", CASES)
def test_what_is_loaded_has_the_bits_of_what_is_traced(folder: Path, traced: list[int], name: str) -> None:
    scenario, settings = CASES[name]
    before = digest(run(scenario, **settings))
    count = len(traced)
    assert count
    assert len(list(folder.glob("*.program"))) == count
    assert digest(run(scenario, **settings)) == before
    assert len(traced) == count


# ---------------------------------------------------------------- what decides
def test_other_sources_another_cpu_and_other_limits_miss(
    folder: Path, traced: list[int], monkeypatch: pytest.MonkeyPatch
) -> None:
    run()
    for count, (where, name, value) in enumerate(
        (
            (compiled, "sources", lambda: "others"),
            (native, "cpu", lambda: ("generic", "")),
            (step_kernels, "INLINE", 0),
        ),
        2,
    ):
        with monkeypatch.context() as patch:
            patch.setattr(where, name, value)
            for _ in range(2):
                run()
                assert len(traced) == count


@pytest.mark.parametrize("edited", ["mechanics/system/kkt.py", "compiler/emit.py", "numerics/jets.py", "words.py"])
def test_an_edit_of_a_source_is_seen(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, edited: str) -> None:
    shutil.copytree(cache.PACKAGE, tmp_path / "lienumba", ignore=shutil.ignore_patterns("__pycache__", "*.js"))
    before = compiled.sources.__wrapped__()
    monkeypatch.setattr(cache, "PACKAGE", tmp_path / "lienumba")
    assert compiled.sources.__wrapped__() == before
    with open(tmp_path / "lienumba" / edited, "a") as file:
        file.write("\n")
    assert compiled.sources.__wrapped__() != before


def test_all_that_tracing_imports_is_among_its_sources() -> None:
    script = "import sys; import lienumba.integrators.tracing.compiled; print(*sys.modules)"
    out = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True).stdout
    known = {name.removesuffix(".py").replace("/", ".") for name in compiled.TRACING}
    modules = {name.removeprefix("lienumba.") for name in out.split() if name.startswith("lienumba.")}
    assert {name for name in modules if name.split(".")[0] not in known} == set()


def test_every_registry_that_tracing_may_read_is_known() -> None:
    import lienumba.integrators.tracing.compiled as room

    modules = [m for name, m in sys.modules.items() if name.startswith(("lienumba.mechanics", "lienumba.integrators"))]
    found = {x.what for m in (*modules, room) for x in vars(m).values() if isinstance(x, Registry)}
    assert found == {x.what for x in compiled.REGISTRIES}


def test_elements_of_ones_own_are_not_kept(folder: Path, traced: list[int]) -> None:
    """Nothing tells whether their sources have changed."""
    double = OutputVariable("double", "m", "twice", rows=lambda seen: [2.0 * body[0] for body in seen.now.bodies[:1]])
    with OUTPUT_VARIABLES.temporarily(double):
        for count in (1, 2):
            run()
            assert len(traced) == count
    assert not list(folder.glob("*.program"))
    run()
    assert len(traced) == 3
    assert JOINTS is joints.JOINTS


LAW = """from lienumba.laws import sin
import own_helper

GAIN = {gain}

class Shape:
    def value(self, t):
        return {method}

def push(body, *, t):
    return body.force((GAIN * own_helper.wave(t), Shape().value(t), 0.0))
"""
HELPER = """from lienumba.laws import cos
from lienumba.numerics.jets import Jet

def wave(t):
    return {jets} if isinstance(t, Jet) else cos(t)
"""


def test_a_law_is_known_by_all_that_it_calls_and_reads(
    folder: Path, traced: list[int], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Also by what does not show on symbols alone."""
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    monkeypatch.syspath_prepend(str(elsewhere))
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    push = {"name": "push", "type": "python", "function": f"{tmp_path / 'law.py'}:push", "bodies": ["top"]}
    data = {**TOP, "model": {**TOP["model"], "forces": [push]}}
    changes: list[dict[str, str]] = [{}, {"gain": "3.0"}, {"method": "sin(2.0*t)"}, {"jets": "2.0*t"}]
    for count, change in enumerate(changes, 1):
        said = {"gain": "2.0", "method": "sin(t)", "jets": "t"} | change
        (tmp_path / "law.py").write_text(LAW.format(**said))
        (elsewhere / "own_helper.py").write_text(HELPER.format(**said))
        invalidate_caches()
        reload(import_module("own_helper"))
        for _ in range(2):
            run(data)
            assert len(traced) == count
    del sys.modules["own_helper"]


# ---------------------------------------------------------------- damage
def torn(content: bytes) -> list[bytes | None]:
    """Ways in which an entry is not whole; None: it is gone."""
    return [None, b"", content[:40], content[:-1], content[:50] + bytes([content[50] ^ 4]) + content[51:]]


def test_damaged_entries_are_ignored_and_written_again(folder: Path, traced: list[int]) -> None:
    before = digest(run())
    (entry,) = folder.glob("*.program")
    objects = sorted(folder.glob("*.o"))
    count = 1
    for path in (entry, objects[0], objects[-1]):
        whole = path.read_bytes()
        for content in torn(whole):
            path.unlink() if content is None else path.write_bytes(content)
            assert digest(run()) == before
            count += 1
            assert len(traced) == count
            assert path.read_bytes() == whole
            run()
            assert len(traced) == count


@pytest.mark.parametrize("content", [b"{}", b"[]", b"nothing", b'{"outline": {}, "kernels": {}, "work_rows": 3}'])
def test_what_is_no_program_is_not_taken_for_one(folder: Path, traced: list[int], content: bytes) -> None:
    before = digest(run())
    (entry,) = folder.glob("*.program")
    cache.keep(entry.name, content)
    assert digest(run()) == before
    assert len(traced) == 2
