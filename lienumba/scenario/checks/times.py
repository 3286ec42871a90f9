"""Where steps are of one length, simulated time and stored times must lie on their grid."""

from collections import Counter
from itertools import pairwise

import numpy as np

from lienumba.scenario.base import timegrid
from lienumba.scenario.base.problems import Report
from lienumba.scenario.schema.output import Output
from lienumba.scenario.schema.scenario import Integrator

MOST_STORED = 1_000_000  # times: a state of one body takes half a gigabyte then
MOST_SAMPLES = 1_000_000  # of a course of noise, or of a law
MOST_TIMES = 200_000  # at which a formula is looked at
WITHOUT_GRID = 20_000  # of these, where steps choose their length


def check_times(integrator: Integrator, output: Output | None, report: Report) -> None:
    """Check the step against the run and the stored times against both; output None is passed over."""
    if integrator.step is None:
        _check_output(integrator, output, False, report)
        return
    step, end = integrator.step, integrator.end_time
    if step > end:
        rule = f"is longer than the run, integrator.end_time = {end!r}"
        report.add("integrator.step", rule, "give a shorter step", step)
        return
    steps = timegrid.count(end, step)
    if steps is None:
        durations = [end] if output is None or output.every is None else [end, output.every]
        nearest = f"the nearest end_time {timegrid.nearest_multiple(end, step):.12g}"
        remedy = f"the nearest step that fits is {timegrid.nearest_divisor(durations, step):.12g}, {nearest}"
        report.add("integrator.end_time", _no_steps(step), remedy, end)
    _check_output(integrator, output, steps is not None, report)


def _no_steps(step: float) -> str:
    return f"is not a whole number of steps of integrator.step = {step!r}"


def _check_output(integrator: Integrator, output: Output | None, end_fits: bool, report: Report) -> None:
    if output is None:
        return
    if output.every is not None and output.times is not None:
        report.add("", "output.every and output.times are both given", "leave one of them out")
    if output.every is not None:
        _check_every(integrator, output.every, end_fits, report)
    if output.times is not None:
        _check_listed(integrator, output.times, report)
    for name, number in Counter(output.variables).items():
        if number > 1:
            report.add("output.variables", f'names "{name}" {number} times', "name it once")


def looked_at(integrator: Integrator) -> np.ndarray | None:
    """The times at which formulas are looked at: steps and half steps, or as many as are looked at in no time."""
    if integrator.step is None:
        return np.linspace(0.0, integrator.end_time, WITHOUT_GRID + 1)
    if not 0.0 < integrator.step <= integrator.end_time:
        return None
    points = min(2.0 * integrator.end_time / integrator.step, MOST_TIMES)
    return np.linspace(0.0, integrator.end_time, round(points) + 1)


def check_samples(at: str, interval: float, report: Report) -> bool:
    """Whether a run can have so many samples."""
    end = 0.0 if report.times is None else float(report.times[-1])
    fits = end / interval <= MOST_SAMPLES
    if not fits:
        rule = f"makes {end / interval:.3g} samples until {end:g} s, at most {MOST_SAMPLES:,} are possible"
        report.add(at, rule, "give a longer interval, or end the run earlier", interval)
    return fits


def _check_every(integrator: Integrator, every: float, end_fits: bool, report: Report) -> None:
    at, step, end = "output.every", integrator.step, integrator.end_time
    if every > end * (1 + timegrid.TOLERANCE):
        rule = f"is longer than the run, integrator.end_time = {end!r}"
        report.add(at, rule, "give a shorter interval", every)
    elif end / every > MOST_STORED:
        rule = f"stores {end / every:.3g} states until integrator.end_time = {end!r}"
        remedy = "give a longer interval, or output.times"
        report.add(at, f"{rule}, at most {MOST_STORED:,} are possible", remedy, every)
    elif step is not None and timegrid.count(every, step) is None:
        nearest = f"the nearest interval {timegrid.nearest_multiple(every, step):.12g}"
        remedy = f"the nearest step that fits is {timegrid.nearest_divisor([every, end], step):.12g}, {nearest}"
        report.add(at, _no_steps(step), remedy, every)
    elif (end_fits or step is None) and timegrid.count(end, every) is None:
        last = timegrid.stored_times(end, every)[-1]
        report.warn(at, f"does not divide integrator.end_time = {end!r}", f"the last stored time is {last!r}", every)


def _check_listed(integrator: Integrator, times: list[float], report: Report) -> None:
    step, end = integrator.step, integrator.end_time
    for index, time in enumerate(times):
        at = f"output.times[{index}]"
        if not 0.0 <= time <= end * (1 + timegrid.TOLERANCE):
            report.add(at, "lies outside the run", f"give a time from 0 to integrator.end_time = {end!r}", time)
        elif time and step is not None and timegrid.count(time, step) is None:
            remedy = f"the nearest time that fits is {timegrid.nearest_multiple(time, step):.12g}"
            report.add(at, _no_steps(step), remedy, time)
    for index, (before, after) in enumerate(pairwise(times), 1):
        if min(after, end) <= before:
            rule = f"does not come after {before!r}"
            report.add(f"output.times[{index}]", rule, "give the times in ascending order", after)
