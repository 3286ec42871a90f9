"""The command that makes scenarios of robots: what it writes, what it says, what it refuses."""

import struct

import numpy as np
import pytest

import lienumba as engine
from lienumba.scenario.base.toml import value_text
from tests.cli.test_commands import lienumba

ARM = """<!-- Copyright somebody, BSD -->
<robot name="arm">
  <link name="base"/>
  <link name="upper"><inertial><origin xyz="0 0 0.2"/><mass value="2"/>
    <inertia ixx="0.02" iyy="0.02" izz="0.001" ixy="0" ixz="0" iyz="0"/></inertial>
    <visual><geometry><mesh filename="wedge.stl"/></geometry></visual></link>
  <joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/><axis xyz="0 1 0"/>
    <limit lower="-2" upper="2" effort="30" velocity="5"/><dynamics damping="0.2"/></joint>
</robot>
"""
BALL = """<mujoco model="ball"><worldbody><body name="b"><joint name="hip" type="ball" stiffness="3"/>
<geom size="0.1" pos="0 0 0.3"/></body></worldbody><keyframe><key name="home" qpos="0 1 0 0"/></keyframe></mujoco>
"""


@pytest.fixture
def arm(tmp_path):
    corners = np.array([[[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 0, 0], [0, 1, 0], [0, 0, 1]]], float)
    facets = b"".join(struct.pack("<12fH", 0, 0, 1, *triangle.ravel(), 0) for triangle in corners)
    facets += struct.pack("<12fH", 0, 0, 1, *[0, 0, 1, 1, 0, 0, 0, 0, 0], 0)
    facets += struct.pack("<12fH", 0, 0, 1, *[0, 0, 1, 0, 1, 0, 1, 0, 0], 0)
    (tmp_path / "wedge.stl").write_bytes(b" " * 80 + struct.pack("<I", 4) + facets)
    (tmp_path / "arm.urdf").write_text(ARM)
    return tmp_path / "arm.urdf"


@pytest.fixture
def ball(tmp_path):
    (tmp_path / "ball.xml").write_text(BALL)
    return tmp_path / "ball.xml"


def test_a_scenario_is_written_with_its_meshes_and_runs(arm):
    target = arm.with_suffix(".toml")
    result = lienumba("import", arm, "-o", target)
    assert (result.exit_code, result.stderr) == (0, "")
    assert result.stdout.splitlines() == [
        "URDF arm.urdf: 1 body, 1 joint, 1 input",
        '- limit of velocity: kept by a robot\'s own controller, left out: joint "shoulder"',
        '- limits of joints are left out; --keep-limits makes stops of them: joint "shoulder"',
        f"wrote {target}; try: lienumba validate {target}",
    ]
    text = target.read_text()
    assert text.startswith("# Made of URDF arm.urdf.\n#\n")
    assert "# The source says of itself:\n# Copyright somebody, BSD\n" in text
    assert '# - limits of joints are left out; --keep-limits makes stops of them: joint "shoulder"\n' in text
    assert [file.name for file in (arm.parent / "arm_meshes").iterdir()] == ["wedge.stl"]
    ds = engine.run(target, overrides={"inputs.shoulder": 50.0, "integrator.end_time": 0.01})
    torque, inertia = 30.0, 0.02 + 2 * 0.2**2  # the motor's limit
    assert ds["angular_velocity"].values[0, -1, 0, 1] == pytest.approx(torque / inertia * 0.01, rel=0.02)


def test_without_a_file_the_text_alone_goes_to_standard_output(arm):
    result = lienumba("import", arm)
    assert result.exit_code == 0
    assert result.stdout.startswith("# Made of URDF arm.urdf.\n")
    assert result.stderr.startswith("URDF arm.urdf: 1 body")


def test_a_scenario_is_replaced_on_request_only(arm):
    target = arm.with_suffix(".toml")
    target.write_text("mine")
    result = lienumba("import", arm, "-o", target)
    assert result.exit_code == 2
    assert (
        result.stderr
        == f"error: output = {target}: exists already; choose another name, or replace it with --overwrite\n"
    )
    assert target.read_text() == "mine"
    assert lienumba("import", arm, "-o", target, "--overwrite").exit_code == 0


def test_limits_become_stops_on_request(arm):
    text = lienumba("import", arm, "--keep-limits").stdout
    assert 'type = "end_stop"\njoint = "shoulder"\nlower = -2\nupper = 2\n' in text


def test_the_base_floats_on_request(arm):
    heavy = '<inertial><mass value="5"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>'
    arm.write_text(ARM.replace('"base"/>', f'"base">{heavy}</link>', 1))
    text = lienumba("import", arm, "--base", "free").stdout
    assert 'name = "upper"' in text
    assert "ground" not in text


def test_a_start_is_a_keyframe_or_coordinates(ball):
    quaternion = [0, 1, 0, 0]
    assert f"rotation = {value_text(quaternion)}\n" in lienumba("import", ball, "--keyframe", "home").stdout
    assert f"rotation = {value_text(quaternion)}\n" in lienumba("import", ball, "--qpos", "0 2 0 0").stdout


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--keyframe", "hom"], 'keyframe = "hom": is not in the model; the nearest known name is "home"'),
        (
            ["--qpos", "1 0"],
            'qpos = [1.0, 0.0]: must be 4 finite numbers, as MuJoCo\'s qpos has them; give 4 of "hip"',
        ),
        (["--qpos", "1 x"], '--qpos 1 x: are not all numbers; give them such as "0 0.5 -1"'),
        (
            ["--strict"],
            'joint "hip": MJCF ball.xml: the stiffness of ball joints is left out; '
            "import it without --strict, or take it out",
        ),
    ],
)
def test_what_cannot_be_is_one_sentence(ball, options, message):
    result = lienumba("import", ball, *options)
    assert (result.exit_code, result.stdout) == (2, "")
    assert result.stderr == f"error: {message}\n"
