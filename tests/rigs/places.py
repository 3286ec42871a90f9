"""Where things lie in the repository."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

ROOT = Path(__file__).parents[2]
SCENARIOS = ROOT / "scenarios"


@contextmanager
def scripts_on_path() -> Iterator[None]:
    """While the modules of the scripts are imported."""
    folder = str(ROOT / "scripts")
    sys.path.insert(0, folder)
    try:
        yield
    finally:
        sys.path.remove(folder)
