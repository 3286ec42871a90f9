"""The memo of programs: what has the same structure is compiled once, and what differs never shares a program."""

import copy
import gc
import sys
import threading
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
import xarray as xr

import lienumba
from lienumba.compiler.memo import text_of
from lienumba.compiler.symbols import Graph, Symbol
from lienumba.integrators.tracing import compiled as memo
from lienumba.integrators.tracing import machine, program, step_kernels
from lienumba.integrators.tracing.compiled import PROGRAMS
from lienumba.keys.registry import Registry
from tests.facade import Body, Model
from tests.rigs.scenarios import start_of

Data = dict[str, Any]


def arm(**changes: Any) -> Data:
    """A skew arm on a hinge with a spring to the ground; changes: by path with "__" for a dot."""
    data: Data = {
        "model": {
            "gravity": [0.3, 0.2, -9.81],
            "bodies": [
                {"name": "arm", "mass": 1.3, "inertia": [0.06, 0.05, 0.02, 0.004, -0.006, 0.005],
                 "rotation": {"axis": [0, 1, 0], "angle": 0.4}},
            ],
            "joints": [
                {"name": "hinge", "type": "revolute", "bodies": ["ground", "arm"],
                 "points": [[0, 0, 0], [0.1, 0.2, 0.5]], "axes": [[0, 1, 0], [0, 1, 0]],
                 "references": [[1, 0, 0], [1, 0, 0]], "rate": 2.0},
            ],
            "forces": [
                {"name": "spring", "type": "spring_damper", "bodies": ["ground", "arm"],
                 "points": [[0.4, 0.1, -0.3], [0.2, 0.3, 0.7]], "stiffness": 40, "damping": 0.5, "free_length": 0.3},
                {"name": "push", "type": "force", "body": "arm", "point": [0.1, 0.3, 0.2],
                 "value": ["0.3*sin(7*t)", 2, 0]},
            ],
        },
        "integrator": {"step": 0.01, "end_time": 0.1},
        "output": {"every": 0.05},
    }  # fmt: skip
    for path, value in changes.items():
        *above, last = path.split("__")
        node: Any = data
        for key in above:
            node = node[int(key) if key.isdigit() else key]
        node[int(last) if last.isdigit() else last] = value
    return data


FORCE, POINT = "model__forces__1__", "model__forces__0__points__1__"
PARAMETERS = {"parameters": {"kp": 3.0}, f"{FORCE}value": ["kp*sin(t)", 2, 0]}


def table(values: list[float], **more: Any) -> Data:
    times = [0.05 * n for n in range(len(values))]
    data = arm(**{f"{FORCE}value": ["wind(t)", 2, 0]})
    return data | {"tables": {"wind": {"times": times, "values": values, **more}}}


def swept(path: str, values: list[float], **changes: Any) -> Data:
    return arm(**changes) | {
        "sweep": {"sampler": "table", "table": {"columns": {"x": values}}, "vary": {path: {"column": "x"}}}
    }


SAME = {  # the first and the others have one program
    "numbers": [
        arm(), arm(model__bodies__0__mass=2.7), arm(model__bodies__0__mass=1), arm(**{f"{POINT}0": 0.7}),
        arm(model__forces__0__stiffness=np.float64(1.0)), arm(integrator__step=0.005), arm(output__every=0.1),
        arm(model__bodies__0__mass=np.float32(2.5)),
    ],
    "swept numbers": [
        arm(), swept("bodies.arm.mass", [1.0, 0.9]), swept("forces.spring.points[1][0]", [0.2, 1.0, 0.0]),
    ],
    "exact numbers": [arm(**{f"{POINT}0": 0}), arm(**{f"{POINT}0": 0.0}), arm(**{f"{POINT}0": np.float64(0.0)})],
    "parameters": [arm(**PARAMETERS), arm(**PARAMETERS | {"parameters": {"kp": 1.0}})],
    "tables": [table([0.0, 1.0, 3.0]), table([5.0, -1.0, 0.5])],
    "starts": [arm(), arm(model__joints__0__rate=1.0)],
}  # fmt: skip
DIFFERENT = {  # no two of them have
    "exact numbers": [arm(**{f"{POINT}0": x}) for x in (0.5, 0.0, 1.0, -1.0)],
    "a sweep": [
        arm(**{f"{POINT}0": 1.0}), swept("forces.spring.points[1][0]", [1.0], **{f"{POINT}0": 1.0}),
        swept("forces.spring.points[1][1]", [1.0], **{f"{POINT}0": 0.0}),
    ],
    "formulas": [arm(**{f"{FORCE}value": [text, 2, 0]}) for text in ("sin(7*t)", "sin(8*t)", "cos(7*t)", "t", "0*t")],
    "names in formulas": [
        arm(parameters={"a": 2.0, "b": 3.0}, **{f"{FORCE}value": [text, 2, 0]}) for text in ("a - b*t", "b - a*t")
    ],
    "tables": [
        table([0.0, 1.0, 3.0]), table([0.0, 1.0, 3.0, 4.0, 5.0]), table([0.0, 1.0, 3.0], interpolation="cubic"),
        table([0.0, 1.0, 3.0], interpolation="hold"),
    ],
    "methods": [
        arm(), arm(integrator__method="rk38"), arm(projection={"position": "none"}), arm(projection={"chord": True}),
        arm(integrator={"tolerance": 1e-6, "end_time": 0.1}), arm(integrator__group="SE3"),
    ],
    "types": [arm(), arm(model__joints__0__type="cylindrical")],
    "events": [
        arm(quantities=[{"name": "q", "type": "joint", "joint": "hinge"}],
            events=[{"name": "e", "when": f"q.angle > {x}", "action": a}])
        for x, a in (("0.5", "record"), ("0.6", "record"), ("0.5", "stop"))
    ],
}  # fmt: skip


