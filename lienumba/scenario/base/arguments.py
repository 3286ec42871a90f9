"""What the command line gives as text: run labels (`3,17` or `0:500`) and settings (`path=value`)."""

import os
import re
from collections.abc import Callable, Iterable, Sequence
from itertools import islice
from typing import Any

from lienumba.errors import ScenarioError
from lienumba.words import option, show

BYTES = 100  # of memory for the label of a run, at least


def parse_labels(text: str, runs: int) -> list[int]:
    """The labels of `--runs` in a sweep of `runs`, ascending and each once; a range leaves its end out."""
    labels: set[int] = set()
    for part in parse_ranges(text, option("runs", text)):
        check_labels([part[-1]], runs)
        labels.update(part)
    return sorted(labels)


def parse_ranges(text: str, given: str) -> list[range]:
    """What runs a text such as "3,17" or "0:500" names; given: the key or option with it."""
    ranges = []
    for part in text.split(","):
        match = re.fullmatch(r"\s*(-1|\d{1,18})(?::(\d{1,18}))?\s*", part)
        if match is None:
            raise ScenarioError.at(
                given, f"{show(part)} is not a run", "give labels such as 3,17 or a range such as 0:500"
            )
        start, end = int(match.group(1)), match.group(2)
        if end is not None and int(end) <= start:
            raise ScenarioError.at(given, f'the range "{part}" is empty', "put its end above its start")
        ranges.append(range(start, start + 1 if end is None else int(end)))
    return ranges


def labels_of(given: object, every: range) -> Sequence[int]:
    """The labels of the runs that are asked for; for None all of the sweep, every."""
    if given is None:
        return every
    labels = list(islice(several(given), every.stop + 2))  # of more labels than runs one is there twice, or wrong
    check_labels(labels, every.stop)
    return labels


def several(given: object) -> Iterable[Any]:
    """What is asked for, if it is labels one by one."""
    if isinstance(given, str) or not isinstance(given, Iterable):
        raise ScenarioError.at("runs", "must be labels in a list", "give such as [3, 17] or range(500)", given)
    return given


def check_count(runs: int, inputs: int) -> None:
    """A ScenarioError for runs whose labels and samples, so many of each, this machine has no memory for."""
    try:
        memory = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    except (AttributeError, ValueError, OSError):
        return
    needed = runs * (BYTES + 8 * inputs)
    if needed > memory:
        raise ScenarioError.at(
            f"{runs:,} runs",
            f"their labels and samples alone take {needed / 2**30:,.0f} GiB of memory, and there are "
            f"{memory / 2**30:,.0f}",
            f"run parts of them, one after the other: {option('part', f'1/{2 * needed // memory + 1}')}",
        )


def check_labels(labels: Sequence[int], runs: int) -> None:
    """Every label must be a run of the sweep, or -1, the nominal run."""
    if not labels:
        raise ScenarioError.at("runs", "names no run", "give labels such as 3,17, or leave it out for all runs", [])
    strange = [label for label in labels if isinstance(label, bool) or not hasattr(label, "__index__")]
    if strange:
        raise ScenarioError.at("runs", f"{strange[0]!r} is not a label", "give whole numbers such as 3 and 17")
    if len(set(labels)) < len(labels):
        twice = next(label for label in labels if list(labels).count(label) > 1)
        raise ScenarioError.at("runs", f"{twice} is named twice", "name each run once")
    wrong = [label for label in labels if not -1 <= label < runs]
    if wrong:
        raise ScenarioError.at(
            f"run {wrong[0]} does not exist",
            f"the sweep has sweep.runs = {runs}",
            f"give labels from 0 to {runs - 1} (-1: the nominal run), or raise sweep.runs",
        )


def parse_numbers(text: str, at: str) -> list[float]:
    """The numbers of a text such as "0 0.5 -1" or "0,0.5,-1"."""
    try:
        return [float(part) for part in text.replace(",", " ").split()]
    except ValueError:
        raise ScenarioError.at(f"{at}{text}", "are not all numbers", 'give them such as "0 0.5 -1"') from None


def parse_share(text: str, at: str) -> Callable[[int], float]:
    """How many of so many runs "10" or "5%" allows."""
    match = re.fullmatch(r"(\d+)|(\d+(?:\.\d+)?)%", text.strip())
    if match is None or (match.group(2) and float(match.group(2)) > 100.0):
        raise ScenarioError.at(
            f"{at}{text}", "is neither a number of runs nor a share of them", "give it such as 10 or 5%"
        )
    number, share = match.groups()
    return lambda runs: float(number) if number else runs * float(share) / 100.0


def parse_assignments(settings: Sequence[str]) -> dict[str, str]:
    """The `--set path=value` options by path; of several for one path the last counts."""
    parsed: dict[str, str] = {}
    for setting in settings:
        path, equals, value = setting.partition("=")
        if not equals or not path.strip():
            raise ScenarioError.at(option("set", setting), "is not PATH=VALUE", "write it such as integrator.step=1e-4")
        parsed[path.strip()] = value.strip()
    return parsed
