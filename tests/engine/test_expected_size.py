"""How large a dataset will be is known before a sweep begins, and asked about where it is too large."""

import pytest
from typer.testing import CliRunner

import lienumba
from lienumba.engine.quality import expected_size
from lienumba.engine.quality.expected_size import expected_bytes
from lienumba.scenario.resolve import resolve
from tests.facade import app
from tests.rigs.places import SCENARIOS

TOP = SCENARIOS / "heavy_top_monte_carlo.toml"
FEW = {"sweep.runs": 40, "output.every": 0.05, "integrator.end_time": 0.5}


@pytest.mark.parametrize("mode", [{}, {"output.mode": "summary", "output.summary": {"energy": ["max"]}}])
def test_it_is_the_size_of_the_dataset(monkeypatch, mode):
    monkeypatch.setattr(expected_size, "SMALL", 0)
    ds = lienumba.run(TOP, overrides=FEW | mode)
    columns = sum(ds[name].nbytes for name in ds.data_vars)
    assert expected_bytes(resolve(TOP, overrides=FEW | mode), None) == pytest.approx(columns, rel=0.1)
    assert expected_bytes(resolve(TOP, overrides=FEW | mode), range(20)) == pytest.approx(columns / 2, rel=0.1)


def test_a_person_is_asked_and_a_script_warned(monkeypatch, tmp_path):
    monkeypatch.setattr(expected_size, "SMALL", 0)
    monkeypatch.setattr(expected_size, "LARGE", 1000)
    line = [
        "run",
        str(TOP),
        "-o",
        str(tmp_path / "out.nc"),
        "--runs",
        "0:4",
        *(f"--set={k}={v}" for k, v in FEW.items()),
    ]
    told = CliRunner().invoke(app, line)
    assert told.exit_code == 0
    assert "warning: output: the dataset has about 0 GB before compression; give a longer output.every" in told.stderr
    monkeypatch.setattr("lienumba.cli.running._answers", lambda: True)
    asked = CliRunner().invoke(app, [*line, "--overwrite"], input="n\n")
    assert asked.exit_code == 2
    assert "begin? [y/N]" in asked.stdout
    assert CliRunner().invoke(app, [*line, "--overwrite"], input="y\n").exit_code == 0
    assert "begin?" not in CliRunner().invoke(app, [*line, "--overwrite", "--yes"]).stdout
