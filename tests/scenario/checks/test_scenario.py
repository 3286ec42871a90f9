"""Every bad input ends with one clear message, exit code 2 and no file."""

from pathlib import Path

import pytest
from typer.testing import CliRunner

from tests.facade import app
from tests.scenario.checks.refusal import check_refused, refused

BASE = """\
title = "Heavy top"

[model]
gravity = [0, 0, -9.81]

[[model.bodies]]
name = "top"
mass = 15
inertia = [0.234375, 0.46875, 0.234375]
position = [0, 1, 0]
rotation = [1, 0, 0, 0]
angular_velocity = [0, 150, -4.61538]

[[model.joints]]
name = "pivot"
type = "spherical"
bodies = ["ground", "top"]
points = [[0, 0, 0], [0, -1, 0]]

[integrator]
method = "rk4"
step = 1e-3
end_time = 0.1

[output]
every = 0.01

[sweep]
runs = 3
seed = 1

[sweep.vary]
"bodies.top.mass" = { distribution = "normal", std = 0.1 }
"""

TOP = BASE[BASE.index("[[model.bodies]]") : BASE.index("[[model.joints]]")]
PIVOT = BASE[BASE.index("[[model.joints]]") : BASE.index("[integrator]")]
MASS = '"bodies.top.mass" = { distribution = "normal", std = 0.1 }'
INERTIA = "inertia = [0.234375, 0.46875, 0.234375]"
ROTATION = "rotation = [1, 0, 0, 0]"


def replaced(old: str, new: str) -> str:
    assert BASE.count(old) == 1, f"{old!r} must occur once"
    return BASE.replace(old, new)


