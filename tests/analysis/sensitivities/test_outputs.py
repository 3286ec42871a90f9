"""Which numbers of a dataset are outputs, what they are called, and what is refused."""

import numpy as np
import pytest

from lienumba import ScenarioError
from lienumba.analysis import sensitivity
from lienumba.store.layout import RUN, Variable
from tests.analysis.sweep_example import TIMES, named, sweep

RUNS = 40
RNG = np.random.default_rng(7)
X = RNG.standard_normal((RUNS, 2))
NOISE = RNG.standard_normal((RUNS, len(TIMES), 2, 3))


def observed(status=0, **more):
    """A dataset with states, events, quantities in time and summaries of them."""
    arrays = {
        "position": X[:, 0, None, None, None] + NOISE,
        "event_time": np.where(X > 0, X, np.nan)[:, :1],
        "steps": np.arange(RUNS),
        "tip": 10 + NOISE[:, :, 0],
        "pointing.angle": np.abs(NOISE[:, :, 1, 0]),
        "pointing.angle_rms": np.abs(X[:, 1]),
    } | more
    return sweep(named(X), status, **{name: x for name, x in arrays.items() if x is not None})


def names(ds, *asked, **options):
    return [str(name) for name in sensitivity(ds, asked, **options)["output"].values]


def refused(ds, *asked, **options):
    with pytest.raises(ScenarioError) as error:
        sensitivity(ds, asked, **options)
    return str(error.value)


def test_outputs_are_named_by_their_labels():
    ds = observed()
    assert names(ds, "tip") == ["tip.x", "tip.y", "tip.z"]
    assert names(ds, "position.top.z", "steps") == ["position.top.z", "steps"]
    assert names(ds, "position.arm") == ["position.arm.x", "position.arm.y", "position.arm.z"]
    assert len(names(ds, "position")) == 6
    assert names(ds, "pointing") == ["pointing.angle", "pointing.angle_rms"]
    assert names(ds, "event_time.far") == ["event_time.far"]
    assert names(ds, "tip.y", "tip") == ["tip.y", "tip.x", "tip.z"]


def test_the_values_are_those_of_the_label_and_the_time():
    ds = observed()
    for options, k in (({}, -1), ({"time": 0.5}, 1)):
        found = sensitivity(ds, ["position.top.z", "position.arm.y"], **options).sel(output="position.top.z")
        values = ds["position"].values[:, k, 1, 2]
        assert float(found["mean"]) == pytest.approx(values.mean(), abs=1e-14)
        assert float(found["deviation"]) == pytest.approx(values.std(ddof=1), abs=1e-14)
        assert (found["output_units"], found["output_time"]) == ("m", TIMES[k])
        assert found["output_long_name"] == "position of the mass centre"
    assert np.isnan(sensitivity(ds, "steps")["output_time"]).all()
    assert list(sensitivity(ds, "steps")["input_units"].values) == ["kg", "kg"]


def test_only_runs_with_a_value_count():
    found = sensitivity(observed(), "event_time.far")
    assert found["runs"].item() == (X[:, 0] > 0).sum()
    assert found["mean"].item() == pytest.approx(X[X[:, 0] > 0, 0].mean(), abs=1e-14)


def test_what_says_most_is_chosen():
    own = ["pointing.angle_rms", "event_time.far", "tip.x", "tip.y", "tip.z", "pointing.angle"]
    assert names(observed()) == own
    assert names(observed(), time=0.5) == ["tip.x", "tip.y", "tip.z", "pointing.angle"]
    failing = observed(np.arange(RUNS) % 5 == 0)
    assert names(failing) == [*own, "failed"]
    assert names(observed(np.arange(RUNS) > 1), "failed") == ["failed"]
    bare = {"tip": None, "pointing.angle": None, "pointing.angle_rms": None, "event_time": None}
    assert names(observed(**bare)) == ["position.top.x", "position.top.y", "position.top.z"]
    last = Variable((*RUN, "body", "axis"), "m", "last position")
    only = {"last_position": NOISE[:, 0]}
    assert names(sweep(named(X), specs={"last_position": last}, **only)) == [
        "last_position.top.x", "last_position.top.y", "last_position.top.z"
    ]  # fmt: skip


