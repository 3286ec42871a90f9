"""Linear systems and modes against closed forms and minimal coordinates."""

from typing import Any

import mpmath as mp
import numpy as np
import pytest
from scipy.signal import StateSpace

import lienumba
from lienumba.analysis.mode_rows import mode_rows
from tests.documents.pages import ROOT
from tests.facade import ScenarioError
from tests.rigs import parts

G = 9.81
SHORT = {"integrator": {"step": 1e-3, "end_time": 0.5}}
M, A, J = 1.2, 0.5, 0.02
ARM = 0.3


def pendulum(down: float = 1.0, **more: Any) -> dict[str, Any]:
    bob = parts.body("bob", M, [J, J, 0.01], position=[0, 0, -down * A])
    return {"model": {"bodies": [bob], "joints": [parts.hinge("pivot", "bob")], **more}, **SHORT}


def top(spin: float, tilt: float = 0.0, precession: float = 0.0) -> dict[str, Any]:
    """On a ball joint, its axis up or tilted towards x; it turns about its axis, and precesses about z."""
    axis = np.array([np.sin(tilt), 0.0, np.cos(tilt)])
    R = np.array([[np.cos(tilt), 0, np.sin(tilt)], [0, 1, 0], [-np.sin(tilt), 0, np.cos(tilt)]])
    w = R.T @ (precession * np.array([0, 0, 1.0]) + spin * axis)
    body = parts.body("top", 2.0, [0.05, 0.05, 0.03], rotation={"axis": [0, 1, 0], "angle": tilt})
    body |= {"angular_velocity": w.tolist()}
    ball = parts.joint("tip", "spherical", "top", points=[[0, 0, 0], [0, 0, -ARM]])
    return {"model": {"bodies": [body], "joints": [ball]}, **SHORT}


def parallelogram(stiffness: float) -> dict[str, Any]:
    """Two cranks of length 0.4 m that hang, and a coupler: hinges with parallel axes, whose rows are redundant."""
    bodies = [
        parts.body("left", 0.7, [0.01, 0.01, 0.001], position=[0, 0, -0.2]),
        parts.body("coupler", 1.5, [0.02, 0.03, 0.02], position=[0.5, 0, -0.4]),
        parts.body("right", 0.7, [0.01, 0.01, 0.001], position=[1, 0, -0.2]),
    ]
    joints = [
        parts.hinge("hinge0", "left"),
        parts.hinge("hinge1", "coupler", [0, 0, -0.4], to="left"),
        parts.hinge("hinge2", "right", [1, 0, -0.4], to="coupler"),
        parts.hinge("hinge3", "ground", [1, 0, 0], to="right"),
    ]
    spring = {"name": "coil", "type": "torsion_spring", "joint": "hinge0", "stiffness": stiffness, "free_angle": 0.0}
    return {"model": {"bodies": bodies, "joints": joints, "forces": [spring]}, **SHORT}


def eigenvalues(found: Any, run: int = 0, time: int = 0) -> np.ndarray:
    own = found.isel(run=run, time=time)
    return np.sort_complex((own.growth + 1j * own.angular_frequency).values)


def close(found: Any, expected: Any) -> None:
    np.testing.assert_allclose(found, np.sort_complex(np.asarray(expected, complex)), rtol=1e-10, atol=1e-10)


@pytest.mark.parametrize("coordinates", ["lie", "joint"])
def test_a_pendulum_hangs_and_an_inverted_one_falls(coordinates: str) -> None:
    w = np.sqrt(M * G * A / (J + M * A * A))
    scenario = pendulum()
    scenario["integrator"] = {**SHORT["integrator"], "coordinates": coordinates}
    hanging, standing = lienumba.modes(scenario), lienumba.modes(pendulum(-1.0))
    close(eigenvalues(hanging), [1j * w])
    close(hanging.frequency.values.ravel(), [w / (2 * np.pi)])
    close(eigenvalues(standing), [-w, w])
    assert hanging.stable.item()
    assert not standing.stable.item()
    shift, turn = (hanging[name].isel(run=0, time=0, mode=0, body=0, part=0).values for name in ("translation", "turn"))
    np.testing.assert_allclose(np.cross(turn, [0, 0, -A]), shift, atol=1e-14)


