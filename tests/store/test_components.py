"""Names of components of a dataset's variables, and what is told of names that it has not."""

import pytest

from lienumba import ScenarioError
from lienumba.store.components import matching

KNOWN = {"pointing": ["pointing.x", "pointing.y", "pointing.z"], "pointing.angle": ["pointing.angle"], "rate": ["rate"]}


@pytest.mark.parametrize(
    ("asked", "near"), [("pointing.angl", "pointing.angle"), ("pointing.Z", "pointing.z"), ("rat", "rate")]
)
def test_the_nearest_of_all_parts_of_a_thing_is_told(asked: str, near: str) -> None:
    with pytest.raises(ScenarioError) as caught:
        matching(asked, KNOWN, "output")
    assert str(caught.value) == f'the dataset has no output "{asked}"; the nearest known name is "{near}"'
