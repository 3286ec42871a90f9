"""Broken files of robots: one sentence each, with file, line, element, value and remedy."""

import pytest

from lienumba.importing.reading import read
from tests.facade import ScenarioError
from tests.importing.robots import ROD, joint, link, mjcf, urdf


def inertial(mass="1", inertia='ixx="1" iyy="1" izz="1"'):
    return f'<inertial><mass value="{mass}"/><inertia {inertia}/></inertial>'


def arm(inside=ROD, of_joint='<axis xyz="0 0 1"/>', type="continuous"):
    """A base and one moving link."""
    return link("base", "") + joint("hinge", "base", "arm", of_joint, type) + link("arm", inside)


def said(file):
    with pytest.raises(ScenarioError) as caught:
        read(file)
    text = str(caught.value)
    assert "\n" not in text
    assert text.startswith(str(file))
    return text.removeprefix(str(file))


URDF = {
    "no robot": ("", " has no <link>; give a robot of at least one link"),
    "a robot of xacro": (
        arm() + "<xacro:hand/>",
        ", line 5: <xacro:hand>: belongs to xacro, and may stand for links and joints; expand the file by xacro first",
    ),
    "a link without name": (
        "<link/>", ', line 2: a <link>: has no name="..."; give it a name of its own'
    ),
    "two links of one name": (
        link("a") + link("a"), ', line 3: link "a": has the name of the link on line 2; rename one of them'
    ),
    "two joints of one name": (
        arm() + joint("hinge", "arm", "base"),
        ', line 5: joint "hinge": has the name of the joint on line 3; rename one of them',
    ),
    "an unknown parent": (
        arm() + joint("b", "arn", "base"),
        ', line 5: joint "b" <parent> link = "arn": is not the name of a link; the nearest known name is "arm"',
    ),
    "an unknown child": (
        arm() + joint("b", "arm", "hand"),
        ', line 5: joint "b" <child> link = "hand": is not the name of a link; known here are "base", "arm"',
    ),
    "no child": (
        arm() + '<joint name="b" type="fixed"><parent link="arm"/></joint>',
        ', line 5: joint "b": has no <child>; give <child link="..."/>',
    ),
    "an unknown type of joint": (
        arm(type="revolut"),
        ', line 3: joint "hinge" type = "revolut": is not a type of joint; the nearest known name is "revolute"',
    ),
    "two parents": (
        arm() + joint("b", "base", "arm"),
        ', line 5: link "arm": is the child of two joints, "hinge" and "b"; URDF knows trees only: leave one of them '
        "out, or write the robot in MJCF and close the loop there",
    ),
    "a loop": (
        arm() + joint("b", "q", "p") + joint("c", "p", "q") + link("p") + link("q"),
        ', line 5: links "p", "q": carry one another in a loop of joints; URDF knows trees only: one link has to be '
        "the child of no joint",
    ),
    "two roots": (
        arm() + link("stray"),
        ': links "base", "stray": 2 links are the child of no joint; join them, such as by fixed joints to a link '
        '"world"',
    ),
    "an axis of zero length": (
        arm(of_joint='<axis xyz="0 0 0"/>'),
        ', line 3: joint "hinge" <axis> xyz = "0 0 0": has no direction; give 3 numbers that are not all 0',
    ),
    "an axis of two numbers": (
        arm(of_joint='<axis xyz="0 1"/>'),
        ', line 3: joint "hinge" <axis> xyz = "0 1": must be 3 numbers, and is 2; give 3',
    ),
    "NaN": (
        arm(of_joint='<origin xyz="0 nan 0"/>'),
        ', line 3: joint "hinge" <origin> xyz = "0 nan 0": is not finite; give 3 numbers',
    ),
    "a word": (
        arm(inertial("two")), ', line 4: link "arm" <mass> value = "two": is not a number; give a number'
    ),
    "a formula of xacro": (
        arm(inertial("${m}")),
        ', line 4: link "arm" <mass> value = "${m}": is not a number; expand the file by xacro first',
    ),
    "a huge mass": (
        arm(inertial("1e300")),
        ', line 4: link "arm" <mass> value = "1e300": must be at most 1e+10 in SI units; check it',
    ),
    "a negative mass": (
        arm(inertial("-1")), ', line 4: link "arm" <mass> value = -1.0: must be at least 0; give the mass in kg'
    ),
    "an inertial without mass": (
        arm("<inertial/>"),
        ', line 4: link "arm" <inertial>: has no <mass>; give <mass value="..."/> in kg, or no <inertial> for a frame '
        "without mass",
    ),
    "an inertial without inertia": (
        arm('<inertial><mass value="2"/></inertial>'),
        ', line 4: link "arm" <inertial>: has a mass of 2 kg and no <inertia>; give it in kg m²',
    ),
    "an element of the inertia is missing": (
        arm(inertial(inertia='ixx="1" iyy="1"')), ', line 4: link "arm" <inertia>: has no izz="..."; give a number'
    ),
    "nothing that moves has mass": (
        arm(""),
        ', line 4: link "arm": moves by joint "hinge", and neither it nor what it carries has mass; give it an '
        "<inertial>, or make the joint fixed",
    ),
    "zero mass": (
        arm(inertial("0", 'ixx="0" iyy="0" izz="0"')),
        ', line 4: link "arm": moves by joint "hinge", and neither it nor what it carries has mass; give it an '
        "<inertial>, or make the joint fixed",
    ),
    "zero inertia": (
        arm(inertial("3", 'ixx="0" iyy="0" izz="0"')),
        ', line 4: link "arm": has a mass of 3 kg and moments of inertia of 0; give the <inertia> of a body of that '
        "size in kg m²",
    ),
    "an indefinite inertia": (
        arm(inertial("3", 'ixx="1" iyy="1" izz="1" ixy="2"')),
        ', line 4: link "arm": has principal moments of inertia -1, 1, 3 kg m², and all must be above 0; check the '
        "signs of <inertia>, and that it is about the mass centre",
    ),
    "inertia without mass": (
        arm(inertial("0")) + joint("b", "arm", "hand") + link("hand"),
        ', line 4: link "arm": has moments of inertia 1, 1, 1 kg m² and a mass of 0; give its mass, or no <inertial> '
        "for a frame without mass",
    ),
    "an unknown shape": (
        arm(ROD + "<visual><geometry><cone/></geometry></visual>"),
        ', line 4: link "arm" <cone>: is not a known shape; the nearest known name is "cylinder"',
    ),
    "a mimic of nothing": (
        arm(of_joint='<mimic joint="hings"/>'),
        ', line 3: joint "hinge" <mimic> joint = "hings": is not the name of a joint; the nearest known name is '
        '"hinge"',
    ),
    "mimics in a ring": (
        arm(of_joint='<mimic joint="b"/>') + joint("b", "arm", "hand", '<mimic joint="hinge"/>') + link("hand"),
        ', line 3: joint "hinge": mimics itself, by "b"; leave out the <mimic> of one of them',
    ),
    "negative damping": (
        arm(of_joint='<dynamics damping="-1"/>'),
        ', line 3: joint "hinge" <dynamics> damping = -1.0: must be at least 0; check its sign',
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", URDF)
def test_of_urdf(tmp_path, case):
    parts, sentence = URDF[case]
    assert said(urdf(tmp_path, parts)) == sentence


BALL = '<geom size="0.1"/>'


def body(inside):
    return f'<worldbody><body name="a">{inside}</body></worldbody>'


MJCF = {
    "no mass": (
        body('<joint name="j"/>'),
        ', line 2, element "a": moves, and has no mass, no inertia, or a negative one; give it an <inertial> or geoms '
        "with mass, or take away its joint",
    ),
    "a triangle": (
        body('<joint/><inertial mass="1" pos="0 0 0" diaginertia="1 1 3"/>'),
        ', line 2, element "a": one of its moments of inertia exceeds the sum of the others, as in no rigid body; '
        "check that they are about the mass centre",
    ),
    "NaN": (
        body(f'<joint axis="nan 0 0"/>{BALL}'), ', line 2: <joint> axis = "nan 0 0": is not finite; give numbers'
    ),
    "a huge mass": (
        body(f'<joint/><inertial mass="1e300" pos="0 0 0" diaginertia="1 1 1"/>{BALL}'),
        ': body "a" mass = 1e+300: must be at most 1e+10 in SI units; check it',
    ),
    "an unknown type of joint": (
        body(f'<joint type="hing"/>{BALL}'),
        ', line 2, element "joint": "hing" is not one of the words that may stand there; check its spelling',
    ),
    "an unknown element": (
        body(f"<joynt/>{BALL}"), ', line 2, element "joynt": no such element is known there; check its name'
    ),
    "an axis of zero length": (
        body(f'<joint name="j" axis="0 0 0"/>{BALL}'),
        ', line 2, element "j": its axis has no direction; give 3 numbers that are not all 0',
    ),
    "a word": (
        body('<joint/><inertial mass="x" pos="0 0 0" diaginertia="1 1 1"/>'),
        ', line 2, element "inertial": the attribute "mass" holds no numbers; give numbers',
    ),
    "two of one name": (
        body(f'<joint name="j"/><joint name="j"/>{BALL}'),
        ', line 2, element "joint": two elements of the kind <joint> are called "j"; rename one of them',
    ),
    "a missing include": (
        '<include file="nowhere.xml"/>',
        ', line 2, element "include": the file "nowhere.xml" is not there; check the path',
    ),
    "a cyclic include": (
        '<include file="robot.xml"/>',
        ', line 2, element "include": the file "robot.xml" is included twice, or includes itself; include it once',
    ),
    "a mesh with mass that is not there": (
        '<asset><mesh name="m" file="m.stl"/></asset>' + body('<joint/><geom type="mesh" mesh="m"/>'),
        ': mesh "m": its file "m.stl" is not there, and the inertia of body "a" comes from it; put it there, or give '
        "the body an <inertial>",
    ),
    "a motor of nothing": (
        body(f'<joint name="j"/>{BALL}') + '<actuator><motor name="m" joint="k"/></actuator>',
        ', line 2, element "m": nothing there is called "k"; check the name',
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", MJCF)
def test_of_mjcf(tmp_path, case):
    inside, sentence = MJCF[case]
    assert said(mjcf(tmp_path, inside)) == sentence


def test_what_is_no_robot(tmp_path):
    assert said(tmp_path) == " is a folder; give the path of a URDF or MJCF file in it"
    (tmp_path / "robot.urdf").touch()
    assert said(tmp_path / "robot.urdf") == " is empty; give a URDF or MJCF file"
    nearest = f" does not exist; the nearest file there is {tmp_path / 'robot.urdf'}"
    assert said(tmp_path / "robbot.urdf") == nearest
    assert said(tmp_path / "a" / "b.urdf") == f" does not exist; nor does the folder {tmp_path / 'a'}; check the path"
    assert said(tmp_path / f"{'b' * 300}.urdf") == " cannot be read: File name too long; check the path"
    endless = tmp_path / "endless.urdf"
    endless.symlink_to("/dev/zero")
    rule = " is larger than 64 MiB; give a URDF or MJCF file, with its meshes in files of their own"
    assert said(endless).removeprefix(":") == rule
    scene = tmp_path / "scene.xml"
    scene.write_text("<sdf>\n</sdf>")
    rule = "is neither the <robot> of a URDF file nor the <mujoco> of an MJCF file"
    assert said(scene) == f", line 1: <sdf>: {rule}; give one of these"
    scene.write_text("<robot>\n<link name='a'>\n</robot>")
    assert said(scene) == ", line 3: not valid XML: mismatched tag, in `</robot>`; give a URDF or MJCF file"
    other = '<?xml version="1.0" encoding="iso-8859-1"?>\n<mujoco model="\xe4"/>'
    scene.write_bytes(other.encode("latin-1"))
    assert said(scene) == ", line 2: is not in UTF-8; save the file in it"
    scene.write_text("mass = 3")
    assert said(scene) == ", line 1: not valid XML: syntax error, in `mass = 3`; give a URDF or MJCF file"


def test_a_base_that_cannot_be_free(tmp_path):
    file = mjcf(tmp_path, body(f'<joint name="j"/>{BALL}'))
    with pytest.raises(ScenarioError) as caught:
        read(file, base="free")
    assert str(caught.value) == (
        f'{file}: body "a": cannot be a free base, it moves by joints of its own, "j"; import it as it is'
    )
    file = urdf(tmp_path, link("world", ""), joint("hinge", "world", "arm"), link("arm"))
    with pytest.raises(ScenarioError, match="carries 1 joints, and would have to carry one that is fixed"):
        read(file, base="free")


def test_without_mujoco(tmp_path, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "mujoco", None)
    with pytest.raises(ScenarioError) as caught:
        read(urdf(tmp_path, arm()))
    assert str(caught.value) == 'importing a robot needs mujoco, which is missing; pip install "lienumba[import]"'
