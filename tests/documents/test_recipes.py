"""The recipes of docs/architecture.md: each adds an element in a temporary registry and runs a scenario with it.

What an element needs stands in its record alone; everything else (keys, messages, schema, dataset, citation) follows.
"""

import ast
import re
import tomllib
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
import pytest
from pydantic import Field
from scipy.optimize import brentq
from scipy.special import ellipj, ellipk
from scipy.stats import qmc

import lienumba
from lienumba.analysis import orders
from lienumba.groups import so3
from lienumba.integrators.methods.tableau import Tableau
from lienumba.keys.literature import Reference
from lienumba.keys.types import Positive, Timed
from lienumba.mechanics.elements.forces import FORCES
from lienumba.mechanics.elements.forces.base import AlongJoint, BetweenPoints, Given
from lienumba.mechanics.elements.forces.numbers import DISSIPATIVE, number
from lienumba.mechanics.elements.joints import Own
from lienumba.mechanics.elements.joints.keys import AtPoints, FirstAxis
from lienumba.mechanics.elements.joints.parts import along, separation
from lienumba.mechanics.mechanism.kinematics import Motion, inertia_times
from lienumba.mechanics.system.output_variables import OUTPUT_VARIABLES, Observation, OutputVariable
from lienumba.numerics.number import Number, Vector
from lienumba.present.cite import cite_dataset
from lienumba.scenario.checks.integrator import method_of, pairs
from lienumba.scenario.schema.json_schema import json_schema
from lienumba.scenario.schema.scenario import Integrator, Projection, ScenarioData
from lienumba.scenario.study_errors import STATE
from lienumba.scene import scene
from lienumba.sweep.samplers import SAMPLERS
from lienumba.sweep.samplers.sampler import Sampler, Streams
from lienumba.sweep.samplers.streams import LARGEST, SMALLEST, uniforms
from tests.facade import JOINTS, METHODS, Joint, ScenarioError, resolve
from tests.integrators.methods.test_tableaus import holds, trees
from tests.rigs.places import ROOT, SCENARIOS

TOP = str(SCENARIOS / "heavy_top.toml")
SHORT = {"integrator.end_time": 0.2, "output.every": 0.05}

RALSTON = Tableau.of(
    "ralston3", 3, "Ralston's method [@ralston1962]", ["", "1/2", "0 3/4"], "2/9 1/3 4/9",
    Reference(
        "ralston1962", "article", "Ralston, Anthony", 1962, "Runge-Kutta methods with minimum error bounds",
        "Mathematics of Computation", "16(80):431--437", "10.1090/S0025-5718-1962-0150954-0",
    ),
)  # fmt: skip


def test_a_method() -> None:
    """The record of a method is its tableau; its weights are those of bs32, so that its runs have the same bits."""
    assert all(holds(RALSTON, tree) for order in (1, 2, 3) for tree in trees(order))
    with METHODS.temporarily(RALSTON):
        runs = {
            method: lienumba.run(TOP, overrides={"integrator.method": method} | SHORT)
            for method in ("ralston3", "bs32")
        }
        assert (runs["ralston3"].position.values == runs["bs32"].position.values).all()
        steps = {
            "extends": TOP,
            "study": {
                "reference": {"method": "dop853", "step": 5e-3},
                "grid": [{"integrator.step": [2e-3, 1e-3, 5e-4]}],
            },
        }
        measured = orders(lienumba.run(steps, overrides={"integrator.method": "ralston3"} | SHORT))
        text = cite_dataset(runs["ralston3"])
        methods = json_schema()["$defs"]["Integrator"]["properties"]["method"]
        with pytest.raises(ScenarioError, match='the nearest known name is "ralston3"'):
            resolve(TOP, overrides={"integrator.method": "ralston"})
    np.testing.assert_allclose(measured["order"], 3, atol=0.1)
    assert "@article{ralston1962,\n  author = {Ralston, Anthony}," in text
    assert "ralston3" in methods["enum"]
    assert "taylor, ralston3 (or omit it" in methods["description"]
    with pytest.raises(ScenarioError, match=r'integrator\.method = "ralston3": is not known'):
        resolve(TOP, overrides={"integrator.method": "ralston3"})


