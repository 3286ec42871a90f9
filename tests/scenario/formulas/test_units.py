"""Units of numbers of whole runs, against what they are by hand."""

import pytest

from lienumba.scenario.formulas.measures import REDUCERS
from lienumba.scenario.formulas.units import units_of

NAMES = {"p.x": "m", "v.x": "m s-1", "a.angle": "rad", "root.force.x": "N", "root.sine": "1", "b.rate": "rad/s"}
REDUCED = {name: reducer.unit for name, reducer in REDUCERS.items()}
BY_HAND = {
    "max(p.x)": "m",
    "max(p.x, t > 5) - 0.2": "m",
    "max(p.x) - k": "m",
    "k*max(p.x)": "1",
    "2*rms(v.x)": "m s-1",
    "integral(v.x)": "m",
    "integral(root.force.x*v.x)": "N m",
    "mean(root.force.x*p.x)": "N m",
    "max(p.x)/time_of_max(p.x)": "m s-1",
    "max(p.x)**2": "m2",
    "sqrt(integral(v.x**2))": "1",
    "sqrt(max(p.x*p.x))": "m",
    "last_time(a.angle > 0.1*deg)": "s",
    "count(p.x > 0)": "1",
    "max(a.angle)/deg": "1",
    "max(sin(a.angle)*p.x)": "m",
    "max(atan2(p.x, v.x))": "rad",
    "max(max(abs(p.x), 0.5))": "m",
    "max(min(p.x), k, 0.5)": "m",
    "max(p.x) + max(v.x)": "1",
    "where(max(p.x) > 1, final(a.angle), 0)": "rad",
    "max(root.sine*p.x)": "m",
    "overshoot(p.x, k)": "m",
    "at(v.x, 0.5)": "m s-1",
    "max(-p.x, not t > 5)": "m",
    "final(t) - 1": "s",
    "max(b.rate)": "rad s-1",
    "integral(b.rate)": "rad",
    "max(table(p.x))*final(p.x)": "1",
}


@pytest.mark.parametrize(("text", "units"), BY_HAND.items())
def test_units_follow_from_the_formula(text: str, units: str) -> None:
    assert units_of(text, NAMES, REDUCED) == units
