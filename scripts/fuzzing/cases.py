"""What is tried: the case of a seed and a number is always the same."""

import tomllib
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from random import Random
from typing import Any

from fuzzing.drawing import HOSTILE_TEXTS, Drawing
from fuzzing.mutations import Tree, copied, mutated, names_of, number_paths
from fuzzing.rich import rich
from lienumba.errors import ScenarioError
from lienumba.scenario.base import toml
from lienumba.scenario.base.paths import LISTS
from lienumba.scenario.reading.loading import load
from lienumba.scenario.resolve import resolve

GALLERY = Path(__file__).parents[2] / "scenarios"
OTHER_ACTS = ("modes", "equilibrium", "linearise", "rare", "worst", "sample", "info")
LARGE = ("talos", "solo12", "iiwa", "ur5", "pendulum_chain")  # tried less often, since they take long
MOST_STEPS, MOST_TRIES = 20, 1e5  # of given length, and by a tolerance
DAMAGE = [
    "\0", "\x1b", "=", "[[", "]]", "{", '"""', "\n", ".", "9" * 5000, "[" * 2000, "{a=" * 400, ".a" * 1500, "\ufeff",
    "\r", "é", "nan", "1e400", "1979-05-27", "07:32:00", "0xffffffffffffffffff",
]  # fmt: skip


@dataclass
class Case:
    """A scenario as dict or as TOML text, other files beside it, settings as a dict or as texts of a command line, and
    what is done with it if it is valid: nothing, or one of `trial.ACTS`."""

    seed: int
    number: int
    scenario: Any
    files: dict[str, str] = field(default_factory=dict)
    overrides: dict[Any, Any] = field(default_factory=dict)
    settings: list[str] = field(default_factory=list)
    act: str = ""


@cache
def gallery() -> dict[str, Tree]:
    """The scenarios of the gallery as trees, with what their files hold."""
    found = {}
    for path in sorted(GALLERY.glob("*.toml")):
        try:
            found[path.stem] = load(path)
        except ScenarioError:
            continue  # it needs a package that is not installed
    return found


def case(seed: int, number: int) -> Case:
    """The case of a seed and a number."""
    random = Random(f"{seed} {number}")
    has_much = random.random() < 0.25
    run = random.random() < (0.2 if has_much else 0.08)
    gentle = run or random.random() < 0.5
    draw = Drawing(random, 0.0 if gentle else random.choice((0.0, 0.02, 0.05)))
    tree = rich(random, _is_valid) if has_much else _made(draw) if random.random() < 0.4 else _chosen(random)
    if run and not has_much:
        _shorten(tree := copied(tree))
    count = random.choice((0, 0, 0, 1, 1, 2) if has_much else (0, 1, 1, 2, 2, 3, 5))
    for _ in range(count):
        tree = _changed(tree, draw, 5 if gentle else 1)
    if run:
        _shorten(tree)
    found = Case(seed, number, tree)
    if run:
        found.act = random.choice(("run", "run", "run", *OTHER_ACTS) if has_much else ("run",))
    elif random.random() < 0.15:
        found.overrides = _settings(draw, tree)
        if random.random() < 0.4:
            found.settings = [f"{path}={_written(x)}" for path, x in found.overrides.items()]
            found.overrides = {}
    if not run and random.random() < 0.15:
        base, tree = _split(tree, random)
        found.files = {"base.toml": _text(base, random)} if base else {}
        found.scenario = _text(tree, random)
    return found


def _split(tree: Tree, random: Random) -> tuple[Tree, Tree]:
    """Sometimes a scenario that another one extends, and that one."""
    if random.random() < 0.5 or "extends" in tree:
        return {}, tree
    base = {key: x for key, x in tree.items() if random.random() < 0.7}
    own = {key: x for key, x in tree.items() if key not in base or random.random() < 0.2}
    return base, {
        "extends": random.choice(("base.toml",) * 6 + ("./base.toml", "case.toml", "", "..", "no.toml")),
        **own,
    }


def _written(value: Any) -> str:
    """A value as somebody types it behind PATH=."""
    try:
        return toml.value_text(value)
    except Exception:  # of what TOML cannot hold
        return str(value)


def _changed(tree: Tree, draw: Drawing, attempts: int, kind: str = "") -> Tree:
    """With one mutation, or one more element of a kind; of so many attempts the first that is valid, or the last."""
    found = tree
    for attempt in range(attempts):
        found = mutated(tree, draw, 1, kind)
        if attempt < attempts - 1 and _is_valid(found):
            break
    return found


