"""Requirements whose value is a formula of the whole run, as a measure of their own name."""

from typing import Any

import numpy as np
import pytest

import lienumba
from tests.facade import ScenarioError
from tests.rigs.inputs import at_hinge

FORMULA = "max(abs(hinge_at.angle), t > 0.25)"
SETTINGS = {"method": "dop853", "tolerance": 1e-10, "end_time": 2.0}


def asked(*requirements: dict[str, Any], **more: Any) -> dict[str, Any]:
    system = at_hinge("-0.1*w**2*hinge_at.angle + push").parameter("w", 3.0).parameter("push", 0.1)
    data: dict[str, Any] = system.vary("parameters.push", "uniform", low=0.05, high=0.2).to_dict()
    data["sweep"] |= {"runs": 40}
    wanted = [{"below": 0.25, "probability": 0.5, **x} for x in requirements]
    return data | {"integrator": SETTINGS, "requirements": wanted} | more


def test_the_value_may_be_a_formula_of_the_whole_run() -> None:
    data = asked({"name": "stays near", "value": FORMULA}, measures=[{"name": "far", "value": FORMULA}])
    ds = lienumba.run(data)
    largest = 2 * ds["parameters.push"] / 0.1 / 9.0  # of an oscillator that is pushed from rest
    np.testing.assert_allclose(ds["stays near"], largest, rtol=0, atol=1e-8)
    np.testing.assert_array_equal(ds["stays near"], ds.far)
    near = ds.sel(requirement="stays near")
    np.testing.assert_allclose(near.requirement_margin, 0.25 - largest, rtol=0, atol=1e-8)
    np.testing.assert_array_equal(near.requirement_met, largest < 0.25)
    assert ds["stays near"].attrs["measure"] == FORMULA
    again = lienumba.run(data, runs=[7, 3])
    np.testing.assert_array_equal(again["stays near"], ds["stays near"].sel(run=[7, 3]))


def test_steps_of_one_length_and_no_other_measure() -> None:
    ds = lienumba.run(asked({"name": "near", "value": "max(t)"}, integrator={"step": 0.05, "end_time": 0.5}), runs=[0])
    np.testing.assert_array_equal(ds["near"], 0.5)


def test_what_never_holds_does_so_late_and_has_done_so_early() -> None:
    """The runs that never leave a band have settled, and were told to have failed; what is undefined, still is."""
    limit = "abs(hinge_at.angle) > 0.25"
    ds = lienumba.run(
        asked(
            {"name": "settles", "value": f"last_time({limit})", "below": 1.7},
            {"name": "settles at all", "value": f"max(last_time({limit}), 0)", "below": 1.7},
            {"name": "late", "value": "late", "below": None, "above": 0.5},
            {"name": "soon", "value": "first_time(hinge_at.angle > 0.25)", "below": 1.0},
            {"name": "undefined", "value": "last_time(sqrt(hinge_at.angle - 0.1) > 2)", "below": 1.7},
            measures=[{"name": "late", "value": f"first_time({limit})"}],
        )
    )
    push, good = ds["parameters.push"].values, ds.status.values == 0
    never = 2 * push / 0.1 / 9.0 < 0.25
    assert 0 < never.sum() < good.sum() == 40
    np.testing.assert_array_equal(np.isnan(ds["settles"]), never)
    np.testing.assert_array_equal(np.isnan(ds["late"]), never)
    np.testing.assert_array_equal(ds["settles at all"][never], 0.0)
    last = np.where(never, -np.inf, ds["settles"])
    first = np.where(never, np.inf, ds["late"])
    for n, met in enumerate((last < 1.7, last < 1.7, first > 0.5, first < 1.0, np.zeros(40, bool))):
        np.testing.assert_array_equal(ds.requirement_met[:, n], met)
    np.testing.assert_array_equal(ds.requirement_margin[never, 0], np.inf)
    np.testing.assert_array_equal(ds.requirement_margin[never, 3], -np.inf)


REFUSED = [
    ({"value": "max(hinge_at.angel)"}, 'requirements.near.value = "max(hinge_at.angel)": has the unknown name'),
    ({"value": "maximum(hinge_at.angle)"}, "calls the unknown function"),
    ({"value": "sin(2)"}, "is no number of a whole run; write one of max(...)"),
    ({"value": "far"}, "is not a number that the dataset has for each run"),
]


@pytest.mark.parametrize(("keys", "message"), REFUSED, ids=str)
def test_what_is_wrong_is_told(keys: dict[str, Any], message: str) -> None:
    with pytest.raises(ScenarioError) as error:
        lienumba.run(asked({"name": "near", **keys}))
    assert message in str(error.value)


def test_its_name_is_that_of_a_variable() -> None:
    measures = [{"name": "near", "value": "max(t)"}]
    with pytest.raises(ScenarioError, match=r"requirements\.near\.name = \"near\": is also the name of a measure"):
        lienumba.run(asked({"name": "near", "value": FORMULA}, measures=measures))
    with pytest.raises(ScenarioError, match=r"requirements\.status\.name = \"status\": the dataset has a variable"):
        lienumba.run(asked({"name": "status", "value": FORMULA}))
