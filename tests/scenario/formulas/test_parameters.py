"""Numbers with names: what depends on them, run by run, and what may go wrong."""

import copy
import tomllib
from typing import Any

import numpy as np
import pytest

import lienumba
from lienumba.engine.programs import program_of
from lienumba.scenario.start.prepare import prepare
from tests.facade import resolve
from tests.rigs.places import ROOT

SERVO: dict[str, Any] = {
    "parameters": {
        "damped": "1.4*sqrt(kp*turning)",  # before what it uses
        "kp": 40,
        "L": 0.8,
        "m": 2,
        "turning": "m*L**2",
        "amplitude": "5*deg",
    },
    "model": {
        "bodies": [
            {
                "name": "rod",
                "mass": "m",
                "inertia": ["m*L**2/12", "m*L**2/12", 1e-3],
                "rotation": {"axis": [0, 1, 0], "angle": "30*deg"},
            }
        ],
        "joints": [
            {
                "name": "hinge",
                "type": "revolute",
                "bodies": ["ground", "rod"],
                "points": [[0, 0, 0], [0, 0, "L/2"]],
                "axes": [[0, 1, 0], [0, 1, 0]],
            }
        ],
        "forces": [
            {
                "name": "servo",
                "type": "actuator",
                "joint": "hinge",
                "value": "where(t > 0.01, -kp, kp)*0.1*sin(3*t)",
                "stiffness": "kp",
                "damping": "damped",
                "target": "amplitude*cos(2*t)",
            }
        ],
    },
    "integrator": {"step": 1e-3, "end_time": 0.05},
}


def servo(**changes: Any) -> dict[str, Any]:
    """With parameters replaced."""
    data = copy.deepcopy(SERVO)
    data["parameters"] |= changes
    return data


def swept(runs: int = 5) -> dict[str, Any]:
    vary = {
        "parameters.kp": {"distribution": "uniform", "low": 20, "high": 60},
        "parameters.L": {"distribution": "normal", "std": 0.1, "relative": True},
    }
    return servo() | {"sweep": {"runs": runs, "seed": 3, "vary": vary}}


def by_hand(kp: float, L: float, m: float = 2.0) -> dict[str, Any]:
    """The same with the numbers written out."""
    turning = m * L**2
    data = copy.deepcopy(SERVO)
    del data["parameters"]
    [rod], [hinge], [force] = (data["model"][kind] for kind in ("bodies", "joints", "forces"))
    rod |= {"mass": m, "inertia": [turning / 12, turning / 12, 1e-3]}
    rod["rotation"]["angle"] = float(30 * np.pi / 180.0)
    hinge["points"] = [[0, 0, 0], [0, 0, L / 2]]
    force["value"] = f"where(t > 0.01, -{kp!r}, {kp!r})*0.1*sin(3*t)"
    force["stiffness"], force["damping"] = kp, 1.4 * float(np.sqrt(kp * turning))
    force["target"] = f"{5 * np.pi / 180.0!r}*cos(2*t)"
    return data


def test_every_run_of_a_sweep_is_the_same_with_its_numbers_written_out():
    ds = lienumba.run(swept())
    for run in range(5):
        one = ds.isel(run=run)
        alone = lienumba.run(by_hand(float(one["parameters.kp"]), float(one["parameters.L"]))).isel(run=0)
        for name in ("position", "angular_velocity", "joint_force", "work", "energy"):
            np.testing.assert_allclose(one[name], alone[name], rtol=1e-13, atol=1e-15, err_msg=name)
    assert len(np.unique(ds["parameters.kp"])) == 5
    assert ds["parameters.kp"].attrs["role"] == "input"
    assert ds.status.values.tolist() == [0] * 5


def test_another_number_or_a_sweep_compiles_nothing():
    def text(data: dict[str, Any]) -> list[str]:
        scenario = resolve(data)
        return [k.text() for k in program_of(scenario, prepare(scenario, [0]), True).kernels.values()]

    plain = text(servo())
    assert text(servo(kp=7.5, m=3)) == plain
    assert text(swept()) == plain


