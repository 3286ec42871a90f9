"""Values drawn from the JSON schema of scenarios: what the registries know is drawn without a word here."""

import math
from functools import cache
from random import Random
from typing import Any

from lienumba.keys.registry import Registry
from lienumba.scenario.schema.json_schema import json_schema

Schema = dict[str, Any]
Names = dict[str, list[str]]  # of what a scenario holds: bodies, joints, ...

HOSTILE_NUMBERS: list[Any] = [
    0, -0.0, 1, -1, 2, 3, 1e-300, 5e-324, 1e-100, 1e-30, 1e-16, -1e-9, 1e9, 1e16, 1e30, 1e99, 1e100, 1.1e100, 1e300,
    -1e300, math.nan, math.inf, -math.inf, 2**31, 2**32, 2**63, -(2**63), 2**64, 10**30, 10**400, 4_000_000_000,
    True, False,
]  # fmt: skip
HOSTILE_TEXTS = [
    "", " ", "\0", "a\0b", "\n", "\x1b[2J", "..", "/", ".", "a.b", "a[0]", "[", "]", '"', "'", "t", "pi", "nan",
    "inf", "1", "1e400", "ground", "global", "none", "name", "x" * 300, "x" * 5000, "é", "😀", "\u202e", "\ud800",
    "__class__", "%s", "{0}", "a:b", "a.py:f", ":f", "../a.csv", "/etc/passwd", "/dev/null", "a" * 5000 + ".csv",
    "nul\0.csv", ".", "inputs.u", "inputs", "t.x", "True", "if",
]  # fmt: skip
HOSTILE_FORMULAS = [
    "1/t", "sqrt(t)", "log(t)", "t**0.5", "1/0", "0/0", "exp(1e5)", "1e200*t", "1e300*1e300", "t**1000", "10**400",
    "9**9**9**9", "-" * 200 + "t", "(" * 90 + "t" + ")" * 90, "(" * 3000, "+".join(["t"] * 3000),
    "sin(" * 60 + "t" + ")" * 60, "t if t else 1", "lambda: 1", "__import__('os')", "t.real", "[t][0]",
    "where(t<1, 1, 1/0)", "where(t, 1, 2)", "t < 1", "t < 1 < t", "not t < 1", "t == 1", "abs(t - 0.001)",
    "atan2(0, 0)", "atan2(t, -t)", "max(t)", "min(1, 2, 3)", "sin", "sin()", "sin(t, t)", "t(1)", "1(t)", "t\n+1",
    "#", "t #", "1_000", "0x10", "1e", "1j", "'a'", "f'{t}'", "u.x", "u", "k", "k*t", "hinge.angle", "t < 0",
    "t > 1e-9", "1e-320*t", "sign(t)", "t*deg", "floor(t*1e15)", "tan(t*1e300)", "asin(2 + t)", "acos(1)", "t**-1",
    "(-t)**0.5", "0**t", "t**t", "exp(-1/t)", "1/(t - 0.0005)", "2t", "1,5", 10**30 * 1, "9" * 5000, "t" * 5000,
    "1e-400", "--1", "t and 1", "t > 0 and t < 1 or not t > 2",
]  # fmt: skip
LISTED = {
    "bodies": "bodies",
    "body": "bodies",
    "relative_to": "bodies",
    "joint": "joints",
    "joints": "joints",
    "driver": "drivers",
}


@cache
def _schema(changes: int) -> Schema:
    """The schema of the registries as they are."""
    return json_schema()


