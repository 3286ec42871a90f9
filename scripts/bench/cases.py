"""What is timed against each other: each case does a fixed amount of work and returns the seconds it took."""

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from bench import engine, naive_numba, naive_numpy, peak, rivals, tuned_numba
from bench.chains import Chain

EVERY = 100  # steps between two outputs: 200 outputs in 2 s
RUNS = 1024
INERTIA, GRAVITY, PIVOT = np.diag(engine.INERTIA), np.array(engine.GRAVITY), np.array(engine.PIVOT)


@dataclass(frozen=True)
class Case:
    """`work`: units of `unit` in one call of `seconds`; `flops`: per unit, 0 where it is not known."""

    key: str
    label: str
    unit: str
    threads: int
    work: float
    seconds: Callable[[], float]
    flops: float = 0.0


def timed(function: Callable[[], Any]) -> Callable[[], float]:
    def seconds() -> float:
        start = time.perf_counter()
        function()
        return time.perf_counter() - start

    return seconds


def scalar(module: Any, sample: engine.Tops, runs: int, steps: int, project: bool) -> np.ndarray:
    """Records (runs, steps // EVERY, 18) of one of the scalar Numba loops."""
    records = np.empty((runs, steps // EVERY, 18))
    module.integrate(
        sample.states[:runs], sample.masses, INERTIA, GRAVITY, PIVOT, engine.STEP, steps, EVERY, project,
        engine.TOLERANCE, records,
    )  # fmt: skip
    return records


def numpy_top(sample: engine.Tops, runs: int) -> naive_numpy.Top:
    return naive_numpy.Top(sample.masses[:runs], INERTIA, GRAVITY, PIVOT)


def engine_cases(sample: engine.Tops, steps: int) -> list[Case]:
    cases = []
    for projection, words in (("none", "no projection"), ("both", "both projections")):
        batch = engine.top_batch(sample, projection, steps=steps, outputs=steps // EVERY)
        step = engine.build(sample.model, engine.METHODS[projection]).kernels["step"]
        for threads in (1, 2):
            cases.append(
                Case(
                    f"engine_{projection}_{threads}", f"engine, {words}", "run-step", threads, RUNS * steps,
                    lambda batch=batch, threads=threads: engine.seconds(batch, threads),
                    step.counts()["flops"] if projection == "none" else 0.0,
                )  # fmt: skip
            )
    return cases


def map_case(sample: engine.Tops, rounds: int) -> Case:
    m = engine.AccelerationMap(sample.model, sample.states)
    work = rounds * m.runs
    return Case(
        "map", "engine, acceleration map alone", "run-evaluation", 1, work, lambda: m.seconds(rounds), m.counts["flops"]
    )


def peak_case(turns: int) -> Case:
    return Case("peak", "multiply-add peak of a core", "flop", 1, 1.0, lambda: 1e-9 / peak.gflops(turns), 1.0)


def naive_cases(sample: engine.Tops, steps: int) -> list[Case]:
    cases = []
    for key, module, words in (("naive", naive_numba, "naive Numba loop"), ("tuned", tuned_numba, "tuned Numba loop")):
        for project, more in ((False, "no projection"), (True, "both projections")):
            scalar(module, sample, 1, EVERY, project)
            run = timed(lambda module=module, project=project: scalar(module, sample, 8, steps, project))
            cases.append(
                Case(f"{key}_{'both' if project else 'none'}", f"{words}, {more}", "run-step", 1, 8 * steps, run)
            )
    one, all_ = numpy_top(sample, 1), numpy_top(sample, RUNS)
    cases.append(
        Case(
            "numpy_one", "NumPy, one run at a time", "run-step", 1, EVERY,
            timed(lambda: one.integrate(sample.states[:1], engine.STEP, EVERY, EVERY)),
        )  # fmt: skip
    )
    few = 10
    cases.append(
        Case(
            "numpy_all", f"NumPy, {RUNS} runs at once", "run-step", 1, few * RUNS,
            timed(lambda: all_.integrate(sample.states, engine.STEP, few, few)),
        )  # fmt: skip
    )
    return cases


def chain_cases(chains: list[Chain]) -> list[Case]:
    return [
        Case(
            f"chain_{c.k}", f"chain of {c.k}", "stage and body", 1, c.evaluations, c.seconds,
            c.counts["flops"] * c.run_steps / c.evaluations,
        )
        for c in chains
    ]  # fmt: skip


def rival_cases(found: list[rivals.Rival]) -> list[Case]:
    return [
        Case(
            f"rival_{r.name.split()[0].lower()}", f"{r.name} {r.version}", "run-step", r.threads, r.runs * r.steps,
            lambda r=r: r.seconds(r.runs, r.steps),
        )
        for r in found
    ]  # fmt: skip


def interleave(cases: list[Case], repeats: int, tick: Callable[[], None]) -> dict[str, np.ndarray]:
    """Seconds per unit of each case, one sample per round; every round runs every case once, after a warm-up."""
    samples: dict[str, list[float]] = {case.key: [] for case in cases}
    for number in range(repeats + 1):
        for case in cases:
            seconds = case.seconds()
            if number:
                samples[case.key].append(seconds / case.work)
            tick()
    return {key: np.array(values) for key, values in samples.items()}
