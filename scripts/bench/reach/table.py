"""What the timed cases say: milliseconds for a run to reach an error, and how many times heyoka's that is."""

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rich.console import Console


def _parts(key: str) -> tuple[str, str, str]:
    """Problem, error, contestant of a case's key."""
    _, problem, error, contestant = key.split("_", 3)
    return problem, error, contestant


def ratios(keys: Sequence[str], ratio: Callable[[str, str], float]) -> dict[str, float]:
    """Of every method to every form of heyoka at the same error; ratio(slow, fast): within rounds."""
    every = [key for key in keys if key.startswith("reach_")]
    rivals = [key for key in every if _parts(key)[2].startswith("heyoka")]
    return {
        f"{key}/{rival}": ratio(key, rival) for key in every for rival in rivals if _parts(key)[:2] == _parts(rival)[:2]
    }


def show(found: dict[str, Any], console: "Console") -> None:
    from rich.table import Table

    rows = {key: row for key, row in found["rows"].items() if key.startswith("reach_")}
    for problem in dict.fromkeys(_parts(key)[0] for key in rows):
        own = {key: row for key, row in rows.items() if _parts(key)[0] == problem}
        errors = list(dict.fromkeys(_parts(key)[1] for key in own))
        title = found["reach"][next(iter(own))]["problem"]
        table = Table(title=f"{title}: ms of core time per run to an error, and times the cheapest of heyoka")
        table.add_column("", no_wrap=True)
        for error in errors:
            table.add_column(f"{error} m", justify="right", no_wrap=True)
        table.add_column("compiled, s", justify="right", no_wrap=True)
        cheapest = {error: _cheapest(own, f"reach_{problem}_{error}_heyoka") for error in errors}
        for contestant in dict.fromkeys(_parts(key)[2] for key in own):
            keys = {error: f"reach_{problem}_{error}_{contestant}" for error in errors}
            label = next(own[key]["label"] for key in keys.values() if key in own)
            compiled = max(found["reach"][key]["compile_s"] for key in keys.values() if key in own)
            cells = [_cell(found, keys[error], cheapest[error]) for error in errors]
            table.add_row(label, *cells, f"{compiled:.1f}")
        console.print(table)


def _cheapest(rows: dict[str, Any], begin: str) -> str | None:
    rivals = [key for key in rows if key.startswith(begin)]
    return min(rivals, key=lambda key: rows[key]["ns"], default=None)


def _cell(found: dict[str, Any], key: str, rival: str | None) -> str:
    if key not in found["rows"]:
        return ""
    times = found["ratios"].get(f"{key}/{rival}", float("nan"))
    return f"{found['rows'][key]['ns'] * 1e-6:.4f}  {times:5.2f}"