def test_in_motion_the_equations_are_those_of_this_moment() -> None:
    scenario = pendulum()
    del scenario["model"]["bodies"][0]["position"]
    scenario["model"]["joints"] = [parts.pivot("pivot", "bob", second=[0, 0, A], angle=0.0, rate=2.0)]
    scenario["output"] = {"joint_coordinates": True, "every": 0.5}
    angle = lienumba.run(scenario).q.values[0, -1, 0]
    found = lienumba.linearise(scenario, at="end").isel(run=0, time=0)
    stiffness = M * G * A * np.cos(angle) / (J + M * A * A)
    np.testing.assert_allclose(found.A.values, [[0, 1], [-stiffness, 0]], rtol=1e-8, atol=1e-12)
    assert found.state.values.tolist() == ["pivot.angle", "pivot.angle.rate"]


def test_a_damped_body_on_a_bushing() -> None:
    body = parts.body("block", 3.0, [0.2, 0.3, 0.4], position=[0, 0, 0], rotation=[1, 0, 0, 0])
    mount = {
        "name": "mount", "type": "bushing", "bodies": ["ground", "block"], "points": [[0, 0, 0]] * 2,
        "stiffness": [100, 200, 300], "rotational_stiffness": [5, 6, 7], "damping": [1, 20, 300],
        "rotational_damping": [0.1, 0.2, 0.3],
    }  # fmt: skip
    scenario = {"model": {"gravity": [0, 0, 0], "bodies": [body], "forces": [mount]}, **SHORT}
    expected: list[complex] = []
    for m, c, k in zip([3.0] * 3 + [0.2, 0.3, 0.4], [1, 20, 300, 0.1, 0.2, 0.3], [100, 200, 300, 5, 6, 7], strict=True):
        expected += [x for x in np.roots([m, c, k]).astype(complex) if x.imag >= 0.0]
    close(eigenvalues(lienumba.modes(scenario)), expected)


def test_a_loop_with_redundant_rows() -> None:
    k = 2.5
    inertia = 2 * (0.01 + 0.7 * 0.2**2) + 1.5 * 0.4**2
    close(
        eigenvalues(lienumba.modes(parallelogram(k))), [1j * np.sqrt((G * (2 * 0.7 * 0.2 + 1.5 * 0.4) + k) / inertia)]
    )


@pytest.mark.parametrize("spin", [10.0, 60.0])
def test_a_sleeping_top(spin: float) -> None:
    """(A + m l^2) z'' - i C n z' - m g l z = 0; below n^2 = 4 A m g l/C^2 it falls."""
    inertia, weight, C = 0.05 + 2.0 * ARM**2, 2.0 * G * ARM, 0.03
    found = lienumba.modes(top(spin))
    both = np.roots([inertia, -1j * C * spin, -weight])
    expected = [0.0, 0.0, *(x if x.imag >= 0 else x.conjugate() for x in both)]
    near = eigenvalues(found)
    close(near[np.abs(near) > 1e-6], [x for x in expected if abs(x) > 1e-6])
    assert found.stable.item() == ((C * spin) ** 2 > 4 * inertia * weight)


def test_a_precessing_top_nutates() -> None:
    """Against the effective potential of the nutation at constant momenta, in the axes that precess with the top."""
    tilt, spin = 0.7, 250.0
    inertia, weight, C = 0.05 + 2.0 * ARM**2, 2.0 * G * ARM, 0.03
    c = np.cos(tilt)
    precession = min(np.roots([(C - inertia) * c, C * spin, -weight]).real, key=abs)
    p_psi = C * (spin + precession * c)
    p_phi = inertia * precession * np.sin(tilt) ** 2 + p_psi * c
    bend = mp.diff(
        lambda x: (p_phi - p_psi * mp.cos(x)) ** 2 / (2 * inertia * mp.sin(x) ** 2) + weight * mp.cos(x), tilt, 2
    )
    found = eigenvalues(lienumba.modes(top(spin, tilt, precession), rotation=[0, 0, precession]))
    close(found[np.abs(found) > 1e-3], [1j * float(mp.sqrt(bend / inertia))])


