"""Derivatives change no bit of the motion, and are the same however runs and inputs are dealt out."""

import warnings
from typing import Any

import numpy as np
import pytest

import lienumba
from tests.oracles.changing import scenarios
from tests.rigs import parts

RUNS = 11
INPUTS = [f"bodies.ball.velocity[{n}]" for n in range(3)] + [f"bodies.ball.position[{n}]" for n in range(3)]
INPUTS += ["contacts.floor.restitution", "contacts.floor.friction", "gravity[2]", "bodies.ball.mass"]
OF = ["position", "event_time", "highest", "last_velocity"]


def ball(**integrator: Any) -> dict[str, Any]:
    """A ball that is thrown and bounces with friction, in runs that bounce at different times; more inputs than a
    vector has lanes."""
    body = parts.body("ball", 1, 0.004, position=[0, 0, 0.4], velocity=[1, 0.3, 0.2], angular_velocity=[0, 2, 5])
    floor = parts.sphere("floor", "ball", 0.1, restitution=0.7, friction=0.2, rest_speed=0.05)
    data = scenarios.scenario("A ball", {"gravity": [0, 0, -9.81], "bodies": [body], "contacts": [floor]}, 0.9, 1e-9)
    ranges = {"bodies.ball.position[2]": (0.3, 0.5), "contacts.floor.restitution": (0.5, 0.8)}
    return data | {
        "integrator": {"method": "dop853", "tolerance": 1e-9, "end_time": 0.9} | integrator,
        "quantities": [{"name": "gap", "type": "contact", "contact": "floor"}],
        "events": [{"name": "low", "when": "gap.gap < 0.05"}],
        "measures": [{"name": "highest", "value": "max(gap.gap)", "units": "m"}],
        "output": {"every": 0.1},
        "sweep": parts.sweep(RUNS, ranges, seed=3),
    }  # fmt: skip


def run(data: dict[str, Any], by: list[str] | None = None, of: list[str] = OF, **options: Any) -> Any:
    asked = {} if by is None else {"sensitivities": {"of": of, "by": by}}
    return lienumba.run(data | asked, progress=False, **{"workers": 1, **options})


def assert_same(one: Any, other: Any, prefix: str = "") -> None:
    """What both have is the same to the bit."""
    names = [x for x in {*one.data_vars} & {*other.data_vars} if str(x).startswith(prefix)]
    assert names
    for name in names:
        assert one[name].values.tobytes() == other[name].values.tobytes(), name


@pytest.mark.parametrize("integrator", [{}, {"method": "rk4", "step": 5e-3, "tolerance": None}], ids=["dop853", "rk4"])
def test_the_motion_is_that_without_derivatives(integrator: dict[str, Any]) -> None:
    data = ball(**integrator)
    data["integrator"] = {key: x for key, x in data["integrator"].items() if x is not None}
    assert_same(run(data, INPUTS), run(data))


def test_workers_chunks_and_neighbours_change_no_bit() -> None:
    data = ball()
    every = run(data, INPUTS)
    assert not np.isnan(every.d_position).any()
    assert np.abs(every.d_highest).max() > 0
    assert_same(every, run(data, INPUTS, workers=2), "d_")
    for labels in ([3], [7, 3], range(9)):  # which share chunks with others
        assert_same(every.sel(run=[3]), run(data, INPUTS, runs=labels).sel(run=[3]), "d_")


def test_an_input_has_its_derivative_alone_and_beside_others() -> None:
    """More inputs than a vector has lanes, in both orders, and some alone."""
    data = ball()
    every = run(data, INPUTS, runs=[2, 5])
    for by in (INPUTS[::-1], INPUTS[6:7], INPUTS[7:9]):
        other = run(data, by, runs=[2, 5])
        for name in ("d_position", "d_event_time", "d_highest", "d_last_velocity"):
            same = other[name].sel(input=by).values
            np.testing.assert_allclose(same, every[name].sel(input=by).values, rtol=1e-12, atol=1e-12)


def test_resumed_and_in_parts_and_replayed(tmp_path: Any) -> None:
    data = ball()
    every = run(data, INPUTS[:2])
    run(data, INPUTS[:2], output=tmp_path / "some.nc", runs=range(4))
    whole = run(data, INPUTS[:2], output=tmp_path / "some.nc", resume=True)
    assert_same(every, whole, "d_")
    whole.close()
    for n in (1, 2):
        run(data, INPUTS[:2], output=tmp_path / f"part{n}.nc", part=(n, 2))
    merged = lienumba.merge([tmp_path / "part1.nc", tmp_path / "part2.nc"], tmp_path / "merged.nc")
    assert_same(every, merged, "d_")
    with warnings.catch_warnings(action="error"):  # it warns of other bits
        lienumba.replay(every, 3, progress=False)


def test_full_runs_and_summaries_have_derivatives_of_ends_alone() -> None:
    data = ball() | {"output": {"mode": "summary", "summary": {"gap.gap": ["max"]}, "full_runs": "3"}}
    found = run(data, INPUTS[:2], ["last_velocity", "highest"])
    expected = run(ball(), INPUTS[:2], ["last_velocity", "highest"])
    np.testing.assert_allclose(found.d_highest, expected.d_highest, rtol=1e-9, atol=1e-12)
    with pytest.raises(lienumba.ScenarioError, match="position"):
        run(data, INPUTS[:2], ["position"])
