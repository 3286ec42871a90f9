"""Files of robots as MuJoCo's models: against Newton and Euler, Pinocchio, and what the files say."""

import struct
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from lienumba import ScenarioError
from lienumba.importing import from_file
from lienumba.importing.notes import Note
from lienumba.importing.reading import read
from tests.importing.newton_euler import Frame, inertia_and_bias
from tests.importing.robots import ROD, joint, link, mjcf, urdf

mujoco = pytest.importorskip("mujoco")
BALL = '<geom size="0.1"/>'
LIMIT = '<limit lower="-1" upper="2" effort="30" velocity="4"/>'


def random_inertial(rng):
    """Of a few points, so that it is one of a rigid body; about axes of its own."""
    points = rng.normal(size=(6, 3))
    points -= points.mean(0)
    J = sum(p @ p * np.eye(3) - np.outer(p, p) for p in points)
    words = " ".join(
        f'i{"xyz"[i]}{"xyz"[j]}="{float(J[i, j])!r}"' for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
    )
    return f'<inertial>{origin(rng)}<mass value="{rng.uniform(1, 3)}"/><inertia {words}/></inertial>'


def origin(rng):
    xyz, rpy = (" ".join(map(repr, rng.normal(size=3).tolist())) for _ in range(2))
    return f'<origin xyz="{xyz}" rpy="{rpy}"/>'


def random_robot(folder, rng):
    """Hinges, slides and fixed joints, with a frame without mass between two of them, and branches."""
    kinds = ["fixed", "revolute", "continuous", "prismatic", "revolute", "fixed", "continuous", "revolute"]
    parts = [link("l0", random_inertial(rng))]
    for i, kind in enumerate(kinds, start=1):
        axis = " ".join(map(repr, rng.normal(size=3).tolist()))
        inside = f'{origin(rng)}<axis xyz="{axis}"/>{LIMIT}'
        parts += [
            joint(f"j{i}", f"l{int(rng.integers(max(0, i - 2), i)) if i < 5 else i - 1}", f"l{i}", inside, kind),
            link(f"l{i}", "" if i == 4 else random_inertial(rng)),
        ]
    return urdf(folder, *parts)


def mass_matrix(model, data):
    M = np.zeros((model.nv, model.nv))
    for i, unit in enumerate(np.eye(model.nv)):
        mujoco.mj_mulM(model, data, M[i], unit)
    return M


@pytest.mark.parametrize("base", ["fixed", "free"])
@pytest.mark.parametrize("seed", range(4))
def test_masses_and_placements_are_those_of_pinocchio(tmp_path, seed, base):
    """M(q) and the forces of weight and rates, at a random state; a massless link is exactly that."""
    pinocchio = pytest.importorskip("pinocchio")
    rng = np.random.default_rng(seed)
    file = random_robot(tmp_path, rng)
    loaded = read(file, base=base)
    model, data = loaded.model, mujoco.MjData(loaded.model)
    assert loaded.massless == {"l4"}
    assert model.body("l4").mass == 0
    root = [pinocchio.JointModelFreeFlyer()] if base == "free" else []
    other = pinocchio.buildModelFromUrdf(str(file), *root)
    assert model.nv == other.nv
    q, v, columns = pinocchio.neutral(other), np.zeros(other.nv), np.arange(other.nv)
    for name, moved in zip(list(other.names)[1 + len(root) :], list(other.joints)[1 + len(root) :], strict=True):
        angle, rate = rng.normal(size=2)
        ours = model.joint(name)
        data.qpos[ours.qposadr[0]], data.qvel[ours.dofadr[0]], v[moved.idx_v] = angle, rate, rate
        q[moved.idx_q : moved.idx_q + moved.nq] = angle if moved.nq == 1 else (np.cos(angle), np.sin(angle))
        columns[moved.idx_v] = ours.dofadr[0]
    mujoco.mj_forward(model, data)
    M = mass_matrix(model, data)
    theirs = other.createData()
    pinocchio.crba(other, theirs, q)
    expected = np.triu(theirs.M) + np.triu(theirs.M, 1).T
    np.testing.assert_allclose(M[np.ix_(columns, columns)], expected, atol=1e-12 * abs(expected).max())
    bias = pinocchio.nonLinearEffects(other, theirs, q, v)
    np.testing.assert_allclose(data.qfrc_bias[columns], bias, atol=1e-11 * abs(bias).max())