def test_a_bead_on_a_rotating_bar() -> None:
    """w^2 = k/m - Omega^2 about the radius where it rests."""
    k, m, omega, r = 50.0, 0.5, 6.0, 0.4
    free = r - m * omega**2 * r / k
    bar = parts.body("bar", 1.0, 0.1, position=[0, 0, 0], rotation=[1, 0, 0, 0])
    bodies = [bar, parts.body("bead", m, 0.01)]
    place: Any = {"points": [[0, 0, 0]] * 2, "axes": [[1, 0, 0]] * 2, "displacement": r, "speed": 0.0}
    joints = [parts.hinge("axle", "bar", axis=parts.Z), parts.joint("slot", "prismatic", "bead", "bar", **place)]
    forces = [{"name": "spring", "type": "actuator", "joint": "slot", "stiffness": k, "target": free}]
    driver = {"name": "turn", "joint": "axle", "rate": omega}
    scenario = {"model": {"bodies": bodies, "joints": joints, "forces": forces, "drivers": [driver]}, **SHORT}
    for t in (0.0, 0.25):
        close(eigenvalues(lienumba.modes(scenario, at=t)), [1j * np.sqrt(k / m - omega**2)])


def test_states_of_laws_are_states_of_the_system() -> None:
    """A motor's current: L i' = u - R i - K w, J w' = K i."""

    def motor(hinge: Any, states: Any, voltage: Any) -> Any:
        return hinge.effort(0.3 * states.current), (voltage - 2.0 * states.current - 0.3 * hinge.rate) / 0.01

    body = parts.body("rotor", 1.0, [0.1, 0.1, 0.05], position=[0, 0, 0], rotation=[1, 0, 0, 0])
    hinge = parts.hinge("axle", "rotor", axis=parts.Z)
    law = {"name": "motor", "type": "python", "function": motor, "joints": ["axle"], "states": {"current": 0.0},
           "parameters": {"voltage": 12.0}}  # fmt: skip
    scenario = {"model": {"bodies": [body], "joints": [hinge], "forces": [law]}, **SHORT}
    found = lienumba.linearise(scenario).isel(run=0, time=0)
    assert found.state.values.tolist() == ["axle.angle", "axle.angle.rate", "motor.current"]
    np.testing.assert_allclose(found.A.values, [[0, 1, 0], [0, 0, 6.0], [0, -30.0, -200.0]], rtol=1e-12, atol=1e-12)


def test_inputs_and_outputs_go_into_scipy_in_one_line() -> None:
    """A pendulum whose pivot slides as it is driven, and that a torque turns: transfer functions in closed form."""
    bodies = [
        parts.body("cart", 1.0, 1, position=[0, 0, 0], rotation=[1, 0, 0, 0]),
        parts.body("bob", M, [J, J, 0.01], position=[0, 0, -A], rotation=[1, 0, 0, 0]),
    ]
    rail = parts.joint("rail", "prismatic", "cart", at=[0, 0, 0], axis=[1, 0, 0])
    joints = [rail, parts.hinge("pivot", "bob", to="cart")]
    forces = [{"name": "motor", "type": "actuator", "joint": "pivot", "value": "0.1*sin(t)"}]
    model = {
        "bodies": bodies, "joints": joints, "forces": forces,
        "drivers": [{"name": "shake", "joint": "rail", "value": "0.2*t"}],
        "quantities": [{"name": "swing", "type": "joint", "joint": "pivot"}],
    }  # fmt: skip
    ds = lienumba.linearise({"model": model, **SHORT}, outputs=["swing.angle", "swing.rate"])
    driven = [f"drivers.shake{derivative}" for derivative in ("", ".rate", ".acceleration")]
    assert ds.input.values.tolist() == ["forces.motor.value", *driven]
    one = ds.isel(run=0, time=0)
    system = StateSpace(*(one[name].values for name in "ABCD"))
    inertia, s = J + M * A * A, 2.0j
    _, found = (None, one.C.values @ np.linalg.solve(s * np.eye(2) - one.A.values, one.B.values) + one.D.values)
    below = inertia * s * s + M * G * A
    np.testing.assert_allclose(found[0], [1 / below, 0.0, 0.0, M * A / below], rtol=1e-12, atol=1e-15)
    assert system.A.shape == (2, 2)


