"""Files that may be written, and what is said of others."""

import os
import subprocess
from pathlib import Path

import pytest

from lienumba.store.targets import check_target, claimed_dataset
from tests.facade import ScenarioError


def claim(path: object, overwrite: bool) -> None:
    """Own a dataset for a moment."""
    with claimed_dataset(path, overwrite):  # type: ignore[arg-type]
        pass


IS_ROOT = os.geteuid() == 0
NOBODY = 65534


def test_a_good_target_passes_and_leaves_nothing(tmp_path, monkeypatch):
    claim(tmp_path / "out.nc", overwrite=False)
    monkeypatch.chdir(tmp_path)
    claim("out.nc", overwrite=False)
    assert not list(tmp_path.iterdir())


def test_an_existing_file_needs_overwrite(tmp_path):
    path = tmp_path / "out.nc"
    path.write_bytes(b"\x89HDF old")
    with pytest.raises(ScenarioError, match=r"out\.nc: exists already; .*overwrite=True"):
        claim(path, overwrite=False)
    claim(path, overwrite=True)
    assert path.read_bytes() == b"\x89HDF old"


def test_only_datasets_are_overwritten(tmp_path):
    path = tmp_path / "scenario.toml"
    path.write_text("title = 'dear to me'")
    with pytest.raises(ScenarioError, match=r"scenario\.toml: is a file of another kind, .*; choose another name"):
        claim(path, overwrite=True)
    path.write_text("")
    claim(path, overwrite=True)


def test_missing_folders_and_wrong_kinds_are_named(tmp_path):
    (tmp_path / "file").touch()
    os.mkfifo(tmp_path / "pipe")
    cases = {
        tmp_path / "gone" / "out.nc": r"folder .*gone does not exist; create it",
        tmp_path / "file" / "out.nc": r"file is not a folder",
        tmp_path: r"is a folder; give the name of a file in it",
        tmp_path / "pipe": r"not a regular file",
        Path("/dev/null"): r"not a regular file",
    }
    for path, message in cases.items():
        with pytest.raises(ScenarioError, match=message) as caught:
            claim(path, overwrite=True)
        assert f"output = {path}: " in str(caught.value)


@pytest.mark.skipif(not Path("/proc/self").is_dir(), reason="needs a folder that not even root can write to")
def test_a_folder_that_not_even_root_can_write_to():
    with pytest.raises(ScenarioError, match=r"cannot be written to /proc \(.*\); .*another folder"):
        claim("/proc/out.nc", overwrite=False)


def test_a_folder_without_write_permission(tmp_path):
    folder = tmp_path / "shut"
    folder.mkdir()
    folder.chmod(0o555)
    os.chmod(tmp_path, 0o755)
    problems = []

    def check():
        try:
            claim(folder / "out.nc", overwrite=False)
        except ScenarioError as error:
            problems.append(str(error))

    if IS_ROOT:  # root may write anywhere: ask as somebody else
        parents = [parent for parent in folder.parents if parent.stat().st_mode & 0o001 == 0]
        modes = [parent.stat().st_mode for parent in parents]
        for parent in parents:
            parent.chmod(0o755)
        os.seteuid(NOBODY)
        try:
            check()
        finally:
            os.seteuid(0)
            for parent, mode in zip(parents, modes, strict=True):
                parent.chmod(mode)
    else:
        check()
    (message,) = problems
    for part in ("cannot be written", "Permission denied", "change its permissions"):
        assert part in message


def test_a_read_only_disk(tmp_path, small_disk):
    subprocess.run(["mount", "-o", "remount,ro", small_disk], check=True)
    with pytest.raises(ScenarioError, match="Read-only file system"):
        claim(small_disk / "out.nc", overwrite=False)


def test_names_say_what_a_file_is(tmp_path):
    check_target(tmp_path / "page.HTML", "page", (".html", ".htm"))
    with pytest.raises(ScenarioError) as refused:
        check_target("page.pdf", "page", (".html", ".htm"))
    assert str(refused.value) == "output = page.pdf: is no page; give a name that ends in .html or .htm"


def test_what_may_be_replaced(tmp_path):
    path = tmp_path / "table.csv"
    path.write_text("run,a\n0,1\n")
    check_target(path, "table")
    check_target(path, "table", replaceable=(b"run",))
    for arguments, sentence in (
        ({"existing": "delete it"}, f"output = {path}: exists already; delete it"),
        ({"replaceable": (b"CDF",)}, f"output = {path}: is a file of another kind, no table to be replaced; "
                                     "choose another name"),
    ):  # fmt: skip
        with pytest.raises(ScenarioError) as refused:
            check_target(path, "table", **arguments)
        assert str(refused.value) == sentence


def test_a_name_that_no_disk_takes_is_refused(tmp_path):
    with pytest.raises(ScenarioError, match=r"a\.nc: cannot be looked up \(File name too long\); choose another name"):
        check_target(tmp_path / ("a" * 300 + ".nc"), "dataset")