def test_a_sweep_leaves_the_other_runs_alone():
    whole = lienumba.run(swept(9))
    part = lienumba.run(swept(9), runs=[4, 7])
    np.testing.assert_array_equal(part.position, whole.position.sel(run=[4, 7]))


def test_the_resolved_text_keeps_the_formulas():
    scenario = resolve(swept())
    text = scenario.to_toml()
    assert 'damping = "damped"' in text
    assert 'points = [[0.0, 0.0, 0.0], [0.0, 0.0, "L/2"]]' in text
    again = resolve(tomllib.loads(text))
    assert again.sha256() == scenario.sha256()
    assert again.to_toml() == text
    other = resolve(servo(kp=41))
    assert other.sha256() != resolve(servo()).sha256()


def test_a_parameter_can_be_set():
    set_ = resolve(servo(), overrides={"parameters.kp": 7.5})
    assert set_.parameters.values()["damped"] == pytest.approx(1.4 * np.sqrt(7.5 * 2 * 0.8**2))
    assert resolve(servo(), overrides={"parameters.kp": '"m/2"'}).parameters.values()["kp"] == 1.0


def test_a_system_has_parameters():
    system = lienumba.System("servo").parameter("kp", 40).parameter("kd", "kp/10")
    system.body("ball", mass="kp/20", inertia=["kd", "kd", 1])
    system.integrator(step=1e-3, end_time=1e-2)
    scenario = resolve(system)
    assert scenario.data.model.bodies[0].mass == 2.0
    assert scenario.data.model.bodies[0].inertia == [4.0, 4.0, 1.0]
    assert resolve(tomllib.loads(system.to_toml())).sha256() == scenario.sha256()


def test_constants_need_no_parameters():
    data = servo()
    data["model"]["bodies"][0]["inertia"][2] = "pi*1e-3"
    assert resolve(data).data.model.bodies[0].inertia[2] == pytest.approx(np.pi * 1e-3)


def test_what_nobody_uses_is_a_warning():
    assert list(map(str, resolve(servo(kq=3)).warnings)) == [
        "parameters.kq: nothing uses it; write its name in a number of the model, or remove it"
    ]
    assert resolve(servo()).warnings == []


BAD: dict[str, tuple[dict[str, Any], str]] = {
    "a circle": (
        servo(kp="damped/2"),
        "parameters: damped and kp depend on one another in a circle; give a number for damped",
    ),
    "itself": (servo(kp="kp + 1"), "parameters: kp depends on itself in a circle; give a number for kp"),
    "unknown name": (
        servo(kp="2*mm"),
        'parameters.kp = "2*mm": has the unknown name "mm"; the nearest known name is "m"',
    ),
    "time": (servo(kp="2*t"), 'parameters.kp = "2*t": has the unknown name "t"; known here are '),
    "reserved": (servo(pi=3), 'parameters.pi: has a meaning in formulas already; give another name'),
    "no name": (servo(**{"k-p": 3}), 'parameters.k-p: is no valid name: a letter, then letters, digits or "_"'),
    "list": (
        servo(kp=[1, 2]),
        'parameters.damped = "1.4*sqrt(kp*turning)": uses "kp", which has several numbers; write kp[0] or kp[1]',
    ),
    "nested": (servo(kp=[[1, 2]]), "parameters.kp[0] = [1, 2]: must be a number or a formula of other parameters; "),
    "nan": (servo(kp=float("nan")), "parameters.kp = nan: must be a finite number"),
    "infinite": (servo(kp="1/(m - 2)"), 'parameters.kp = "1/(m - 2)": is inf; it must be a finite number'),
    "forbidden": (servo(kp="__import__('os').getcwd()"), "parameters.kp = "),
    "slip": (servo(kp="2m"), 'parameters.kp = "2m": multiplies without a star; write 2*t, 30*deg'),
    "no table": (servo() | {"parameters": 3}, "parameters = 3: must be a table of keys and values; "),
}  # fmt: skip


