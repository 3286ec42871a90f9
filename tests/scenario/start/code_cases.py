"""Laws of the user's own that do not work, by what is wrong: their file, their arguments, or what they do when called.

Each case: the text of the scenario and that of the file `law.py`, and how the message begins.
"""

from tests.scenario.checks.refusal import force, joint, rig

HEAD = "import math\nimport numpy as np\nfrom lienumba.laws import *\n"
AT, RULES = 'model.forces.push.function = "law.py:f": ', "model.forces.push: "
IN = "model.forces.push: f in law.py, line "


def law(text: str, *lines: str, sees: str = 'joints = ["pivot"]', head: str = HEAD, more: str = "") -> tuple[str, str]:
    """A scenario with a force, and the text of its file."""
    return rig(force('type = "python"', 'function = "law.py:f"', sees, *lines), more), head + text


def own_joint(text: str, *lines: str, ends: str = 'bodies = ["arm"]', more: str = "") -> tuple[str, str]:
    """A scenario with a joint, and the text of its file."""
    return rig(joint('type = "python"', 'function = "law.py:f"', *lines, ends=ends), more), HEAD + text


def body(text: str, *lines: str) -> tuple[str, str]:
    return law(text, *lines, sees='bodies = ["arm"]')


STATES = "states = { x = 0 }"
QUANTITIES = """
[[quantities]]
name = "load"
type = "reaction"
joint = "pivot"
[[quantities]]
name = "far"
type = "expression"
value = "2*load.force.x"
[[quantities]]
name = "swift"
type = "point"
body = "arm"
derivative = 1
[[quantities]]
name = "pushed"
type = "point"
body = "arm"
derivative = 2
"""
WHERE = "decides on a number of the state, which is known only while it runs; write where(condition, number, other"
NEEDS = "needs an ordinary number, but this one is known only while it runs; use the functions of lienumba.laws"
LOADS = "f: it must return loads, made with body.force(...), body.torque(...) or joint.effort(...): one, several, none"

FILES = {
    "missing file": (
        (rig(force('type = "python"', 'function = "lav.py:f"', 'joints = ["pivot"]')), ""),
        'model.forces.push.function = "lav.py:f": there is no file lav.py; check the path',
    ),
    "missing function": (law("def g(j): pass\n"), f"{AT}law.py has no function f; "),
    "no function": (law("f = 3\n"), f"{AT}law.py has no function f; "),
    "no file named": (
        (rig(force('type = "python"', 'function = "law.py"', 'joints = ["pivot"]')), ""),
        'model.forces.push.function = "law.py": must name a file and a function in it; write "arm.py:pd"',
    ),
    "syntax": (
        law("def f(j):\n    return j.effort(1\n", head=""),
        f"{AT}law.py cannot be run: line 2, `return j.effort(1`: SyntaxError: '(' was never closed",
    ),
    "indentation": (
        law("def f(j):\nreturn j.effort(1)\n", head=""),
        f"{AT}law.py cannot be run: line 2, `return j.effort(1)`: IndentationError: ",
    ),
    "unknown import": (
        law("import nosuch\n\n\ndef f(j): pass\n", head=""),
        f"{AT}law.py cannot be run: line 1, `import nosuch`: ModuleNotFoundError: No module named 'nosuch'; correct it",
    ),
    "import of a name that no file can have": (
        law(f"import {'n' * 300}\n\n\ndef f(j): pass\n", head=""),
        f"{AT}law.py cannot be run: line 1, `import nnn",
    ),
    "raises when it is read": (
        law("def g():\n    return 1 / 0\n\n\nx = g()\n\n\ndef f(j): pass\n", head=""),
        f"{AT}law.py cannot be run: line 2, `return 1 / 0`: ZeroDivisionError: division by zero; correct it",
    ),
    "joint: missing function": (
        own_joint("def g(b): pass\n"),
        'model.joints.extra.function = "law.py:f": law.py has no function f; ',
    ),
}

