"""What Python code of a scenario is the user's own, and that none of anybody else runs without the user's word."""

import os
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

import lienumba
from tests.facade import ScenarioError, app, resolve

LAW = 'from pathlib import Path\nPath("ran").write_text("x")\ndef push(ball):\n    return ball.force([0, 0, 1])\n'
BALL = """\
[model]
bodies = [{ name = "ball", mass = 1, inertia = [1, 1, 1] }]
forces = [{ name = "push", type = "python", bodies = ["ball"], function = "%s" }]
[integrator]
step = 0.01
end_time = 0.01
"""
INSIDE = BALL % "a.py:push" + f'[files]\n"a.py" = """\n{LAW}"""\n'


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "own").mkdir()
    monkeypatch.chdir(tmp_path)
    return tmp_path / "own"


def told(command: str, path: Path, *options: str) -> Any:
    return CliRunner().invoke(app, [command, str(path), *options])


@pytest.mark.parametrize("command", ["validate", "info", "sample", "run"])
def test_code_inside_of_a_scenario_waits_for_the_users_word(folder: Path, command: str) -> None:
    path = folder / "case.toml"
    path.write_text(INSIDE)
    result = told(command, path)
    assert result.exit_code == 2
    assert result.stderr == (
        f"error: {path}: brings Python code in itself, a.py; nothing of it was run; read it, and if you trust it, give "
        "--allow-code\n"
    )
    assert sorted(Path().rglob("*")) == [Path("own"), Path("own/case.toml")]
    if command == "validate":
        assert told(command, path, "--allow-code").exit_code == 0
        assert Path("ran").exists()


def test_code_of_what_a_scenario_extends(folder: Path) -> None:
    (folder / "base.toml").write_text(INSIDE)
    (folder / "case.toml").write_text('extends = "base.toml"\n')
    for load in (resolve, lienumba.System.from_toml, lienumba.prepare, lienumba.run):
        with pytest.raises(ScenarioError, match=r'extends = "base.toml": .*brings Python code in itself, a'):
            load(folder / "case.toml")  # type: ignore[operator]
    assert not Path("ran").exists()
    assert resolve(folder / "case.toml", allow_code=True).data.files.keys() == {"a.py"}
    assert lienumba.run(folder / "case.toml", allow_code=True).status.item() == 0


@pytest.mark.parametrize("name", ["a.py", "laws/a.py", "./a.py"])
def test_a_file_beside_or_below_is_the_users_own(folder: Path, name: str) -> None:
    (folder / "laws").mkdir()
    (folder / name).write_text(LAW)
    (folder / "case.toml").write_text(BALL % f"{name}:push")
    assert resolve(folder / "case.toml").data.files == {"a.py": LAW}
    assert told("validate", folder / "case.toml").exit_code == 0


@pytest.mark.parametrize("linked", [False, True])
def test_a_file_elsewhere_is_not(folder: Path, linked: bool) -> None:
    (folder.parent / "a.py").write_text(LAW)
    name = "b.py" if linked else "../a.py"
    if linked:
        (folder / name).symlink_to("../a.py")
    (folder / "case.toml").write_text(BALL % f"{name}:push")
    with pytest.raises(ScenarioError, match=r"case.toml: names Python code outside its folder: .*; nothing of it was"):
        resolve(folder / "case.toml")
    assert resolve(folder / "case.toml", allow_code=True).data.files.keys() == {name.rpartition("/")[2]}


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() != 0, reason="needs root to give files away")
def test_another_users_file_is_not(folder: Path) -> None:
    (folder / "a.py").write_text(LAW)
    (folder / "case.toml").write_text(BALL % "a.py:push")
    assert resolve(folder / "case.toml")
    os.chown(folder / "a.py", 12345, 12345)
    with pytest.raises(ScenarioError, match=r"case.toml: names Python code that is another user's: a.py; nothing of"):
        resolve(folder / "case.toml")


def test_what_python_hands_over_is_its_own() -> None:
    def push(ball: Any) -> Any:
        return ball.force([0, 0, 1])

    system = lienumba.System("x").body("ball", mass=1, inertia=[1, 1, 1])
    system.force("push", type="python", bodies=["ball"], function=push).integrator(step=0.01, end_time=0.01)
    assert resolve(system).data.files.keys() == {"push.py"}
    assert resolve(system.to_dict()).data.files.keys() == {"push.py"}


@pytest.mark.parametrize("line", ["sys.exit(3)", "raise SystemExit", "exit()"])
def test_a_law_that_ends_the_program(folder: Path, line: str) -> None:
    for text in (f"import sys\ndef push(ball):\n    {line}\n", f"import sys\n{line}\ndef push(ball):\n    pass\n"):
        (folder / "a.py").write_text(text)
        (folder / "case.toml").write_text(BALL % "a.py:push")
        result = told("validate", folder / "case.toml")
        assert result.exit_code == 2
        assert "SystemExit" in result.stderr
        assert "correct it" in result.stderr