@pytest.mark.parametrize("base", ["fixed", "free"])
@pytest.mark.parametrize("seed", range(2))
def test_masses_and_placements_are_those_of_newton_and_euler(tmp_path, seed, base):
    """The same by what the file says, read anew; the base turned and in motion."""
    rng = np.random.default_rng(seed)
    file = random_robot(tmp_path, rng)
    model = read(file, base=base).model
    data, n = mujoco.MjData(model), model.nv
    data.qpos[:], data.qvel[:] = rng.normal(size=model.nq), rng.normal(size=n)
    first = Frame(*np.zeros((1, 3)), np.eye(3), *np.zeros((3, 3)), np.zeros((3, n)), np.zeros((3, n)))
    if base == "free":
        data.qpos[3:7] /= np.linalg.norm(data.qpos[3:7])
        R = Rotation.from_quat(data.qpos[3:7], scalar_first=True).as_matrix()
        first.Jv[:, :3], first.Jw[:, 3:6] = np.eye(3), R  # rates: global, and along axes of the base
        first = replace(first, p=data.qpos[:3].copy(), R=R, w=R @ data.qvel[3:6])
    joints = [model.joint(i) for i in range(model.njnt) if model.jnt_type[i] != mujoco.mjtJoint.mjJNT_FREE]
    states = {x.name: (data.qpos[x.qposadr[0]], data.qvel[x.dofadr[0]], x.dofadr[0]) for x in joints}
    assert len(states) == 6
    mujoco.mj_forward(model, data)
    M = mass_matrix(model, data)
    expected, bias = inertia_and_bias(file, first, states, model.opt.gravity)
    np.testing.assert_allclose(M, expected, atol=1e-12 * abs(expected).max())
    np.testing.assert_allclose(data.qfrc_bias, bias, atol=1e-11 * abs(bias).max())


def arm(of_joint, type="revolute"):
    return link("base", "") + joint("hinge", "base", "arm", of_joint, type) + link("arm")


def test_a_joint_has_its_motor_limits_and_resistance(tmp_path):
    loaded = read(urdf(tmp_path, arm(f'<axis xyz="0 0 2"/>{LIMIT}<dynamics damping="3" friction="0.5"/>')))
    model = loaded.model
    hinge = model.joint("hinge")
    assert (hinge.type, hinge.limited, list(hinge.range), list(hinge.axis)) == (3, 1, [-1, 2], [0, 0, 1])
    assert float(hinge.damping.ravel()[0]) == 3
    assert hinge.frictionloss == 0.5
    motor = model.actuator("hinge")
    assert (motor.forcelimited, list(motor.forcerange), list(motor.trnid)) == (1, [-30, 30], [hinge.id, -1])
    data = mujoco.MjData(model)
    data.ctrl[:] = 7
    mujoco.mj_forward(model, data)
    assert data.qfrc_actuator == [7]
    assert loaded.notes == [
        Note("limit of velocity: kept by a robot's own controller, left out", ('joint "hinge"',), lost=False)
    ]
    assert loaded.source == "URDF robot.urdf"


