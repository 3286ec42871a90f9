"""How runs ended, counted for terminal, page and figure alike."""

from lienumba.analysis.outcomes import counts
from tests.analysis.test_summary import known


def test_the_nominal_run_is_counted_apart():
    ds = known([0, 0, 1, 1, 9]).assign_coords(run=[-1, 0, 1, 2, 3])
    ran = counts(ds)
    assert (ran.runs, ran.good, ran.stopped, ran.beside) == (4, 2, 1, " and the nominal run")
    assert ran.failed == "2 failed (2 non finite)"
    assert [x.which for x in ran.early] == ["1 (at 0.25 s), 2 (at 0.25 s)", "3 (at 0.25 s)"]
    assert ran.nominal is not None
    assert (ran.nominal.good, ran.nominal.early) == (True, False)


def test_a_nominal_run_that_failed_stands_last():
    ran = counts(known([1, 0, 2]).assign_coords(run=[-1, 0, 1]))
    assert [x.status for x in ran.early] == ["projection_not_converged", "non_finite"]


def test_a_nominal_run_alone_is_the_sweep():
    ran = counts(known([0]).assign_coords(run=[-1]))
    assert (ran.runs, ran.nominal, ran.beside, ran.failed) == (1, None, "", "")


def test_of_many_runs_the_first_are_named():
    (outcome,) = counts(known([1] * 7)).drawn
    assert outcome.which == ", ".join(f"{n} (at 0.25 s)" for n in range(100, 105)) + ", ..."
