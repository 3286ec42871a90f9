"""Laws of the user's own that do not work: one clear message each that names the place, the same from both commands."""

from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from typer.testing import CliRunner

from tests.facade import app
from tests.scenario.checks.refusal import force, refused, refused_by_both, rig
from tests.scenario.start.code_cases import (
    ARGUMENTS,
    CALLS,
    FILES,
    IN,
    LOADS,
    QUANTITIES,
    RULES,
    STATES,
    body,
    law,
    own_joint,
)

RETURNS = {
    "a number": (law("def f(j): return 3.0\n"), RULES + LOADS),
    "a text": (law("def f(j): return 'push'\n"), RULES + LOADS),
    "numbers": (law("def f(j): return [1, 2]\n"), RULES + LOADS),
    "an array": (law("def f(j): return np.zeros(3)\n"), RULES + LOADS),
    "a generator": (law("def f(j): yield j.effort(1)\n"), RULES + LOADS),
    "two numbers for three": (
        body("def f(b): return b.force((1, 2))\n"),
        f"{RULES}f: the force that it returns must have 3",
    ),
    "a point of two": (
        body("def f(b): return b.force((1, 2, 3), at=(1, 2))\n"),
        f"{RULES}f: the force that it returns must ",
    ),
    "an effort of a text": (law("def f(j): return j.effort('x')\n"), RULES),
    "an effort of a vector": (law("def f(j): return j.effort((1, 2))\n"), RULES),
    "a complex number": (law("def f(j): return j.effort(1j)\n"), RULES),
    "NaN": (law("def f(j): return j.effort(math.nan)\n"), f"{RULES}must be finite at the start; "),
    "NaN at the start": (
        law("def f(j): return j.effort(sqrt(-1 - j.angle))\n"),
        f"{RULES}must be finite at the start; ",
    ),
    "states without a pair": (
        law("def f(j): return j.effort(1)\n", STATES),
        f"{RULES}f: it has states, so it must return a p",
    ),
    "states by wrong names": (
        law("def f(j): return None, {'y': 1}\n", STATES),
        f"{RULES}f: it must return one number for each of its states, x",
    ),
    "too many states": (
        law("def f(j): return None, (1, 2)\n", STATES),
        f"{RULES}f: it must return one number for each of its",
    ),
    "a state of a text": (law("def f(j): return None, 'x'\n", STATES), f"{RULES}the state x needs a number, but "),
    "rates that nobody asked for": (law("def f(j): return j.effort(1), {'x': 1}\n"), RULES + LOADS),
}

