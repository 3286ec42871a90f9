"""From samples to numbers, and from numbers to a table."""

import os
import platform
from dataclasses import asdict
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from bench import deployments, robot_cases
from bench.cases import Case
from bench.checks import Check
from bench.reach import table as reach_table

if TYPE_CHECKING:
    from rich.console import Console


BUSY = 0.5  # load of the last minute, before the benchmark itself


def hardware() -> dict[str, Any]:
    """Of the machine and the versions; `load`: of the last minute, so call this first."""
    import llvmlite
    import numba

    from lienumba import __version__
    from lienumba.compiler.native import cpu, register_lanes

    info = Path("/proc/cpuinfo")
    lines = info.read_text().splitlines() if info.exists() else []
    models = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return {
        "cpu": models[0] if models else platform.processor(),
        "target": cpu()[0],
        "vector_doubles": register_lanes(),
        "caches": caches(),
        "cores": os.cpu_count(),
        "load": os.getloadavg()[0] if hasattr(os, "getloadavg") else None,
        "lienumba": __version__,
        "python": platform.python_version(),
        "numba": numba.__version__,
        "llvmlite": llvmlite.__version__,
        "numpy": np.__version__,
        "time": datetime.now(UTC).isoformat(timespec="seconds"),
    }


def caches() -> list[str]:
    """Those of the first core, where Linux tells them: such as "L1d 32K"."""
    found = []
    for place in sorted(Path("/sys/devices/system/cpu/cpu0/cache").glob("index*")):
        level, kind, size = ((place / name).read_text().strip() for name in ("level", "type", "size"))
        found.append(f"L{level}{'' if kind == 'Unified' else kind[0].lower()} {size}")
    return found


def results(
    machine: dict[str, Any],
    cases: list[Case],
    samples: dict[str, np.ndarray],
    cold: dict[int, list[dict[str, float]]],
    checks: list[Check],
) -> dict[str, Any]:
    rows = {
        case.key: {
            "label": case.label,
            "threads": case.threads,
            "ns": _core(samples[case.key]) * 1e9,
            "ns_least": float(np.min(samples[case.key][:, 1])) * 1e9,
            "wall_ns": float(np.median(samples[case.key][:, 0])) * 1e9,
            "gflops": case.flops / _core(samples[case.key]) * 1e-9,
            "flops": case.flops,
            "parts": case.parts,
            "beside_us": case.beside() * 1e6,
            "samples_ns": [float(x) * 1e9 for x in samples[case.key][:, 1]],
        }
        for case in cases
    }
    compile_ = {
        str(k): {part: float(np.median([run[part] for run in runs])) for part in runs[0]} for k, runs in cold.items()
    }
    return {
        "hardware": machine,
        "checks": [asdict(check) | {"good": check.good} for check in checks],
        "rows": rows,
        "ratios": _ratios(cases, samples),
        "cold_compile_s": compile_,
    }


def _core(samples: np.ndarray) -> float:
    return float(np.median(samples[:, 1]))


def _ratios(cases: list[Case], samples: dict[str, np.ndarray]) -> dict[str, float]:
    """Medians of the ratios within a round, of core time, by name; of one thread to two of the time on the clock."""

    def ratio(slow: str, fast: str, which: int = 1) -> float:
        return float(np.median(samples[slow][:, which] / samples[fast][:, which]))

    keys = [case.key for case in cases]
    found = reach_table.ratios(keys, ratio) | deployments.ratios(keys, ratio)
    if "peak" not in samples:  # nothing but those
        return found
    found |= {
        f"{slow}/engine_{projection}": ratio(slow, f"engine_{projection}_1")
        for projection in ("none", "both")
        for slow in ("naive_none", "naive_both", "tuned_none", "tuned_both", "numpy_one", "numpy_all")
    }
    flops = {case.key: case.flops for case in cases}
    found |= {f"peak_fraction_{key}": ratio("peak", key) * n for key, n in flops.items() if n and key != "peak"}
    found |= {f"two_threads_{p}": ratio(f"engine_{p}_1", f"engine_{p}_2", 0) for p in ("none", "both")}
    chains = [case.key for case in cases if case.key.startswith("chain_")]
    if "chain_4" in chains:
        found |= {f"{key}/chain_4": ratio(key, "chain_4") for key in chains}
    found |= robot_cases.ratios(cases, ratio)
    for case in cases:
        if case.key.startswith("rival_"):
            for projection in ("none", "both"):
                found[f"{case.key}/engine_{projection}"] = ratio(case.key, f"engine_{projection}_{case.threads}")
    return found


