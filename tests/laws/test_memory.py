"""Arrays that sampled laws keep for each run: the same numbers however a law is written, and each run has its own."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import lienumba
from tests.facade import ScenarioError
from tests.laws import memories
from tests.laws.rigs import pendulum, run
from tests.rigs.libraries import built

FILE = Path(__file__).with_name("memories.py")
SIZE, EVERY, GAIN = 60, 0.01, 1.5
SPREAD = {"distribution": "uniform", "low": 0.3, "high": 0.9}
DELAY = """
void late(const double *u, double *x, double *y)
{
    y[0] = -u[1] * x[0];
    for (int n = 0; n < 59; n++)
        x[n] = x[n + 1];
    x[59] = u[0];
}
"""
LAW = """
import ctypes
import lienumba

command = lienumba.foreign(ctypes.CDLL({path!r}).late, inputs=2, outputs=1, states=60)


def late(joint, *, gain, memory):
    return joint.effort(command(joint.angle, gain, states=memory.line))
"""


def delayed(function: str, **keys: Any) -> dict[str, Any]:
    law = {"name": "own", "type": "python", "function": f"{FILE}:{function}", "joints": ["hinge"],
           "parameters": {"gain": GAIN}, "memory": {"line": SIZE}, "every": EVERY}  # fmt: skip
    return pendulum(law | keys)


def pendulum_until(end: float, gain: float) -> dict[str, Any]:
    data = delayed("late", parameters={"gain": gain}) | {"output": {"every": EVERY}}
    data["integrator"]["end_time"] = end
    return data


def ringing(**sections: Any) -> dict[str, Any]:
    """Pendulums with a ring of numbers of which some swing too far."""
    law = {"name": "own", "type": "python", "function": f"{FILE}:ring", "joints": ["hinge"],
           "parameters": {"limit": 0.6}, "memory": {"ring": 70, "places": 1}, "states": {"count": 0},
           "every": EVERY}  # fmt: skip
    sweep = {"runs": 11, "seed": 3, "vary": {"forces.own.parameters.limit": SPREAD}}
    return pendulum(law, sweep=sweep, output={"every": 0.1}, **sections)


def test_what_comes_late_comes_when_the_memory_is_full():
    """A gain of 0 moves otherwise from then on."""
    data, free = (pendulum_until(0.8, gain) for gain in (GAIN, 0.0))
    differs = np.flatnonzero((run(data).position.values != run(free).position.values).any(axis=(0, 2, 3)))
    assert differs[0] == SIZE + 1  # sampled at 0.6 s, and seen a step later


@pytest.mark.parametrize("function", ["late_jitted", "late_batched", "late_by_name"])
def test_a_law_has_the_bits_of_the_traced_one(function):
    np.testing.assert_array_equal(run(delayed(function)).position, run(delayed("late")).position)


def test_a_function_of_c_writes_to_the_memory(tmp_path):
    file = tmp_path / "laws.py"
    file.write_text(LAW.format(path=str(built(tmp_path, source=DELAY))))
    law = delayed("late")["model"]["forces"][0] | {"function": f"{file}:late"}
    np.testing.assert_array_equal(
        run(pendulum(law)).position,
        run(delayed("late")).position,
    )


@pytest.mark.usefixtures("vectors")
@pytest.mark.parametrize("integrator", [{"step": 0.01}, {"tolerance": 1e-6}])
def test_each_run_has_its_own(integrator):
    """Runs fail alone, and have the same bits for any workers, in whichever lane they are, and alone."""
    data = ringing(integrator={"end_time": 1.0, **integrator})
    whole = lienumba.run(data, workers=1)
    failed = whole.status.values != 0
    assert 0 < failed.sum() < 11
    assert set(np.unique(whole["own.count"].values[~failed, -1])) == {101.0}
    good = np.flatnonzero(~failed).tolist()
    for ds in (lienumba.run(data, workers=2), run(data, runs=good[1:]), run(data, runs=good[:1])):
        np.testing.assert_array_equal(ds.position, whole.position.sel(run=ds.run))


def test_on_floats_a_function_writes_to_a_memory():
    line = lienumba.laws.Memory([1.0, 2.0, 3.0])
    assert (memories.shifted(0.5, 2.0, line), list(line)) == (-2.0, [2.0, 3.0, 0.5])
    assert (memories.rolled(0.25, 2.0, line), list(line)) == (-4.0, [3.0, 0.5, 0.25])


REFUSED = {
    "longer": ({}, r"model\.forces\.own: longer in .*ValueError: a memory of 60 numbers would get 61"),
    "twice": ({}, r"model\.forces\.own: counted gets one array of a memory twice; give it once"),
    "set_state": ({"parameters": {"limit": 1}, "states": {"count": 0}}, "a law does not set its state count, but"),
    "wordy": ({}, r"model\.forces\.own: memory\.line needs a number, but gets \"late\""),
    "absent": ({}, r"the law has no memory lines; it has line"),
    "outside": ({}, r"model\.forces\.own: outside in .*IndexError"),
    "late": ({"every": None}, r"model\.forces\.own\.memory: only a sampled law has a memory; give every"),
    "late_jitted": ({"memory": {"line": 0}}, r"model\.forces\.own\.memory\.line = 0"),
    "late_batched": ({"memory": {"line": 3000}}, r"model\.forces\.own\.memory = 3000: has more than 2,000 numbers"),
    "late_unsaid": ({"memory": {}}, r"has the argument memory, which is .* give memory = \{ line = 200 \}, and every"),
}


@pytest.mark.parametrize("function", REFUSED)
def test_what_is_refused_is_refused_before_runs_begin(function):
    keys, rule = REFUSED[function]
    data = delayed(function.removesuffix("_unsaid"))
    law = data["model"]["forces"][0] | keys
    data["model"]["forces"][0] = {key: value for key, value in law.items() if value is not None}
    with pytest.raises(ScenarioError, match=rule):
        lienumba.run(data)


def test_an_equilibrium_has_no_memory():
    with pytest.raises(ScenarioError, match=r"model\.forces\.own\.memory: has a memory, and an equilibrium"):
        lienumba.equilibrium(delayed("late"))
