"""Names of numbers of a dataset, and what is told of names that it has not."""

import pytest

from lienumba import ScenarioError
from lienumba.store.names import Names, find, kind_of, names_in

LABELS = {"axis": ["x", "y", "z"]}
SERIES = ("run", "time")
EVERY = [
    *names_in("pointing", ["axis"], LABELS, "rad", kind_of("pointing", (*SERIES, "axis"), False)),
    *names_in("pointing.angle", [], {}, "rad", kind_of("pointing.angle", SERIES, False)),
    *names_in("rate", [], {}, "1", kind_of("rate", SERIES, False)),
]
KNOWN = Names({x.name: x for x in EVERY})


@pytest.mark.parametrize(
    ("asked", "near"), [("pointing.angl", "pointing.angle"), ("pointing.Z", "pointing.z"), ("rat", "rate")]
)
def test_the_nearest_of_all_parts_of_a_thing_is_told(asked: str, near: str) -> None:
    with pytest.raises(ScenarioError) as caught:
        find(asked, KNOWN)
    assert str(caught.value) == f'the dataset has no output "{asked}"; the nearest known name is "{near}"'
