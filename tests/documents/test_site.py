"""The documents as a site, and the notebooks in it."""

import json
import re
import subprocess
from pathlib import Path

import nbformat
import pytest
from nbclient import NotebookClient

from tests.documents.pages import ROOT

NOTEBOOKS = sorted((ROOT / "docs" / "notebooks").glob("*.ipynb"))
pytestmark = pytest.mark.release


def test_the_site_is_made_without_a_warning_and_can_be_searched(tmp_path: Path) -> None:
    made = subprocess.run(
        ["scripts/site", tmp_path, "-D", "nb_execution_mode=off"], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert made.returncode == 0, made.stderr
    index = (tmp_path / "searchindex.js").read_text(encoding="utf-8")
    words = json.loads(re.fullmatch(r"Search\.setIndex\((.*)\);?\s*", index, re.DOTALL)[1])["terms"]
    assert {"friction", "urdf", "clopper", "pearson", "stiff"} <= words.keys()
    assert (tmp_path / "docs" / "notebooks" / "verdict.html").exists()


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_notebooks_run(path: Path) -> None:
    notebook = nbformat.read(path, as_version=4)
    assert not any(cell.get("outputs") for cell in notebook.cells)  # which would grow old
    notebook.metadata.kernelspec.name = "python3"
    NotebookClient(notebook, timeout=120, resources={"metadata": {"path": path.parent}}).execute()