# Each case: the text, and the whole message: key, value, rule; remedy.
CASES = {
    "unknown key, by another program's name": (
        replaced("angular_velocity =", "omega ="),
        'model.bodies.top.omega is not a known key; the nearest known name is "angular_velocity"',
    ),
    "table in the wrong place": (
        BASE + '[[bodies]]\nname = "b"\n',
        'bodies is not a known key here; "bodies" belongs in [model]',
    ),
    "no bodies": (
        replaced(TOP, "").replace(PIVOT, "").replace(MASS, ""),
        "model.bodies is missing; give at least one body, each as [[model.bodies]]",
    ),
    "missing body": (
        replaced('bodies = ["ground", "top"]', 'bodies = ["ground", "tpo"]'),
        'model.joints.pivot.bodies[1] = "tpo": is not a body of the model; the nearest known name is "top"',
    ),
    "duplicate joint": (
        replaced("[integrator]", PIVOT + "[integrator]"),
        'model.joints[1].name = "pivot": is also the name of model.joints[0]; give each its own name',
    ),
    "a name that is none": (
        replaced("[[model.joints]]", TOP.replace('"top"', '"my top"') + "[[model.joints]]"),
        'model.bodies.my top.name = "my top": is no valid name; give the name: a letter, then letters, digits or "_"',
    ),
    "chord method of nothing": (
        replaced("[output]", '[projection]\nposition = "none"\nchord = true\n[output]'),
        'projection.chord = true: is for projected positions, and projection.position = "none" projects none; '
        'leave it out, or give position = "local" or "embedded"',
    ),
    "joint to itself": (
        replaced('bodies = ["ground", "top"]', 'bodies = ["top", "top"]'),
        'model.joints.pivot.bodies = ["top", "top"]: joins "top" to itself; name two different bodies',
    ),
    "unknown joint": (
        replaced('type = "spherical"', 'type = "ball"'),
        'model.joints.pivot.type = "ball": is not known; the nearest known name is "spherical"',
    ),
    "length of a spherical joint": (
        replaced('type = "spherical"', 'type = "spherical"\nlength = 1'),
        "model.joints.pivot.length has no meaning for a spherical joint; leave it out (it belongs to distance)",
    ),
    "negative mass": (
        replaced("mass = 15", "mass = -1"),
        "model.bodies.top.mass = -1: must be above 0; give the mass in kg, above 0",
    ),
    "inertia not symmetric": (
        replaced(INERTIA, "inertia = [[1, 0.1, 0], [0.2, 1, 0], [0, 0, 1]]"),
        "model.bodies.top.inertia = [[1.0, 0.1, 0.0], [0.2, 1.0, 0.0], [0.0, 0.0, 1.0]]: is not symmetric, "
        "[0][1] is 0.1 and [1][0] is 0.2; make them equal, or give the 6 elements xx yy zz xy xz yz",
    ),
    "inertia not positive definite": (
        replaced(INERTIA, "inertia = [1, 1, 1, 2, 0, 0]"),
        "model.bodies.top.inertia = [1.0, 1.0, 1.0, 2.0, 0.0, 0.0]: is not positive definite, its principal moments "
        "are -1, 1, 3 and must all be above 0; check the signs, and the order xx yy zz xy xz yz of 6 elements",
    ),
    "inertia with two numbers": (
        replaced(INERTIA, "inertia = [1, 1]"),
        "model.bodies.top.inertia = [1, 1]: has 2 entries and must have 3; give the inertia in kg m^2 about the mass "
        "centre in the body frame: 3 principal moments, the 6 elements xx yy zz xy xz yz of the tensor, or its 3x3 "
        "matrix",
    ),
    "reflection": (
        replaced(ROTATION, "rotation = [[1, 0, 0], [0, 1, 0], [0, 0, -1]]"),
        "model.bodies.top.rotation = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0]]: is a reflection "
        "(determinant -1), not a rotation; make its determinant +1, for instance by changing the sign of one axis",
    ),
    "rotation not orthogonal": (
        replaced(ROTATION, "rotation = [[1, 0, 0], [0, 1, 0.1], [0, 0, 1]]"),
        "model.bodies.top.rotation = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.1], [0.0, 0.0, 1.0]]: is not orthogonal, "
        "R R^T differs from the unit matrix by 0.1 and may by 1e-06; give more digits, a quaternion, "
        "{axis, angle} or {euler, angles}",
    ),
    "zero quaternion": (
        replaced(ROTATION, "rotation = [0, 0, 0, 0]"),
        "model.bodies.top.rotation = [0.0, 0.0, 0.0, 0.0]: is a quaternion of length 0; give [w, x, y, z] of "
        "length 1, such as [1, 0, 0, 0] for no rotation",
    ),
    "zero axis": (
        replaced(ROTATION, "rotation = { axis = [0, 0, 0], angle = 1 }"),
        "model.bodies.top.rotation.axis = [0.0, 0.0, 0.0]: has no direction; give 3 numbers that are not all 0",
    ),
    "infinite gravity": (
        replaced("gravity = [0, 0, -9.81]", "gravity = [0, 0, -inf]"),
        "model.gravity[2] = -inf: must be a finite number; replace it",
    ),
    "zero step": (
        replaced("step = 1e-3", "step = 0"),
        "integrator.step = 0: must be above 0; give the time step in s, above 0",
    ),
    "step longer than the run": (
        replaced("step = 1e-3", "step = 0.5"),
        "integrator.step = 0.5: is longer than the run, integrator.end_time = 0.1; give a shorter step",
    ),
    "step does not divide the run": (
        replaced("step = 1e-3", "step = 0.003").replace("every = 0.01", "every = 0.03"),
        "integrator.end_time = 0.1: is not a whole number of steps of integrator.step = 0.003; "
        "the nearest step that fits is 0.0025, the nearest end_time 0.099",
    ),
    "output interval incompatible with the step": (
        replaced("every = 0.01", "every = 0.0125"),
        "output.every = 0.0125: is not a whole number of steps of integrator.step = 0.001; "
        "the nearest step that fits is 0.00125, the nearest interval 0.012",
    ),
    "output interval longer than the run": (
        replaced("every = 0.01", "every = 0.2"),
        "output.every = 0.2: is longer than the run, integrator.end_time = 0.1; give a shorter interval",
    ),
    "output time after the end": (
        replaced("every = 0.01", "times = [0, 0.2]"),
        "output.times[1] = 0.2: lies outside the run; give a time from 0 to integrator.end_time = 0.1",
    ),
    "output time off the grid": (
        replaced("every = 0.01", "times = [0, 0.0505]"),
        "output.times[1] = 0.0505: is not a whole number of steps of integrator.step = 0.001; "
        "the nearest time that fits is 0.05",
    ),
    "output times not ascending": (
        replaced("every = 0.01", "times = [0, 0.05, 0.02]"),
        "output.times[2] = 0.02: does not come after 0.05; give the times in ascending order",
    ),
    "two kinds of output times": (
        replaced("every = 0.01", "every = 0.01\ntimes = [0]"),
        "output.every and output.times are both given; leave one of them out",
    ),
    "unknown output variable": (
        replaced("every = 0.01", 'every = 0.01\nvariables = ["positon"]'),
        'output.variables[0] = "positon": is not known; the nearest known name is "position"',
    ),
    "unknown method": (
        replaced('method = "rk4"', 'method = "rk5"'),
        'integrator.method = "rk5": is not known; the nearest known name is "rk4"',
    ),
    "varied path without quotes": (
        replaced('"bodies.top.mass" =', "bodies.top.mass ="),
        'sweep.vary.bodies: a varied path needs quotes; write "bodies.top.mass" = { ... }',
    ),
    "masses of 0": (
        replaced('"normal", std = 0.1', '"uniform", low = 0, high = 14'),
        'sweep.vary."bodies.top.mass".low = 0.0: allows values of 0 or below, which no body has; give low above 0',
    ),
    "no distribution": (
        replaced('distribution = "normal", ', ""),
        'sweep.vary."bodies.top.mass".distribution is missing; give one of normal, uniform, truncated_normal, '
        "lognormal, triangular, choice, constant, rotation_normal, rotation_uniform, direction, inertia, or scipy, "
        "expression, column instead",
    ),
    "0 runs": (
        replaced("runs = 3", "runs = 0"),
        "sweep.runs = 0: must be at least 1; give a whole number of runs, at least 1",
    ),
    "a float of runs": (
        replaced("runs = 3", "runs = 1e3"),
        "sweep.runs = 1000.0: must be a whole number; write 1000",
    ),
    "no runs": (
        replaced("runs = 3\n", ""),
        "sweep.runs is missing; give a whole number of runs, at least 1",
    ),
}

