"""Small mechanisms that are valid and have much: measures, requirements, noise, changes, contacts, laws, sweeps.

What the schema alone gives is refused nearly always where names and formulas have to fit together; these are broken
behind that.
"""

from collections.abc import Callable
from random import Random
from typing import Any

from fuzzing.mutations import Tree, copied
from lienumba.scenario.formulas.measures import REDUCERS
from lienumba.sweep.samplers import SAMPLERS

CONDITIONS = (
    "t > 0.004",
    "root.angle > 0",
    "bob.z < 0 and t > 1e-3",
    "not t > 0.002",
    "root.rate < where(t > 1, 1, 0)",
)
NUMBERS = ("root.angle", "bob.z", "sqrt(bob.x**2 + bob.z**2)", "root.rate*k", "bob.x/(t - 0.003)", "0*t + 2", "k")
LAW = """
def pull(bob, t, gain=2.0):
    return bob.force([0, 0, gain * sin(t)]){more}

def well(bob, gain):
    return gain * bob.position.norm(){more}

def lag(bob, gain, states):
    return bob.force([0, states.i, gain]), dict(i=gain - states.i){more}

def swept(t, root_angle):
    return abs(root_angle).max()
"""
OTHERS = ("", " + 1", ".x", "[0]", "\n    raise ValueError('no')", " if t > 0 else None", ", 5", "\n  return")


def rich(random: Random, valid: Callable[[Tree], bool]) -> Tree:
    """Two hinges and a ball, and some of everything else, as far as it is valid together, most of it."""
    tree: Tree = {
        "parameters": {"k": 1.5, "ks": [0.5, 2.0]},
        "model": {"bodies": _bodies(random), "joints": _joints(random), "forces": []},
        "quantities": [
            {"name": "root", "type": "joint", "joint": "pivot"},
            {"name": "bob", "type": "point", "body": "one", "point": [0.3, 0, 0]},
            {"name": "sum", "type": "expression", "value": "k*root.angle + bob.z", "units": "1"},
        ],
        "integrator": random.choice(
            (
                {"step": 1e-3, "end_time": 0.01},
                {"tolerance": 1e-6, "end_time": 0.05},
                {"tolerance": 1e-8, "end_time": 0.02, "method": random.choice(("bs32", "taylor", "radau5", "dop853"))},
                {"step": 1e-3, "end_time": 0.01, "coordinates": "joint"},
            )
        ),
    }
    for act in random.sample(FEATURES, min(len(FEATURES), random.randint(1, 5))):
        act(more := copied(tree), random)
        if random.random() < 0.1 or valid(more):
            tree = more
    return tree


def _bodies(random: Random) -> list[Tree]:
    ball: Tree = {"name": "ball", "mass": 0.5, "inertia": [0.01] * 3, "position": [2, 0, 0.1005]}
    return [
        {"name": "one", "mass": 1.0, "inertia": [0.1, 0.2, 0.3], "position": [0.3, 0, 0]},
        {"name": "two", "mass": "k", "inertia": [0.1, 0.1, 0.1], "position": [0.9, 0, 0]},
        *([ball] if random.random() < 0.6 else []),
    ]


def _joints(random: Random) -> list[Tree]:
    second = random.choice(("revolute", "spherical", "universal", "cylindrical"))
    return [
        {"name": "pivot", "type": "revolute", "bodies": ["ground", "one"], "at": [0, 0, 0], "axis": [0, 1, 0]},
        {"name": "elbow", "type": second, "bodies": ["one", "two"], "at": [0.6, 0, 0],
         **({"axis": [0, 1, 0]} if second in ("revolute", "cylindrical") else
            {"axes": [[0, 1, 0], [0, 0, 1]]} if second == "universal" else {})},
    ]  # fmt: skip


def measures(tree: Tree, random: Random) -> None:
    found = tree.setdefault("measures", [])
    for n in range(random.randint(1, 3)):
        found.append({"name": f"m {n}", "value": _measure(random)})
    if random.random() < 0.2:
        tree["files"] = {"law.py": LAW.format(more="")}
        found.append({"name": "swept", "function": "law.py:swept"})