def test_limits_that_are_none(tmp_path):
    loaded = read(urdf(tmp_path, arm('<limit lower="0" upper="0" effort="0"/>')))
    assert (loaded.model.joint("hinge").limited, loaded.model.actuator("hinge").forcelimited) == (0, 0)
    assert loaded.notes == [Note("its limits, 0 and 0, leave no room: left out", ('joint "hinge"',))]
    loaded = read(urdf(tmp_path, arm('<limit lower="-1e16" upper="1e16" effort="1e20"/>')))
    assert (loaded.model.joint("hinge").limited, loaded.model.actuator("hinge").forcelimited) == (0, 0)
    assert loaded.notes == []
    loaded = read(urdf(tmp_path, arm('<limit effort="-1"/>', "continuous")))
    assert loaded.model.actuator("hinge").forcelimited == 0
    assert loaded.notes == [Note("limit of effort -1, which is below 0: none", ('joint "hinge"',), lost=False)]
    loaded = read(urdf(tmp_path, arm(LIMIT, "continuous")))
    assert (loaded.model.joint("hinge").limited, loaded.model.actuator("hinge").forcelimited) == (0, 1)
    loaded = read(urdf(tmp_path, arm("")))
    assert list(loaded.model.joint("hinge").axis) == [1, 0, 0]  # as URDF says
    assert loaded.notes == [
        Note("no <limit>, which URDF asks for: the joint has no limits", ('joint "hinge"',), lost=False)
    ]


def test_mimics(tmp_path):
    """Of a joint that stands further below, of one that is a mimic itself, of one that does not move."""
    parts = [link("base"), link("a"), link("b"), link("c"), link("d"), link("tip")]
    joints = [
        joint("one", "base", "a", '<mimic joint="two" multiplier="-2" offset="0.5"/>'),
        joint("two", "a", "b", '<mimic joint="three" multiplier="3" offset="0.1"/>'),
        joint("three", "b", "c"),
        joint("four", "c", "d", '<mimic joint="weld" multiplier="5" offset="0.2"/>', "prismatic"),
        joint("weld", "d", "tip", "", "fixed"),
    ]
    model = read(urdf(tmp_path, *parts, *joints)).model
    assert [model.actuator(i).name for i in range(model.nu)] == ["three"]
    names = {model.joint(i).id: model.joint(i).name for i in range(model.njnt)} | {-1: ""}
    found = {
        names[int(model.eq_obj1id[i])]: (names[int(model.eq_obj2id[i])], *model.eq_data[i, :5])
        for i in range(model.neq)
    }
    assert set(model.eq_type.tolist()) == {int(mujoco.mjtEq.mjEQ_JOINT)}
    assert found == {
        "one": ("three", pytest.approx(0.5 - 2 * 0.1), -6.0, 0, 0, 0),
        "two": ("three", 0.1, 3.0, 0, 0, 0),
        "four": ("", 0.2, 0, 0, 0, 0),
    }


@pytest.mark.parametrize("axis", ["0 0 1", "1 0 0", "1 2 -1"])
def test_a_planar_joint_moves_across_its_axis_and_about_it(tmp_path, axis):
    inside = f'<origin xyz="1 2 3" rpy="0.3 0.2 0.1"/><axis xyz="{axis}"/>'
    model = read(urdf(tmp_path, link("base"), joint("p", "base", "b", inside, "planar"), link("b"))).model
    normal = np.array(axis.split(), float) / np.linalg.norm(np.array(axis.split(), float))
    assert [model.joint(name).type[0] for name in ("p_x", "p_y", "p")] == [2, 2, 3]
    axes = np.array([model.joint(name).axis for name in ("p_x", "p_y", "p")])
    np.testing.assert_allclose(axes[2], normal, atol=1e-15)
    np.testing.assert_allclose(axes @ axes.T, np.eye(3), atol=1e-15)
    assert np.linalg.det(axes) == pytest.approx(1)
    assert model.nu == 0
    if axis == "0 0 1":
        np.testing.assert_array_equal(axes, np.eye(3))


def test_a_floating_joint(tmp_path):
    """On the ground a free joint; elsewhere three slides and a ball."""
    model = read(urdf(tmp_path, link("world", ""), joint("f", "world", "b", "", "floating"), link("b"))).model
    assert [(model.joint(i).name, model.joint(i).type[0]) for i in range(model.njnt)] == [("f", 0)]
    parts = link("base"), joint("h", "base", "a"), link("a"), joint("f", "a", "b", '<origin xyz="1 0 0"/>', "floating")
    model = read(urdf(tmp_path, *parts, link("b"))).model
    assert [model.joint(i).type[0] for i in range(model.njnt)] == [3, 2, 2, 2, 1]
    data = mujoco.MjData(model)
    data.qpos[:4] = np.pi / 2, 0.1, 0.2, 0.3
    mujoco.mj_kinematics(model, data)
    np.testing.assert_allclose(data.body("b").xpos, [-0.2, 1.1, 0.3], atol=1e-14)


