"""Shapes of bodies: what is drawn, in stills and reports, and that no number knows of it."""

import json
import re
import zlib
from base64 import b64decode

import numpy as np
import pytest

import lienumba
from lienumba import ScenarioError
from lienumba.figures.picture import Picture
from lienumba.figures.playing import film
from lienumba.integrators.tracing.template import split
from lienumba.present.html import motion
from lienumba.scenario.meshes import surfaces
from lienumba.scenario.reading.loading import load
from lienumba.scenario.start.build import build
from lienumba.scene import box, scene, write_stl
from tests.facade import resolve

SPHERE = {"type": "sphere", "radius": 0.1}
BOX = {"type": "box", "size": [0.1, "2*w", 0.3], "position": [0, -0.5, 0], "colour": "#8090A0"}
ARM = {"type": "capsule", "radius": 0.05, "ends": [[0, -1, 0], [0, 0, 0]]}


def top(*shapes, ground=(), **keys):
    system = lienumba.System("A top")
    if BOX in shapes:
        system.parameter("w", 0.2)
    system.body("top", mass=15, inertia=[0.2, 0.4, 0.2], position=[0, 1, 0], shapes=shapes or None)
    system.joint("pivot", "spherical", ["ground", "top"], points=[[0, 0, 0], [0, -1, 0]], **keys)
    for shape in ground:
        system.ground_shape(**shape)
    system.output(every=0.02)
    return system.integrator(step=1e-2, end_time=0.1)


def refused(*shapes):
    with pytest.raises(ScenarioError) as error:
        resolve(top(*shapes))
    return str(error.value).replace("model.bodies.top.shapes", "...")


def test_no_number_and_no_kernel_knows_of_shapes():
    vary = {"bodies.top.mass": {"distribution": "normal", "std": 0.1}}
    plain, shown = (
        resolve(system, overrides={"sweep": {"runs": 8, "vary": vary}})
        for system in (top(), top(SPHERE, ARM, ground=[SPHERE]))
    )
    assert plain.sha256() == shown.sha256()
    assert split(build(plain, {})[0])[0] == split(build(shown, {})[0])[0]
    first, second = lienumba.run(plain), lienumba.run(shown)
    for name in first.variables:
        if first[name].dtype.kind == "f" and not name.endswith("time_per_run"):
            assert first[name].values.tobytes() == second[name].values.tobytes(), name


def test_bodies_are_drawn_by_their_shapes():
    found = scene(lienumba.run(top(SPHERE, BOX, ground=[SPHERE])))
    mechanism = found.runs[0].mechanism
    (solid,) = mechanism.solids
    assert np.array([solid.vertices.min(axis=0), solid.vertices.max(axis=0)]) == pytest.approx(
        np.array([[-0.1, -0.7, -0.15], [0.1, 0.1, 0.15]])
    )
    assert {*solid.colours} == {"", "#8090a0"}
    assert mechanism.ground.radius == pytest.approx(0.1)
    assert mechanism.segments == ()  # no arms
    assert mechanism.marks == ()
    low, high = box(found.runs)
    assert low[0] == pytest.approx(-0.15, abs=0.05)
    assert high[1] == pytest.approx(1.1, abs=0.02)


def test_each_run_has_its_own_size():
    vary = {"bodies.top.shapes[0].radius": {"distribution": "uniform", "low": 0.1, "high": 0.2}}
    ds = lienumba.run(top(SPHERE), overrides={"sweep": {"runs": 3, "vary": vary}})
    for run in scene(ds, runs=[0, 2]).runs:
        radius = ds["bodies.top.shapes[0].radius"].sel(run=run.run).item()
        assert run.mechanism.solids[0].radius == pytest.approx(radius)
        assert ds["bodies.top.shapes[0].radius"].attrs["units"] == "m"


def test_formulas_stay_and_all_is_read_again():
    scenario = resolve(top(BOX, ARM))
    assert '{ type = "box", colour = "#8090a0", position' in scenario.to_toml()
    assert 'size = [0.1, "2*w", 0.3]' in scenario.to_toml()
    assert resolve(top(BOX, ARM).to_dict()).to_toml() == scenario.to_toml()
    assert resolve(top(BOX), overrides={"parameters.w": 0.5}).data.model.bodies[0].shapes[0].size == [0.1, 1.0, 0.3]


def test_helpers_without_mass_are_not_seen():
    arm = top().body("helper", mass=0)
    arm.joint("a", "revolute", ["top", "helper"], points=[[0, 1, 0], [0, 0, 0]], axes=[[0, 0, 1], [0, 0, 1]], angle=0)
    arm.body("hand", mass=1, inertia=[1, 1, 1])
    arm.joint("b", "revolute", ["helper", "hand"], points=[[0, 0, 0], [0, -1, 0]], axes=[[1, 0, 0]] * 2, angle=0)
    arm.integrator(step=1e-2, end_time=0.1, coordinates="joint")
    mechanism = scene(lienumba.run(arm)).runs[0].mechanism
    assert [mechanism.bodies[n] for n in mechanism.seen] == ["top", "hand"]


