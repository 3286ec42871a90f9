"""Studies that cannot be run: one clear message each, that names the value to blame, the same from both commands."""

from pathlib import Path

import pytest

from tests.scenario.checks.refusal import check_refused, refused, refused_by_both, rig

STEPS = '"integrator.step" = [1e-3, 5e-4]'
SETTINGS = 'reference = { method = "dop853", step = 1e-3 }'
FITS = "the nearest step that fits is 0.0025, the nearest end_time 0.009"
KEYS = (
    'known here are "method", "order", "rho_infinity", "step", "tolerance", "first_step", "max_step", "min_step", '
    '"dexpinv", "group", "coordinates", "file", "position", "rotation", "velocity", "angular_velocity"'
)
SWEEP = '[sweep]\nruns = 2\n[sweep.vary]\n"bodies.arm.mass" = { distribution = "normal", std = 0.1 }\n'


def study(*grids: str, reference: str = SETTINGS) -> str:
    return "\n".join(["[study]", reference, *(f"[[study.grid]]\n{grid}" for grid in grids)]) + "\n"


def formulas(text: str) -> str:
    return f"reference = {{ {text} }}"


GRIDS = {
    "a step that does not divide the run": (
        '"integrator.method" = ["heun", "rk4"]\n"integrator.step" = [1e-3, 3e-3]',
        'study.grid[0]."integrator.step"[1] = 0.003: integrator.end_time = 0.01: is not a whole number of steps of '
        f"integrator.step = 0.003; {FITS}",
    ),
    "a combination": (
        '"integrator.end_time" = [0.01, 0.009]\n"integrator.step" = [1e-3, 3e-3]',
        "study.grid[0]: is not a whole number of steps of",
    ),
    "an unknown method": (
        f'{STEPS}\n"integrator.method" = ["rk4", "rk5"]',
        'study.grid[0]."integrator.method"[1]: is not known',
    ),
    "an unknown key": (
        '"integrator.stp" = [1e-3, 5e-4]',
        'study.grid[0]."integrator.stp": integrator.stp is not a known key; the nearest known name is "step"',
    ),
    "an unknown body": (
        f'{STEPS}\n"bodies.amr.mass" = [1, 2]',
        'study.grid[0]."bodies.amr.mass": the path bodies.amr.mass has no "amr" here; the nearest known name is "arm"',
    ),
    "an unknown parameter": (
        '"parameters.kp" = [1]',
        'study.grid[0]."parameters.kp": the path parameters.kp is no parameter of the',
    ),
    "an unknown section": (
        '"integrater.step" = [1e-3]',
        'study.grid[0]."integrater.step": the path integrater.step leads to nothing that a study can change; the '
        'nearest known name is "integrator"',
    ),
    "a whole section": (
        '"integrator" = [{ step = 1e-3 }]',
        "study.grid[0].integrator: the path integrator is a whole section; give the path of one of its keys, such as "
        "integrator.step",
    ),
    "no path": (
        '"bodies..mass" = [1]',
        'study.grid[0]."bodies..mass": the path bodies..mass is not a path; write one such as bodies.top.mass or '
        "bodies.top.position[1]",
    ),
    "a path without quotes": (
        "integrator.step = [1e-3]",
        'study.grid[0].integrator: a path needs quotes; write "integrator.step" = [...]',
    ),
    "the sweep": ('"sweep.runs" = [1, 2]', 'study.grid[0]."sweep.runs": the path sweep.runs is part of sweep, whose'),
    "the output": (
        '"output.every" = [0.01]',
        'study.grid[0]."output.every": the path output.every is part of output, which is the same at each point, so '
        "that errors can be compared; give a path of the model or of integrator or projection",
    ),
    "the study": (
        '"study.repeats" = [1, 2]',
        'study.grid[0]."study.repeats": the path study.repeats is part of study, which',
    ),
    "no values": ('"integrator.step" = []', 'study.grid[0]."integrator.step": must be a list of values'),
    "no list": (
        '"integrator.step" = 1e-3',
        'study.grid[0]."integrator.step" = 0.001: must be a list of values; give at least one in []',
    ),
    "a value twice": (
        '"integrator.step" = [1e-3, 0.001]',
        'study.grid[0]."integrator.step"[1] = 0.001: is there twice; give it once',
    ),
    "a path twice": (
        '"bodies.arm.mass" = [1]\n"model.bodies[0].mass" = [2]',
        'study.grid[0]."model.bodies[0].mass": the path model.bodies[0].mass is the same as "bodies.arm.mass"; give it '
        "once",
    ),
    "alternatives": (
        f'{STEPS}\n"integrator.tolerance" = [1e-6]',
        'study.grid[0]."integrator.tolerance": the path integrator.tolerance takes the place of "integrator.step", so '
        "they cannot be crossed; give two grids",
    ),
    "nothing": ("", 'study.grid[0]: is empty; give paths with lists of values, such as "integrator.step" = [1e-2]'),
    "a start that does not fit": (
        '"bodies.arm.position" = [[0, 0, -0.3], [0, 0, -0.4]]',
        'study.grid[0] at "bodies.arm.position" = [0, 0, -0.4]: model.joints.pivot',
    ),
}
REFERENCES = {
    "empty": (
        "reference = {}",
        'study.reference = {}: is empty; give settings such as { method = "dop853", step = 1e-4 }, formulas, or '
        '{ file = "ref.nc" }',
    ),
    "no table": ('reference = "dop853"', "study.reference: must be a table of keys and values"),
    "an unknown key": ('reference = { metod = "rk4" }', "study.reference.metod: is not a known key"),
    "nothing like a key": ("reference = { zzz = 1 }", "study.reference.zzz: is not a known key"),
    "another end": ("reference = { end_time = 1 }", "study.reference.end_time: is that of the scenario; leave it out"),
    "another model": (
        'reference = { "bodies.arm.mass" = 1 }',
        'study.reference."bodies.arm.mass": is not a setting of integrator or projection, and a reference solves the '
        "same problem; leave it out",
    ),
    "a bad step": ("reference = { step = 3e-3 }", "study.reference: is not a whole number of steps of"),
    "a file and settings": (
        'reference = { file = "case.toml", step = 1e-3 }',
        "study.reference.step: has no meaning beside a file; leave one of them out",
    ),
    "formulas and settings": (
        formulas("position = { arm = [0, 0, 0] }, step = 1e-3"),
        "study.reference.step: has no meaning beside formulas",
    ),
    "a file that is not there": ('reference = { file = "fine.nc" }', "study.reference.file: there is no such file"),
    "an unknown body": (
        formulas("position = { amr = [0, 0, 0] }"),
        'study.reference.position.amr: is not a body of the model; the nearest known name is "arm"',
    ),
    "an unknown function": (
        formulas('position = { arm = ["sn(t)", 0, 0] }'),
        "study.reference.position.arm[0]: calls the unknown function",
    ),
    "an unknown name": (
        formulas('rotation = { arm = { axis = [0, 1, 0], angle = "w*t" } }'),
        "study.reference.rotation.arm.angle: has the unknown name",
    ),
    "two numbers": (
        formulas('velocity = { arm = ["t", 1] }'),
        'study.reference.velocity.arm = ["t", 1]: must be 3 numbers, or formulas of t and parameters; give those',
    ),
    "no rotation": (
        formulas('rotation = { arm = { angle = "t" } }'),
        'study.reference.rotation.arm = {angle = "t"}: must be a rotation in one of its five forms, of numbers or '
        "formulas of t and parameters; give those",
    ),
    "no direction": (
        formulas('rotation = { arm = { axis = [0, 0, 0], angle = "t" } }'),
        "study.reference.rotation.arm.axis: has no direction",
    ),
    "a formula that is infinite": (
        formulas('position = { arm = ["1/(t - 0.005)", 0, 0] }'),
        'study.reference.position.arm[0] = "1/(t - 0.005)": is inf at t = 0.005; give finite numbers',
    ),
    "no body": (
        formulas("position = [0, 0, 0]"),
        'study.reference.position = [0, 0, 0]: must be a table; give { body = ["sin(t)", 0, 0] }',
    ),
}


