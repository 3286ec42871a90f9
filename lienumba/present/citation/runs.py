"""Which runs there were, in what they differed, and how they ended."""

from typing import TYPE_CHECKING

from lienumba.present.citation import sampling
from lienumba.present.citation.source import CitedScenario
from lienumba.scenario.base.toml import Tables
from lienumba.words import number, plural

if TYPE_CHECKING:
    import xarray as xr


def sweep(source: CitedScenario) -> str:
    """What was varied, and how; nothing without a sweep."""
    rules = source.content["sweep"]
    if not rules["vary"]:
        return ""
    labels = None if source.dataset is None else [int(x) for x in source.dataset["run"].values]
    own = None if labels is None else [x for x in labels if x >= 0]
    if own == []:
        return "Of the sweep, the nominal run alone was simulated."
    inputs = sampling.inputs(rules["vary"], source.units, source.nominal)
    said = [f"{_runs(rules, own, _stopped(source))}: {inputs}.", f"{sampling.drawn(rules)}."]
    if rules["correlate"]:
        said.append(sampling.correlations(rules["correlate"]))
    if rules["nominal"] if labels is None else labels != own:
        said.append("One run more had the nominal values.")
    if rules.get("proposal"):
        said.append(sampling.proposals(rules["proposal"]))
    if rules.get("stop"):
        said.append(_stop(source, rules["stop"]))
    return " ".join(said)


def _runs(rules: Tables, own: list[int] | None, stopped: str) -> str:
    """How many runs there were, of how many: `own` are the labels of a dataset."""
    whole, inputs = rules["runs"], plural(len(rules["vary"]), "input", "inputs")
    most = "at most " if rules.get("stop") else ""
    if whole == 1:
        return f"One run was simulated, with values drawn for {inputs}"
    if own is None:
        return sampling.capital(f"{most}{whole:,} runs differed in {inputs}")
    if len(own) == whole:
        return f"{whole:,} runs differed in {inputs}"
    if stopped:
        return f"{plural(len(own), 'run', 'runs')} of {most}{whole:,} differed in {inputs}"
    some = f"Run {own[0]} was" if len(own) == 1 else f"{len(own):,} runs were"
    return f"{some} simulated, of a sweep of {most}{whole:,} runs that differ in {inputs}"


def _stopped(source: CitedScenario) -> str:
    return "" if source.dataset is None else str(source.dataset.attrs.get("stopped", ""))


def _stop(source: CitedScenario, rule: Tables) -> str:
    """When a sweep was to end, and whether it did."""
    dataset, stopped = source.dataset, _stopped(source)
    after = f"after every {plural(rule['every'], 'run', 'runs')}"
    if "requirement" in rule:
        text = f'The sweep was to end once its runs, looked at {after}, showed whether "{rule["requirement"]}" is met'
        text += ", by a mixture martingale [@robbins1970]."
    else:
        text = _interval(dataset, rule, after)
    if dataset is None:
        return text
    return f"{text} It had {stopped}." if stopped else f"{text} These runs were not enough for that."


def _interval(dataset: "xr.Dataset | None", rule: Tables, after: str) -> str:
    """How narrow an interval was to become."""
    name = rule["variable"]
    what = "mean" if rule["statistic"] == "mean" else f"{100 * rule['probability']:g} % quantile"
    unit = "" if dataset is None or name not in dataset else sampling.unit(str(dataset[name].attrs.get("units", "1")))
    return (
        f"The sweep was to end once the {100 * rule['confidence']:g} % confidence interval of the {what} of {name}, "
        f"computed {after}, was no wider than {number(rule['width'])}{unit}."
    )


def ends(source: CitedScenario) -> str:
    """How many runs succeeded, and why others did not."""
    if source.dataset is None:
        return "(No run has been made yet; cite the dataset to say how many failed, and why.)"
    from lienumba.batch.statuses import GOOD, STATUSES, STOPPED

    codes = source.dataset["status"].values.ravel()
    counts = {status: int((codes == status.code).sum()) for status in STATUSES}
    failed = {status: n for status, n in counts.items() if n and status.code not in GOOD}
    whole, bad, at_event = len(codes), sum(failed.values()), int((codes == STOPPED).sum())
    what = "simulation" if source.grids or whole == 1 else "run"
    if whole == at_event:
        return f"{_all(whole, what)} ended at an event, as intended."
    by_event = f"; {at_event:,} of them ended at an event, as intended" if at_event else ""
    if not failed:
        return f"{_all(whole, what)} succeeded{by_event}."
    reasons = {f"{status.sentence.partition(';')[0]} ({status.name})": n for status, n in failed.items()}
    whys = "; ".join(f"{n:,}: {why}" for why, n in reasons.items()) if bad < whole or len(reasons) > 1 else min(reasons)
    if bad == whole:
        return f"{_all(whole, what)} failed ({whys})."
    return f"{plural(bad, what, f'{what}s')} of {whole:,} failed ({whys}); {whole - bad:,} succeeded{by_event}."


def _all(whole: int, what: str) -> str:
    if whole <= 2:
        return f"The {what}" if whole == 1 else f"Both {what}s"
    return f"All {whole:,} {what}s"
