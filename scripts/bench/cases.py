"""What is timed against each other: each case does a fixed amount of work and says what time it took."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from bench import engine, naive_numba, naive_numpy, peak, rivals, tuned_numba
from bench.chains import Chain
from bench.clock import Spent, Stopwatch

EVERY = 100  # steps between two outputs: 200 outputs in 2 s
RUNS = 1024
INERTIA, GRAVITY, PIVOT = np.diag(engine.INERTIA), np.array(engine.GRAVITY), np.array(engine.PIVOT)


@dataclass(frozen=True)
class Case:
    """`work`: steps times runs (or other units) in one call of `spend`; per unit, 0 where not known: `flops`, and
    `parts`, stages times bodies; `beside`: what a run costs beside its steps (s)."""

    key: str
    label: str
    threads: int
    work: float
    spend: Callable[[], Spent]
    flops: float = 0.0
    parts: int = 0
    beside: Callable[[], float] = float


def timed(function: Callable[..., Any], *arguments: Any) -> Callable[[], Spent]:
    """What function(*arguments) spends."""

    def spend() -> Spent:
        watch = Stopwatch()
        function(*arguments)
        return watch.spent()

    return spend


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
        program = engine.build(sample.model, engine.METHODS[projection])
        for threads in (1, 2):
            flops = engine.step_flops(program) if projection == "none" else 0.0
            run = partial(engine.spend, batch, threads)
            cases.append(Case(f"engine_{projection}_{threads}", f"engine, {words}", threads, RUNS * steps, run, flops))
    return cases


def map_case(sample: engine.Tops, rounds: int) -> Case:
    m = engine.AccelerationMap(sample.model, sample.states)
    run = partial(m.spend, rounds)
    return Case("map", "engine, one acceleration map alone", 1, rounds * m.runs, run, m.counts["flops"])


def peak_case(turns: int) -> Case:
    """A flop is its unit of work."""
    return Case("peak", "multiply-add peak of a core", 1, 1.0, lambda: peak.of_a_flop(turns), 1.0)


def naive_cases(sample: engine.Tops, steps: int) -> list[Case]:
    cases = []
    for key, module, words in (("naive", naive_numba, "naive Numba loop"), ("tuned", tuned_numba, "tuned Numba loop")):
        for project, more in ((False, "no projection"), (True, "both projections")):
            run = timed(scalar, module, sample, 8, steps, project)
            cases.append(Case(f"{key}_{'both' if project else 'none'}", f"{words}, {more}", 1, 8 * steps, run))
    for key, label, runs, few in (
        ("numpy_one", "NumPy, one run at a time", 1, 100),
        ("numpy_all", f"NumPy, {RUNS} runs at once", RUNS, 10),
    ):
        run = timed(numpy_top(sample, runs).integrate, sample.states[:runs], engine.STEP, few, few)
        cases.append(Case(key, label, 1, few * runs, run))
    return cases


def chain_cases(chains: list[Chain]) -> list[Case]:
    """Their unit of work is a stage of one body."""
    cases = []
    for c in chains:
        flops = c.flops * c.run_steps / c.evaluations
        cases.append(Case(f"chain_{c.k}", f"chain of {c.k}", 1, c.evaluations, c.spend, flops))
    return cases


def rival_cases(found: list[rivals.Rival]) -> list[Case]:
    cases = []
    for r in found:
        key, label = f"rival_{r.name.split()[0].lower()}", f"{r.name}, {r.version}"
        cases.append(Case(key, label, r.threads, r.runs * r.steps, partial(r.spend, r.runs, r.steps)))
    return cases


def interleave(cases: list[Case], repeats: int, tick: Callable[[], None]) -> dict[str, np.ndarray]:
    """Seconds per unit of each case (rounds, 2), wall and core; every round runs every case once, after a warm-up."""
    samples: dict[str, list[Spent]] = {case.key: [] for case in cases}
    for number in range(repeats + 1):
        for case in cases:
            spent = case.spend()
            if number:
                samples[case.key].append(spent)
            tick()
    return {case.key: np.array(samples[case.key]) / case.work for case in cases}