@pytest.mark.parametrize("between", ["ground", "cart"])
@pytest.mark.parametrize("coordinates", ["lie", "joint"])
def test_what_is_driven_has_three_columns_whether_they_act_or_not(between: str, coordinates: str) -> None:
    """A mass on a spring to a cart that is driven: on a rail of its own it sees where the cart is and how it moves,
    on one of the cart only how that accelerates."""
    bodies = [
        parts.body(name, mass, position=[x, 0, 0], rotation=[1, 0, 0, 0])
        for name, mass, x in (("cart", 1.0, 0), ("mass", 2.0, 1))
    ]
    joints = [
        parts.joint(name, "prismatic", body, to, at=[0, 0, 0], axis=[1, 0, 0])
        for name, body, to in (("rail", "cart", "ground"), ("own", "mass", between))
    ]
    spring = {
        "name": "spring", "type": "spring_damper", "bodies": ["cart", "mass"], "points": [[0, 0, 0]] * 2,
        "stiffness": 100.0, "damping": 1.0, "free_length": 1.0,
    }  # fmt: skip
    driver = {"name": "shake", "joint": "rail", "value": "0*t"}
    model = {"bodies": bodies, "joints": joints, "forces": [spring], "drivers": [driver]}
    system = lienumba.linearise({"model": model, **SHORT}, overrides={"integrator.coordinates": coordinates})
    assert system.input.values.tolist() == [f"drivers.shake{x}" for x in ("", ".rate", ".acceleration")]
    expected = [0.0, 0.0, -1.0] if between == "cart" else [50.0, 0.5, 0.0]
    np.testing.assert_allclose(system.B.isel(run=0, time=0).values[1], expected, rtol=1e-12, atol=1e-12)


def test_inputs_and_outputs_go_into_control_by_the_line_of_the_documents() -> None:
    """A damped pendulum with a torque: stable, with the closed form's response, and held upright by its LQR."""
    control = pytest.importorskip("control")
    line = 'control.ss(*(one[name].values for name in "ABCD"))'
    assert f"`{line}`" in (ROOT / "docs" / "linearise.md").read_text(encoding="utf-8")
    motor = {"name": "motor", "type": "actuator", "joint": "pivot", "value": "0.0*t", "damping": 0.3}
    swing = {"name": "swing", "type": "joint", "joint": "pivot"}
    inertia, s = J + M * A * A, 2.0j
    for down in (1.0, -1.0):
        scenario = pendulum(down, forces=[motor], quantities=[swing])
        one = lienumba.linearise(scenario, outputs=["swing.angle"]).isel(run=0, time=0)
        system = eval(line, {"control": control, "one": one})
        found = complex(np.squeeze(system(s)))
        assert found == pytest.approx(1 / (inertia * s * s + 0.3 * s + down * M * G * A), rel=1e-12)
        assert (system.poles().real < 0).all() == (down > 0)
        gain, _, _ = control.lqr(system, np.eye(2), np.eye(1))
        assert (np.linalg.eigvals(system.A - system.B @ gain).real < 0).all()