def _measure(random: Random) -> str:
    name = random.choice([*REDUCERS])
    x, c = random.choice(NUMBERS), random.choice(CONDITIONS)
    one = {
        "overshoot": f"overshoot({x}, {random.choice(NUMBERS)})",
        "time_above": f"time_above({x}, 0.1*k)",
        "at": f"at({x}, {random.choice(('0.005', 'low', '0', 'k', '1e-3*k'))})",
    }.get(name, f"{name}({c})" if name in ("first_time", "last_time", "time_when", "count") else f"{name}({x})")
    if name in ("max", "min", "mean", "rms", "integral", "final") and random.random() < 0.4:
        one = f"{name}({x}, {c})"
    return random.choice(("{}", "{}", "k*{} - 1", "abs({})", "max({}, 0.1)", "sqrt({})", "where({} > 0, 1, 2)")).format(
        one
    )


def requirements(tree: Tree, random: Random) -> None:
    named = [x["name"] for x in tree.get("measures", [])]
    value = random.choice([*named, "energy_lost", "max(root.angle)", "final(bob.z, t > 0.002)", "max_energy_drift"])
    bound = random.choice(({"below": 0.1}, {"above": "-k"}, {"between": [-1, "k"]}))
    more = random.choice(({}, {"confidence": 0.5}, {"failed": "ignore"}))
    tree["requirements"] = [{"name": "holds", "value": value, "probability": 0.9, **bound, **more}]
    if random.random() < 0.5:
        sweep(tree, random)


def events(tree: Tree, random: Random) -> None:
    acts: list[Tree] = [
        {"action": "record"}, {"action": "stop"}, {"action": "lock", "joint": "elbow"},
        {"action": "unlock", "joint": "elbow"}, {"action": "release", "joint": "elbow"},
        {"action": "engage", "joint": "elbow", "closing": 0.1}, {"action": "set", "parameters": {"k": "2 - t"}},
        {"action": "lock", "joint": "elbow", "coordinate": "angle", "once": True},
    ]  # fmt: skip
    found = tree.setdefault("events", [])
    for name in ("low", "late")[: random.randint(1, 2)]:
        found.append({"name": name, "when": random.choice(CONDITIONS), **random.choice(acts)})
    if random.random() < 0.3:
        tree["model"]["joints"][1][random.choice(("locked", "active"))] = random.random() < 0.5


def contacts(tree: Tree, random: Random) -> None:
    kinds: list[Tree] = [
        {"type": "point_plane", "points": [[0, 0, -0.1], [0, 0, 0]]},
        {"type": "sphere_plane", "radius": 0.1, "points": [[0, 0, 0], [0, 0, 0]]},
        {"type": "capsule_plane", "radius": 0.1, "axis": [1, 0, 0], "length": 0.1, "points": [[0, 0, 0], [0, 0, 0]]},
        {"type": "cylinder_plane", "radius": 0.1, "axis": [0, 1, 0], "points": [[0, 0, 0], [0, 0, 0]]},
        {"type": "sphere_sphere", "radii": [0.05, 0.05]},
    ]
    body = random.choice(("ball", "two"))
    if body == "ball" and len(tree["model"]["bodies"]) < 3:
        return
    how = random.choice(
        (
            {"restitution": 0.5},
            {"friction": 0.4},
            {"friction": {"static": 0.5, "kinetic": "0.3*k"}},
            {"stiffness": 1e4, "dissipation": 0.5, "friction": 0.3, "velocity": 0.01},
            {"restitution": "0.2*k", "rest_speed": 0.1},
        )
    )
    contact = {"name": "floor", "bodies": [body, "ground"], "normal": [0, 0, 1], **random.choice(kinds), **how}
    if contact["type"] == "sphere_sphere":
        del contact["normal"]
    tree["model"]["contacts"] = [contact]
    tree["quantities"].append({"name": "touch", "type": "contact", "contact": "floor"})