ARGUMENTS = {
    "too few": (law("def f(): pass\n"), AT),
    "too many": (law("def f(a, b): pass\n"), f"{AT}has the argument b, which is neither t"),
    "missing parameter": (
        law("def f(j, *, kp): pass\n", "parameters = { kd = 1 }"),
        "model.forces.push.parameters.kd: ",
    ),
    "no parameters": (law("def f(j, *, kp): pass\n"), f"{AT}has the argument kp, which is neither t"),
    "unknown parameter": (
        law("def f(j, *, kp): pass\n", "parameters = { kp = 1, kpp = 2 }"),
        'model.forces.push.parameters.kpp: the function has no argument of this name; the nearest known name is "kp"',
    ),
    "states that it has not": (law("def f(j, *, states): pass\n"), f"{AT}has the argument states, which is neither t"),
    "sees nothing": (law("def f(): pass\n", sees=""), f"{RULES}sees nothing; give bodies or joints"),
    "joint: unknown parameter": (
        own_joint("def f(b): pass\n", "parameters = { x = 1 }"),
        "model.joints.extra.parameters.x: the function has no argument of this name; ",
    ),
    "a state is a text": (
        law("def f(j): pass\n", 'states = { x = "a" }'),
        'model.forces.push.states.x = "a": has the unknown name "a"; ',
    ),
}

CALLS = {
    "raises": (
        law("def g(j):\n    return j.angl\n\n\ndef f(j):\n    return g(j)\n"),
        f"{IN}5, `return j.angl`: Attribut",
    ),
    "if": (law("def f(j):\n    if j.angle > 0:\n        return j.effort(1)\n"), f"{IN}5, `if j.angle > 0:` {WHERE}"),
    "while": (law("def f(j):\n    while j.rate > 0:\n        pass\n"), f"{IN}5, `while j.rate > 0:` {WHERE}"),
    "min": (law("def f(j):\n    return min(j.angle, 1)\n"), f"{IN}5, `return min(j.angle, 1)` {WHERE}"),
    "max": (law("def f(j):\n    return max(j.angle, 1)\n"), f"{IN}5, `return max(j.angle, 1)` {WHERE}"),
    "and": (law("def f(j):\n    return 0 < j.angle < 1\n"), f"{IN}5, `return 0 < j.angle < 1` {WHERE}"),
    "if on a state": (
        law("def f(j, *, states):\n    x = 1 if states.x > 0 else 2\n    return None, x\n", STATES),
        f"{IN}5, `x = 1 if states.x > 0 else 2` {WHERE}",
    ),
    "if on a parameter of time": (
        law("def f(j, *, t):\n    return j.effort(1 if t > 1 else 2)\n"),
        f"{IN}5, `return j.effort(1 if t > 1 else 2)` {WHERE}",
    ),
    "math": (law("def f(j):\n    return math.sin(j.angle)\n"), f"{IN}5, `return math.sin(j.angle)` {NEEDS}"),
    "float": (law("def f(j):\n    return float(j.angle)\n"), f"{IN}5, `return float(j.angle)` {NEEDS}"),
    "numpy": (
        law("def f(j):\n    return np.sin(j.angle)\n"),
        f"{IN}5, `return np.sin(j.angle)` calls NumPy on a number of the state; use the functions and Vec",
    ),
    "njit": (
        law("import numba\n\n\n@numba.njit\ndef g(x): return x\n\n\ndef f(j):\n    return j.effort(g(j.angle))\n"),
        f"{IN}12, `return j.effort(g(j.angle))` calls a function of Numba on a number of the state; decorate it",
    ),
    "norm of numpy": (
        body("def f(b):\n    return np.linalg.norm(b.velocity)\n"),
        f"{IN}5, `return np.linalg.norm(b.velo",
    ),
    "a frame that there is not": (
        body("def f(b):\n    return b.torque((1, 2, 3), frame='bdy')\n"),
        f"{IN}5, `return b.torque((1, 2, 3), frame='bdy')`: ValueError: frame = 'bdy': must be \"global\" or \"body\"",
    ),
    "a coordinate that there is not": (
        law("def f(j):\n    return j.effort(1, 'displacement')\n"),
        f"{IN}5, `return j.effo",
    ),
    "a state that there is not": (
        law("def f(j, *, states):\n    return None, states.y\n", STATES),
        f"{IN}5, `return None, states.y`: AttributeError: ",
    ),
    "an endless recursion": (law("def f(j):\n    return f(j)\n"), f"{IN}5, `return f(j)`: RecursionError: "),
}