POTENTIAL, VELOCITY = 'returns = "potential"', 'level = "velocity"'
LEVELS = {
    "potential of a velocity": (body("def f(b): return b.velocity.x\n", POTENTIAL), f"{RULES}depends on velocities, "),
    "potential of a rate": (law("def f(j): return j.rate*2\n", POTENTIAL), IN),
    "potential of nothing": (law("def f(j): pass\n", POTENTIAL), f"{RULES}must return one number, "),
    "potential of loads": (
        body("def f(b): return b.force([0, 0, 1])\n", POTENTIAL),
        f"{RULES}must return one number, ",
    ),
    "potential of two": (law("def f(j): return 1, 2\n", POTENTIAL), f"{RULES}must return one number, "),
    "potential with states": (law("def f(j): return 1\n", POTENTIAL, STATES), f"{RULES}a potential energy has "),
    "potential sampled": (law("def f(j): return 1\n", POTENTIAL, "every = 1"), f"{RULES}a potential energy has "),
    "position level of a velocity": (
        own_joint("def f(b): return b.velocity.y\n"),
        'model.joints.extra: depends on velocities, but a constraint of positions may not; give level = "velocity"',
    ),
    "position level of an angular velocity": (
        own_joint("def f(b): return b.position.y + b.angular_velocity.y\n"),
        'model.joints.extra: depends on velocities, but a constraint of positions may not; give level = "velocity"',
    ),
    "not affine": (
        own_joint("def f(b): return b.velocity.y**2\n", VELOCITY),
        "model.joints.extra: must be affine in the velocities (a sum of velocities times functions of positions and t)",
    ),
    "a speed": (
        own_joint("def f(b): return b.velocity_of((0, 0, 1)).norm() - 1\n", VELOCITY),
        "model.joints.extra: must be affine in the velocities (a sum of velocities times functions of positions and t)",
    ),
    "no equation": (own_joint("def f(b): return ()\n"), "model.joints.extra: returns no equation; "),
    "nothing": (own_joint("def f(b): pass\n"), "model.joints.extra: must return numbers that vanish "),
    "a text": (own_joint("def f(b): return 'x'\n"), "model.joints.extra: must return numbers that vanish "),
    "a constant": (own_joint("def f(b): return 0.0\n"), "model.joints.extra: an equation does not depend on "),
    "other units": (
        own_joint("def f(b): return b.position.y\n", 'rows = ["m", "rad"]'),
        "model.joints.extra.rows: has 2 entries for 1 equations; give one for each",
    ),
    "not where it should be": (
        own_joint("def f(b): return b.position.y - 3\n"),
        "model.joints.extra: its points are not where it allows them at t = 0: they miss by 3 m, at most ",
    ),
    "a reaction": (
        law("def f(j, *, load): return j.effort(load.force.x)\n", more=QUANTITIES),
        f"{RULES}reads the quantity load, which follows from the forces themselves; read positions and velocities",
    ),
    "of a reaction": (
        law("def f(j, *, far): return j.effort(far)\n", more=QUANTITIES),
        f"{RULES}reads the quantity far, which follows from the forces themselves; read positions and velocities",
    ),
    "an acceleration": (
        law("def f(j, *, pushed): return j.effort(pushed.x)\n", more=QUANTITIES),
        f"{RULES}reads the quantity pushed, which follows from the forces themselves; read positions and velocities",
    ),
    "potential of a velocity quantity": (
        law("def f(j, *, swift): return swift.x\n", POTENTIAL, more=QUANTITIES),
        f"{RULES}reads the quantity swift, a velocity, which this law may not depend on; read positions",
    ),
    "a joint of a reaction": (
        own_joint("def f(b, *, load): return b.position.y - load.force.x\n", more=QUANTITIES),
        "model.joints.extra: reads the quantity load, which follows from the forces themselves; read positions",
    ),
}  # fmt: skip
CASES = FILES | ARGUMENTS | CALLS | {f"returns {k}": v for k, v in RETURNS.items()} | LEVELS


@pytest.mark.parametrize("case", CASES)
def test_one_clear_message(case, tmp_path):
    (text, written), sentence = CASES[case]
    (tmp_path / "law.py").write_text(written, encoding="utf-8")
    lines = refused_by_both(tmp_path, text)
    assert len(lines) == 1, lines
    assert lines[0].startswith(sentence), lines
    assert "0x" not in lines[0]


