"""What a System says of itself, finished or not."""

import pytest

from lienumba.scenario.system import System
from tests.scenario.test_system import heavy_top


def test_a_finished_system_says_what_it_comes_to():
    top = heavy_top().force("rope", type="spring_damper", bodies=["ground", "top"], points=[[0, 0, 0]] * 2, stiffness=5)
    lines = repr(top).splitlines()
    assert lines[:3] == [
        'System "example"',
        "  bodies      top (mass 15)",
        "  joints      pivot (spherical, ground - top)",
    ]
    assert "  forces      rope (spring_damper, ground - top, stiffness 5)" in lines
    assert "  integrator  step = 0.001, end_time = 0.1" in lines
    assert "  varied      bodies.top.mass (normal)" in lines
    assert lines[-1].startswith("  ready       1 body, 1 joint, 1 force, 100 steps of rk4, 11 stored times, 3 runs")


def test_an_unfinished_one_says_what_is_missing():
    assert repr(System()).splitlines()[0] == "System"
    assert "integrator is missing; give the section [integrator]" in repr(System())
    system = System().body("a", mass=-1, inertia=[1, 1, 1]).joint("j", "spherical", ["a", "b"]).integrator(end_time=1)
    assert "wrong" in repr(system)
    assert "model.bodies.a.mass = -1: must be above 0" in repr(system)


@pytest.mark.parametrize("data", [{}, {"model": 3}, {"model": {"bodies": [1, {"name": 2}]}, "sweep": {"vary": [0]}}])
def test_nothing_that_is_in_it_makes_it_fail(data):
    system = System()
    system._data = data
    assert "wrong" in repr(system) or "missing" in repr(system)
    assert system._repr_html_().startswith("<table>")


def test_files_that_are_not_there_are_told():
    assert "there is no such file" in repr(System().table("thrust", file="nowhere.csv", time="t", value="F"))


def test_many_things_are_cut_and_texts_escaped():
    system = System("<b>&</b>")
    for k in range(20):
        system.body(f"link_{k}", mass=1, inertia=[1, 1, 1])
    system.parameter("x", "<script>")
    assert "link_5 (mass 1), and 14 more" in repr(system)
    html = system._repr_html_()
    assert "&lt;b&gt;&amp;&lt;/b&gt;" in html
    assert "<script>" not in html
    assert "\n" not in repr(System("a\nb")).splitlines()[0]