# More of these rules: the place, and words of the rule.
MORE = {
    'sweep.vary."bodies.top.velocity[0]": leads to a key that is omitted': replaced(
        '"bodies.top.mass"', '"bodies.top.velocity[0]"'
    ),
    "model.bodies.top.mass: is missing": replaced("mass = 15\n", ""),
    "model.bodies.top.mass: must be a number, not a text": replaced("mass = 15", 'mass = "15"'),
    'sweep.vary."bodies.top.name": the path bodies.top.name is not a number but': replaced(
        '"bodies.top.mass"', '"bodies.top.name"'
    ),
    'sweep.vary."bodies.top.position": the path bodies.top.position is not a number': replaced(
        '"bodies.top.mass"', '"bodies.top.position"'
    ),
    'sweep.vary."integrator.step": the path integrator.step is not part of the': replaced(
        '"bodies.top.mass"', '"integrator.step"'
    ),
    'sweep.vary."model.bodies.top.mass": the path model.bodies.top.mass is the same': replaced(
        MASS, MASS + "\n" + MASS.replace('"bodies', '"model.bodies')
    ),
    'sweep.vary."bodies.top.rotation[0][1]": the path bodies.top.rotation': replaced(
        ROTATION, "rotation = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]"
    ).replace('"bodies.top.mass"', '"bodies.top.rotation[0][1]"'),
    'sweep.vary."bodies.top.mass".low: must not be above high': replaced(
        '"normal", std = 0.1', '"uniform", low = 16, high = 14'
    ),
    'sweep.vary."gravity[0]".relative: must be false for a nominal value of': replaced(
        MASS, '"gravity[0]" = { distribution = "normal", std = 0.1, relative = true }'
    ),
}
CASES |= {wanted: (text, wanted) for wanted, text in MORE.items()}


