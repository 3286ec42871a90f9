"""Ways to break a scenario: each changes a tree of tables and lists in place."""

from collections.abc import Callable
from typing import Any

from fuzzing.drawing import HOSTILE_NUMBERS, Drawing, Names, every, nested
from lienumba.scenario.base.paths import BESIDE, LISTS

Tree = dict[str, Any]
Place = tuple[Any, Any]  # a table or list, and a key in it


def copied(tree: Any) -> Any:
    """A deep copy of tables and lists, however deep they are."""
    holder: list[Any] = [tree]
    waiting: list[Place] = [(holder, 0)]
    while waiting:
        within, key = waiting.pop()
        value = within[key]
        if isinstance(value, dict | list):
            within[key] = value.copy()
            waiting += [(within[key], k) for k in (value if isinstance(value, dict) else range(len(value)))]
    return holder[0]


def places(node: Any) -> list[Place]:
    """Every value of a tree: what it stands in, and under which key; not far into long lists."""
    found: list[Place] = []
    waiting = [node]
    while waiting and len(found) < 3000:
        holder = waiting.pop()
        keys = list(holder) if isinstance(holder, dict) else range(min(len(holder), 40))
        for key in keys:
            found.append((holder, key))
            if isinstance(holder[key], dict | list):
                waiting.append(holder[key])
    return found


def names_of(tree: Tree) -> Names:
    """The names that a scenario gives."""
    model = tree.get("model")
    model = model if isinstance(model, dict) else {}
    found: Names = {}
    for kind in LISTS:
        items = [x for holder in (model, tree) if isinstance(holder.get(kind), list) for x in holder[kind]]
        found[kind] = [x["name"] for x in items if isinstance(x, dict) and isinstance(x.get("name"), str)]
    for kind in ("parameters", "tables", "inputs"):
        found[kind] = [str(key) for key in tree[kind]] if isinstance(tree.get(kind), dict) else []
    found["numbers"] = [
        *found["parameters"],
        *(f"inputs.{x}" for x in found["inputs"]),
        *(f"{x}(t)" for x in found["tables"]),
    ]
    return found


def replace_by_junk(tree: Tree, draw: Drawing) -> None:
    holder, key = draw.random.choice(places(tree))
    holder[key] = draw.junk()


def remove(tree: Tree, draw: Drawing) -> None:
    holder, key = draw.random.choice(places(tree))
    del holder[key]


def swap(tree: Tree, draw: Drawing) -> None:
    found = places(tree)
    (a, i), (b, j) = draw.random.choice(found), draw.random.choice(found)
    a[i], b[j] = copied(b[j]), copied(a[i])


def double(tree: Tree, draw: Drawing) -> None:
    """An item of a list twice, or a value in another table, too."""
    holder, key = draw.random.choice(places(tree))
    if isinstance(holder, list):
        holder.append(copied(holder[key]))
        return
    tables = [x[k] for x, k in places(tree) if isinstance(x[k], dict)]
    draw.random.choice([tree, *tables])[key] = copied(holder[key])


def change_number(tree: Tree, draw: Drawing) -> None:
    found = [(x, k) for x, k in places(tree) if isinstance(x[k], int | float)]
    if not found:
        return
    holder, key = draw.random.choice(found)
    random, x = draw.random, holder[key]
    if not abs(x) < 1e200:
        holder[key] = -x
        return
    nearby = x * (1 + 1e-15 * random.randint(-9, 9))
    whole = int(x) if abs(x) < 1e9 else 1
    scaled = x * 10.0 ** random.randint(-20, 20)
    holder[key] = random.choice((scaled, -x, nearby, 0.0, whole, random.choice(HOSTILE_NUMBERS)))


def change_many_numbers(tree: Tree, draw: Drawing) -> None:
    for _ in range(draw.random.randint(2, 8)):
        change_number(tree, draw)


def put_formula(tree: Tree, draw: Drawing) -> None:
    found = [(x, k) for x, k in places(tree) if isinstance(x[k], int | float)]
    if found:
        holder, key = draw.random.choice(found)
        holder[key] = draw.formula(names_of(tree))


def collide(tree: Tree, draw: Drawing) -> None:
    """A name, or a key, that something else has."""
    names = names_of(tree)
    known = [*every(names), "t", "ground", "inputs", "sin", "position", "run", "time"]
    found = [(x, k) for x, k in places(tree) if k == "name"]
    if found and draw.random.random() < 0.7:
        holder, key = draw.random.choice(found)
        holder[key] = draw.random.choice(known)
        return
    tables = [x[k] for x, k in places(tree) if isinstance(x[k], dict) and x[k]]
    if tables:
        table = draw.random.choice(tables)
        table[draw.random.choice(known)] = table.pop(draw.random.choice(list(table)))