@pytest.mark.parametrize(("grid", "message"), GRIDS.values(), ids=GRIDS)
def test_bad_grid(tmp_path: Path, grid: str, message: str) -> None:
    check_refused(tmp_path, rig("[output]\ntimes = [0]\n", study(grid)), message)


@pytest.mark.parametrize(("reference", "message"), REFERENCES.values(), ids=REFERENCES)
def test_bad_reference(tmp_path: Path, reference: str, message: str) -> None:
    check_refused(tmp_path, rig(study(STEPS, reference=reference)), message)


def test_what_is_swept_cannot_be_gridded(tmp_path: Path) -> None:
    text = rig(study('"bodies.arm.mass" = [1, 2]'), SWEEP)
    assert refused_by_both(tmp_path, text) == [
        'study.grid[0]."bodies.arm.mass": the path bodies.arm.mass is varied by sweep.vary."bodies.arm.mass", so it '
        "cannot be set; set sweep.vary.bodies.arm.mass.std, or take it out of sweep.vary"
    ]


def test_a_reference_has_a_step_or_a_tolerance(tmp_path: Path) -> None:
    text = rig(study(STEPS, reference="reference = { step = 1e-3, tolerance = 1e-9 }"))
    assert "study.reference: gives both step and tolerance; leave one of them out" in refused_by_both(tmp_path, text)


def test_a_file_has_one_motion(tmp_path: Path) -> None:
    (tmp_path / "one.nc").write_bytes(b"")
    text = rig(study('"bodies.arm.mass" = [1, 2]', reference='reference = { file = "one.nc" }'))
    assert refused_by_both(tmp_path, text) == [
        'study.grid[0]."bodies.arm.mass": the path bodies.arm.mass changes what is solved, but study.reference.file '
        "has one motion; give the reference as settings or formulas"
    ]


def test_missing_and_unknown_keys(tmp_path: Path) -> None:
    said = refused_by_both(tmp_path, rig("[study]\nrepeat = 3\ngrid = []\n"))
    assert [line.partition(";")[0] for line in said] == [
        "study.reference is missing",
        "study.grid = []: has 0 entries and must have at least 1",
        "study.repeat is not a known key",
    ]
    said = refused_by_both(tmp_path, rig(study(STEPS, reference=f"{SETTINGS}\nrepeats = 0")))
    assert said == [
        "study.repeats = 0: must be at least 1; give a whole number of times that each point is run to time it, at "
        "least 1"
    ]


def test_settings_that_every_grid_has_cannot_be_set(tmp_path: Path) -> None:
    text = rig(study(STEPS))
    assert refused(tmp_path, text, "--set", "integrator.step=1e-3") == [
        '--set integrator.step=1e-3: the path integrator.step is set by study.grid[0]."integrator.step", so it cannot '
        'be set here; set that (study.grid[0]."integrator.step"=[...])'
    ]
    assert refused(tmp_path, text, "--set", 'study.grid[0]."integrator.step"=[1e-3, 4e-3]') == [
        'study.grid[0]."integrator.step"[1] = 0.004: integrator.end_time = 0.01: is not a whole number of steps of '
        "integrator.step = 0.004; the nearest step that fits is 0.005, the nearest end_time 0.008"
    ]