@pytest.fixture(autouse=True)
def empty() -> None:
    PROGRAMS.clear()


def anew(data: Data) -> xr.Dataset:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(PROGRAMS, "entries", 0)
        kept = dict(PROGRAMS._kept)
        PROGRAMS.clear()
        try:
            return lienumba.run(copy.deepcopy(data))
        finally:
            PROGRAMS._kept.update(kept)


def assert_same_bits(a: xr.Dataset, b: xr.Dataset) -> None:
    assert set(a.variables) == set(b.variables)
    for name in a.variables:
        assert a[name].values.tobytes() == b[name].values.tobytes(), name


def test_a_program_leaves_nothing_behind_for_the_collector() -> None:
    """A graph that only the collector could free would be walked through three times before it is."""

    def alive() -> int:
        return sum(issubclass(type(thing), Symbol | Graph) for thing in gc.get_objects())

    gc.collect()
    before = alive()
    gc.disable()
    try:
        lienumba.run(arm())
        left = alive() - before
    finally:
        gc.enable()
    assert left < 100  # of thousands; a formula has a graph of its own


@pytest.mark.parametrize("name", SAME)
def test_other_numbers_have_the_same_program_and_their_own_bits(name: str) -> None:
    for data in SAME[name]:
        assert_same_bits(lienumba.run(copy.deepcopy(data)), anew(data))
        assert len(PROGRAMS) == 1


@pytest.mark.parametrize("name", DIFFERENT)
def test_what_differs_in_more_has_another_program(name: str) -> None:
    for n, data in enumerate(DIFFERENT[name]):
        lienumba.run(copy.deepcopy(data))
        assert len(PROGRAMS) == n + 1
    first = DIFFERENT[name][0]
    assert_same_bits(lienumba.run(copy.deepcopy(first)), anew(first))
    assert len({text_of(key) for _, key in PROGRAMS._kept}) == len(PROGRAMS)  # by which they are found on disk


def test_another_method_has_other_steps_and_nothing_else_to_compile() -> None:
    """Kernels of the mechanism alone are found by their text, whatever the method hoists."""
    texts = []
    for name in ("rk4", "dop853", "radau5"):
        model, _ = start_of(arm())
        kernels = program.build(model, program.Method(name, "local", "mass")).kernels
        assert sum(len(kernel.hoisted) for kernel in kernels.values()) > 10
        texts.append({kernel: kernels[kernel].text() for kernel in ("position", "velocity", "observe")})
    assert texts[0] == texts[1] == texts[2]


def test_a_zero_with_a_sign_has_a_key_of_its_own() -> None:
    method = program.Method("rk4", "none", "none")

    def key(x: Any) -> Any:
        return memo.key_of(Model((x, 0.0, -9.81), (Body("b", 1.0, (1.0,) * 6),)), method, memo.UNIQUE, True)

    keys = [key(x) for x in (0.0, -0.0, 1.0, -1.0, 0.5, np.array([0.0]))]
    assert None not in keys
    assert len(set(keys)) == 5  # 0.5 and a swept 0 are slots
    assert key(0.0) == key(0) == key(np.float64(0.0))


def test_a_function_of_time_that_is_no_data_has_no_key() -> None:
    model = Model((lambda t: t, 0.0, -9.81), (Body("b", 1.0, (1.0,) * 6),))
    assert memo.key_of(model, program.Method("rk4", "none", "none"), memo.UNIQUE, True) is None


def test_other_limits_make_another_program(monkeypatch: pytest.MonkeyPatch) -> None:
    lienumba.run(arm())
    monkeypatch.setattr(step_kernels, "INLINE", 0)
    lienumba.run(arm())
    assert len(PROGRAMS) == 2
    monkeypatch.setattr(Registry, "changes", Registry.changes + 1)  # a name may mean another element now
    lienumba.run(arm())
    assert len(PROGRAMS) == 3