def test_modes_keep_their_number_where_frequencies_cross() -> None:
    """Two pendulums side by side; the mass centre of one is swept through the frequency of the other."""
    scenario = pendulum()
    scenario["model"]["bodies"].append(parts.body("other", 1.0, position=[0, 3, -0.5]))
    scenario["model"]["joints"].append(parts.hinge("second", "other", [0, 3, 0]))
    path = "bodies.other.inertia[1]"
    scenario["sweep"] = parts.table({path: [0.9, 0.01, 0.2, 0.005, 0.4]})
    found = lienumba.modes(scenario)
    still = found.frequency.values[:, 0]
    w = np.sqrt(M * G * A / (J + M * A * A))
    which = int(np.abs(found.frequency.values[0, 0] * 2 * np.pi - w).argmin())
    np.testing.assert_allclose(still[:, which] * 2 * np.pi, w, rtol=1e-12)
    assert found.crossed.values[:, 0].any(axis=1).tolist() == [False, True, False, True, False]
    assert (found.mac.values > 0.99).all()


@pytest.mark.parametrize(
    ("keywords", "message"),
    [
        ({"at": 2.0}, "at = 2.0: must lie from 0 to integrator.end_time = 0.5 s; give such times"),
        ({"at": "later"}, 'at = "later": must be times in s; give numbers such as 0 and 1.5, or "end"'),
        ({"runs": 5}, "runs = 5: must be labels in a list; give such as [3, 17] or range(500)"),
        ({"rotation": [1, 2]}, "rotation = [1, 2]: must be three numbers in rad/s; give them, such as 0,0,5"),
    ],
)
def test_bad_input_is_told(keywords: Any, message: str) -> None:
    with pytest.raises(ScenarioError) as told:
        lienumba.modes(pendulum(), **keywords)
    assert str(told.value) == message


def test_unknown_inputs_are_told_with_those_that_there_are() -> None:
    scenario, coil = pendulum(), {"name": "coil", "type": "torsion_spring", "joint": "pivot", "stiffness": 1.0}
    choices = ("give [[model.forces]] or [[model.drivers]]", "choose from forces.coil.")
    for forces, choice in zip(([], [coil]), choices, strict=True):
        scenario["model"]["forces"] = forces
        with pytest.raises(ScenarioError) as told:
            lienumba.linearise(scenario, inputs=["forces.none.value"])
        expected = f'inputs = "forces.none.value": must name numbers of forces and drivers; {choice}'
        assert str(told.value).startswith(expected)


def carts(dampings: list[float], stiffness: float = 300.0) -> dict[str, Any]:
    """Two bodies of 1 kg on rails along x, each on a spring; the damper of the first is swept."""
    places = (("one", 0), ("two", 1))
    bodies = [parts.body(x, 1.0, 1, rotation=[1, 0, 0, 0], position=[0, y, 0]) for x, y in places]
    rails = [parts.joint(f"rail_{x}", "prismatic", x, at=[0, y, 0], axis=[1, 0, 0]) for x, y in places]
    springs = [
        {"name": "first", "type": "actuator", "joint": "rail_one", "stiffness": 100.0, "damping": 1.0, "target": 0.0},
        {"name": "second", "type": "actuator", "joint": "rail_two", "stiffness": stiffness, "target": 0.0},
    ]
    sweep = parts.table({"forces.first.damping": dampings})
    return {"model": {"bodies": bodies, "joints": rails, "forces": springs}, "sweep": sweep, **SHORT}


def test_a_pair_that_becomes_two_real_modes_keeps_its_number_in_the_slower() -> None:
    dampings = [1.0, 30.0, 18.0, 60.0]
    found = lienumba.modes(carts(dampings)).isel(time=0)
    values = (found.growth + 1j * found.angular_frequency).values
    for d, own in zip(dampings, values, strict=True):
        slow, fast = -d / 2 + np.array([1, -1]) * np.sqrt(complex(d * d / 4 - 100.0))
        np.testing.assert_allclose(own[:2], [slow, 1j * np.sqrt(300.0)], rtol=1e-10)
        if d > 20.0:
            np.testing.assert_allclose(own[2], fast, rtol=1e-10)
    assert np.isnan(values[[0, 2], 2]).all()
    assert not found.crossed.any()
    np.testing.assert_allclose(found.frequency_quantiles.sel(mode=2), np.sqrt(300.0) / (2 * np.pi), rtol=1e-10)
    (rows,) = mode_rows(lienumba.modes(carts(dampings)))
    assert rows.notes == [
        "mode 1 does not swing in 2 of 4 runs: there its eigenvalue is real",
        "mode 3 is there in 2 of 4 runs",
    ]


