"""One case, and what came of it: nothing but success or a ScenarioError, in time, in memory, with finite values."""

import re
import signal
import sys
import tempfile
import time
import traceback
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from itertools import chain
from pathlib import Path
from types import FrameType
from typing import Any

import numpy as np

import lienumba
from fuzzing.cases import Case
from lienumba.batch.statuses import SUCCESS
from lienumba.errors import ScenarioError
from lienumba.present.info import describe_scenario
from lienumba.scenario.base.arguments import parse_assignments
from lienumba.scenario.resolve import resolve
from lienumba.scenario.start.samples_file import claimed_samples, sample
from lienumba.scenario.start.study_start import check_starts

SECONDS = 20.0  # of core time
NEVER = re.compile(r"event_time|\bat\(|(first|last)_time\(|,|sqrt\((?!bob\.x\*\*2)|/\(t - ")
VALIDATED, RUN, REFUSED = "validated", "run", "refused"


class TooSlowError(BaseException):
    """Nothing catches it."""


@dataclass
class Outcome:
    """`failure`: what is wrong, empty if nothing is."""

    what: str
    seconds: float
    failure: str = ""


def tried(case: Case) -> Outcome:
    """What comes of a case; in the main thread of a process, whose alarm it uses."""
    start = time.process_time()
    what, failure = "", ""
    old = signal.signal(signal.SIGPROF, _too_slow)
    signal.setitimer(signal.ITIMER_PROF, SECONDS)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            what = _act(case)
    except ScenarioError as error:
        what, failure = REFUSED, _fault_of(error)
    except TooSlowError:
        what, failure = "slow", f"took more than {SECONDS:g} s: " + traceback.format_exc()
    except BaseException as error:
        if isinstance(error, KeyboardInterrupt):
            raise
        what, failure = "traceback", traceback.format_exc()
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.signal(signal.SIGPROF, old)
    seconds = time.process_time() - start
    if not failure and seconds > SECONDS:
        what, failure = "slow", f"took {seconds:.1f} s"
    return Outcome(what, seconds, failure)


def _act(case: Case) -> str:
    if isinstance(case.scenario, str):
        with tempfile.TemporaryDirectory() as folder:
            for name, text in {**case.files, "case.toml": case.scenario}.items():
                (Path(folder) / name).write_bytes(text.encode("utf-8", "surrogatepass"))
            return _validated(Path(folder) / "case.toml", case)
    if not case.act:
        return _validated(case.scenario, case)
    ACTS[case.act](case.scenario)
    return RUN


def _run(scenario: Any) -> None:
    dataset = lienumba.run(scenario, workers=1, progress=False, allow_code=True)
    wrong = _not_finite(dataset, _may_not_happen(scenario))
    if wrong:
        raise AssertionError(f"status 0 and values that are not finite: {wrong}")


def _sample(scenario: Any) -> None:
    resolved = resolve(scenario, allow_code=True)
    with tempfile.TemporaryDirectory() as folder, claimed_samples(Path(folder) / "samples.csv", False) as output:
        sample(resolved, resolved.labels, output)


ACTS: dict[str, Callable[[Any], object]] = {
    "run": _run,
    "modes": lambda x: lienumba.modes(x, allow_code=True),
    "equilibrium": lambda x: lienumba.equilibrium(x, allow_code=True),
    "linearise": lambda x: lienumba.linearise(x, allow_code=True),
    "rare": lambda x: lienumba.rare(x, method="form", workers=1, allow_code=True),
    "worst": lambda x: lienumba.worst(x, runs=20, workers=1, allow_code=True),
    "sample": _sample,
    "info": lambda x: describe_scenario(resolve(x, allow_code=True)),
}


def _validated(scenario: object, case: Case) -> str:
    overrides = parse_assignments(case.settings) if case.settings else case.overrides
    resolved = resolve(scenario, overrides=overrides, allow_code=True)
    check_starts(resolved)
    resolved.sha256()
    return VALIDATED


def _fault_of(error: ScenarioError) -> str:
    """What is wrong with the sentences of an error."""
    text = str(error)
    if not text.strip():
        return "an error without a sentence"
    if not all(c.isprintable() or c == "\n" for c in text):
        return f"control characters in {text!r}"
    if len(text) > 100_000:
        return f"a message of {len(text)} characters"
    if "Traceback" in text or "pydantic" in text:
        return f"not a sentence: {text}"
    return ""


def _may_not_happen(scenario: dict) -> set[str]:
    """The measures and requirements about moments that a run need not see, events, first times, conditions, and about
    what has a pole, or roots of numbers of a run that may be negative."""
    found: set[str] = set()
    tables = [part.get(kind, ()) for kind in ("measures", "requirements") for part in (scenario["model"], scenario)]
    for one in chain(*tables):
        formula = str(one.get("value", ""))  # measures may be functions instead
        if NEVER.search(formula) or any(name in formula for name in found):
            found.add(one["name"])
    return found


def _not_finite(dataset: object, may_not_happen: set[str]) -> str:
    """The variables in which a run that ended well has a value that is not finite."""
    ds = dataset
    if "status" not in ds or "run" not in ds["status"].dims:  # a study
        return ""
    good = (ds["status"] == SUCCESS).to_numpy()
    wrong = []
    for name, x in ds.data_vars.items():
        if x.dims[:1] != ("run",) or x.dtype.kind != "f" or {"event", "change"} & {*map(str, x.dims)}:
            continue  # what may not have happened
        if str(name).startswith(("event_", "last_", "change_")) or name in may_not_happen:
            continue
        if "requirement" in x.dims:
            x = x.sel(requirement=[one not in may_not_happen for one in x["requirement"].to_numpy()])
        if not np.isfinite(x.to_numpy()[good]).all():
            wrong.append(str(name))
    return ", ".join(wrong)


def _too_slow(number: int, frame: FrameType | None) -> None:
    raise TooSlowError


def peak_memory() -> float:
    """The largest memory of this process so far, in bytes."""
    import resource

    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * (1 if sys.platform == "darwin" else 1024)
