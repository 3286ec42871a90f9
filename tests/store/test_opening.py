"""Files that HDF5 does not come back from end with a sentence, and so does what comes behind them."""

import struct
import subprocess
import sys
import threading
from pathlib import Path

import netCDF4
import pytest

from lienumba.store import opening
from tests.facade import ScenarioError

LIMIT = "import sys\nfrom lienumba.store import opening\nopening.PATIENCE = 0.3\n"
CALLS = {  # what opens a file of somebody else
    "a command": "from lienumba.cli import main\nsys.argv = ['lienumba', 'info', damaged]\nmain()",
    "Python": """
import lienumba
top = lienumba.System("top").body("b", mass=1, inertia=[1, 1, 1]).integrator(step=1e-2, end_time=1e-2)
for act in (
    lambda: lienumba.report(damaged, damaged + ".html"),
    lambda: lienumba.replay(sound, run=0),
    lambda: lienumba.run(top, output=damaged + ".new", progress=False),
):
    try:
        act()
    except lienumba.ScenarioError as error:
        print(f"error: {error}")
sys.exit(7)
""",
    "a table": """
import lienumba
top = lienumba.System("top").body("b", mass="wind(t)", inertia=[1, 1, 1])
try:
    lienumba.run(top.table("wind", file=damaged, time="time", value="name").integrator(step=1e-2, end_time=1e-2))
except lienumba.ScenarioError as error:
    print(f"error: {error}")
sys.exit(7)
""",
}


def holed(source: Path, target: Path) -> None:
    """A file with the size of what is free in each of its global heaps set to 0: 8 bytes, as a lost sector leaves them.

    HDF5 file format, III.E: a heap has a head of 16 bytes, then objects: index 0 for what is free, and its size.
    """
    content = bytearray(source.read_bytes())
    heap = content.find(b"GCOL")
    while heap >= 0:
        at = heap + 16
        while (index := struct.unpack_from("<H", content, at)[0]) != 0:
            assert index < 1000
            at += 16 + -(-struct.unpack_from("<Q", content, at + 8)[0] // 8) * 8
        content[at + 8 : at + 16] = bytes(8)
        heap = content.find(b"GCOL", at)
    target.write_bytes(content)


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    folder = tmp_path_factory.mktemp("files")
    sound, damaged = folder / "sound.nc", folder / "damaged.nc"
    with netCDF4.Dataset(sound, "w") as file:
        file.title = "of texts: µ"  # which HDF5 puts into a heap
        file.createDimension("time", 2)
        file.createVariable("time", "f8", ("time",))[:] = [0, 1]
        file.createVariable("name", str, ("time",))[0] = "x"
    holed(sound, damaged)
    return {"sound": str(sound), "damaged": str(damaged)}


@pytest.mark.parametrize("call", CALLS)
def test_what_hdf5_does_not_come_back_from_is_told(files: dict[str, str], call: str) -> None:
    program = LIMIT + "".join(f"{name} = {path!r}\n" for name, path in files.items()) + CALLS[call]
    ended = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=120)
    first, *others = [line for line in (ended.stdout + ended.stderr).splitlines() if line]
    assert first == (
        f"error: {files['damaged']}: cannot be opened, HDF5 has been at it for 0.3 s of computing, as where a file is "
        "damaged; make it again, or give it as it was"
    )
    busy = f"HDF5 is still at work on {files['damaged']}, which is probably damaged"
    remedy = "leave that file out, in a new process"
    assert others == [
        f"error: {what}: {busy}; {remedy}"
        for what in ((files["sound"], f"output = {files['damaged']}.new") if call == "Python" else ())
    ]
    assert ended.returncode == (2 if call == "a command" else 7)  # and does not crash as it ends


def test_what_comes_back_late_is_no_obstacle(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(opening, "_end_without_hdf5", lambda: None)
    monkeypatch.setattr(opening, "PATIENCE", 0.0)
    free = threading.Event()
    with pytest.raises(ScenarioError, match=r"^slow.nc: cannot be opened, HDF5 has been at it for 0 s of computing"):
        opening.opened(Path("slow.nc"), lambda: free.wait(60))
    with pytest.raises(ScenarioError, match=r"^next.nc: HDF5 is still at work on slow.nc"):
        opening.opened(Path("next.nc"), lambda: 1)
    free.set()
    [(thread, _)] = opening._away
    thread.join(60)
    monkeypatch.setattr(opening, "PATIENCE", 60.0)
    assert opening.opened(Path("next.nc"), lambda: 1) == 1


def test_errors_come_through() -> None:
    with pytest.raises(FileNotFoundError):
        opening.netcdf_file("nowhere.nc")


def test_a_slow_disk_is_waited_for(monkeypatch: pytest.MonkeyPatch) -> None:
    """What computes nothing is not in a loop."""
    monkeypatch.setattr(opening, "PATIENCE", 0.2)
    monkeypatch.setattr(opening.time, "process_time", lambda: 0.0)
    assert opening.opened(Path("far.nc"), lambda: threading.Event().wait(0.5)) is False