def test_names_of_the_ground(tmp_path):
    """A root called world is the ground; another link of this name is not."""
    chain = link("world", ""), joint("mount", "world", "base", '<origin xyz="0 0 1"/>', "fixed"), link("base")
    file = urdf(tmp_path, *chain, joint("h", "base", "a"), link("a"))
    fixed, free = read(file), read(file, base="free")
    assert [fixed.model.body(i).name for i in range(fixed.model.nbody)] == ["world", "base", "a"]
    assert [free.model.body(i).name for i in range(free.model.nbody)] == ["world", "base", "a"]
    assert (fixed.model.nv, free.model.nv) == (1, 7)
    assert list(free.model.qpos0[:3]) == list(fixed.model.body("base").pos) == [0, 0, 1]
    assert free.notes == [Note("left out, for a free base", ('joint "mount"',), lost=False)]
    loaded = read(urdf(tmp_path, link("base"), joint("h", "base", "world"), link("world")))
    assert loaded.model.body(2).name == "world_link"
    assert loaded.notes[0].places == ('link "world"',)


def test_a_floating_base_is_fixed_when_asked(tmp_path):
    file = urdf(
        tmp_path,
        link("world", ""),
        joint("f", "world", "b", "", "floating"),
        link("b"),
        joint("h", "b", "a"),
        link("a"),
    )
    assert (read(file).model.nv, read(file, base="free").model.nv, read(file, base="fixed").model.nv) == (7, 7, 1)


def test_an_inertia_of_no_body_is_read_and_told(tmp_path):
    """Where it breaks the triangle inequality, or is odd only until it is welded to the rest."""
    odd = '<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="5"/></inertial>'
    parts = [link("base"), joint("h", "base", "a"), link("a", odd)]
    loaded = read(urdf(tmp_path, *parts))
    np.testing.assert_array_equal(loaded.model.body("a").inertia, [1, 1, 5])
    assert [(x.places, x.lost) for x in loaded.notes] == [(('link "a"',), False)]
    parts = [link("base"), joint("h", "base", "a"), link("a"), joint("w", "a", "b", "", "fixed"), link("b", odd)]
    loaded = read(urdf(tmp_path, *parts))
    np.testing.assert_array_equal(loaded.model.body("b").inertia, [1, 1, 5])
    assert [x.places for x in loaded.notes] == [('link "a"',), ('link "b"',)]


def triangle_mesh(file):
    """A tetrahedron, in the binary form of STL."""
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], "<f4")
    faces = [corners[list(f)] for f in ((0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3))]
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_bytes(bytes(80) + struct.pack("<I", 4) + b"".join(bytes(12) + f.tobytes() + bytes(2) for f in faces))


def with_mesh(folder, name):
    shape = f'<geometry><mesh filename="{name}" scale="2 2 2"/></geometry>'
    folder.mkdir(parents=True, exist_ok=True)
    return urdf(folder, link("base", f"{ROD}<visual>{shape}</visual><collision>{shape}</collision>"))


@pytest.mark.parametrize(
    ("mesh", "name"),
    [
        ("bot/meshes/a.stl", "package://bot/meshes/a.stl"),
        ("share/bot/meshes/a.stl", "package://bot/meshes/a.stl"),
        ("bot/urdf/a.stl", "a.stl"),
        ("bot/meshes/a.STL", "../meshes/a.STL"),
        ("elsewhere/bot/a.stl", "package://bot/a.stl"),
        ("bot/my meshes/a.stl", "package://bot/my%20meshes/a.stl"),
    ],
)
def test_meshes_are_found(tmp_path, monkeypatch, mesh, name):
    monkeypatch.setenv("ROS_PACKAGE_PATH", f"/nowhere:{tmp_path / 'elsewhere'}")
    triangle_mesh(tmp_path / mesh)
    loaded = read(with_mesh(tmp_path / "bot" / "urdf", name))
    assert loaded.notes == []
    assert loaded.model.nmesh == 1
    assert [(int(g), int(c)) for g, c in zip(loaded.model.geom_group, loaded.model.geom_contype, strict=True)] == [
        (1, 0), (0, 1),
    ]  # fmt: skip


