"""Everything that the engine "numba" does not support is refused before the run, in one sentence each."""

import pytest

import lienumba
from tests.facade import ScenarioError
from tests.rigs.every_law import EVERY_LAW

TOP = "scenarios/heavy_top.toml"
KEYS = [
    ({"integrator.method": "radau5"}, "integrator.method"),
    ({"integrator.method": "cf4"}, "integrator.method"),
    ({"integrator.group": "SE3"}, "integrator.group"),
    ({"integrator.coordinates": "joint"}, "integrator.coordinates"),
    ({"projection.position": "embedded"}, "projection.position"),
    ({"projection.chord": True}, "projection.chord"),
    ({"output.joint_coordinates": True}, "output.joint_coordinates"),
    ({"model.gravity": [0, 0, "where(t < 0.1, 0, -9.81)"]}, "model"),
    ({"model.events": [{"name": "low", "when": "t > 0.1"}]}, "events"),
]


@pytest.mark.parametrize(("keys", "place"), KEYS)
def test_a_refusal_names_the_key_and_the_remedy(keys, place):
    with pytest.raises(ScenarioError) as error:
        lienumba.run(TOP, overrides={"integrator.engine": "numba"} | keys, progress=False)
    (sentence,) = str(error.value).splitlines()
    assert sentence.startswith(place)
    assert 'the engine "numba" does not support' in sentence
    assert sentence.endswith("or leave integrator.engine out")


def test_elements_that_it_does_not_support_are_refused_one_by_one():
    with pytest.raises(ScenarioError) as error:
        lienumba.run(EVERY_LAW, overrides={"integrator.engine": "numba"}, progress=False)
    refused = [x.partition(":")[0].partition(" = ")[0] for x in str(error.value).splitlines()]
    assert {"model.drivers.pull", "model.forces.rub.type", "model.forces.air.type", "model.forces.mount.type"} <= {
        *refused
    }
    assert not any("push" in x or "coil" in x or "servo" in x for x in refused)
