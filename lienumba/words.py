"""Words of messages: the nearest known name, values as TOML writes them."""

from collections.abc import Collection, Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

# What other programs call the same thing; of several, the first that is known where the word stands.
ALIASES = {
    "omega": "angular_velocity rate", "w": "angular_velocity", "spin": "angular_velocity", "quaternion": "rotation",
    "orientation": "rotation", "attitude": "rotation", "R": "rotation", "J": "inertia", "I": "inertia", "m": "mass",
    "r": "position", "x": "position", "location": "position", "v": "velocity speed", "parent": "relative_to",
    "g": "gravity", "dt": "step", "h": "step", "time_step": "step", "timestep": "step", "duration": "end_time",
    "t_end": "end_time", "tend": "end_time", "tf": "end_time", "solver": "method", "scheme": "method",
    "n": "runs", "count": "runs", "samples": "runs", "interval": "every", "parameters": "vary",
    "std_dev": "std", "sigma": "std", "stddev": "std", "loc": "mean", "mu": "mean friction", "scale": "std",
    "min": "low lower", "max": "high upper", "gaussian": "normal", "gauss": "normal", "norm": "normal",
    "ball": "spherical", "rod": "distance", "hinge": "revolute", "pin": "revolute", "slider": "prismatic",
    "translational": "prismatic", "weld": "fixed", "rigid": "fixed", "cardan": "universal", "hooke": "universal",
    "helical": "screw", "lead": "pitch", "transmission": "gear", "belt": "gear", "anchor": "points",
    "body": "bodies", "bodies": "body", "point": "points", "points": "point", "joint": "joints", "joints": "joint",
    "coordinate": "coordinates", "coordinates": "coordinate",
    "spring": "spring_damper", "damper": "spring_damper", "motor": "actuator value", "servo": "actuator",
    "controller": "actuator", "stop": "end_stop", "bumper": "end_stop", "k": "stiffness", "d": "damping",
    "c": "damping", "length": "free_length", "length0": "free_length", "rest_length": "free_length",
    "function": "value", "formula": "value", "expression": "value", "torque": "value", "force": "value",
    "rotation": "angle orientation value", "angle": "value", "translation": "displacement",
    "position": "displacement point value", "displacement": "value", "velocity": "rate angular_velocity",
    "speed": "rate", "sequence": "euler", "order": "euler",
    "world": "ground global", "earth": "ground global", "inertial": "global", "local": "body",
    "rk2": "midpoint", "rk3": "kutta3", "rungekutta4": "rk4", "rk44": "rk4", "forward_euler": "euler",
    "explicit_euler": "euler", "ode23": "bs32", "rk23": "bs32", "dopri5": "dp54", "dopri": "dp54", "rk45": "dp54",
    "rkdp": "dp54", "ode45": "dp54", "rkf45": "dp54", "dormand_prince": "dp54", "tsit5": "tsit54", "dop": "dop853",
    "dopri8": "dop853", "rk78": "dop853", "ode78": "dop853", "ode89": "dop853", "vern9": "dop853",
    "radau": "radau5", "implicit": "radau5", "stiff": "radau5", "bdf": "radau5", "lsoda": "radau5",
    "ode15s": "radau5", "ode23s": "radau5", "ode23t": "radau5", "ida": "radau5", "dassl": "radau5", "cvode": "radau5",
    "rodas": "radau5", "backward_euler": "radau3", "implicit_euler": "radau3", "newmark": "generalized_alpha",
    "hht": "generalized_alpha", "gen_alpha": "generalized_alpha", "trapezoidal": "generalized_alpha",
    "dynamic": "kinetic coulomb", "sliding": "kinetic coulomb", "mu_k": "kinetic", "mu_d": "kinetic",
    "stiction": "static", "mu_s": "static", "coefficient_of_friction": "friction", "damping": "dissipation",
    "coefficient_of_restitution": "restitution", "cor": "restitution", "elasticity": "restitution",
    "latch": "lock", "hold": "lock", "brake": "lock", "detach": "release", "separate": "release", "attach": "engage",
    "dock": "engage", "capture": "engage", "end": "stop", "terminate": "stop", "log": "record",
    "verlet": "rk4", "leapfrog": "rk4", "semi_implicit_euler": "rk4", "symplectic_euler": "rk4",
}  # fmt: skip
SIMILAR, ALIKE, VERY_SIMILAR = 0.5, 0.6, 0.8  # of two words, as difflib measures
MOST_NEAR, AS_LIKE = 3, 0.1  # names that are like a word, and how much less like it they are than the first
MOST_KNOWN = 30  # names of a list
LINE = 80  # characters of a value in a message
_terminal = False  # whether options of messages are those of the command line


def alias(word: str, known: Iterable[str]) -> str | None:
    """The known name for which other programs have this word."""
    names = list(known)
    return next((name for name in ALIASES.get(word, "").split() if name in names), None)


def nearest(word: str, known: Iterable[str], cutoff: float = SIMILAR) -> str | None:
    """The known name most like a word, or None if none is like it."""
    return next(iter(_like(word, known, cutoff)), None)


