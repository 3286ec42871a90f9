"""Ctrl-C and a request to terminate: what was computed is kept, and told; --resume goes on with it."""

import signal
import time
from pathlib import Path

import pytest

import lienumba
from lienumba.scenario.base import toml
from tests.process.programs import PATIENCE, started
from tests.rigs.disturbed import assert_same_data, sweep


@pytest.mark.parametrize("sent", [signal.SIGINT, signal.SIGTERM], ids=["interrupt", "terminate"])
def test_what_is_computed_is_kept(sent: signal.Signals, tmp_path: Path) -> None:
    data = sweep(3000, end=0.4, every=0.1)
    data["integrator"]["step"] = 2e-5  # some seconds of two cores
    (tmp_path / "top.toml").write_text(toml.dumps(data))
    folder = tmp_path / "top.nc.runs"
    with started("run", "top.toml", folder=tmp_path) as process:
        deadline = time.monotonic() + PATIENCE
        while not list(folder.glob("run-*.npy")):
            assert process.poll() is None, "it ended before anything was safe"
            assert time.monotonic() < deadline
            time.sleep(0.01)
        process.send_signal(sent)
        _, errors = process.communicate(timeout=PATIENCE)
    assert process.returncode == 130
    assert f"of 3000 runs are kept in {folder.name}; go on with --resume" in errors
    assert "Traceback" not in errors
    assert not (tmp_path / "top.nc").exists()
    assert [path.name for path in tmp_path.glob("*.partial")] == []
    kept = int(errors.split("interrupted: ")[1].split()[0])
    assert 0 < kept < 3000
    few = {"sweep.runs": 3000, "integrator.step": 2e-5}
    told: list[int] = []
    with lienumba.run(
        data, overrides=few, output=tmp_path / "top.nc", resume=True, runs=[0, 2999],
        progress=lambda event: event.stage == "prepare" or told.append(event.done),
    ) as resumed:  # fmt: skip
        assert told[0] == kept
        assert resumed.sizes["run"] in (kept, kept + 1, kept + 2)
        again = lienumba.run(data, runs=[0, 2999])
        assert_same_data(resumed.sel(run=[0, 2999]), again)