def show(found: dict[str, Any], console: "Console") -> None:
    h, rows = found["hardware"], found["rows"]
    load = "" if h["load"] is None else f", load before {h['load']:.2f}"
    console.print(
        f"{h['cpu']} ({h['target']}), {h['cores']} cores{load}; lienumba {h['lienumba']}, Python {h['python']}, "
        f"numba {h['numba']}, llvmlite {h['llvmlite']}, numpy {h['numpy']}",
        highlight=False,
    )
    peak = f", peak {rows['peak']['gflops']:.0f} Gflop/s a core" if "peak" in rows else ""
    console.print(
        f"Vectors of {h['vector_doubles']} doubles, caches {', '.join(h['caches']) or 'unknown'}{peak}", highlight=False
    )
    if h["load"] is not None and h["load"] > BUSY:
        console.print("[yellow]The machine is busy: two threads and fractions of the peak come out too low.[/yellow]")
    if "peak" in rows:
        _show_engine(found, console)
    if found["deployments"]:
        deployments.show(found, console)
    reach_table.show(found, console)
    for check in found["checks"]:
        mark = "[green]ok[/green]" if check["good"] else f"[red]WRONG, allowed {check['allowed']:.0e}[/red]"
        console.print(f"{mark} {check['label']}: {check['error']:.1e}", highlight=False)


def _show_engine(found: dict[str, Any], console: "Console") -> None:
    from rich.table import Table

    rows, ratios = found["rows"], found["ratios"]
    table = Table(title="Heavy top, RK4, h = 1e-4, an output every 100 steps: ns of core time per step and run")
    table.add_column("", no_wrap=True)
    for name in ("threads", "ns", "on the clock", "Gflop/s", "of peak", "engine faster by", "projecting engine by"):
        table.add_column(name, justify="right")
    for key, row in rows.items():
        if key.startswith(("chain_", "robot_", "joints_", "reach_", "deploy_")):
            continue
        of_peak = ratios.get(f"peak_fraction_{key}")
        faster = [ratios.get(f"{key}/engine_{projection}") for projection in ("none", "both")]
        table.add_row(
            row["label"],
            str(row["threads"]),
            *("" if key == "peak" else f"{row[time]:,.2f}" for time in ("ns", "wall_ns")),
            f"{row['gflops']:.1f}" if row["gflops"] else "",
            f"{of_peak:.0%}" if of_peak else "",
            *(f"{ratio:,.0f}" if ratio else "" for ratio in faster),
        )
    console.print(table)
    chains = Table(title="Chains of spherical joints, RK4, no projection, one thread; compiled from an empty cache")
    for name in ("bodies", "ns per stage and body", "to chain of 4", "Gflop/s", "trace s", "compile s", "total s"):
        chains.add_column(name, justify="right")
    for k, seconds in found["cold_compile_s"].items():
        row, ratio = rows[f"chain_{k}"], ratios.get(f"chain_{k}/chain_4")
        chains.add_row(
            k, f"{row['ns']:.1f}", f"{ratio:.2f}" if ratio else "", f"{row['gflops']:.1f}",
            *(f"{seconds[part]:.2f}" for part in ("trace", "compile", "total")),
        )  # fmt: skip
    console.print(chains)
    robot_cases.show(found, console)
    driver = max(seconds["driver"] for seconds in found["cold_compile_s"].values())  # the first has compiled it
    console.print(
        f"Two threads: {ratios['two_threads_none']:.2f} times one, with both projections "
        f"{ratios['two_threads_both']:.2f}. The driver, compiled once and for all: {driver:.1f} s.",
        highlight=False,
    )