def test_the_nominal_run_is_the_first_and_no_part_of_quantiles() -> None:
    scenario = carts([4.0, 5.0, 6.0])
    scenario["sweep"] |= {"nominal": True}
    found = lienumba.modes(scenario)
    assert found.run.values.tolist() == [-1, 0, 1, 2]
    np.testing.assert_allclose(found.damping_ratio_quantiles.sel(mode=1, quantile=0.5), 0.25, rtol=1e-12)
    (rows,) = mode_rows(found)
    assert rows.headline == "t = 0 s: 3 runs beside the nominal one"


def test_quantiles_are_those_of_runs_by_their_weights() -> None:
    spread = {"distribution": "normal", "mean": 300.0, "std": 30.0}
    path = "forces.second.stiffness"
    sweep = {"sampler": "importance", "runs": 4000, "vary": {path: spread}, "proposal": {path: {"shift": 3.0}}}
    found = lienumba.modes(carts([]) | {"sweep": sweep})
    assert float(found[path].median()) > 360.0
    exact = np.sqrt(300.0 + 30.0 * np.array([-1.6448536, 0.0, 1.6448536])) / (2 * np.pi)
    np.testing.assert_allclose(found.frequency_quantiles.sel(mode=2)[:, 0], exact, rtol=0.02)
    (rows,) = mode_rows(found)
    assert any("4,000 runs have weights, which statistics respect" in note for note in rows.notes)
    assert "weighted runs" in lienumba.analysis.sensitivity(found, "frequency.2").attrs["notes"]


def test_what_drifts_is_one_mode_for_each_freedom() -> None:
    body = parts.body("block", 1.0, [1, 2, 3], position=[0, 0, 0], rotation=[1, 0, 0, 0])
    found = lienumba.modes({"model": {"bodies": [body]}, **SHORT})
    assert found.sizes["mode"] == 6
    assert not found.growth.any()
    assert found.stable.item()


def test_a_first_run_that_is_not_there_is_compared_with_nothing() -> None:
    scenario = carts([5.0, 1.0, 2.0])
    scenario["sweep"]["table"]["columns"] |= {
        "forces.second.stiffness": [300.0, 50.0, 300.0], "bodies.one.mass": [-1.0, 1.0, 1.0],
    }  # fmt: skip
    found = lienumba.modes(scenario).isel(time=0)
    assert found.status.values.tolist() == [1, 0, 0]
    np.testing.assert_allclose(found.angular_frequency.values[1:, 0], np.sqrt([50.0, 300.0]), rtol=1e-10)
    assert found.crossed.values.any(axis=1).tolist() == [False, False, True]


SWUNG = pendulum() | {"output": {"times": [0.1, 0.4]}}
SWUNG["model"]["bodies"][0]["angular_velocity"] = [0, 3, 0]
COIL = {"name": "coil", "type": "torsion_spring", "joint": "pivot", "stiffness": 1.0, "free_angle": 0.0}


@pytest.mark.parametrize(
    ("changes", "origins", "comment"),
    [
        ({}, ["start", "stored", "simulated"], "simulated where the dataset stores no such time"),
        ({"integrator.step": None, "integrator.tolerance": 1e-8}, ["start", "stored", "simulated"], None),
        ({"integrator.coordinates": "joint", "integrator.step": 2e-3}, ["start", "stored", "simulated"], None),
        ({"output.precision": "float32"}, ["start", "simulated", "simulated"],
         "simulated since the dataset does not hold the states: it stores position rounded"),
        ({"model.forces": [COIL]}, ["start", "simulated", "simulated"],
         "simulated since the dataset does not hold the states: it does not store how often pivot turned "
         "(output.joint_coordinates)"),
        ({"model.forces": [COIL], "output.joint_coordinates": True}, ["start", "stored", "simulated"], None),
    ],
)  # fmt: skip
def test_states_that_a_dataset_holds_are_taken_from_it(
    changes: dict[str, Any], origins: list[str], comment: str | None
) -> None:
    """The last time is none of the ends of steps."""
    at = [0.0, 0.4, 0.30007]
    dataset = lienumba.run(SWUNG, overrides=changes)
    found, other = lienumba.modes(dataset, at=at), lienumba.modes(SWUNG, at=at, overrides=changes)
    assert [found.origin.attrs["flag_meanings"].split()[n] for n in found.origin.values] == origins
    assert comment is None or found.origin.attrs["comment"] == comment
    for name in ("growth", "angular_frequency", "position", "rotation"):
        np.testing.assert_allclose(found[name], other[name], rtol=1e-12, atol=1e-12)
    assert other.origin.values.tolist() == [0, 2, 2]
    assert abs(found.angular_frequency.values[0, 1] - found.angular_frequency.values[0, 0]) > 0.1


