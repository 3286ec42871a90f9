"""What of a report lies beside its code goes along when lienumba is installed."""

import subprocess
import sys
import tarfile
import zipfile
from pathlib import Path
from shutil import copytree

import pytest

ROOT = Path(__file__).parents[2]
ASSETS = {path.relative_to(ROOT).as_posix() for path in (ROOT / "lienumba" / "reporting" / "assets").iterdir()}
BUILD = (
    "import sys; from setuptools import build_meta as b; print(b.build_wheel(sys.argv[1]), b.build_sdist(sys.argv[1]))"
)


def test_wheel_and_source_have_the_assets(tmp_path):
    pytest.importorskip("setuptools", minversion="77")
    source = tmp_path / "source"
    copytree(ROOT / "lienumba", source / "lienumba")
    for name in ("pyproject.toml", "README.md", "LICENSE"):
        (source / name).write_bytes((ROOT / name).read_bytes())
    done = subprocess.run(
        [sys.executable, "-c", BUILD, str(tmp_path)], cwd=source, capture_output=True, text=True, check=True
    )
    wheel, sdist = done.stdout.split()[-2:]
    with zipfile.ZipFile(tmp_path / wheel) as file:
        assert set(file.namelist()) >= ASSETS
    with tarfile.open(tmp_path / sdist) as file:
        assert {name.partition("/")[2] for name in file.getnames()} >= ASSETS
    assert len(ASSETS) >= 7
