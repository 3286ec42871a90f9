"""Names of what is wanted of runs: the dataset has one variable of a name, which is said before anything runs."""

from pathlib import Path
from typing import Any

import pytest

import lienumba
from lienumba.scenario.base.toml import dumps
from lienumba.store.layout import COORDINATES, VARIABLES
from tests.facade import resolve
from tests.rigs.everything import EVERYTHING
from tests.scenario.checks.refusal import force, refused_by_both, rig

TAKEN = "the dataset has a variable of this name already"
REMEDY = "give another name; docs/write_a_scenario.md lists those that are reserved"
ASKED = {
    "measures": {"value": "max(swing.angle)"},
    "requirements": {"value": "max(swing.angle)", "below": 1, "probability": 0.5},
}


@pytest.mark.parametrize("kind", ASKED)
@pytest.mark.parametrize("name", dict.fromkeys([*COORDINATES, *VARIABLES, "failed"]))
def test_names_that_datasets_take_are_refused(kind: str, name: str) -> None:
    with pytest.raises(lienumba.ScenarioError) as caught:
        resolve(EVERYTHING | {"requirements": [], "measures": [], kind: [{"name": name, **ASKED[kind]}]})
    assert str(caught.value) == f'{kind}.{name}.name = "{name}": {TAKEN}; {REMEDY}'


def test_what_a_dataset_has_is_no_name_for_another_measure(tmp_path: Path) -> None:
    """Of every kind that there is, before a run and by `validate`."""
    names = [str(name) for name in lienumba.run(EVERYTHING, runs=[0]).variables if "." not in str(name)]
    assert {"axis", "q", "swings far", "run", "effort", "coordinate_units"} & {*names} >= {"axis", "q", "run"}

    def with_measures(*names: str) -> dict[str, Any]:
        return EVERYTHING | {"measures": EVERYTHING["measures"] + [{"name": x, **ASKED["measures"]} for x in names]}

    with pytest.raises(lienumba.ScenarioError) as caught:
        resolve(with_measures(*names))
    said = [str(problem) for problem in caught.value.problems if TAKEN in str(problem)]
    later = [name for name in names if not any(f'name = "{name}": ' in line for line in said)]
    assert len(later) < len(names) / 2
    for name in [names[0], *later]:  # of which some are known once the model is built
        lines = refused_by_both(tmp_path, dumps(with_measures(name)))
        assert any(text in lines[0] for text in (TAKEN, "is also the name of")), lines


def test_the_name_of_a_requirement_on_another_number_is_a_label(tmp_path: Path) -> None:
    asked = {"name": "axis", "value": "peak", "below": 1, "probability": 0.5}
    ds = lienumba.run(EVERYTHING | {"requirements": [asked]}, runs=[0])
    assert ds.requirement.values.tolist() == ["axis"]


def test_states_of_laws_are_stored_by_names_that_are_free(tmp_path: Path) -> None:
    (tmp_path / "laws.py").write_text("def law(t, arm, states):\n    return (0, 0, 0), {'s': 0}\n")
    keys = 'type = "python"', 'function = "laws.py:law"', 'bodies = ["arm"]', "states = { s = 0 }"
    lines = refused_by_both(tmp_path, rig(force(*keys, name='name = "axis"')))
    assert any("its states are stored by this name, which the dataset has already" in line for line in lines), lines
