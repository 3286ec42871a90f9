"""What of a report lies beside its code goes along when lienumba is installed."""

import subprocess
import sys
import tarfile
import zipfile
from shutil import copytree

import pytest

from tests.rigs.places import ROOT

ASSETS = {path.relative_to(ROOT).as_posix() for path in (ROOT / "lienumba" / "present" / "html" / "assets").iterdir()}
BUILD = "import sys; from setuptools import build_meta; getattr(build_meta, sys.argv[1])(sys.argv[2])"


@pytest.mark.parametrize("kind", ["wheel", "sdist"])
def test_what_is_installed_has_the_assets(tmp_path, kind):
    pytest.importorskip("setuptools", minversion="77")
    source, target = tmp_path / "source", tmp_path / "built"
    copytree(ROOT / "lienumba", source / "lienumba")
    for name in ("pyproject.toml", "README.md", "LICENSE"):
        (source / name).write_bytes((ROOT / name).read_bytes())
    command = [sys.executable, "-c", BUILD, f"build_{kind}", str(target)]
    subprocess.run(command, cwd=source, capture_output=True, text=True, check=True)
    (built,) = target.iterdir()
    if kind == "wheel":
        with zipfile.ZipFile(built) as file:
            names = set(file.namelist())
    else:
        with tarfile.open(built) as file:
            names = {name.partition("/")[2] for name in file.getnames()}
    assert names >= ASSETS
    assert {name.rpartition("/")[2] for name in ASSETS} == {"motion.js", "template.html"}
