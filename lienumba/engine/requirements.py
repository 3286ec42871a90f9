"""Whether each run meets what is wanted of it, by which margin, and what that says of all of them."""

import json
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from lienumba.batch.statuses import GOOD
from lienumba.errors import BadValueError, ScenarioError
from lienumba.scenario.base.paths import REQUIREMENTS
from lienumba.scenario.formulas.measures import is_formula
from lienumba.scenario.resolve import Scenario
from lienumba.scenario.schema.requirements import Requirement
from lienumba.store.layout import MARGIN, MET, VERDICT, VERDICTS, WEIGHT
from lienumba.store.names import Names, find_one
from lienumba.sweep.samplers import SAMPLERS
from lienumba.sweep.verdicts import Verdict, Wanted, judge

Place = tuple[str, tuple[int, ...]]
Column = Callable[[str, np.ndarray], np.ndarray]  # a variable of the runs with these labels (runs, ...)
NEVER = "event_time"  # which is later than any limit where an event did not happen


@dataclass(frozen=True)
class Judged:
    """A requirement, with the variable that it is about and where in it, and its unit."""

    requirement: Requirement
    at: Place
    units: str

    def margins(self, records: np.ndarray) -> np.ndarray:
        """How far runs are on the good side of the limit (runs,), NaN where a run failed or has no value."""
        name, place = self.at
        column: Any = records[name]
        values: np.ndarray = column[(..., *place)].astype(float)
        values = np.where(np.isnan(values), np.inf, values) if name == NEVER else values
        wanted = self.requirement
        if wanted.below is not None:
            found = wanted.below - values
        elif wanted.above is not None:
            found = values - wanted.above
        else:
            assert wanted.between is not None, "checked"
            low, high = wanted.between
            found = np.minimum(values - low, high - values)
        return np.where(np.isin(records["status"], GOOD), found, np.nan)

    def rises(self, value: float) -> bool:
        """Whether the margin grows with the value."""
        low_high = self.requirement.between
        return self.requirement.above is not None if low_high is None else 2.0 * value < sum(low_high)

    def met(self, margins: np.ndarray, good: np.ndarray) -> np.ndarray:
        """Whether runs meet it (runs,): 1, 0, or -1 where a run does not count; limits of `between` are good."""
        enough = margins >= 0.0 if self.requirement.between is not None else margins > 0.0
        return np.where(good | (self.requirement.failed == "count"), enough, -1).astype(np.int8)


def judge_runs(records: np.ndarray, judged: Sequence[Judged]) -> None:
    """Write into records of runs whether they meet each requirement, and by which margin."""
    good = np.isin(records["status"], GOOD)
    for n, one in enumerate(judged):
        margins = one.margins(records)
        records[MARGIN][:, n] = margins
        records[MET][:, n] = one.met(margins, good)


def judged_of(resolved: Scenario, names: Names) -> tuple[Judged, ...]:
    """All requirements of a scenario; a ScenarioError if one is about none of these names."""
    found, problems = [], []
    for requirement in resolved.data.model.requirements:
        measured = requirement.name in resolved.parameters.measures and is_formula(requirement.value)
        others = replace(names, requirements=[name for name in names.requirements if name != requirement.name])
        try:
            number = find_one(requirement.name if measured else requirement.value, others)
            found.append(Judged(requirement, (number.variable, number.place), number.units))
        except BadValueError as error:
            problems.append(error.at(f"{REQUIREMENTS}.{requirement.name}.value", requirement.value))
    if problems:
        raise ScenarioError(*problems)
    return tuple(found)


def verdicts(resolved: Scenario, labels: np.ndarray, column: Column) -> Iterator[Verdict]:
    """The verdicts on runs with these labels, the nominal one apart."""
    sweep, requirements = resolved.data.sweep, resolved.data.model.requirements
    sampler = SAMPLERS[sweep.sampler]
    inputs = sum(kind.dimensions > 0 for kind in sweep.vary.values())
    drawn = labels[sampler.counting(labels, inputs)]
    weights = column(WEIGHT, drawn) if resolved.weighted else None
    every = [column(name, drawn).astype(float) for name in (MET, MARGIN)]
    for n, requirement in enumerate(requirements):
        met, margin = (x[:, n] for x in every)
        wanted = Wanted(requirement.name, requirement.probability, requirement.confidence)
        met = np.where(met < 0.0, np.nan, met)
        yield judge(wanted, met, margin, weights)


def attributes(resolved: Scenario, labels: np.ndarray, column: Column) -> dict[str, str]:
    """What the dataset says of them: a sentence for each, and the same for programs."""
    found = list(verdicts(resolved, labels, column))
    sentences = "\n".join(verdict.sentence() for verdict in found)
    return {VERDICT: sentences, VERDICTS: json.dumps([verdict.to_dict() for verdict in found])}