def weyl(streams: Streams, labels: np.ndarray, seed: int, runs: int) -> dict[str, np.ndarray]:
    """Run n of stream j at the fraction of shift + n alpha^(j+1), 1/alpha the root of x^(d+1) = x + 1."""
    names = [name for of_path in streams.values() for name in of_path]
    alpha = 1 / brentq(lambda x: x ** (len(names) + 1) - x - 1, 1, 2)
    shifted = {name: uniforms(f"{name} shift", [0], seed) + labels * alpha ** (j + 1) for j, name in enumerate(names)}
    return {name: np.clip(x % 1, SMALLEST, LARGEST) for name, x in shifted.items()}


WEYL = Sampler(
    "weyl", weyl,
    (Reference(
        "weyl1916", "article", "Weyl, Hermann", 1916, "Über die Gleichverteilung von Zahlen mod. Eins",
        "Mathematische Annalen", "77(3):313--352", "10.1007/BF01475864",
    ),),
    order_matters=True,
)  # fmt: skip


def test_a_sampler(tmp_path: Path) -> None:
    """The record of a sampler is how it draws, and what follows from that: here, that sweeps may grow."""
    vary = {"bodies.top.mass": {"distribution": "uniform", "low": 14, "high": 16}}
    scenario, file = {"extends": TOP, "sweep": {"runs": 64, "sampler": "weyl", "vary": vary}}, tmp_path / "runs.nc"
    more: dict[str, Any] = {"output": file, "overrides": SHORT | {"sweep.runs": 80}, "resume": True}
    with SAMPLERS.temporarily(WEYL):
        short = lienumba.run(scenario, output=file, overrides=SHORT).load()
        long = lienumba.run(scenario, **more).load()
        text = cite_dataset(long)
    with SAMPLERS.temporarily(replace(WEYL, whole="places all runs at once")):
        match = 'has samples for sweep.runs = 80, not 96: the sampler "weyl" places all runs at once'
        with pytest.raises(ScenarioError, match=match):
            lienumba.run(scenario, **more | {"overrides": SHORT | {"sweep.runs": 96}})
    mass = long["bodies.top.mass"].values
    assert (mass[:64] == short["bodies.top.mass"].values).all()
    assert np.histogram(mass, 16, (14, 16))[0].min() >= 4
    points = np.array(list(weyl({"a": ["a"], "b": ["b"]}, np.arange(512), 1, 512).values()))
    assert qmc.discrepancy(points.T) < 0.1 * qmc.discrepancy(np.random.default_rng(1).random((512, 2)))
    assert "@article{weyl1916," in text


def angular_momentum(seen: Observation) -> Sequence[Number]:
    """sum m r x v + R J w about the origin."""
    total: Vector = (0.0, 0.0, 0.0)
    for body, x in zip(seen.model.bodies, seen.now.bodies, strict=True):
        orbital = so3.scale(body.mass, so3.cross(x[0:3], x[12:15]))
        total = so3.add(total, so3.add(orbital, so3.rotate(x[3:12], inertia_times(body.inertia, x[15:18]))))
    return total


MOMENTUM = OutputVariable(
    "angular_momentum", "kg m2 s-1", "angular momentum about the origin", "global", ("axis",), rows=angular_momentum
)