def limits(tree: Tree, random: Random) -> None:
    bounds = random.choice(({"low": -1e-4}, {"high": "0.1*k"}, {"low": -0.1, "high": 0.1, "restitution": 0.5}))
    tree["model"]["limits"] = [{"name": "stop", "joint": "pivot", **bounds}]
    tree["quantities"].append({"name": "at_stop", "type": "limit", "limit": "stop"})


def noise(tree: Tree, random: Random) -> None:
    kinds: list[Tree] = [
        {"type": "white"}, {"type": "walk"}, {"type": "bias"}, {"type": "band", "frequency": 20.0},
        {"type": "band", "order": 2, "damping": "0.5*k"},
        {"type": "dryden", "length": 1.0, "speed": "20*k", "direction": random.choice(("along", "across"))},
    ]  # fmt: skip
    kind = random.choice(kinds)
    kind |= {} if kind["type"] == "bias" else {"every": random.choice((1e-3, 3.3e-3, 0.02))}
    tree["noise"] = [{"name": "gust", "std": random.choice((0.0, 0.1, "0.2*k")), **kind}]
    tree["model"]["forces"].append(
        {"name": "wind", "type": "actuator", "joint": "pivot", "value": "gust + 0.1*gust**2"}
    )


def inputs(tree: Tree, random: Random) -> None:
    kinds: list[Any] = [
        1.0, "sin(t)*k", {"value": "root.angle", "filter": 0.01}, {"rate": "root.angle - 0.1", "limit": "k"},
        {"joint": "pivot", "kp": 20, "kd": "2*k", "target": "0.1*sin(t)", "limits": [-5, 5]},
        {"times": [0, 0.005, 0.1], "values": [0, 1, 0], "interpolation": random.choice(("hold", "linear", "cubic"))},
        {"times": [0, 0.005, 0.1], "values": [0, 1, 0], "delay": "1e-3*k"},
    ]  # fmt: skip
    tree["inputs"] = {"u": random.choice(kinds), "v": "0.5*inputs.u + k"}
    tree["model"]["forces"].append(
        {"name": "motor", "type": "actuator", "joint": "pivot", "value": "inputs.v", "limit": 9}
    )


def tables(tree: Tree, random: Random) -> None:
    kind = random.choice(("linear", "cubic", "hold"))
    tree["tables"] = {"wave": {"times": [0, 0.004, 0.01, 1], "values": [0, 1, -1, 0], "interpolation": kind}}
    tree["model"]["forces"].append(
        {"name": "push", "type": "force", "body": "two", "value": ["wave(t)", 0, "k*wave(2*t)"]}
    )


def laws(tree: Tree, random: Random) -> None:
    more = random.choice(OTHERS) if random.random() < 0.5 else ""
    kinds: list[Tree] = [
        {"function": "law.py:pull"}, {"function": "law.py:pull", "every": 2e-3},
        {"function": "law.py:lag", "states": {"i": 0.0}},
        {"function": "law.py:lag", "states": {"i": "k"}, "every": 1e-3},
        {"function": "law.py:well", "returns": "potential"},
    ]  # fmt: skip
    tree["files"] = {"law.py": "from lienumba.laws import sin\n" + LAW.format(more=more)}
    law = {"name": "law", "type": "python", "bodies": ["two"], "parameters": {"gain": "k*t"}}
    tree["model"]["forces"].append(law | random.choice(kinds))


def start(tree: Tree, random: Random) -> None:
    for body in tree["model"]["bodies"][:2]:
        del body["position"]
    tree["model"]["joints"] = [_apart(x) for x in tree["model"]["joints"]]
    tree["start"] = random.choice(
        (
            {"from": "equilibrium"},
            {"from": "equilibrium", "rotation": [0, 0, "k"]},
            {"q": {"pivot": "0.3*k"}, "qd": {"pivot": 1.0}},
            {"q": {"pivot": 1.0, "elbow": 0.5}},
        )
    )


def _apart(joint: Tree) -> Tree:
    """With points and axes in both bodies in the place of `at` and `axis`."""
    first = joint["name"] == "pivot"
    axis = {"axes": [joint["axis"]] * 2} if "axis" in joint else {}
    points = [[0, 0, 0], [-0.3, 0, 0]] if first else [[0.3, 0, 0], [-0.3, 0, 0]]
    return {**{k: x for k, x in joint.items() if k not in ("at", "axis")}, "points": points, **axis}


