"""Keys that choose among equations are the same in all runs; odd rotations and names are told in a sentence."""

from typing import Any

import pytest

import lienumba
from tests.facade import ScenarioError
from tests.rigs.inputs import at_hinge

POINT = {"name": "p", "type": "point", "body": "wheel", "derivative": 1}
SHAPED = {"name": "n", "type": "band", "std": 1.0, "every": 0.1, "order": 2}


@pytest.mark.parametrize("path", ["quantities.p.derivative", "noise.n.order"])
def test_a_choice_is_not_varied(path: str) -> None:
    system = at_hinge("0*n").quantity(**POINT).noise(**SHAPED).vary(path, "uniform", low=0.0, high=1.0)
    with pytest.raises(ScenarioError, match="chooses what is computed, which is the same in all runs; vary a number"):
        lienumba.run(system, overrides={"sweep.runs": 4})


def test_a_rotation_that_varies_about_an_axis_of_length_0() -> None:
    system = at_hinge("0").vary("bodies.wheel.rotation", "rotation_normal", std=0.1)
    data: dict[str, Any] = system.to_dict()
    data["model"]["bodies"][0]["rotation"] = {"axis": [0, 0, 0], "angle": 1.0}
    data["sweep"]["runs"] = 4
    with pytest.raises(ScenarioError, match=r"rotation\.axis = .* has no direction"):
        lienumba.run(data)


def test_a_name_of_a_file_is_written_out() -> None:
    with pytest.raises(ScenarioError) as error:
        lienumba.run(at_hinge("0").to_dict() | {"start": {"file": "a\u202eb.nc"}})
    assert str(error.value) == 'start.file = "a\\u202eb.nc": a\\u202eb.nc does not exist; check the path'