def test_an_output_variable() -> None:
    """The record of an output variable is how it is computed, and how the dataset describes it."""
    with OUTPUT_VARIABLES.temporarily(MOMENTUM):
        ds = lienumba.run(TOP, overrides=SHORT)
        kept = lienumba.run(
            TOP, overrides=SHORT | {"output.mode": "summary", "output.summary": {"angular_momentum": ["max"]}}
        )
        output = json_schema()["$defs"]["Output"]["properties"]["variables"]
        with pytest.raises(ScenarioError, match='the nearest known name is "angular_momentum"'):
            resolve(TOP, overrides={"output.variables": ["angular_momenta"]})
    L = ds["angular_momentum"]
    assert L.dims == ("run", "time", "axis")
    assert L.attrs == {"units": "kg m2 s-1", "long_name": "angular momentum about the origin", "frame": "global"}
    J, (r, R, v, w) = np.diag([0.234375, 0.46875, 0.234375]), (ds[name].values[0, :, 0] for name in STATE)
    expected = 15 * np.cross(r, v) + np.einsum("tij,jk,tk->ti", R, J, w)
    np.testing.assert_allclose(L.values[0], expected, rtol=1e-13)
    np.testing.assert_allclose(L.sel(axis="z"), float(L[0, 0, 2]), rtol=1e-6)  # weight has no moment about the vertical
    np.testing.assert_array_equal(kept["angular_momentum_max"], L.max("time"))
    assert "angular_momentum" in output["default"]
    assert "angular_momentum" not in lienumba.run(TOP, overrides=SHORT)


def test_a_pair_that_is_added_is_nobodys_default() -> None:
    pair = Tableau.of("bs32b", 3, "another pair", ["", "1/2", "0 3/4"], "2/9 1/3 4/9", errors=["-5/72 1/12 1/9 -1/8"])
    with METHODS.temporarily(pair):
        assert "bs32b" in pairs()
        assert method_of(Integrator(tolerance=1e-6, end_time=1.0)) == "dop853"


@pytest.fixture
def more_iterations() -> Iterator[None]:
    """Another default of a key: it stands in its field, and nowhere else."""
    field = Projection.model_fields["max_iterations"]
    before, field.default = field.default, 20
    rebuild()
    yield
    field.default = before
    rebuild()


def rebuild() -> None:
    for section in (Projection, ScenarioData):
        section.model_rebuild(force=True)


@pytest.fixture(scope="module")
def written() -> str:
    """A scenario with every default that there is without `more_iterations`."""
    return resolve(TOP).to_toml()


@pytest.mark.usefixtures("more_iterations")
def test_a_default(written: str) -> None:
    """Scenarios that omit the key are others from now on, with another hash; what is written out stays what it was."""
    scenario, before = resolve(TOP), resolve(tomllib.loads(written))
    assert "max_iterations = 20" in scenario.to_toml()
    assert "max_iterations = 10" in before.to_toml() == written
    assert scenario.sha256() != before.sha256()
    assert json_schema()["$defs"]["Projection"]["properties"]["max_iterations"]["default"] == 20


class OnRing(AtPoints, FirstAxis):
    """The point of the second body stays on a circle about the point of the first, across its axis."""

    words, leaves = "a point stays on a circle", "a point of the second body stays on a circle of the first"
    row_kinds = "mm"

    type: Literal["on_ring"]
    radius: Annotated[Positive, Own("m", 0.5)] = Field(description="the radius in m, above 0")

    @staticmethod
    def residual(joint: Joint, a: Motion, b: Motion) -> Vector:
        d, radius = separation(joint, a, b), joint.numbers["radius"]
        return along(joint, a, b), 0.5 * (so3.dot(d, d) / radius - radius)


def bead(**ring: object) -> dict[str, object]:
    """A small ball on a ring of 2 m that stands upright, let go at the height of its centre."""
    ball = {"name": "ball", "mass": 0.1, "inertia": [1e-4, 1e-4, 1e-4], "guess": {"position": [1.8, 0, 0]}}
    points = {"points": [[0, 0, 0], [0, 0, 0]], "axes": [[0, 1, 0]]}
    joint = {"name": "ring", "type": "on_ring", "bodies": ["ground", "ball"], **points, "radius": 2.0, **ring}
    return {"model": {"bodies": [ball], "joints": [joint]}, "integrator": {"step": 1e-3, "end_time": 2.0}}