SWEEP = '[sweep]\nruns = 2\n[sweep.vary]\n"forces.push.every" = { distribution = "uniform", low = 0.1, high = 2 }\n'
MORE = {
    "a forgotten return": law("def f(j): j.effort(1.0)\n"),
    "an if on a parameter": law("def f(j, *, k):\n    return j.effort(1 if k > 0 else 2)\n", "parameters = { k = 1 }"),
    "math of a parameter": law("def f(j, *, k): return j.effort(math.sin(k))\n", "parameters = { k = 1 }"),
    "a division by zero at the start": law("def f(j): return j.effort(1 / j.rate)\n"),
    "a law that changes": law("import random\n\n\ndef f(j): return j.effort(random.random())\n"),
    "a coordinate that is not there": law("def f(j): return j.effort(j.speed)\n"),
    "a state that is not there": law("def f(j, *, states): return j.effort(states.y), 0\n", STATES),
    "a comparison as a constraint": own_joint("def f(b): return b.position.y < 0\n"),
    "a sibling": law("import law_cases\n\n\ndef f(j): return []\n"),
    "an interval that is swept": law("def f(j): pass\n", "every = 0.002", more=SWEEP),
    "velocity level of positions": own_joint("def f(b): return b.position.y\n", VELOCITY),
    "an interval that a parameter sweeps": (
        "[parameters]\nh = 0.1\n"
        + rig(
            force('type = "python"', 'function = "law.py:f"', 'joints = ["pivot"]', 'every = "h"'),
            SWEEP.replace("forces.push.every", "parameters.h"),
        ),
        "def f(j): pass\n",
    ),
    "a vector as a condition": body("def f(b): return b.force((1, 2, 3)) if b.position else None\n"),
    "vectors that are compared": body("def f(b): return b.force((1, 2, 3)) if b.position == b.velocity else None\n"),
    "a law named as a variable": (law("", STATES)[0].replace('"push"', '"position"'), "def f(j): return None, 1\n"),
    "a class": law("class f:\n    def __init__(self, j): pass\n"),
    "a built-in function": law("f = print\n"),
    "a state without a plain name": law("def f(j): return None, 1\n", 'states = { "x y" = 0 }'),
    "a parameter t": law("def f(j, *, t): pass\n", "parameters = { t = 3 }"),
    "a file that exits": law("raise SystemExit(0)\n\n\ndef f(j): pass\n"),
    "the address of a number": law("def f(j): return j.effort(f'{j.angle}')\n"),
}


@pytest.mark.parametrize("case", MORE)
def test_one_clear_message_instead_of_none(case, tmp_path):
    text, written = MORE[case]
    (tmp_path / "law_cases.py").touch()
    (tmp_path / "law.py").write_text(written, encoding="utf-8")
    lines = refused(tmp_path, text)
    assert len(lines) == 1, lines
    assert lines[0].startswith(("model.forces.p", "model.joints.extra", "sweep.vary")), lines
    assert "0x" not in lines[0]


FAILING = "def f(j, *, gap, t):\n    return j.effort(sqrt(gap - t))\n"


def test_a_law_that_is_not_a_number_later_fails_its_own_run_alone(tmp_path):
    """From the time on at which the root has no value."""
    text, written = law(FAILING, "parameters = { gap = 0.2 }")
    vary = '"forces.push.parameters.gap" = { distribution = "uniform", low = 1e-3, high = 0.02 }\n'
    sweep = f"\n[sweep]\nruns = 12\nseed = 1\n[sweep.vary]\n{vary}"
    (tmp_path / "law.py").write_text(written, encoding="utf-8")
    (tmp_path / "case.toml").write_text(text + sweep, encoding="utf-8")

    def run(name: str, *options: str) -> xr.Dataset:
        path: Path = tmp_path / name
        done = CliRunner().invoke(app, ["run", str(tmp_path / "case.toml"), "-o", str(path), *options])
        assert done.exit_code == 1, done.output
        return xr.load_dataset(path)

    ds = run("all.nc")
    failed = ds.status.values != 0
    assert 0 < failed.sum() < 12
    meanings = dict(zip(ds.status.attrs["flag_values"], ds.status.attrs["flag_meanings"].split(), strict=True))
    assert {meanings[code] for code in ds.status.values[failed]} == {"non_finite"}
    assert np.isnan(ds.position.values[failed, -1]).all()
    assert np.isfinite(ds.position.values[~failed]).all()
    good, bad = np.flatnonzero(~failed)[0], np.flatnonzero(failed)[0]
    two = run("two.nc", "--runs", f"{good},{bad}")
    for name in ("position", "angular_velocity", "work", "end_time"):
        np.testing.assert_array_equal(two[name], ds[name].sel(run=two.run), err_msg=name)