def test_a_package_may_lie_in_a_folder_of_another_name(tmp_path):
    triangle_mesh(tmp_path / "clone" / "a.stl")
    (tmp_path / "clone" / "package.xml").write_text("<package><name>bot</name></package>")
    assert read(with_mesh(tmp_path / "clone" / "urdf", "package://bot/a.stl")).model.nmesh == 1


def test_meshes_that_cannot_be_read_are_left_out(tmp_path):
    (tmp_path / "a.ply").touch()
    (tmp_path / "bad.stl").write_bytes(b"no mesh")
    for name, what in (
        ("gone.stl", "mesh not found, left out"),
        ("a.ply", "mesh of a format that MuJoCo does not read (.ply), left out"),
        ("bad.stl", "mesh that MuJoCo does not read"),
    ):
        loaded = read(with_mesh(tmp_path, name))
        assert (loaded.model.nmesh, loaded.model.ngeom, loaded.model.body("base").mass) == (0, 0, 2)
        assert {x.lost for x in loaded.notes} == {False}
        assert all(x.what.startswith(what) for x in loaded.notes)
        assert all(name in place for x in loaded.notes for place in x.places)


def test_a_mesh_of_stl_may_be_text(tmp_path):
    corners, faces = ["0 0 0", "1 0 0", "0 1 0", "0 0 1"], [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]
    facets = "".join(
        "facet normal 0 0 0\nouter loop\n" + "".join(f"vertex {corners[i]}\n" for i in face) + "endloop\nendfacet\n"
        for face in faces
    )
    (tmp_path / "a.stl").write_text(f"solid a\n{facets}endsolid a\n")
    triangle_mesh(tmp_path / "b.stl")
    text, binary = (read(with_mesh(tmp_path, name)) for name in ("a.stl", "b.stl"))
    assert text.notes == []
    for of in (text, binary):
        placed = mujoco.MjData(of.model)
        mujoco.mj_kinematics(of.model, placed)
        seen = of.model.mesh_vert @ placed.geom_xmat[0].reshape(3, 3).T + placed.geom_xpos[0]
        expected = {(0, 0, 0), (2, 0, 0), (0, 2, 0), (0, 0, 2)}  # by the scale
        assert {tuple(round(x) for x in corner.tolist()) for corner in seen} == expected


def test_shapes(tmp_path):
    forms = '<box size="2 4 6"/>', '<sphere radius="3"/>', '<cylinder radius="1" length="4"/>'
    seen = "".join(f'<visual><geometry>{x}</geometry><material name="red"/></visual>' for x in forms)
    red = '<material name="red"><color rgba="1 0 0 0.5"/></material>'
    model = read(urdf(tmp_path, red, link("base", f"{ROD}{seen}"))).model
    assert [int(x) for x in model.geom_type] == [6, 2, 5]
    np.testing.assert_array_equal(model.geom_size, [[1, 2, 3], [3, 0, 0], [1, 2, 0]])
    np.testing.assert_array_equal(model.geom_rgba, [[1, 0, 0, 0.5]] * 3)


def test_what_is_left_out_is_counted(tmp_path):
    aside = "<transmission/><transmission/><gazebo/>"
    loaded = read(urdf(tmp_path, aside, arm("<safety_controller/>", "continuous")))
    assert loaded.notes == [
        Note("<transmission>: what a motor is wired to; efforts act on joints directly; 2 left out", lost=False),
        Note("<gazebo>: settings of another simulator; 1 left out", lost=False),
        Note("<safety_controller>: soft limits, kept by a robot's own controller; 1 left out", lost=False),
    ]