def test_a_mass_of_zero_that_varies(tmp_path: Path) -> None:
    assert refused(tmp_path, replaced("mass = 15", "mass = 0")) == [
        'model.bodies.top.mass = 0.0: must be above 0 with integrator.coordinates = "lie"; give the mass in kg, or '
        'coordinates = "joint"',
        'sweep.vary."bodies.top.mass": varies the mass of a body that has none; give it a mass above 0, and an inertia',
    ]


@pytest.mark.parametrize(("text", "message"), CASES.values(), ids=CASES)
def test_bad_scenario(tmp_path: Path, text: str, message: str) -> None:
    check_refused(tmp_path, text, message)


def test_all_problems_are_reported_together(tmp_path: Path) -> None:
    text = replaced("mass = 15", "mass = -1").replace("every = 0.01", "every = 0.0125")
    text = text.replace('["ground", "top"]', '["ground", "tpo"]').replace("std = 0.1", "std = -1")
    starts = [line.split(" = ")[0] for line in refused(tmp_path, text)]
    assert starts == [
        "model.bodies.top.mass",
        'sweep.vary."bodies.top.mass".std',
        "model.joints.pivot.bodies[1]",
        "output.every",
    ]


# ------------------------------------------------------------------------------------------------ TOML syntax
@pytest.mark.parametrize(
    ("old", "new", "line", "column", "remedy"),
    [
        ("mass = 15", "mass = 15 kg", 8, 11, "write the number alone, without its unit"),
        ("mass = 15", "mass = .5", 8, 8, "a decimal point needs a digit on both sides: 0.5, 15.0"),
        ("mass = 15", "mass = 15.", 8, 10, "a decimal point needs a digit on both sides: 0.5, 15.0"),
        ('method = "rk4"', "method = rk4", 21, 10, "a text needs quotes"),
        ("[0, 1, 0]", "[0, 1, 0", 11, 1, "check brackets, quotes and commas"),
        ("mass = 15", "mass = 1,5", 8, 9, "a decimal number has a point: 1.5"),
        ("mass = 15", "mass = 15;", 8, 10, "a line ends without a comma or semicolon"),
        ("mass = 15", "mass = 15\nmass = 16", 9, 10, "this key or table is there twice; keep one of them"),
        ("mass = 15", "mass: 15", 8, 5, "a line is `key = value` or `[section]`"),
        (MASS, 'bodies.top.inertia[0] = { distribution = "normal", std = 0.1 }', 33, 19, "needs quotes"),
    ],
)
def test_toml_syntax(tmp_path: Path, old: str, new: str, line: int, column: int, remedy: str) -> None:
    (message,) = refused(tmp_path, replaced(old, new))
    assert message.startswith(f"{tmp_path / 'case.toml'}, line {line}, column {column}: not valid TOML: ")
    assert message.endswith(remedy)