@pytest.mark.parametrize("limit", [2.0, -2.0])
def test_a_state_that_begins_at_a_limit_is_held_there(limit: float) -> None:
    """The integral of a controller that leads beyond its limit as long as the mass rests beside its target."""
    target = 1.0 if limit > 0.0 else -1.0
    law = f"20*({target} - place.displacement) - 6*place.speed + inputs.I - {3 * target}"
    integral = {"rate": f"6*({target} - place.displacement)", "start": limit, "limits": [-2, 2]}
    scenario = {
        "model": {
            "gravity": [0, 0, 0],
            "bodies": [parts.body("mass", 1.0)],
            "joints": [parts.slide("s", "mass", displacement=0.95 * target)],
            "forces": [{"type": "actuator", "joint": "s", "value": law}],
        },
        "quantities": [{"name": "place", "type": "joint", "joint": "s"}],
        "inputs": {"I": integral},
        "integrator": {"method": "dop853", "tolerance": 1e-10, "end_time": 1.0},
    }
    free = np.sqrt(20.0 - 9.0)
    for given in (scenario, {**scenario, "start": {"from": "equilibrium"}}):
        found = lienumba.modes(given, at=[0.0, 1.0])
        np.testing.assert_allclose(found.angular_frequency.values[0], [[0.0, free]] * 2, atol=1e-7)
        np.testing.assert_allclose(found.growth.values[0], [[0.0, -3.0]] * 2, atol=1e-7)


def test_a_run_has_its_own_coordinates_where_those_of_the_first_do_not_fit() -> None:
    """A body at a distance of 1 m from the ground's origin, on a bushing: beside it, above it, and nearly above it."""
    places = np.array([[1.0, 0.0], [0.0, 1.0], [1e-9, 1.0]])
    bushing = {"name": "mount", "type": "bushing", "bodies": ["ground", "b"], "points": [[0, 0, 0]] * 2,
               "stiffness": [100, 200, 300], "rotational_stiffness": [5, 6, 7]}  # fmt: skip
    body = parts.body("b", 1.0, 0.1, position=[1, 0, 0], rotation=[1, 0, 0, 0])
    rod = {"name": "rod", "type": "distance", "bodies": ["ground", "b"], "points": [[0, 0, 0]] * 2, "length": 1}
    data = {
        "model": {"gravity": [0, 0, 0], "bodies": [body], "joints": [rod], "forces": [bushing]},
        **SHORT,
        "sweep": {"sampler": "table", "table": {"columns": {
            f"bodies.b.position[{n}]": places[:, n].tolist() for n in range(2)}}},
    }  # fmt: skip
    found, growth = lienumba.equilibrium(data), np.sqrt(200.0 - 100.0)
    assert found.status.values.tolist() == [0, 2, 0]
    assert found.growth.values[1] == pytest.approx(growth, rel=1e-9)
    assert abs(found.position.values[2, 0, 0]) == pytest.approx(1.0)  # it goes down to where the others are stable
    modes = lienumba.modes(data).growth.values[:, 0]
    np.testing.assert_allclose(np.nanmax(modes[1:], axis=1), growth, rtol=1e-6)
    assert np.nanmax(modes[0]) < 1e-9