class Drawing:
    """Draws values that suit the schema, most of them, with names of a scenario where names stand."""

    def __init__(self, random: Random, hostile: float = 0.03) -> None:
        self.random, self.hostile = random, hostile
        self.schema = _schema(Registry.changes)

    def resolved(self, schema: Schema) -> Schema:
        while "$ref" in schema:
            schema = self.schema["$defs"][schema["$ref"].rpartition("/")[2]]
        return schema

    def at(self, *keys: str) -> Schema:
        """The schema of a key."""
        node = self.schema
        for key in keys:
            node = self.resolved(node)
            for choice in node.get("anyOf", []):
                if choice.get("type") != "null":
                    node = self.resolved(choice)
                    break
            node = node["properties"][key] if key in node.get("properties", {}) else node["items"]
        return node

    def value(self, schema: Schema, key: str, names: Names, depth: int = 0) -> Any:
        """One value; key: under which it stands."""
        random, schema = self.random, self.resolved(schema)
        if random.random() < self.hostile:
            return self.junk()
        choices = schema.get("oneOf") or schema.get("anyOf")
        if choices:
            given = [x for x in choices if x.get("type") != "null"]
            return self.value(random.choice(given), key, names, depth)
        if "const" in schema:
            return schema["const"]
        if "enum" in schema:
            return random.choice(schema["enum"])
        kind = schema.get("type")
        if isinstance(kind, list):
            kind = random.choices(kind, [8, *[1] * (len(kind) - 1)])[0]
            if kind == "string":
                return self.formula(names)
        if kind in ("number", "integer"):
            return self.number(schema, kind == "integer")
        if kind == "string":
            return self.text(key, names)
        if kind == "boolean":
            return random.random() < 0.5
        if kind == "array":
            few = schema.get("minItems", 0)
            count = random.randint(few, schema.get("maxItems", few + random.choice((0, 1, 2, 3))))
            return [self.value(schema.get("items", {}), key, names, depth + 1) for _ in range(min(count, 9))]
        if kind == "object" or "properties" in schema:
            return self.table(schema, names, depth)
        return self.junk() if depth > 3 else self.number({}, False)

    def table(self, schema: Schema, names: Names, depth: int = 0) -> dict[str, Any]:
        """What must be there, and some of what may."""
        random, own = self.random, schema.get("properties", {})
        often = random.choice((0.0, 0.1, 0.3, 0.6))
        wanted = [key for key in own if key in schema.get("required", ()) or random.random() < often]
        found = {key: self.value(own[key], key, names, depth + 1) for key in wanted}
        more = schema.get("additionalProperties")
        if isinstance(more, dict) and depth < 6:
            for _ in range(random.choice((0, 1, 1, 2))):
                key = self.path(names)
                found[key] = self.value(more, key, names, depth + 1)
        return found

    def number(self, schema: Schema, whole: bool) -> Any:
        random = self.random
        low, high = schema.get("minimum", schema.get("exclusiveMinimum")), schema.get("maximum")
        if whole:
            return random.choice((low or 0, (low or 0) + 1, random.randint(low or 0, min(high or 9, (low or 0) + 9))))
        x = random.choice((0.0, 1.0, -1.0, 0.5, 0.1, random.gauss(0, 1), 10 ** random.uniform(-3, 3), random.random()))
        return abs(x) or 0.1 if low is not None else x

    def formula(self, names: Names) -> Any:
        random = self.random
        if random.random() < 0.1 + 3 * self.hostile:
            return random.choice(HOSTILE_FORMULAS)
        known = [*names.get("numbers", []), "t", "0.5", "2"]
        known += [f"{name}{end}" for name in names.get("quantities", []) for end in ("", ".x", ".angle", ".value")]
        x, y = random.choice(known), random.choice(known)
        return random.choice(
            ("{}*{}", "{} + {}", "sin({}) * {}", "{} - {}", "{}/{}", "{} > {}", "where({} < 1, {}, 1)")
        ).format(x, y)

    def text(self, key: str, names: Names) -> str:
        random = self.random
        if key == "name":
            return random.choice([*every(names), "a", "b", "c", "d1", "e_2", f"n{random.randint(0, 99)}"])
        if key == "when" and random.random() < 0.9:
            return f"{self.formula(names)} {random.choice('<>')} {random.choice(('t', '0.5', 't/2', '1e-3'))}"
        if key in ("value", "expression") and random.random() < 0.8:
            return str(self.formula(names))
        pool = names.get(LISTED.get(key, ""), [])
        if pool and random.random() < 0.9:
            return random.choice([*pool, "ground"] if LISTED[key] == "bodies" else pool)
        return random.choice([*every(names), "global", "ground", "body", *HOSTILE_TEXTS])

    def path(self, names: Names) -> str:
        """A name, or a path of a number."""
        random = self.random
        kind = random.choice(
            ["bodies", "joints", "forces", "drivers", "inputs", "parameters", "tables", "start.q", "gravity"]
        )
        known = names.get(kind, [])
        name = random.choice(known) if known else "a"
        keys = [
            "mass",
            "inertia",
            "inertia[0]",
            "position[1]",
            "rotation",
            "length",
            "value",
            "stiffness",
            "points[0][1]",
            "axis",
        ]
        return random.choice(
            (name, f"{kind}.{name}.{random.choice(keys)}", f"{kind}.{name}", f"{kind}[{random.randint(0, 2)}]", kind)
        )

    def junk(self) -> Any:
        """Anything that TOML or Python can hand over."""
        random = self.random
        pick = random.randrange(9)
        if pick < 3:
            return random.choice(HOSTILE_NUMBERS)
        if pick < 5:
            return random.choice(HOSTILE_TEXTS)
        if pick == 5:
            return random.choice(HOSTILE_FORMULAS)
        if pick == 6:
            return [self.junk() for _ in range(random.choice((0, 1, 2, 3, 3, 4, 6)))]
        if pick == 7:
            return {
                random.choice((*HOSTILE_TEXTS, "name", "type", "file", "value")): self.junk()
                for _ in range(random.choice((0, 1, 2)))
            }
        return random.choice(
            (
                nested([], 5),
                nested({}, 5),
                nested([], 300),
                nested({}, 300),
                [[]] * 50,
                [0.0] * 1000,
                [{}],
                [[{}]],
                None,
            )
        )


def every(names: Names) -> list[str]:
    """The names of all kinds."""
    return [name for of_kind in names.values() for name in of_kind]


def nested(kind: Any, depth: int) -> Any:
    """A list in lists, or a table in tables."""
    value: Any = 1
    for _ in range(depth):
        value = [value] if isinstance(kind, list) else {"a": value}
    return value