def test_what_is_not_known_is_called_so_and_refused_by_strict(tmp_path):
    """Wherever it stands: it may say something of the motion."""
    spring = '<dynamics damping="1"/><spring/>'
    cog = link("base", ROD.replace("<mass", "<cog/><mass"))
    file = urdf(tmp_path, cog, joint("hinge", "base", "arm", spring), link("arm"))
    loaded = read(file)
    assert loaded.notes == [
        Note("<cog>: unknown; 1 left out", ('link "base"',)),
        Note("<spring>: unknown; 1 left out", ('joint "hinge"',)),
    ]
    with pytest.raises(ScenarioError, match="<spring>: unknown"):
        from_file(file, strict=True)


SOLIDS = {  # of URDF, and the same as geoms of MuJoCo
    "box": ('<box size="0.2 0.4 0.6"/>', 'type="box" size="0.1 0.2 0.3"'),
    "sphere": ('<sphere radius="0.3"/>', 'type="sphere" size="0.3"'),
    "cylinder": ('<cylinder radius="0.1" length="0.4"/>', 'type="cylinder" size="0.1 0.2"'),
    "capsule": ('<capsule radius="0.1" length="0.4"/>', 'type="capsule" size="0.1 0.2"'),
    "mesh": ('<mesh filename="c.obj" scale="1 2 3"/>', 'type="mesh" mesh="c"'),
}


@pytest.mark.parametrize("names", [*([x] for x in SOLIDS), [*SOLIDS]], ids="+".join)
def test_links_without_mass_get_that_of_their_collision_shapes(tmp_path, names):
    """As MuJoCo has it, of each shape and of all together, placed anywhere."""
    corners = "v 0 0 0\nv 0.1 0 0\nv 0 0.2 0\nv 0 0 0.3\nv 0.05 0.1 -0.1\n"
    (tmp_path / "c.obj").write_text(corners + "f 1 2 5\nf 2 3 5\nf 3 1 5\nf 1 4 2\nf 2 4 3\nf 3 4 1\n")
    rng = np.random.default_rng(3)
    ours = theirs = ""
    for name in names:
        shape, geom = SOLIDS[name]
        place = origin(rng)
        ours += f"<collision>{place}<geometry>{shape}</geometry></collision>"
        xyz, rpy = place.split('"')[1::2]
        theirs += f'<geom {geom} pos="{xyz}" euler="{rpy}" density="700"/>'
    loaded = read(urdf(tmp_path, link("base", "") + joint("hinge", "base", "arm") + link("arm", ours)), density=700)
    text = (
        '<mujoco><compiler angle="radian" eulerseq="XYZ"/><asset><mesh name="c" file="c.obj" scale="1 2 3" '
        f'inertia="convex"/></asset><worldbody><body name="arm"><joint/>{theirs}</body></worldbody></mujoco>'
    )
    (tmp_path / "m.xml").write_text(text)
    model, wanted = loaded.model.body("arm"), mujoco.MjModel.from_xml_path(str(tmp_path / "m.xml")).body("arm")
    np.testing.assert_allclose(model.mass, wanted.mass, rtol=1e-6)
    np.testing.assert_allclose(model.ipos, wanted.ipos, atol=1e-6)
    np.testing.assert_allclose(tensor(model), tensor(wanted), atol=1e-6 * max(wanted.inertia))
    what = "mass and inertia of its collision shapes at 700 kg/m³, as it has none"
    assert loaded.notes == [Note(what, ('link "arm"',), lost=False)]


def tensor(body):
    """About the mass centre, in the frame of the body."""
    R = Rotation.from_quat(body.iquat, scalar_first=True).as_matrix()
    return R @ np.diag(body.inertia) @ R.T


