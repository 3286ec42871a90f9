"""What is built has all sources, and runs where it is installed: as for users, without a compiler."""

import os
import re
import shutil
import subprocess
import sys
import tarfile
import tomllib
import zipfile
from pathlib import Path
from typing import Any

import pytest
import yaml

import lienumba
from tests.documents.pages import blocks
from tests.rigs.places import ROOT, SCENARIOS

PYTHONS = ("3.11", "3.12", "3.13", "3.14")
BESIDE = ("pyproject.toml", "README.md", "LICENSE")
ASSETS = {"motion.js", "template.html"}
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
BUILD = "import sys; from setuptools import build_meta; print(getattr(build_meta, sys.argv[1])(sys.argv[2]))"
CONDA_NAMES = {"isal": "python-isal"}


def ran(command: list[Any], **how: Any) -> str:
    done = subprocess.run([str(x) for x in command], capture_output=True, text=True, **how)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def sources() -> set[str]:
    """The files of the package in the repository."""
    command = ["git", "ls-files", "-z", "lienumba"]
    return {
        *subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True).stdout.strip("\0").split("\0")
    }


def build(kind: str, source: Path, target: Path) -> Path:
    return target / ran([sys.executable, "-c", BUILD, f"build_{kind}", target], cwd=source).splitlines()[-1]


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """An sdist, and the wheel that is built from it, as `python -m build` makes them."""
    pytest.importorskip("setuptools", minversion="77")
    folder = tmp_path_factory.mktemp("built")
    for name in (*sources(), *BESIDE):
        (folder / "source" / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(ROOT / name, folder / "source" / name)
    sdist = build("sdist", folder / "source", folder)
    with tarfile.open(sdist) as file:
        file.extractall(folder / "unpacked", filter="data")
    return {"sdist": sdist, "wheel": build("wheel", folder / "unpacked" / sdist.name.removesuffix(".tar.gz"), folder)}


def names_in(file: Path) -> set[str]:
    if file.suffix == ".whl":
        with zipfile.ZipFile(file) as wheel:
            return set(wheel.namelist())
    with tarfile.open(file) as sdist:
        return {name.partition("/")[2] for name in sdist.getnames()}


@pytest.mark.parametrize("kind", ["wheel", "sdist"])
def test_what_is_built_has_all_sources(kind: str, built: dict[str, Path]) -> None:
    """Functions are read from their files when they are traced; a report has assets; types are for others, too."""
    names = names_in(built[kind])
    assert names >= sources()
    assert "lienumba/py.typed" in names
    assert {name.rpartition("/")[2] for name in names if "/assets/" in name} == ASSETS
    assert not any(name.startswith(("tests/", "scripts/")) for name in names_in(built["wheel"]))


def python_of(version: str) -> str:
    """An interpreter of this version: this one, one on the path, or one of pyenv's, which is on it and may not run."""
    pyenv = Path(os.environ.get("PYENV_ROOT", Path.home() / ".pyenv"))
    own = [sys.executable] if "{}.{}".format(*sys.version_info) == version else []
    for found in (*own, shutil.which(f"python{version}"), *pyenv.glob(f"versions/{version}.*/bin/python")):
        if found and subprocess.run([found, "-c", "import venv"], capture_output=True).returncode == 0:
            return str(found)
    pytest.skip(f"there is no Python {version} here")


@pytest.mark.release
@pytest.mark.parametrize("version", PYTHONS)
def test_it_runs_where_it_is_installed(version: str, built: dict[str, Path], tmp_path: Path) -> None:
    """In an environment of its own, of wheels alone: the README's ten lines, a run, a report."""
    ran([python_of(version), "-m", "venv", tmp_path / "own"])
    own = tmp_path / "own" / "bin"
    outside = {"PYTHONPATH": "", "PATH": str(own), "CC": "no-compiler", "LIENUMBA_CACHE_DIR": str(tmp_path / "cache")}
    how = {"cwd": tmp_path, "env": os.environ | outside}
    pip = [own / "python", "-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--no-compile"]
    if subprocess.run([*pip, "--dry-run", "typer"], capture_output=True, **how).returncode:
        pytest.skip("there is no package index here")
    ran([*pip, "--only-binary", ":all:", f"{built['wheel']}[report]"], **how)
    shutil.copytree(SCENARIOS, tmp_path / "scenarios")

    (lines,) = (x for x in blocks((ROOT / "README.md").read_text(encoding="utf-8")) if "import lienumba" in x.text)
    assert ran([own / "python", "-c", lines.text], **how).split() == str(lines.output).split()
    ran([own / "lienumba", "run", "scenarios/heavy_top.toml"], **how)
    ran([own / "lienumba", "report", "heavy_top.nc"], **how)
    assert "<html" in (tmp_path / "heavy_top.html").read_text(encoding="utf-8")
    assert str(own.parent) in ran([own / "python", "-c", "import lienumba; print(lienumba.__file__)"], **how)


def name_of(requirement: str) -> tuple[str, str]:
    """A requirement's name and versions, without what it depends on."""
    name, versions = re.fullmatch(r"([\w.-]+) ?([^;]*?) *(?:;.*)?", requirement.lower()).groups()  # type: ignore[union-attr]
    return name, versions


def test_conda_needs_the_same() -> None:
    recipe = yaml.safe_load((ROOT / "packaging" / "conda" / "recipe.yaml").read_text(encoding="utf-8"))
    wanted = {name_of(x) for x in PROJECT["project"]["dependencies"]}
    wanted = {(CONDA_NAMES.get(name, name), versions) for name, versions in wanted}
    wanted.add(("python", PROJECT["project"]["requires-python"]))
    assert {name_of(x) for x in recipe["requirements"]["run"]} == wanted
    assert recipe["context"]["version"] == lienumba.__version__


def test_groups_of_developers_are_the_extra_dev() -> None:
    groups = PROJECT["dependency-groups"]
    parts = [x["include-group"] for x in groups["dev"]]
    assert sorted(parts) == sorted(set(groups) - {"dev"})
    assert sorted(x for part in parts for x in groups[part]) == sorted(
        PROJECT["project"]["optional-dependencies"]["dev"]
    )