def deepen(tree: Tree, draw: Drawing) -> None:
    holder, key = draw.random.choice(places(tree))
    kind: Any = draw.random.choice(([], {}))
    inner = nested(kind, draw.random.choice((1, 1, 2, 30, 500)))
    holder[key] = [holder[key]] if kind == [] and draw.random.random() < 0.5 else inner


def add_element(tree: Tree, draw: Drawing, kind: str = "") -> None:
    """One more joint, force, quantity, event, ... as the schema has it."""
    kind = kind or draw.random.choice(LISTS)
    holder = tree if kind in BESIDE else tree.setdefault("model", {})
    if not isinstance(holder, dict):
        return
    schema = draw.at(kind) if kind in BESIDE else draw.at("model", kind)
    item = draw.value(draw.resolved(schema)["items"], kind, names_of(tree))
    if isinstance(item, dict) and draw.random.random() < 0.9:
        item["name"] = f"new{draw.random.randint(0, 99)}"
    items = holder.setdefault(kind, [])
    if isinstance(items, list):
        items.append(item)


def add_key(tree: Tree, draw: Drawing) -> None:
    """A key of a section, as the schema has it."""
    section = draw.random.choice([key for key in draw.schema["properties"] if key != "model"])
    schema = draw.resolved(draw.schema["properties"][section])
    schema = draw.resolved(next((x for x in schema.get("anyOf", []) if x.get("type") != "null"), schema))
    held, names = tree.get(section), names_of(tree)
    if not isinstance(held, dict) or "properties" not in schema:
        tree[section] = draw.value(schema, section, names)
        return
    new = draw.table(schema, names)
    keys = [key for key in new if key not in held] or list(new)
    for key in draw.random.sample(keys, min(len(keys), draw.random.randint(1, 2))):
        held[key] = new[key]


def new_section(tree: Tree, draw: Drawing) -> None:
    section = draw.random.choice(list(draw.schema["properties"]))
    tree[section] = draw.value(draw.schema["properties"][section], section, names_of(tree))


def vary(tree: Tree, draw: Drawing) -> None:
    """A number that exists varies."""
    names = names_of(tree)
    schema = draw.resolved(draw.at("sweep", "vary"))["additionalProperties"]
    sweep = tree.setdefault("sweep", {})
    if isinstance(sweep, dict) and isinstance(entries := sweep.setdefault("vary", {}), dict):
        path = draw.random.choice(number_paths(tree)) if draw.random.random() < 0.8 else draw.path(names)
        entries[path] = draw.value(schema, path, names)
        sweep.setdefault("runs", 2)


def study(tree: Tree, draw: Drawing) -> None:
    """A grid over a number that exists."""
    path = draw.random.choice(["integrator.step", "integrator.method", *number_paths(tree)])
    values = [draw.random.choice([1e-3, 5e-4, "rk4", draw.junk()]) for _ in range(draw.random.randint(1, 3))]
    reference = draw.random.choice([{"method": "rk4", "step": 5e-4}, {"step": 1e-3}, draw.junk()])
    tree["study"] = {"reference": reference, "grid": [{path: values}], "repeats": 1}


def number_paths(tree: Tree) -> list[str]:
    """Paths of numbers of the model, and of some other values."""
    found = ["gravity[2]", "bodies[0].mass"]

    def walk(node: Any, path: str, depth: int) -> None:
        if depth > 5 or len(found) > 200:
            return
        if isinstance(node, dict):
            for key, x in node.items():
                walk(x, f"{path}.{key}" if path else str(key), depth + 1)
        elif isinstance(node, list):
            for i, x in enumerate(node[:20]):
                name = x.get("name") if isinstance(x, dict) else None
                walk(x, f"{path}.{name}" if isinstance(name, str) else f"{path}[{i}]", depth + 1)
        elif path:
            found.append(path)

    model = tree.get("model")
    walk({key: x for key, x in model.items() if key in (*LISTS, "gravity")} if isinstance(model, dict) else {}, "", 0)
    walk({key: tree[key] for key in ("parameters", "inputs") if key in tree}, "", 0)
    return found


MUTATIONS: dict[Callable[[Tree, Drawing], None], float] = {
    replace_by_junk: 3, remove: 2, swap: 1, double: 1, change_number: 3, change_many_numbers: 1, put_formula: 2,
    collide: 1.5, deepen: 0.5, add_element: 4, add_key: 3, new_section: 0.7, vary: 2, study: 0.7,
}  # fmt: skip


def mutated(tree: Tree, draw: Drawing, count: int, kind: str = "") -> Tree:
    """A copy with so many mutations, or with one more element of a kind."""
    tree = copied(tree)
    if kind:
        add_element(tree, draw, kind)
        return tree
    for act in draw.random.choices(list(MUTATIONS), list(MUTATIONS.values()), k=count):
        if tree:
            act(tree, draw)
    return tree