def near(word: str, known: Iterable[str], cutoff: float = SIMILAR) -> list[str]:
    """The few known names most like a word, the nearest first, else as they are known; none if none is like it."""
    names = list(known)
    like = _like(word, names, cutoff)
    least = max(like.values(), default=0.0) - AS_LIKE
    return sorted((name for name, x in like.items() if x > least), key=lambda name: (-like[name], names.index(name)))


def _like(word: str, known: Iterable[str], cutoff: float) -> dict[str, float]:
    """A few names that are like a word, the nearest first, and how much they are."""
    import difflib

    names = list(known)
    same = alias(word, names) or alias(word.lower(), names)
    if same is not None:
        return {same: 1.0}
    folded = {name.lower(): name for name in names}
    close = difflib.get_close_matches(word.lower(), list(folded), n=MOST_NEAR, cutoff=cutoff)
    return {folded[name]: difflib.SequenceMatcher(None, name, word.lower()).ratio() for name in close}


def suggestion(word: str, known: Iterable[str], cutoff: float = SIMILAR) -> str:
    """The remedy for an unknown name: the nearest known one, or the list of them."""
    names = list(known)
    close = nearest(word, names, cutoff)
    if close is not None:
        return f'the nearest known name is "{close}"'
    if not names:
        return "none is known here"
    more = f" and {len(names) - MOST_KNOWN} more" if len(names) > MOST_KNOWN else ""
    return "known here are " + ", ".join(f'"{name}"' for name in names[:MOST_KNOWN]) + more


def absence(path: Path, endings: Collection[str], missing: str = "does not exist") -> tuple[str, str]:
    """What is wrong where there is no file, and the remedy: of those there with such an ending the nearest name."""
    folder = path.parent
    try:
        if path.exists():
            return "is a pipe, a socket or a device", "give a file"
        if path.is_symlink():
            return "is a link that leads nowhere", "give the file that it should lead to"
        if not folder.is_dir():
            return missing, f"nor does the folder {printable(str(folder))}; check the path"
        close = nearest(path.name, [item.name for item in folder.iterdir() if item.suffix in endings], ALIKE)
    except (OSError, ValueError):
        return missing, "check the path"
    return missing, f"the nearest file there is {printable(str(folder / close))}" if close else "check the path"


def printable(text: str) -> str:
    """A text in one line."""
    return "".join(c if c.isprintable() else repr(c)[1:-1] for c in text)


def readable(text: str) -> str:
    """A text of several lines, without what a terminal would obey."""
    return "".join(c if c in "\n\t" else printable(c) for c in text) if not _is_plain(text) else text


def _is_plain(text: str) -> bool:
    return text.replace("\n", "").replace("\t", "").isprintable()


class Written(str):
    """A value that is written already."""


def show(value: Any) -> str:
    """A value as TOML writes it, cut to one line of reading."""
    text = _written(value, 0)
    return text if len(text) <= LINE else text[: LINE - 4] + " ..."


def _written(value: Any, depth: int) -> str:
    """Of what would not be read, no more than tells that there is more."""
    if isinstance(value, Written):
        return str(value)
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return f'"{printable(value[: 2 * LINE])}"'
    if isinstance(value, dict):
        items = (f"{printable(str(key))} = {_written(item, depth + 1)}" for key, item in value.items())
        return "{" + _joined(items, depth) + "}"
    if isinstance(value, list | tuple):
        return "[" + _joined((_written(item, depth + 1) for item in value), depth) + "]"
    try:
        return printable(repr(value))
    except ValueError:
        return "a number of thousands of digits"


def _joined(items: Iterable[str], depth: int) -> str:
    """Separated by commas, as far as a line goes."""
    if depth > LINE:
        return "..."
    found, length = [], 0
    for item in items:
        found.append(item)
        length += len(item) + 2
        if length > LINE:
            break
    return ", ".join(found)


@contextmanager
def to_terminal() -> Iterator[None]:
    """While whoever reads messages has given options on the command line."""
    global _terminal
    before, _terminal = _terminal, True
    try:
        yield
    finally:
        _terminal = before


def option(name: str, value: object = None) -> str:
    """An option as whoever reads a message gives it: on the command line, or as an argument in Python.

    value: of one that is no switch; a word that stands for it is `Written`.
    """
    if _terminal:
        return f"--{name.replace('_', '-')}" + ("" if value is None else f" {printable(str(value))}")
    return f"{name}={'True' if value is None else show(value)}"


def settings(path: str = "", value: str = "") -> str:
    """A new value of a scenario as whoever reads a message gives it; without a path: how new values are given."""
    if not path:
        return "--set" if _terminal else "overrides"
    return f"--set {path}={value}" if _terminal else f'{{"{path}": {value}}}'


def plural(number: int, one: str, many: str) -> str:
    return f"{number:,} {one if number == 1 else many}"


def listed(words: Iterable[str], joining: str = "and") -> str:
    """a, b and c."""
    *most, last = words
    return f"{', '.join(most)} {joining} {last}" if most else last


def is_number(text: str) -> bool:
    """Whether a text is a number without its quotes."""
    try:
        float(text)
    except ValueError:
        return False
    return True
