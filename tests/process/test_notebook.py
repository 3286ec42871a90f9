"""In a notebook, with a real kernel: Systems and datasets show themselves, progress is a line, interrupts are told."""

import re
from pathlib import Path

import pytest

from tests.process.kernel import Kernel
from tests.rigs.places import ROOT, SCENARIOS

SETUP = f"""
import sys, threading
sys.path.insert(0, {str(ROOT)!r})
import lienumba
LONG = {{"sweep.runs": 4000, "integrator.step": 2e-6, "integrator.end_time": 0.4, "output.every": 0.1}}
TOP = {str(SCENARIOS / "heavy_top_monte_carlo.toml")!r}
"""


@pytest.fixture(scope="module")
def kernel(tmp_path_factory):
    kernel = Kernel(tmp_path_factory.mktemp("notebook"))
    assert kernel.run(SETUP).error == ""
    yield kernel
    kernel.close()


def test_a_system_shows_itself(kernel):
    cell = kernel.run("lienumba.System.from_toml(TOP)")
    (shown,) = cell.outputs
    assert "top (mass 15)" in shown["text/plain"]
    assert "<td" in shown["text/html"]
    assert "1,000 runs" in shown["text/html"]


def test_a_dataset_shows_itself_and_a_short_run_nothing_else(kernel):
    kernel.run("lienumba.run(TOP, overrides={'sweep.runs': 3})")  # is compiled then
    cell = kernel.run("lienumba.run(TOP, overrides={'sweep.runs': 3})")
    (shown,) = cell.outputs
    assert cell.streams == ""
    assert "xarray.Dataset" in shown["text/html"]
    attributes = shown["text/plain"].partition("Attributes:")[2].splitlines()
    assert "title:" in attributes[2]
    assert attributes[-1].split(":")[0].strip() == "scenario"


def running(cell):
    return any("simulating" in shown["text/plain"] and " 0/" not in shown["text/plain"] for shown in cell.outputs)


def test_progress_is_one_line_that_is_replaced_and_an_interrupt_ends_it(kernel):
    cell = kernel.run("lienumba.run(TOP, overrides=LONG)", interrupt_when=running)
    (line,) = cell.outputs
    assert cell.updates > 1
    assert re.fullmatch(r"[\d,]+ of 4,000 runs, 0 failed, \d+ s", line["text/plain"])
    assert "<progress" not in line["text/html"]
    assert cell.streams == ""
    assert cell.error.startswith("Interrupted: interrupted: no run is kept; name an output, so that")
    left = kernel.run("print([thread.name for thread in threading.enumerate() if 'Pool' in thread.name])")
    assert left.streams == "[]\n"


def test_the_next_cell_works(kernel):
    cell = kernel.run("print(int((lienumba.run(TOP, overrides={'sweep.runs': 5}).status == 0).sum()))")
    assert cell.streams == "5\n"
    assert cell.error == ""


def test_runs_on_the_disk_are_kept_and_gone_on_with(kernel):
    start = "lienumba.run(TOP, output='top.nc', overrides=LONG{})"

    def kept(cell):
        return running(cell) and bool(list(folder.glob("top.nc.runs/run-*.npy")))

    folder = Path(kernel.run("import os; print(os.getcwd())").streams.strip())
    cell = kernel.run(start.format(""), interrupt_when=kept)
    assert cell.error.startswith("Interrupted: interrupted: ")
    assert "of 4000 runs are kept in top.nc.runs; go on with resume=True" in cell.error
    done = int(cell.error.split("interrupted: ")[1].split()[0])
    assert done > 0
    code = "told = []\nds = lienumba.run(TOP, output='top.nc', overrides=LONG, resume=True, runs=[0, 3999], "
    seen = "progress=lambda event: event.stage == 'prepare' or told.append(event.done))"
    cell = kernel.run(f"{code}{seen}\nprint(told[0], ds.sizes['run'])")
    first, runs = map(int, cell.streams.split())
    assert first == done
    assert runs in (done, done + 1, done + 2)


@pytest.mark.release
def test_no_ipywidgets_are_needed(kernel):
    assert kernel.run("print('ipywidgets' in sys.modules)").streams == "False\n"