def _is_valid(tree: Tree) -> bool:
    try:
        resolve(copied(tree), allow_code=True)
    except Exception:  # the case itself is judged
        return False
    return True


def _chosen(random: Random) -> Tree:
    small = [name for name in gallery() if not name.startswith(LARGE)]
    return gallery()[random.choice([*gallery()] if random.random() < 0.03 else small)]


def _made(draw: Drawing) -> Tree:
    """A small mechanism of the schema: a few bodies, and one or two of everything else."""
    random = draw.random
    bodies = [_body(draw, f"b{i}") for i in range(random.choice((1, 1, 2, 3)))]
    tree: Tree = {
        "model": {"bodies": bodies},
        "integrator": {"step": 1e-3, "end_time": 0.01}
        if random.random() < 0.7
        else {"tolerance": 1e-6, "end_time": 0.01},
    }
    if random.random() < 0.3:
        tree["parameters"] = {"k": 1.0}
    if random.random() < 0.3:
        tree["inputs"] = {"u": random.choice((1.0, "sin(t)", {"value": "t", "filter": 0.1}))}
    if random.random() < 0.3:
        tree["integrator"]["coordinates"] = random.choice(
            draw.at("integrator", "coordinates").get("enum", ["lie", "joint"])
        )
    for kind in ("joints", *LISTS[1:], "forces", "quantities"):
        if random.random() < (0.8 if kind == "joints" else 0.3):
            tree = _changed(tree, draw, 6, kind)
    return tree


def _body(draw: Drawing, name: str) -> Tree:
    """One that is valid, so that what stands beside it is looked at."""
    random = draw.random
    body: Tree = {
        "name": name,
        "mass": random.choice((1, 0.5, 10.0)),
        "inertia": [random.uniform(1, 2) for _ in range(3)],
    }
    if random.random() < 0.3:
        body["position"] = [random.gauss(0, 1) for _ in range(3)]
    if random.random() < 0.3:
        body["angular_velocity"] = [random.gauss(0, 1) for _ in range(3)]
    return body


def _shorten(tree: Tree) -> None:
    """Few steps, few runs, where they stand as numbers."""
    integrator, sweep, output = (tree.get(key) for key in ("integrator", "sweep", "output"))
    if isinstance(integrator, dict):
        step = integrator.get("step")
        step = step if isinstance(step, float) and 0 < step < 1e3 else 1e-3
        end = integrator.get("end_time")
        if isinstance(end, int | float) and end > MOST_STEPS * step:
            integrator["end_time"] = MOST_STEPS * step
            if isinstance(output, dict):
                for key in ("every", "times"):
                    output.pop(key, None)
        end = integrator.get("end_time")
        if "tolerance" in integrator and "step" not in integrator and isinstance(end, float) and end > 0:
            integrator.setdefault("min_step", end / MOST_TRIES)
    if isinstance(sweep, dict) and isinstance(sweep.get("runs"), int) and sweep["runs"] > 8:
        sweep["runs"] = 4
    tree.pop("study", None)


def _settings(draw: Drawing, tree: Tree) -> dict[Any, Any]:
    """What `--set` or `overrides` may hold."""
    random, found = draw.random, {}
    for _ in range(random.choice((1, 1, 2, 5))):
        sections = [
            f"{key}.{inner}" for key, x in tree.items() if isinstance(x, dict) for inner in x if isinstance(inner, str)
        ]
        path: Any = random.choice([*number_paths(tree), *sections, *HOSTILE_TEXTS, draw.path(names_of(tree))])
        value = draw.junk()
        found[path] = str(value) if random.random() < 0.4 else value
    if random.random() < 0.03:
        found[5] = 1
    return found


def _text(tree: Tree, random: Random) -> str:
    """The scenario as a TOML text, which may be damaged."""
    try:
        text = toml.dumps(tree)
        tomllib.loads(text)
    except Exception:  # of what TOML cannot hold
        text = "[model]\n"
    for _ in range(random.choice((0, 1, 1, 2, 5))):
        i, j = sorted((random.randint(0, len(text)), random.randint(0, min(len(text), 10**6))))
        inner = text[i : min(j, i + random.choice((1, 3, 30)))]
        damage = random.choice(["", inner * 2, *DAMAGE])
        text = text[:i] + damage + text[i + len(inner) :]
    return text