def sweep(tree: Tree, random: Random) -> None:
    kinds: list[Tree] = [
        {"distribution": "normal", "std": 0.1, "relative": True}, {"distribution": "uniform", "low": 0.5, "high": 2},
        {"distribution": "truncated_normal", "std": 0.3, "low": 0.1}, {"distribution": "lognormal", "sigma": 0.2},
        {"distribution": "triangular", "low": 0.5, "high": 3}, {"distribution": "choice", "values": [1, 2]},
        {"distribution": "constant", "value": 2}, {"scipy": "gamma", "a": 2.0},
    ]  # fmt: skip
    known = ["parameters.k", "bodies.one.mass", "gravity[2]", "parameters.ks[1]"]
    paths = random.sample(known + ["noise.gust.std"] * ("noise" in tree), 2)
    vary = {path: random.choice(kinds) for path in paths}
    vary |= random.choice(
        (
            {},
            {"bodies.one.inertia": {"distribution": "inertia", "std": 0.1}},
            {"gravity": {"distribution": "direction", "angle": 0.1}},
            {"bodies.one.inertia[0]": {"expression": f"0.1*{paths[0]}"}},
        )
    )
    sampler = random.choice([*SAMPLERS])
    runs = len(vary) * 8 + 8 if sampler in ("morris", "saltelli") else 6
    tree["sweep"] = {"runs": runs, "sampler": sampler, "vary": vary, "nominal": random.random() < 0.3}
    if sampler == "importance":
        tree["sweep"]["proposal"] = {
            paths[0]: {"shift": random.choice((2.0, -6, "x")), "scale": random.choice((1, 5.0))}
        }
    if sampler == "table":
        tree["sweep"]["table"] = {"columns": {paths[0]: [1.0, 1.5, 2.0]}, "runs": random.choice(([0, 1, 2], [5, 1, 9]))}
        tree["sweep"]["runs"] = 3
    if random.random() < 0.2:
        tree["sweep"]["correlate"] = [{"paths": paths, "matrix": [[1, 0.5], [0.5, 1]]}]
    if random.random() < 0.3:
        stop = random.choice(({"variable": "max_energy_drift", "width": 1e-9}, {
            "variable": "energy_lost", "statistic": "quantile", "probability": 0.5, "width": 1.0}))  # fmt: skip
        tree["sweep"]["stop"] = {**stop, "every": 2}


def study(tree: Tree, random: Random) -> None:
    grid = random.choice(
        ({"integrator.step": [1e-3, 5e-4]}, {"integrator.tolerance": [1e-5, 1e-7]}, {"parameters.k": [1, 2]},
         {"integrator.coordinates": ["lie", "joint"]}, {"integrator.method": ["rk4", "dop853"],
          "integrator.step": [1e-3]})
    )  # fmt: skip
    reference = random.choice(({"step": 5e-4}, {"tolerance": 1e-9}, {"position": {"one": ["0.3*cos(t)", 0, 0]}}))
    for key in ("requirements", "output"):
        tree.pop(key, None)
    tree["study"] = {"reference": reference, "grid": [grid], "repeats": 1}


def output(tree: Tree, random: Random) -> None:
    tree["output"] = random.choice(
        (
            {"every": 2e-3, "mode": "summary", "summary": {"root.angle": ["max", "rms"], "energy": ["final"]}},
            {"times": [0, 1e-3, 5e-3], "at_events": True},
            {"every": 1e-3, "joint_coordinates": True, "also": ["multiplier"], "precision": "float32"},
            {"mode": "summary", "full_runs": random.choice(("0:2", "1,3", "-1")), "every": 5e-3, "max_changes": 1},
            {"variables": ["root", "sum", "position"], "precision": {"root": "float32"}},
        )
    )


FEATURES: list[Callable[[Tree, Random], None]] = [
    measures, requirements, events, contacts, limits, noise, inputs, tables, laws, start, sweep, study, output,
]  # fmt: skip