def test_a_joint() -> None:
    """A ball on an upright ring is a pendulum, whose angle Jacobi's functions know."""
    sweep = {
        "runs": 20,
        "vary": {"joints.ring.radius": {"distribution": "uniform", "low": 1.0, "high": 3.0}},
    }
    with JOINTS.temporarily(OnRing):
        one, many = lienumba.run(bead()), lienumba.run(bead() | {"sweep": sweep})
        drawn = scene(one)
        schema = json_schema()["$defs"]["OnRing"]
    radius = many["joints.ring.radius"]
    for runs, radii in ((one, [2.0]), (many, radius.values)):
        assert (runs.status == 0).all()
        for run, r in zip(runs.position.values[:, :, 0], radii, strict=True):
            # released at 90 degrees: sin(angle/2) = k sn(K - w t, k), k = sin(45 degrees), w = sqrt(g/r)
            sn, *_ = ellipj(ellipk(0.5) - np.sqrt(9.81 / r) * runs.time.values, 0.5)
            angle = 2.0 * np.arcsin(np.sqrt(0.5) * sn)
            np.testing.assert_allclose(run[:, 0], r * np.sin(angle), rtol=0, atol=1e-8)
            np.testing.assert_allclose(run[:, 2], -r * np.cos(angle), rtol=0, atol=1e-8)
            np.testing.assert_allclose(run[:, 1], 0.0, rtol=0, atol=1e-12)
    assert radius.attrs["units"] == "m"
    assert [segment.kind for segment in drawn.runs[0].mechanism.segments] == ["arm", "axis"]
    assert schema["properties"]["radius"]["description"] == "the radius in m, above 0"


@pytest.mark.parametrize(
    ("keys", "sentence"),
    [
        ({"radius": -1.0}, "model.joints.ring.radius = -1.0: must be above 0; give the radius in m, above 0"),
        ({"radus": 1.0}, 'model.joints.ring.radus is not a known key; the nearest known name is "radius"'),
        ({"length": 1.0}, "model.joints.ring.length has no meaning for an on_ring joint; leave it out (it belongs to"),
        ({"type": "on_rng"}, 'model.joints.ring.type = "on_rng": is not known; the nearest known name is "on_ring"'),
        ({"axes": None}, "model.joints.ring.axes is missing; give the direction in the frame of the first body, as"),
        ({"radius": "2*t"}, 'model.joints.ring.radius = "2*t": must be a number'),
    ],
)
def test_a_joint_that_is_written_wrong(keys: dict[str, object], sentence: str) -> None:
    data = bead(**keys)
    data["model"]["joints"] = [{key: x for key, x in data["model"]["joints"][0].items() if x is not None}]
    with JOINTS.temporarily(OnRing), pytest.raises(ScenarioError, match=re.escape(sentence)):
        resolve(data)


def test_a_joint_of_which_a_sample_would_be_none() -> None:
    radius = {"distribution": "uniform", "low": -1.0, "high": 3.0}
    sentence = (
        'sweep.vary."joints.ring.radius".low = -1.0: allows values of 0 or below, which no joint of this type has'
    )
    with JOINTS.temporarily(OnRing), pytest.raises(ScenarioError, match=re.escape(sentence)):
        resolve(bead() | {"sweep": {"runs": 20, "vary": {"joints.ring.radius": radius}}})


def test_a_joint_that_does_not_fit_its_start() -> None:
    data = bead()
    data["model"]["bodies"][0] |= {"position": [1.8, 0, 0], "rotation": [1, 0, 0, 0]}
    del data["model"]["bodies"][0]["guess"]
    sentence = "model.joints.ring: its points are not where it allows them at t = 0: they miss by 0.19 m"
    with JOINTS.temporarily(OnRing), pytest.raises(ScenarioError, match=re.escape(sentence)):
        lienumba.run(data)


class Magnet(BetweenPoints):
    """Two magnets that repel each other with strength/d^3."""

    type: Literal["magnet"]
    strength: Timed = number("the strength in {}", "N m3", DISSIPATIVE)

    @staticmethod
    def potential(given: Given, c: Vector) -> Number:
        return 0.5 * given["strength"] / (c[0] * c[0])


def repelled(**push: Any) -> dict[str, Any]:
    """A bob that flies towards a magnet at the origin."""
    bob = {"name": "bob", "mass": 2, "inertia": [1, 1, 1], "position": [0.5, 0, 0], "velocity": [-0.3, 0, 0]}
    magnets = {"name": "push", "type": "magnet", "bodies": ["ground", "bob"], "points": [[0, 0, 0], [0, 0, 0]]}
    return {
        "model": {"gravity": [0, 0, 0], "bodies": [bob | {"rotation": [1, 0, 0, 0]}], "forces": [magnets | push]},
        "quantities": [{"name": "gap", "type": "point", "body": "bob"}],
        "integrator": {"step": 1e-3, "end_time": 1.0},
    }


