"""How often 95 % intervals hold the truth: each of so many trials draws runs whose truth is known in closed form."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
from scipy import special, stats

from document import markdown, renew
from lienumba.analysis.comparison import proportions as paired
from lienumba.analysis.sensitivities.explained import explained
from lienumba.analysis.sensitivities.morris import design_of, effects
from lienumba.analysis.sensitivities.ranks import rank_interval, standard_ranks, tornado
from lienumba.analysis.sensitivities.sobol import Rows, indices
from lienumba.engine.rare.rare import METHODS
from lienumba.sweep import weighted
from lienumba.sweep.confidence import bounds, half_width, proportion, ranks
from lienumba.sweep.samplers.importance import Proposal, proposed
from lienumba.sweep.samplers.morris import MORRIS
from lienumba.sweep.verdicts import Wanted, judge

DOCUMENT = Path(__file__).parents[1] / "docs" / "statistics.md"
TRIALS = 1000
CONFIDENCE = 0.95
TAIL = stats.norm.pdf(stats.norm.ppf(0.9)) / 0.1  # the mean of a standard normal number above its 90 % quantile
RUNS = (100, 200, 1000)

Interval = tuple[float, float]
Trial = Callable[[np.random.Generator, int], tuple[Interval, float]]  # runs drawn: the interval, and what is true


def mean(noise: Callable[[np.random.Generator, int], np.ndarray], truth: float) -> Trial:
    def trial(rng: np.random.Generator, runs: int) -> tuple[Interval, float]:
        y = noise(rng, runs)
        half = half_width(y.std(ddof=1), runs, CONFIDENCE)
        return (y.mean() - half, y.mean() + half), truth

    return trial


def mean_where_narrow(rng: np.random.Generator, runs: int) -> tuple[Interval, float]:
    """Of a sweep of at most so many runs that ends where the interval of its mean is narrow enough, which it is after
    about half of them; one looks ten times."""
    y, width = rng.standard_normal(runs), 2.0 * half_width(1.0, runs // 2, CONFIDENCE)
    for upto in range(runs // 10, runs + 1, runs // 10):
        half = half_width(y[:upto].std(ddof=1), upto, CONFIDENCE)
        if 2.0 * half <= width:
            break
    middle = y[:upto].mean()
    return (middle - half, middle + half), 0.0


def quantile(q: float) -> Trial:
    def trial(rng: np.random.Generator, runs: int) -> tuple[Interval, float]:
        y = np.sort(rng.standard_cauchy(runs))
        low, high = map(int, ranks(runs, q, CONFIDENCE))
        return (y[low] if low >= 0 else -np.inf, y[high] if high < runs else np.inf), stats.cauchy.ppf(q)

    return trial


def part(p: float) -> Trial:
    def trial(rng: np.random.Generator, runs: int) -> tuple[Interval, float]:
        low, high = proportion(int((rng.uniform(size=runs) < p).sum()), runs, CONFIDENCE)
        return (float(low), float(high)), p

    return trial


def verdict(p: float, side: int) -> Trial:
    """One bound of a requirement that a part p of all runs meets: at least (0), at most (1)."""

    def trial(rng: np.random.Generator, runs: int) -> tuple[Interval, float]:
        bound = float(bounds(int((rng.uniform(size=runs) < p).sum()), runs, CONFIDENCE)[side])
        return (bound, 1.0) if side == 0 else (0.0, bound), p

    return trial


def weighed(rng: np.random.Generator, runs: int) -> tuple[Interval, float]:
    """Runs drawn from x^2 instead of x in [0, 1], with the weights that make up for it: what is met below 0.9."""
    x = rng.uniform(size=runs) ** 0.5
    found = judge(Wanted("", 0.9, CONFIDENCE), (x < 0.9).astype(float), 0.9 - x, 1.0 / x)
    return (found.at_least, 1.0), 0.9


def tolerance(part: float) -> Trial:
    """The margin that so large a part of all runs keeps, of values without a mean."""

    def trial(rng: np.random.Generator, runs: int) -> tuple[Interval, float]:
        y = rng.standard_cauchy(runs)
        margin = judge(Wanted("", part, CONFIDENCE), (y > 0.0).astype(float), y).margin
        return (-np.inf if margin is None else margin, np.inf), stats.cauchy.ppf(1.0 - part)

    return trial


def pairs(less: float, more: float) -> Trial:
    """The difference of two designs, of which so large parts of the pairs pass in the first alone, and in the
    second."""

    def trial(rng: np.random.Generator, runs: int) -> tuple[Interval, float]:
        u = rng.uniform(size=runs)
        return paired(int((u < less).sum()), int((u > 1.0 - more).sum()), runs), more - less

    return trial


def rank(slope: float) -> Trial:
    def trial(rng: np.random.Generator, runs: int) -> tuple[Interval, float]:
        x, other = rng.standard_normal((2, runs))
        y = slope * x + other
        pearson = slope / (slope * slope + 1.0) ** 0.5
        r = float(standard_ranks(x) @ standard_ranks(y))
        return rank_interval(r, runs), 6.0 / np.pi * np.arcsin(pearson / 2.0)

    return trial


def change(noise: float) -> Trial:
    def trial(rng: np.random.Generator, runs: int) -> tuple[Interval, float]:
        x, other = rng.standard_normal((2, runs))
        found = tornado(x, x + noise * other)
        return (found["change_low"], found["change_high"]), 2.0 * TAIL

    return trial


def ishigami(x: np.ndarray) -> np.ndarray:
    """Of angles (..., 3)."""
    return np.sin(x[..., 0]) * (1.0 + 0.1 * x[..., 2] ** 4) + 7.0 * np.sin(x[..., 1]) ** 2


VARIANCE = 49 / 8 + np.pi**4 / 50 + np.pi**8 / 1800 + 0.5
FIRST = np.array([0.5 * (1 + np.pi**4 / 50) ** 2, 49 / 8, 0.0]) / VARIANCE
TOTAL = FIRST + np.array([1.0, 0.0, 1.0]) * np.pi**8 * (1 / 18 - 1 / 50) / 100 / VARIANCE


def of_data(which: int) -> Trial:
    def trial(rng: np.random.Generator, runs: int) -> tuple[Interval, float]:
        x = rng.uniform(-np.pi, np.pi, (runs, 3))
        found = explained(x[:, which], ishigami(x))
        return (found["first_order_low"], found["first_order_high"]), FIRST[which]

    return trial


def of_product(rng: np.random.Generator, runs: int) -> tuple[Interval, float]:
    x = rng.standard_normal((runs, 2))
    found = explained(x[:, 0], x[:, 0] * x[:, 1])
    return (found["first_order_low"], found["first_order_high"]), 0.0


def of_square(rng: np.random.Generator, runs: int) -> tuple[Interval, float]:
    x = rng.standard_normal((runs, 2))
    found = explained(x[:, 0], x[:, 0] ** 2 + x[:, 1])
    return (found["first_order_low"], found["first_order_high"]), 2 / 3


def of_failures(rng: np.random.Generator, runs: int) -> tuple[Interval, float]:
    x = rng.standard_normal((runs, 2))
    found = explained(x[:, 0], (x.sum(axis=1) > 1.0).astype(float))
    z, weight = special.roots_hermitenorm(200)
    given, p = stats.norm.cdf(z - 1.0), stats.norm.sf(1.0 / 2**0.5)
    truth = (weight @ (given - p) ** 2) / weight.sum() / (p * (1 - p))
    return (found["first_order_low"], found["first_order_high"]), truth


def of_rows(which: int, total: bool) -> Trial:
    """Of a saltelli sweep with so many rows."""

    def trial(rng: np.random.Generator, runs: int) -> tuple[Interval, float]:
        a, b = rng.uniform(-np.pi, np.pi, (2, runs, 3))
        mixed = [np.where(np.arange(3) == k, b, a) for k in range(3)]
        values = ishigami(np.stack([a, b, *mixed], axis=1)).ravel()
        found = indices(values, Rows(["a", "b", "c"], np.arange(5 * runs).reshape(runs, 5)))
        of = found.total if total else found.first
        return (of[1, which], of[2, which]), (TOTAL if total else FIRST)[which]

    return trial


def elementary(name: str, which: str, truth: float) -> Trial:
    """Of a morris sweep with so many rows, of a b + a and of c alone, inputs uniform in 0 to 1."""
    streams = {x: [x] for x in "abc"}
    sweep = {"vary": {x: {"distribution": "uniform", "low": 0, "high": 1} for x in streams}}

    def trial(rng: np.random.Generator, runs: int) -> tuple[Interval, float]:
        seed, labels = int(rng.integers(2**31)), np.arange(4 * runs)
        x = MORRIS.draw(streams, labels, seed, 0)
        design = design_of(labels, sweep | {"seed": seed}, x)
        found = effects(x["a"] * x["b"] + x["a"] + x["c"] ** 2, design)[name]
        return (found[f"{which}_low"], found[f"{which}_high"]), truth

    return trial


def shifted(what: str) -> Trial:
    """Runs with a standard normal input that is drawn about 2, a tenth of them about 0."""

    def trial(rng: np.random.Generator, runs: int) -> tuple[Interval, float]:
        u = rng.uniform(size=runs)
        found, w = proposed({"x": u}, {"x": Proposal(shift=2.0)}, np.arange(runs), int(rng.integers(2**31)))
        x = stats.norm.ppf(found["x"])
        if what == "mean":
            one, truth = weighted.mean(x, w, CONFIDENCE), 0.0
        elif what == "quantile":
            one, truth = weighted.quantile(x, w, 0.99, CONFIDENCE), stats.norm.ppf(0.99)
        else:
            one, truth = weighted.proportion((x > 3.0).astype(float), w, CONFIDENCE), stats.norm.sf(3.0)
        return (one.low, one.high), truth

    return trial


def rare(method: str) -> Trial:
    """A plane at 1e-4 of three standard normal numbers; runs: of each level, or about the design points."""

    def trial(rng: np.random.Generator, runs: int) -> tuple[Interval, float]:
        beta = stats.norm.isf(1e-4)
        found = METHODS[method](lambda z: beta - z.sum(axis=1) / 3**0.5, 3, runs, int(rng.integers(2**31)), CONFIDENCE)
        return (found.low, found.high), 1e-4

    return trial


CASES: dict[str, Trial] = {
    "mean, normal": mean(lambda rng, n: rng.standard_normal(n), 0.0),
    "mean, exponential": mean(lambda rng, n: rng.exponential(size=n), 1.0),
    "mean, normal, where narrow enough": mean_where_narrow,
    "median, Cauchy": quantile(0.5),
    "95 % quantile, Cauchy": quantile(0.95),
    "proportion 0.5": part(0.5),
    "proportion 0.01": part(0.01),
    "requirement met by 0.99, at least": verdict(0.99, 0),
    "requirement met by 0.9, at most": verdict(0.9, 1),
    "requirement met by 0.9, weights": weighed,
    "tolerance bound, 0.9": tolerance(0.9),
    "tolerance bound, 0.95": tolerance(0.95),
    "two designs, 10 and 5 % of pairs": pairs(0.1, 0.05),
    "two designs, 2 % of pairs each": pairs(0.02, 0.02),
    "rank correlation, y = x + noise": rank(1.0),
    "rank correlation, no effect": rank(0.0),
    "tornado, y = x": change(0.0),
    "tornado, y = x + noise": change(1.0),
    "first index of runs, Ishigami a": of_data(0),
    "first index of runs, Ishigami b": of_data(1),
    "first index of runs, Ishigami c (0)": of_data(2),
    "first index of runs, product (0)": of_product,
    "first index of runs, square": of_square,
    "first index of runs, failures": of_failures,
    "first index of rows, Ishigami a": of_rows(0, False),
    "total index of rows, Ishigami a": of_rows(0, True),
    "total index of rows, Ishigami c": of_rows(2, True),
    "elementary effects of rows, mu, a b + a": elementary("a", "mu", 1.5),
    "elementary effects of rows, mu*, a b + a": elementary("a", "mu_star", 1.5),
    "elementary effects of rows, sigma, a b + a": elementary("a", "sigma", (1 / 12) ** 0.5),
    "weighted mean, shift 2": shifted("mean"),
    "weighted 99 % quantile, shift 2": shifted("quantile"),
    "weighted proportion 0.00135, shift 2": shifted("proportion"),
    "rare, importance, 1e-4": rare("importance"),
    "rare, subset, 1e-4": rare("subset"),
}


def held(trial: Trial, runs: int, trials: int) -> float:
    """The part of the trials whose interval holds the truth."""
    found = [trial(np.random.default_rng([seed, runs]), runs) for seed in range(trials)]
    return float(np.mean([low <= truth <= high for (low, high), truth in found]))


def lines() -> Iterator[list[str]]:
    for name, trial in CASES.items():
        yield [name, *(f"{100 * held(trial, runs, TRIALS):.1f} %" for runs in RUNS)]


if __name__ == "__main__":
    head = ["95 % interval of", *(f"{runs:,} runs" for runs in RUNS)]
    renew(DOCUMENT, {"coverage": lambda: markdown(head, list(lines()))})
