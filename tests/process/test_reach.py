"""What heyoka gets are the equations of the same mechanisms, whether it is installed or not. Nothing is timed."""

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from tests.rigs.places import scripts_on_path

RUNS, CLOSE = 8, 1e-10
ENDS = {"top": 0.1, "chain": 0.2, "satellite": 2.0}  # s
FORMS = [("top", "rows"), ("top", "quaternion"), ("top", "maximal"), ("chain", "minimal"), ("satellite", "minimal")]


@cache
def bench() -> Any:
    with scripts_on_path():
        from bench.reach import contestants, study, table
    return contestants, study, table


@cache
def problem(name: str) -> Any:
    """A short one."""
    made, end = bench()[1].PROBLEMS[name][0](RUNS), ENDS[name]
    integrator = made.data["integrator"] | {"end_time": end}
    data = {**made.data, "integrator": integrator, "output": {"variables": [], "every": end}}
    return replace(made, end=end, data=data)


@cache
def ours(name: str) -> np.ndarray:
    return bench()[0].Engine(problem(name), "dop853", "joint", True).run(1e-12)[0]


class Numbers:
    """Stands in for heyoka: its variables are numbers."""

    sin, cos = np.sin, np.cos

    def __init__(self, values: np.ndarray, par: np.ndarray) -> None:
        self.values, self.par = iter(values), par

    def make_vars(self, *names: str) -> list[np.ndarray]:
        return [next(self.values) for _ in names]


@pytest.mark.parametrize(("name", "key"), FORMS)
@pytest.mark.filterwarnings("ignore:.*no rigid body")
def test_the_equations_are_of_the_same_mechanism(name: str, key: str) -> None:
    """By SciPy, in numbers. Variables come as they are made, states as the equations list them."""
    form = next(form for form in problem(name).forms if form.key == key)
    start, par = np.asarray(form.states, float), np.asarray(form.parameters, float)
    order = np.argsort([int(x) for x, _ in form.equations(Numbers(np.arange(len(start)), np.ones(len(par))))])

    def rates(_: float, x: np.ndarray) -> np.ndarray:
        made = form.equations(Numbers(x.reshape(start.shape)[order], par))
        return np.concatenate([np.broadcast_to(rate, (RUNS,)) for _, rate in made])

    found = solve_ivp(rates, (0.0, problem(name).end), start.ravel(), method="DOP853", rtol=1e-12, atol=1e-13)
    ends = form.centres(found.y[:, -1].reshape(start.shape), par, problem(name).end)
    assert np.abs(ends - ours(name)[-len(ends) :]).max() < CLOSE
    assert np.ptp(ends, axis=2).max() > 1e-4  # the runs differ


@pytest.mark.parametrize(("name", "key"), FORMS)
@pytest.mark.filterwarnings("ignore:.*no rigid body")
def test_heyoka_goes_the_same_way(name: str, key: str) -> None:
    pytest.importorskip("heyoka", reason="heyoka is not installed (extra bench)")
    form = next(form for form in problem(name).forms if form.key == key)
    rival = bench()[0].Heyoka(problem(name), form, compact=True)
    ends, seconds = rival.run(1e-13)
    assert np.abs(ends - ours(name)[-len(ends) :]).max() < CLOSE
    assert seconds > 0


def test_the_coarsest_setting_that_reaches_an_error() -> None:
    _, study, _ = bench()

    class Halving:
        """Each setting has half the error of the one before; the first two fail."""

        ladder = tuple(range(20))

        def searched(self) -> "Halving":
            return self

        def run(self, setting: float) -> tuple[np.ndarray, float]:
            if setting < 2:
                raise bench()[0].FailedError("Halving", setting, np.array([3]))
            return np.full((1, 3, 2), 0.5**setting / np.sqrt(3.0)), 1.0

    search = study.Search(Halving(), np.zeros((1, 3, 2)))
    assert search.reaches(1e-2) == 7
    assert search.reaches(0.5**12) == 12
    assert search.reaches(1e-9) is None
