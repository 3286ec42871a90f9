"""Functions by `lienumba.jit` in laws: as the same laws traced, run by run; refused where derivatives are needed."""

import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import lienumba
from lienumba.compiler import native
from lienumba.compiler.foreign.calls import Argument
from tests.facade import ScenarioError, resolve
from tests.laws import jitted
from tests.laws.rigs import close, pendulum, run
from tests.rigs import parts
from tests.rigs.places import ROOT

FILE = Path(__file__).with_name("jitted.py")
GAINS = {"kp": 30, "ki": 8, "kd": 2, "target": 0.2, "limit": 4}
SPREAD = {"distribution": "uniform", "low": 0.3, "high": 0.9}
WITHOUT = """
import sys
import lienumba
from lienumba.compiler import emit, flat, native
from lienumba.compiler.value_types import DOUBLE
from tests.laws.test_jitted import arm
native.LEVEL, flat.PASSES, emit.VALUES = 0, 0, DOUBLE
assert (lienumba.run(arm(), workers=1).status == 0).all()
assert "numba" not in sys.modules, "numba"
"""


def own(function: str, **keys: Any) -> dict[str, Any]:
    return {"name": "own", "type": "python", "function": f"{FILE}:{function}", **keys}


def arm(function: str = "pid", **sections: Any) -> dict[str, Any]:
    law = own(function, joints=["hinge"], parameters=GAINS, states={"integral": 0.1}, every=0.037)
    return pendulum(law, end=0.3, **sections)


def swinging(**keys: Any) -> dict[str, Any]:
    """Pendulums of which some swing too far for their motors."""
    sweep = {"runs": 11, "seed": 3, "vary": {"forces.own.parameters.limit": SPREAD}}
    law = own("motor", joints=["hinge"], parameters={"limit": 0.6}, **keys)
    return pendulum(law, end=0.3, sweep=sweep, output={"every": 0.1})


def flight(function: str) -> dict[str, Any]:
    craft = parts.body("craft", 1.0, [0.02, 0.02, 0.03], position=[0, 0, 0.5], velocity=[0, 0, 0.5],
                       rotation={"axis": [1, 0.5, 0], "angle": 0.3}, angular_velocity=[0.5, -1, 0.3])  # fmt: skip
    states = {"phase": 0, "waited": 0, "integral": 0}
    return {
        "model": {"bodies": [craft], "forces": [own(function, bodies=["craft"], every=0.02, states=states)]},
        "integrator": {"step": 0.02, "end_time": 1.2},
        "output": {"every": 0.1},
    }


def test_a_sampled_controller_is_as_the_traced_one():
    a, b = run(arm()), run(arm("traced_pid"))
    close(a, b, "position", "angular_velocity", "own.integral", atol=1e-13)
    assert float(a["own.integral"][0, -1]) != 0.1


def test_an_autopilot_with_phases_anti_windup_and_a_table_is_as_the_traced_one():
    a, b = run(flight("fly")), run(flight("traced_fly"))
    close(a, b, "position", "rotation", "velocity", "own.phase", "own.integral", atol=1e-13)
    assert set(a["own.phase"].values.ravel()) == {0.0, 1.0, 2.0}


@pytest.mark.parametrize("every", [{}, {"every": 0.02}])
def test_a_run_in_which_it_raises_fails_alone(every):
    """The others have the bits that they have without it, in whichever lane they are, and for any workers."""
    whole = lienumba.run(swinging(**every), workers=1)
    failed = whole.status.values != 0
    assert 0 < failed.sum() < 11
    assert set(whole.status.values[failed]) == {1}  # non_finite
    good = np.flatnonzero(~failed).tolist()
    for ds in (lienumba.run(swinging(**every), workers=2), run(swinging(**every), runs=good[1:])):
        np.testing.assert_array_equal(ds.position, whole.position.sel(run=ds.run))


def test_it_may_be_handed_over_in_python_and_a_table_that_is_edited_makes_another_program(monkeypatch):
    def scenario() -> dict[str, Any]:
        data = flight("fly")
        data["model"]["forces"][0]["function"] = jitted.fly
        return data

    monkeypatch.setattr(jitted, "FACTORS", jitted.FACTORS.copy())
    before, sha = run(scenario()), resolve(scenario()).sha256()
    np.testing.assert_array_equal(before.position, run(flight("fly")).position)
    jitted.FACTORS[:] *= 0.5
    assert resolve(scenario()).sha256() != sha
    assert abs(run(scenario()).position - before.position).max() > 0.1


def test_kernels_are_linked_before_another_process_compiles_them(monkeypatch, anew):
    """As it does with long ones."""
    whole, here, made = run(arm()), native.compile_text, []

    def compile_text(text: str) -> bytes:
        made.append("@lienumba_call_" in text)
        return native._emit_elsewhere(text, *native.cpu()) if made[-1] else here(text)

    monkeypatch.setattr(native, "compile_text", compile_text)
    np.testing.assert_array_equal(run(arm()).position, whole.position)
    assert any(made)


def test_later_processes_import_no_numba():
    jitted.controller.compiled([Argument("number", 1)] * 9)
    done = subprocess.run([sys.executable, "-c", WITHOUT], cwd=ROOT, env=os.environ, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("method", ["taylor", "radau5", "generalized_alpha"])
def test_a_method_that_needs_derivatives_takes_a_sampled_one_only(method):
    law = own("motor", joints=["hinge"], parameters={"limit": 3})
    rule = f'model.forces.own: integrator.method = "{method}" differentiates it, but it calls limited, .*every'
    with pytest.raises(ScenarioError, match=rule):
        lienumba.run(pendulum(law), overrides={"integrator.method": method})


def test_a_law_is_not_decorated_itself():
    rule = r"model\.forces\.own\.function.*: is a function for Numba or of arrays, but a law is traced; write a law"
    for function in (f"{FILE}:limited", jitted.limited):
        with pytest.raises(ScenarioError, match=rule):
            lienumba.run(pendulum(own("", joints=["hinge"]) | {"function": function}))


def test_an_implicit_method_with_a_sampled_one():
    radau = {"integrator.method": "radau5"}
    a, b = (run(arm(function), overrides=radau) for function in ("pid", "traced_pid"))
    close(a, b, "position", "own.integral", atol=1e-12)


def test_what_differentiates_a_law_refuses_it():
    law = own("motor", joints=["hinge"], parameters={"limit": 3})
    with pytest.raises(
        ScenarioError, match=r"the function limited: .* has no derivative, which is needed here; sample"
    ):
        lienumba.linearise(pendulum(law))
    lienumba.linearise(pendulum(law | {"every": 0.1}))
    with pytest.raises(ScenarioError, match=r"model\.forces\.own: an equilibrium differentiates it, but it calls lim"):
        lienumba.equilibrium(pendulum(law | {"every": 0.1}))
    potential = own("energy", joints=["hinge"], parameters={"limit": 3}, returns="potential")
    with pytest.raises(ScenarioError, match=r"a potential energy is differentiated, but calls limited, .*return loads"):
        lienumba.run(pendulum(potential))
    data = pendulum()
    equation = {"name": "line", "type": "python", "function": f"{FILE}:turns", "bodies": ["rod"]}
    data["model"]["joints"].append(equation | {"parameters": {"limit": 3}})
    with pytest.raises(ScenarioError, match="an equation of a joint is differentiated, but calls limited"):
        lienumba.run(data)