# ---------------------------------------------------------------- laws of the user's own
LAW = "import settings\nfrom lienumba.laws import sin\n\nSCALE = {scale}\n\ndef helper(t):\n    return {helper}\n\n"
LAW += "def push(body, *, t):\n    return body.force((settings.GAIN, SCALE * helper(t), {value}))\n"


def lawful(folder: Path, scale: str = "2.0", helper: str = "sin(t)", value: str = "0.5") -> Data:
    (folder / "law.py").write_text(LAW.format(scale=scale, helper=helper, value=value))
    push = {"name": "push", "type": "python", "function": f"{folder / 'law.py'}:push", "bodies": ["arm"]}
    return arm(model__forces=[push])


def test_a_law_that_was_changed_never_meets_the_program_of_the_old_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    settings: Any = ModuleType("settings")
    settings.GAIN = 3.0
    monkeypatch.setitem(sys.modules, "settings", settings)
    count = 0
    for changes in ({}, {"scale": "3.0"}, {"helper": "sin(2*t)"}, {"value": "-0.0"}, {"value": "0.0"}, {"value": "t"}):
        data = lawful(tmp_path, **changes)
        for gain in (3.0,) if changes else (4.0, 0.0, 1.0, 3.0):
            settings.GAIN = gain
            count += 1
            expected = anew(data)
            for _ in range(2):
                assert_same_bits(lienumba.run(data), expected)
                assert len(PROGRAMS) == count


@pytest.mark.parametrize(
    ("name", "text", "more"),
    [
        ("push", "N = {n}\ndef push(body):\n    return [body.force((3.0, 0.0, 0.0))] * N\n", {}),
        (
            "sqrt",
            "from lienumba.laws import sqrt\nN = {n}\ndef push(body, *, t):\n"
            "    x, y = body.position[0] + 3.0, body.position[2] + 5.0\n"
            "    sqrt(x), sqrt(y)\n    return (x, y)[N - 1]\n",
            {"returns": "potential"},
        ),
    ],
    ids=["the same load twice", "the name of an operation"],
)
def test_what_a_law_returns_is_part_of_its_program(tmp_path: Path, name: str, text: str, more: Data) -> None:
    push = {"name": name, "type": "python", "function": f"{tmp_path / 'law.py'}:push", "bodies": ["arm"], **more}
    for n in (1, 2, 1):
        (tmp_path / "law.py").write_text(text.format(n=n))
        data = arm(model__forces=[push])
        assert_same_bits(lienumba.run(data), anew(data))


def test_a_parameter_of_a_law_is_no_part_of_its_program(tmp_path: Path) -> None:
    (tmp_path / "law.py").write_text("def push(body, *, x):\n    return body.force((x, 0.0, 1.0))\n")
    for x in (3.0, 1.0, 4.0):
        push = {"name": "push", "type": "python", "function": f"{tmp_path / 'law.py'}:push", "bodies": ["arm"],
                "parameters": {"x": x}}  # fmt: skip
        data = arm(model__forces=[push])
        assert_same_bits(lienumba.run(data), anew(data))
        assert len(PROGRAMS) == 1


# ---------------------------------------------------------------- memory and threads
def test_runs_of_one_structure_in_many_threads_compile_it_once(monkeypatch: pytest.MonkeyPatch) -> None:
    made, original = [], program.build

    def counted(*arguments: Any) -> Any:
        made.append(threading.get_ident())
        return original(*arguments)

    monkeypatch.setattr(program, "build", counted)
    masses = [1.0 + 0.1 * n for n in range(8)]
    expected = [anew(arm(model__bodies__0__mass=mass)) for mass in masses]
    made.clear()
    with ThreadPoolExecutor(8) as pool:
        found = list(pool.map(lambda mass: lienumba.run(arm(model__bodies__0__mass=mass)), masses))
    for a, b in zip(found, expected, strict=True):
        assert_same_bits(a, b)
    assert len(made) == 1


def test_machine_code_goes_with_its_program() -> None:
    from lienumba.compiler import native

    PROGRAMS.clear()
    before = len(native._engines)
    lienumba.run(arm(model__gravity=[0.123, 0.456, 1.0]))
    assert len(native._engines) > before
    PROGRAMS.clear()
    import gc

    gc.collect()
    assert len(native._engines) == before


def test_a_machine_keeps_its_code_when_it_is_forgotten() -> None:
    made = memo.compiled(Model((0.0, 0.0, -9.81), (Body("b", 1.0, (1.0,) * 6),)), program.Method("rk4", "none", "none"))
    PROGRAMS.clear()
    parameters = machine.aligned(1, made[1].sizes.parameters, 8)
    parameters[:] = 2.0
    machine.prepare(made[1], parameters)
    assert np.isfinite(parameters).all()
