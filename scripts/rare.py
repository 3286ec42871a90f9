"""How often intervals of a probability of 1e-6 hold it: renews the table of docs/rare.md, in 15 minutes.

Usage: PYTHONPATH=.:scripts .venv/bin/python scripts/rare.py [REPEATS]
"""

import sys
from pathlib import Path

import numpy as np

from document import markdown, renew
from lienumba.engine.rare.rare import METHODS
from lienumba.errors import ScenarioError
from tests.engine.rare.test_methods import CASES

DOCUMENT = Path("docs/rare.md")
RUNS = {"subset": 2400, "importance": 6000}  # what `lienumba rare` takes where nothing is said
LIMITS = {
    "a plane, 5 inputs": "plane",
    "a plane, 40 inputs": "many inputs",
    "curved, 2 inputs": "curved",
    "on both sides, 4 inputs": "two sides",
    "four planes, 3 inputs": "four planes",
    "two exponential inputs": "exponentials",
    "three exponential inputs": "three exponentials",
    "a jump, 2 inputs": "jump",
    "flat where it begins, 2 inputs": "flat at first",
    "two ways, one behind the other": "behind another",
    "a region of runs that fail, 20 inputs": "hidden among many",
    "a region behind a jump, 50 inputs": "hidden askew",
    "all round, 3 inputs": "all round",
}


def held(method: str, case: str, repeats: int) -> str:
    """In which part of the repeats the interval holds the truth, and the most runs that one took."""
    margins, d, truth = CASES[case]
    try:
        found = [METHODS[method](margins, d, RUNS[method], seed, 0.95) for seed in range(repeats)]
    except ScenarioError:
        return "refuses, and says so"
    part = np.mean([x.low <= truth <= x.high for x in found])
    return f"{100 * part:.1f} %, {max(x.runs for x in found):,} runs"


def table(repeats: int) -> str:
    lines = [[name, *(held(method, case, repeats) for method in RUNS)] for name, case in LIMITS.items()]
    return markdown(["limit", *(f"`{method}`" for method in RUNS)], lines)


if __name__ == "__main__":
    renew(DOCUMENT, {"rare": lambda: table(int(sys.argv[1]) if len(sys.argv) > 1 else 1000)})