@pytest.mark.parametrize("rate", [1.0, 3.0, 999.0, 1000.0, 1000.0000000016, 1000.1, 0.99999999 * 2e4, 2.1e4])
def test_the_step_is_1_2_or_5_of_a_power_of_ten_below_what_damping_allows(tmp_path, rate):
    """A disc whose damping is this many times its inertia per second, also just beside a power of ten."""
    disc = '<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial>'
    spin = f'<axis xyz="0 0 1"/><dynamics damping="{rate!r}"/>'
    file = urdf(tmp_path, link("base", ""), joint("spin", "base", "disc", spin), link("disc", disc))
    longest = min(0.002, 1.0 / rate)
    step = from_file(file).to_dict()["integrator"]["step"]
    known = [float(f"{x}e{n}") for n in range(-6, -2) for x in (1, 2, 5)]
    assert step == max(x for x in known if x <= longest * (1 + 1e-9))


FREE = f'<worldbody><body name="prop" pos="1 0 0"><freejoint name="p"/>{BALL}</body>'
TWO = (
    FREE
    + f'<body name="robot" pos="0 0 2">{{}}{BALL}<body name="leg"><joint name="knee"/>{BALL}</body></body></worldbody>'
)
HOME = '<keyframe><key name="home" qpos="{}"/></keyframe>'


def test_bases_of_mjcf(tmp_path):
    """The robot is the body that carries the most joints; keyframes follow."""
    prop, root = "1 0 0 1 0 0 0", "0 0 3 0 1 0 0"
    fixed = mjcf(tmp_path, TWO.format("") + HOME.format(f"{prop} 0.5"), "fixed.xml")
    free = mjcf(tmp_path, TWO.format('<freejoint name="root"/>') + HOME.format(f"{prop} {root} 0.5"), "free.xml")
    assert read(fixed).model.nq == read(fixed, base="fixed").model.nq == read(free, base="fixed").model.nq == 8
    assert read(free).model.nq == read(free, base="free").model.nq == read(fixed, base="free").model.nq == 15
    np.testing.assert_array_equal(read(free, base="fixed").model.key_qpos, [[*map(float, prop.split()), 0.5]])
    np.testing.assert_array_equal(
        read(fixed, base="free").model.key_qpos, [[*map(float, prop.split()), 0, 0, 2, 1, 0, 0, 0, 0.5]]
    )
    what = 'stays as it is: the base that is fixed is that of body "robot"'
    assert read(free, base="fixed").notes == [Note(what, ('body "prop"',), lost=False)]
    assert read(free).source == "MJCF free.xml"


def test_a_mesh_that_nothing_weighs_may_be_missing(tmp_path):
    asset = '<asset><mesh name="m" file="gone.stl"/><texture name="t" type="2d" file="gone.png"/></asset>'
    geom = f'<joint/><geom type="mesh" mesh="m" mass="0"/>{BALL}'
    loaded = read(mjcf(tmp_path, f'{asset}<worldbody><body name="a">{geom}</body></worldbody>'))
    assert loaded.model.ngeom == 1
    assert {x.what for x in loaded.notes} == {"mesh not found, left out", "picture not found, left out"}


def test_includes_are_read_from_the_file_on(tmp_path):
    (tmp_path / "parts").mkdir()
    inside = f'<worldbody><body name="a"><joint name="j"/>{BALL}</body></worldbody>'
    (tmp_path / "parts" / "arm.xml").write_text(f"<mujoco>{inside}</mujoco>")
    assert read(mjcf(tmp_path, '<include file="parts/arm.xml"/>')).model.njnt == 1


@pytest.mark.parametrize(
    ("head", "licence"),
    [
        ("<!-- Copyright 2020 A. Maker -->\n<mujoco>", "Copyright 2020 A. Maker"),
        ("<mujoco>\n<!-- License: MIT\n -- by A. Maker -->", "License: MIT\n-- by A. Maker"),
        ("<!-- ====\n| autogenerated by xacro from http://a.b |\n| License: MIT |\n==== -->\n<mujoco>", "License: MIT"),
        ("<!-- | This document was autogenerated by xacro from http://a.b | -->\n<mujoco>", ""),
        ("<!-- A pendulum -->\n<mujoco>", ""),
        ("<mujoco><option/><!-- Copyright of the option -->", ""),
    ],
)
def test_the_licence_at_the_head(tmp_path, head, licence):
    file = tmp_path / "robot.xml"
    file.write_text(f"{head}</mujoco>")
    assert read(file).licence == licence