# ----------------------------------------------------------------------------------------------- command line
@pytest.mark.parametrize(
    ("options", "message"),
    [
        (
            ["--set", "sweep.vary.bodies.top.mass.mean=15", "--set", "bodies.top.mass=3"],
            '--set bodies.top.mass=3: the path bodies.top.mass is varied by sweep.vary."bodies.top.mass", '
            "whose samples do not follow it; set sweep.vary.bodies.top.mass.mean, or take it out of sweep.vary",
        ),
        (
            ["--set", "sweep.vary.bodies.top.mass.mean=15", "--set", "model.bodies.top.mass=3"],
            '--set model.bodies.top.mass=3: the path model.bodies.top.mass is varied by sweep.vary."bodies.top.mass", '
            "whose samples do not follow it; set sweep.vary.bodies.top.mass.mean, or take it out of sweep.vary",
        ),
        (
            ["--set", "bodies.tpo.position=[0, 1, 0]"],
            '--set bodies.tpo.position=[0, 1, 0]: the path bodies.tpo.position has no "tpo" here; '
            'the nearest known name is "top"',
        ),
        (
            ["--set", "integrator.stp=1e-4"],
            'integrator.stp is not a known key; the nearest known name is "step"',
        ),
        (
            ["--set", "integrator.step=1 ms"],
            "--set integrator.step=1 ms: the value 1 ms is not TOML; give a number, a list in [] or a text in quotes "
            "(bare words need none)",
        ),
        (
            ["--set", "integrator.step"],
            "--set integrator.step: is not PATH=VALUE; write it such as integrator.step=1e-4",
        ),
        (
            ["--set", "sweep.runs=0"],
            "sweep.runs = 0: must be at least 1; give a whole number of runs, at least 1",
        ),
        (
            ["--runs", "3"],
            "run 3 does not exist: the sweep has sweep.runs = 3; give labels from 0 to 2 (-1: the nominal run), or "
            "raise sweep.runs",
        ),
        (
            ["--runs", "first"],
            '--runs first: "first" is not a run; give labels such as 3,17 or a range such as 0:500',
        ),
        (["--runs", "2:2"], '--runs 2:2: the range "2:2" is empty; put its end above its start'),
        (["--seed", "-1"], "sweep.seed = -1: must be at least 0; give a whole number from 0 to 2^63 - 1"),
    ],
)
def test_bad_options(tmp_path: Path, options: list[str], message: str) -> None:
    assert refused(tmp_path, BASE, *options) == [message]


def test_output_exists(tmp_path: Path) -> None:
    target = tmp_path / "out.nc"
    target.write_bytes(b"precious")
    (message,) = refused(tmp_path, BASE)
    assert message == (
        f"output = {target}: exists already; choose another name, replace it with --overwrite, or add runs to it with "
        "--resume"
    )
    assert target.read_bytes() == b"precious"


def test_default_output_exists(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("case.toml").write_text(BASE, encoding="utf-8")
    Path("case.nc").write_bytes(b"precious")
    result = CliRunner().invoke(app, ["run", "case.toml"])
    assert result.exit_code == 2
    assert "case.nc: exists already" in result.stderr


def test_output_folder_does_not_exist(tmp_path: Path) -> None:
    (message,) = refused(tmp_path, BASE, output="nowhere/out.nc")
    assert str(tmp_path / "nowhere") in message
    assert "does not exist; create it or choose another" in message


def test_output_folder_is_a_file(tmp_path: Path) -> None:
    (message,) = refused(tmp_path, BASE, output="case.toml/out.nc")
    assert "is not a folder; choose another" in message


def test_scenario_does_not_exist(tmp_path: Path) -> None:
    (tmp_path / "heavy_top.toml").write_text(BASE, encoding="utf-8")
    missing = tmp_path / "heavy_tpo.toml"
    result = CliRunner().invoke(app, ["run", str(missing), "-o", str(tmp_path / "out.nc")])
    assert result.exit_code == 2
    expected = f"error: {missing} does not exist; the nearest file there is {tmp_path / 'heavy_top.toml'}\n"
    assert result.stderr == expected
    assert not (tmp_path / "out.nc").exists()


# ----------------------------------------------------------------------------------- what the engine must see
def test_points_do_not_meet(tmp_path: Path) -> None:
    for command in ("run", "validate"):
        message = "\n".join(
            refused(tmp_path, replaced("position = [0, 1, 0]", "position = [0, 1.5, 0]"), command=command)
        )
        assert "pivot" in message
        assert "0.5" in message


def test_velocity_contradicts_a_joint(tmp_path: Path) -> None:
    text = replaced(ROTATION, ROTATION + "\nvelocity = [0, 0, 0]")
    for command in ("run", "validate"):
        message = "\n".join(refused(tmp_path, text, command=command))
        assert "pivot" in message
        assert "4.62 m/s" in message