def test_a_force() -> None:
    """The record of a force is its keys and its potential; of a body that it drives away, d^2 is a parabola in time."""
    vary = {"forces.push.strength": {"distribution": "uniform", "low": 0.5, "high": 2}}
    with FORCES.temporarily(Magnet):
        ds = lienumba.run(repelled(strength=1) | {"sweep": {"runs": 5, "vary": vary}})
        forces = json_schema()["$defs"]["ModelSection"]["properties"]["forces"]["items"]
        told = resolve(repelled(strength=-1)).warnings
        with pytest.raises(ScenarioError, match='"magnt": is not known; the nearest known name is "magnet"'):
            resolve(repelled(type="magnt"))
        with pytest.raises(ScenarioError, match=r"must be a number; give the strength in N m\^3"):
            resolve(repelled(strength=[1, 2]))
    strength, t = ds["forces.push.strength"], ds["time"]
    wanted = 0.25 - 0.3 * t + (0.09 + strength / (2 * 0.25)) * t**2
    np.testing.assert_allclose(ds["gap"].sel(axis="x") ** 2, wanted.transpose("run", "time"), rtol=1e-9)
    assert abs(ds["energy_residual"]).max() < 1e-9
    assert strength.attrs["units"] == "N m3"
    assert "magnet" in forces["discriminator"]["mapping"]
    assert "model.forces.push.strength = -1.0: is negative, so it pushes away" in str(told[0])


class Mainspring(AlongJoint):
    """The spring of a clock: its torque grows with the angle, over all turns."""

    kinds: ClassVar[tuple[str, ...]] = ("angle",)

    type: Literal["mainspring"]
    winding: Timed = number("the winding in {}", "N m rad-1", DISSIPATIVE)

    @staticmethod
    def potential(given: Given, c: Vector) -> Number:
        return 0.5 * given["winding"] * c[0] * c[0]


def test_a_force_about_an_axis() -> None:
    """It counts turns without being told to: from one side to the other it swings as far as it was wound."""
    wheel = {"name": "wheel", "mass": 1, "inertia": [1, 1, 0.5], "position": [0, 0, 0], "rotation": [1, 0, 0, 0]}
    hinge = {"name": "hinge", "type": "revolute", "bodies": ["ground", "wheel"], "at": [0, 0, 0], "axis": [0, 0, 1]}
    spring = {"name": "spring", "type": "mainspring", "joint": "hinge", "winding": 2}
    scenario = {
        "model": {"bodies": [wheel], "joints": [hinge | {"angle": 50.0, "rate": 0.0}], "forces": [spring]},
        "quantities": [{"name": "spin", "type": "angular_velocity", "body": "wheel"}],
        "integrator": {"step": 1e-3, "end_time": 2.0},
    }
    with FORCES.temporarily(Mainspring):
        ds = lienumba.run(scenario)
    t = ds["time"].values
    np.testing.assert_allclose(ds["spin"][0, :, 2], -100.0 * np.sin(2.0 * t), atol=1e-6)
    np.testing.assert_allclose(ds["potential_energy"][0], 2500.0 * np.cos(2.0 * t) ** 2, atol=1e-4)


SHOWN = ("OnRing", "Magnet", "RALSTON", "weyl", "WEYL", "angular_momentum", "MOMENTUM")


@pytest.mark.parametrize("name", SHOWN)
def test_the_document_shows_what_is_tested(name: str) -> None:
    """docs/architecture.md has the same lines, which are run there, too."""
    source = Path(__file__).read_text(encoding="utf-8")
    found = [
        ast.get_source_segment(source, node)
        for node in ast.parse(source).body
        if getattr(node, "name", None) == name
        or (isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name) and node.targets[0].id == name)
    ]
    assert len(found) == 1
    page = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
    assert str(found[0]) in page
