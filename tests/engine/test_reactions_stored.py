"""What joints do is computed where it is stored, and leaves all else as it is."""

import numpy as np
import pytest

import lienumba
from lienumba.engine.runner import operation_counts
from tests.facade import resolve
from tests.rigs.places import ROOT

SHORT = {"integrator.end_time": 0.1, "output.every": 0.05}
FEW = {**SHORT, "output.variables": ["position", "energy"]}


def scenario(name: str):
    return ROOT / "scenarios" / f"{name}.toml"


@pytest.mark.parametrize("name", ["four_bar", "ur5"])
def test_without_reactions_all_else_has_the_same_bits_and_less_is_computed(name: str) -> None:
    every, few = (lienumba.run(scenario(name), overrides=x, progress=False) for x in (SHORT, FEW))
    for variable in ("position", "energy", "max_energy_drift", "max_position_violation", "last_velocity"):
        assert few[variable].values.tobytes() == every[variable].values.tobytes(), variable
    more, less = (operation_counts(resolve(scenario(name), overrides=x)) for x in (SHORT, FEW))
    assert less["observe"]["operations"] < 0.6 * more["observe"]["operations"]
    assert {kernel: x for kernel, x in less.items() if kernel != "observe"} == {
        kernel: x for kernel, x in more.items() if kernel != "observe"
    }


@pytest.mark.parametrize("asked", [{"output.summary": {"joint_force": ["max"]}}, {"quantities": "reaction"}])
def test_what_reads_them_has_them(asked: dict) -> None:
    every = lienumba.run(scenario("four_bar"), overrides=SHORT, progress=False)
    name = str(every["joint"].values[1])
    if "quantities" in asked:
        asked = {"quantities": [{"name": "seen", "type": "reaction", "joint": name}]}
        few = lienumba.run(
            scenario("four_bar"), overrides={**FEW, **asked, "output.variables": ["seen"]}, progress=False
        )
        assert few["seen.force"].values.tobytes() == every["joint_force"].sel(joint=name).values.tobytes()
        assert np.ptp(few["seen.force"].values) > 0.0
    else:
        few = lienumba.run(scenario("four_bar"), overrides={**FEW, **asked}, progress=False)
        np.testing.assert_array_equal(few["joint_force_max"].values, every["joint_force"].values.max(axis=1))