def test_constant_outputs_and_inputs_are_left_out_and_told():
    tip = 10 + NOISE[:, :, 0]
    tip[..., 1] = 10 * (1 + 1e-15 * X[:, :1])  # rounding
    found = sensitivity(observed(tip=tip), "tip")
    assert list(found["output"].values) == ["tip.x", "tip.z"]
    assert "tip.y: is 10 in all runs, so it depends on no input" in found.attrs["notes"].split("\n")
    samples = {"a": X[:, 0], "b": np.full(RUNS, 2.0)}
    found = sensitivity(sweep(samples, y=X[:, 0]))
    assert list(found["input"].values) == ["a"]
    assert found.attrs["notes"].startswith("inputs that do not vary are left out: b\n")


def made(samples, **more):
    return sweep(samples, **{"y": X[:, 0], **more})


REFUSED = {
    "no inputs": (lambda: observed().drop_vars(["a", "b"]), (), {},
        "the dataset has no inputs; give one of a scenario with [sweep.vary]"),
    "one run": (lambda: observed().isel(run=[3]), (), {}, "the dataset has 1 run with samples; give one of several"),
    "constant inputs": (lambda: made({"a": np.ones(RUNS), "b": np.zeros(RUNS)}), (), {},
        "the inputs do not vary: a, b; give each a spread in [sweep.vary]"),
    "a constant output": (lambda: made(named(X), y=np.full(RUNS, 0.5)), (), {},
        "y: is 0.5 in all runs, so it depends on no input; ask for another output"),
    "an output that is infinite or constant": (lambda: made(named(X), y=np.where(X[:, 0] > 0.5, np.inf, 0.5)), (), {},
        f"y: is 0.5 in {np.sum(X[:, 0] <= 0.5)} runs, and infinite in {np.sum(X[:, 0] > 0.5)} runs, such as a time of "
        "what never happens; ask for another output"),
    "an unknown output": (observed, ["positon"], {},
        'the dataset has no output "positon"; the nearest known name is "position"'),
    "an unknown label": (observed, ["tip.q"], {},
        'the dataset has no output "tip.q"; the nearest known names are "tip.x", "tip.y" and "tip.z"'),
    "the status": (observed, ["status"], {},
        'the output "status" is a code, not a number; ask for "failed"'),
    "failures that are none": (lambda: made(named(X)), ["failed"], {},
        "failed: is 0 in all runs, so it depends on no input; ask for another output"),
    "nothing but failures": (lambda: observed(1), ["tip"], {},
        "tip.x: 0 good runs have a value, and an analysis takes at least 4; see with lienumba info why runs failed"),
    "no variables": (lambda: sweep(named(X)), (), {},
        "the dataset has no variable of runs to analyse; store one, such as a quantity"),
    "few good runs": (lambda: observed(np.arange(RUNS) > 2), ["steps"], {},
        "steps: 3 good runs have a value, and an analysis takes at least 4; see with lienumba info why runs failed"),
    "a time outside": (observed, ["tip"], {"time": 1.5},
        "time = 1.5: lies outside the stored times; give one from 0 to 1 s"),
    "a time that is none": (observed, ["tip"], {"time": float("nan")},
        "time = nan: lies outside the stored times; give one from 0 to 1 s"),
    "a time that is not stored": (observed, ["tip"], {"time": 0.6},
        "time = 0.6: is not stored; the nearest stored time is 0.5 s"),
    "a time of what has none": (observed, ["steps"], {"time": 0.5},
        "time = 0.5: has no meaning for steps, which each run has once; leave it out"),
}  # fmt: skip


@pytest.mark.parametrize("case", REFUSED)
def test_refused(case):
    ds, asked, options, sentence = REFUSED[case]
    assert refused(ds(), *asked, **options) == sentence