def test_stills_show_shapes(tmp_path):
    drawn = []
    for n, system in enumerate([top(), top(SPHERE), top(ARM, ground=[BOX | {"size": [1, 1, 0.1]}])]):
        found = scene(lienumba.run(system))
        picture = Picture(found, film(found.runs, 10, 1.0), "title")
        picture.figure.savefig(tmp_path / f"{n}.png")
        drawn.append((tmp_path / f"{n}.png").read_bytes())
    assert len(set(drawn)) == 3


def test_meshes_travel_with_the_scenario(tmp_path):
    write_stl(tmp_path / "meshes" / "arm.stl", *surfaces.capsule(50, 300))
    mesh = {"type": "mesh", "file": "meshes/arm.stl", "scale": 0.001}
    (tmp_path / "top.toml").write_text(_text(mesh))
    ds = lienumba.run(tmp_path / "top.toml")
    (tmp_path / "meshes" / "arm.stl").unlink()
    (solid,) = scene(ds).runs[0].mechanism.solids
    assert len(solid.faces) == len(surfaces.capsule(50, 300)[1])
    assert np.ptp(solid.vertices, axis=0) == pytest.approx([0.1, 0.1, 0.4], abs=1e-4)
    assert 'file = "meshes/arm.stl"' in ds.attrs["scenario"]
    again = resolve(load_of(ds)).data.model.bodies[0].shapes[0]
    np.testing.assert_array_equal(again.placed()[0], solid.vertices)


def _text(shape):
    text = top(SPHERE).to_toml()
    pairs = ", ".join(f"{key} = {json.dumps(value)}" for key, value in shape.items())
    return re.sub(r"\{ type = \"sphere\".*?\}", f"{{ {pairs} }}", text)


def load_of(ds):
    import tomllib

    return load(tomllib.loads(ds.attrs["scenario"]))


def test_a_report_of_33_links_is_small():
    system = lienumba.System("links")
    mesh = {"type": "mesh", "data": lienumba.scene.packed_mesh(*surfaces.ellipsoid([0.1, 0.2, 0.3]))["data"]}
    twice = [mesh | {"position": [0, 0, 0.3 * k]} for k in range(2)]  # of 528 triangles each
    for n in range(33):
        system.body(f"link_{n}", mass=1, inertia=[1, 1, 1], position=[n, 0, 0], shapes=twice)
    found = scene(lienumba.run(system.integrator(step=0.1, end_time=1)), count=2)
    sent = motion.data(found, [0, 0, -9.81])
    assert len(sent["figures"]) == 1
    assert sum(faces for _, faces in sent["figures"][0]["counts"]) == 33 * 2 * 528
    assert len(zlib.compress(json.dumps(sent).encode())) * 4 / 3 < 1_500_000
    assert len(b64decode(sent["figures"][0]["vertices"]["bdata"])) == 6 * sum(
        x for x, _ in sent["figures"][0]["counts"]
    )


@pytest.mark.parametrize(
    ("shape", "said"),
    [
        ({"type": "bx"}, '...[0].type = "bx": is not known; the nearest known name is "box"'),
        ({}, "...[0].type is missing; give one of box, sphere, ellipsoid, cylinder, capsule, mesh"),
        ({"type": "sphere", "radius": -1}, "...[0].radius = -1: must be above 0; give the radius in m, above 0"),
        ({"type": "sphere", "radius": float("nan")}, "...[0].radius = nan: must be a finite number; give the radius"),
        ({**SPHERE, "size": [1, 1, 1]}, "...[0].size has no meaning for a sphere; leave it out (it belongs to box)"),
        ({**SPHERE, "color": "#ffffff"}, '...[0].color is not a known key; the nearest known name is "colour"'),
        ({**SPHERE, "colour": "red"}, '...[0].colour = "red": is no colour; give red, green and blue in hexadecimal'),
        ({**SPHERE, "radius": "v"}, '...[0].radius = "v"'),
        ({**SPHERE, "rotation": [[1, 0, 0], [0, 1, 0], [0, 0, 2]]}, "...[0].rotation = [[1.0, 0.0, 0.0], [0.0, 1.0, "),
        ({"type": "capsule", "radius": 1}, "...[0].length is missing; give the length in m along z, or ends = "),
        ({**ARM, "length": 1}, "...[0].length: the ends say already where it is; leave out either this or ends"),
        ({**ARM, "ends": [[0, 0, 0]] * 2}, "...[0].ends = [[0.0, 0.0, 0.0], [0.0, 0.0, 0.0]]: are one point; give two"),
        ({"type": "mesh"}, "...[0].file is missing; give the path of an STL or OBJ file, relative to the scenario"),
        ({"type": "mesh", "file": "no.stl"}, '...[0].file = "no.stl": there is no such file; check the path'),
        ({"type": "mesh", "file": __file__}, "is neither .stl nor .obj; save the mesh as STL or OBJ"),
        ({"type": "mesh", "data": "abc"}, '...[0].data = "abc": is no packed mesh; give the file of a mesh instead'),
        ({"type": "mesh", "data": "", "scale": 0}, "...[0].scale = 0: must be above 0; give the unit of the file in m"),
    ],
)  # fmt: skip
def test_what_is_wrong_is_said_in_a_sentence(shape, said):
    assert any(said in line for line in refused(shape).splitlines())


def test_shapes_of_the_ground_are_checked():
    with pytest.raises(ScenarioError, match=re.escape("model.ground_shapes[0].radius = -1: must be above 0")):
        resolve(top(ground=[SPHERE | {"radius": -1}]))