@pytest.mark.parametrize("case", BAD)
def test_bad_parameters(case):
    data, sentence = BAD[case]
    with pytest.raises(lienumba.ScenarioError) as caught:
        resolve(data)
    lines = str(caught.value).split("\n")
    assert any(line.startswith(sentence) for line in lines), lines


@pytest.mark.parametrize(
    ("place", "text", "sentence"),
    [
        ("mass", "2*mm", 'model.bodies.rod.mass = "2*mm": has the unknown name "mm"; the nearest known name is "m"'),
        ("mass", "m*t", "model.bodies.rod.mass = \"m*t\" = \"2.0 * t\": must be a number, not a formula, because it "),
        ("mass", "1/(m - 2)", 'model.bodies.rod.mass = "1/(m - 2)": is inf with the nominal parameters; it must be '),
        ("mass", "m - 5", 'model.bodies.rod.mass = "m - 5" = -3.0: must be above 0; give the mass in kg, above 0'),
        ("mass", "15", 'model.bodies.rod.mass = "15": must be a number, not a text; write it without quotes: 15'),
        ("mass", "m.real", 'model.bodies.rod.mass = "m.real": reads "m.real", but m has no components; write m'),
    ],
)  # fmt: skip
def test_bad_formulas_of_parameters(place, text, sentence):
    data = servo()
    data["model"]["bodies"][0][place] = text
    with pytest.raises(lienumba.ScenarioError) as caught:
        resolve(data)
    assert str(caught.value).startswith(sentence)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("path", "sentence"),
    [
        (
            "parameters.damped",
            'is the formula "1.4*sqrt(kp*turning)"; vary parameters.kp or parameters.turning instead',
        ),
        ("parameters.kq", 'does not exist; the nearest known name is "kp"'),
        ("bodies.rod.mass", 'is the formula "m"; vary parameters.m instead'),
        ("model.joints[0].points[1][2]", 'is the formula "L/2"; vary parameters.L instead'),
    ],
)
def test_what_a_sweep_may_not_vary(path, sentence):
    data = servo() | {"sweep": {"runs": 3, "vary": {path: {"distribution": "normal", "std": 1}}}}
    with pytest.raises(lienumba.ScenarioError) as caught:
        resolve(data)
    assert str(caught.value) == f'sweep.vary."{path}": the path {path} {sentence}'


def test_what_is_varied_cannot_be_set():
    with pytest.raises(lienumba.ScenarioError, match=r"is varied by sweep\.vary"):
        resolve(swept(), overrides={"parameters.kp": 3})


def test_a_value_of_a_quantity_that_has_none_may_even_read_itself() -> None:
    with open(ROOT / "scenarios" / "belt_drive.toml", "rb") as file:
        raw = tomllib.load(file)
    lists = raw["model"] if "quantities" in raw["model"] else raw
    motor = next(x for x in lists["quantities"] if x["name"] == "motor")
    motor["value"] = "2*motor.angle"
    raw["requirements"] = [{"name": "slow", "value": "motor.angle", "below": 1.0}]
    with pytest.raises(lienumba.ScenarioError, match=r"motor\.value.* has no meaning for a quantity of type joint"):
        resolve(raw)


def test_an_order_of_a_derivative_may_be_written_as_a_decimal() -> None:
    with open(ROOT / "scenarios" / "heavy_top.toml", "rb") as file:
        raw = tomllib.load(file)
    for order in (0.0, 1.0, 2.0):
        place = {"name": "tip", "type": "point", "body": "top", "point": [0, 0, 0], "derivative": order}
        raw["quantities"] = [place, {"name": "twice", "type": "expression", "value": "2*tip.x"}]
        raw["integrator"] |= {"end_time": 0.01}
        ds = lienumba.run(raw, progress=False)
        assert ds.tip.units == ("m", "m s-1", "m s-2")[int(order)]
        np.testing.assert_array_equal(ds.twice, 2.0 * ds.tip.isel(axis=0))
