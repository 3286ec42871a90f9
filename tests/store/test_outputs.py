"""Writing under real faults: a full disk, a killed process, folders that cannot be written."""

import errno
import os
import signal
import subprocess
import sys
import textwrap
import threading
import time
from pathlib import Path

import pytest
import xarray as xr

from lienumba.store import outputs
from lienumba.store.outputs import WriteError, write
from lienumba.store.targets import claimed_dataset
from tests.rigs.places import ROOT
from tests.store.store_example import example

IS_ROOT = os.geteuid() == 0
NOBODY = 65534


def python(code: str, *arguments: object) -> subprocess.Popen[str]:
    """Run `code`, which may use `example`, in a process of its own."""
    return subprocess.Popen(
        [sys.executable, "-c", textwrap.dedent(code), *map(str, arguments)],
        env=os.environ | {"PYTHONPATH": str(ROOT)},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


FULL_DISK = """
    import os, resource, sys
    from lienumba.store.outputs import WriteError, write
    from tests.store.store_example import example

    folder, limit = sys.argv[1], int(sys.argv[2])
    write(example(runs=2), f"{folder}/out.nc")
    before = open(f"{folder}/out.nc", "rb").read()
    if limit:
        resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))
    for _ in range(3):
        free = os.statvfs(folder).f_bavail
        try:
            write(example(runs=200), f"{folder}/out.nc")
        except WriteError as error:
            print(error)
        assert os.listdir(folder) == ["out.nc"], os.listdir(folder)
        assert open(f"{folder}/out.nc", "rb").read() == before
        assert abs(os.statvfs(folder).f_bavail - free) < 200 or limit, "the failed file still takes room"
    write(example(runs=3), f"{folder}/other.nc")  # the library is still usable
    import xarray
    xarray.testing.assert_identical(xarray.load_dataset(f"{folder}/other.nc"), example(runs=3))
"""


def check_full_disk(folder, limit, reason):
    process = python(FULL_DISK, folder, limit)
    out, err = process.communicate()
    assert process.returncode == 0, err
    lines = out.splitlines()
    assert len(lines) == 3
    assert all(line.startswith(f"output = {folder}/out.nc: could not be written ({reason}): ") for line in lines)


def test_a_file_size_limit_leaves_the_old_file(tmp_path):
    check_full_disk(tmp_path, 1_000_000, "File too large")


def test_a_full_disk_leaves_the_old_file(small_disk):
    check_full_disk(small_disk, 0, "No space left on device")


WRITE_FOR_EVER = """
    import sys
    from lienumba.store.outputs import write
    from tests.store.store_example import example

    big = example(runs=600)
    print("ready", flush=True)
    while True:
        write(big, sys.argv[1])
"""


def wait_for_partial_file(folder, process):
    deadline = time.monotonic() + 60
    while not list(folder.glob("*.partial")):
        assert process.poll() is None, process.stderr.read()
        assert time.monotonic() < deadline, "no *.partial file was ever seen"
        time.sleep(0.001)


@pytest.mark.parametrize("wait", [0.0, 0.1])
def test_a_killed_process_leaves_the_old_file_whole(tmp_path, wait):
    path = tmp_path / "out.nc"
    old = example(seed=1)
    write(old, path)
    process = python(WRITE_FOR_EVER, path)
    try:
        assert process.stdout.readline() == "ready\n"
        wait_for_partial_file(tmp_path, process)
        time.sleep(wait)
        assert list(tmp_path.glob("*.partial"))
    finally:
        os.kill(process.pid, signal.SIGKILL)
        process.communicate()
    assert all(entry.name == "out.nc" or entry.suffix in (".partial", ".lock") for entry in tmp_path.iterdir())
    xr.testing.assert_identical(xr.load_dataset(path), old)
    with claimed_dataset(path, overwrite=True) as output:
        write(old, output)
    assert [entry.name for entry in tmp_path.iterdir()] == ["out.nc"]


def test_a_killed_process_leaves_no_file_where_there_was_none(tmp_path):
    process = python(WRITE_FOR_EVER, tmp_path / "out.nc")
    try:
        wait_for_partial_file(tmp_path, process)
    finally:
        os.kill(process.pid, signal.SIGKILL)
        process.communicate()
    assert not (tmp_path / "out.nc").exists()


@pytest.mark.parametrize("call", ["replace", "fsync"])
def test_a_failing_system_call_leaves_the_old_file(tmp_path, monkeypatch, call):
    path = tmp_path / "out.nc"
    write(example(seed=1), path)

    def fail(*_):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(outputs.os, call, fail)
    with pytest.raises(WriteError, match=r"No space left on device.*make room"):
        write(example(seed=2), path)
    monkeypatch.undo()
    assert [entry.name for entry in tmp_path.iterdir()] == ["out.nc"]
    xr.testing.assert_identical(xr.load_dataset(path), example(seed=1))


def test_data_reach_the_disk_before_the_name(tmp_path, monkeypatch):
    order = []
    fsync, replace, link = os.fsync, os.replace, os.link
    monkeypatch.setattr(outputs.os, "fsync", lambda handle: (order.append("fsync"), fsync(handle)))
    monkeypatch.setattr(outputs.os, "replace", lambda *names: (order.append("replace"), replace(*names)))
    monkeypatch.setattr(outputs.os, "link", lambda *names: (order.append("link"), link(*names)))
    write(example(), tmp_path / "out.nc")
    assert order == ["fsync", "link", "fsync"]
    order.clear()
    write(example(), tmp_path / "out.nc")
    assert order == ["fsync", "replace", "fsync"]


def test_an_interrupt_removes_the_partial_file(tmp_path, monkeypatch):
    def interrupted(self, path, **_):
        Path(path).write_bytes(b"half")
        raise KeyboardInterrupt

    monkeypatch.setattr(xr.Dataset, "to_netcdf", interrupted)
    with pytest.raises(KeyboardInterrupt):
        write(example(), tmp_path / "out.nc")
    assert not list(tmp_path.iterdir())


def test_a_vanished_folder_is_named(tmp_path):
    with pytest.raises(WriteError, match="gone"):
        write(example(), tmp_path / "gone" / "out.nc")


def test_only_one_thread_at_a_time_touches_netcdf(tmp_path):
    code = """
        import sys, threading
        from lienumba.store.outputs import write
        from tests.store.store_example import example

        data = example(runs=20)
        def work(k):
            for i in range(4):
                write(data, f"{sys.argv[1]}/{k}-{i}.nc")
        threads = [threading.Thread(target=work, args=(k,)) for k in range(4)]
        for thread in threads: thread.start()
        for thread in threads: thread.join()
    """
    process = python(code, tmp_path)
    _, err = process.communicate()
    assert (process.returncode, err) == (0, "")
    names = sorted(entry.name for entry in tmp_path.iterdir())
    assert names == sorted(f"{k}-{i}.nc" for k in range(4) for i in range(4))
    xr.testing.assert_identical(xr.load_dataset(tmp_path / "3-3.nc"), example(runs=20))


def test_a_link_is_followed(tmp_path):
    (tmp_path / "elsewhere").mkdir()
    link = tmp_path / "out.nc"
    link.symlink_to(tmp_path / "elsewhere" / "real.nc")
    with claimed_dataset(link, overwrite=False) as output:
        write(example(), output)
    assert link.is_symlink()
    assert (tmp_path / "elsewhere" / "real.nc").is_file()


def test_the_new_file_has_the_usual_permissions(tmp_path):
    (tmp_path / "usual").touch()
    write(example(), tmp_path / "out.nc")
    assert (tmp_path / "out.nc").stat().st_mode == (tmp_path / "usual").stat().st_mode


def test_the_lock_is_free_after_a_failure(tmp_path, monkeypatch):
    monkeypatch.setattr(xr.Dataset, "to_netcdf", lambda *_, **__: (_ for _ in ()).throw(RuntimeError("HDF error")))
    with pytest.raises(WriteError, match="HDF error"):
        write(example(), tmp_path / "out.nc")
    monkeypatch.undo()
    thread = threading.Thread(target=write, args=(example(), tmp_path / "out.nc"))
    thread.start()
    thread.join(timeout=60)
    assert (tmp_path / "out.nc").exists()
