"""What of a model is the authors' own: laws written in Python; its contacts, and the events that were watched for."""

from collections.abc import Mapping
from typing import Any

from lienumba.mechanics.elements.events import ends_run
from lienumba.present.citation.source import CitedScenario
from lienumba.words import listed, number

Table = Mapping[str, Any]


def laws(source: CitedScenario) -> str:
    """The constraints and force laws in Python, those that share a function and an interval in one sentence."""
    found: dict[tuple[str, str], list[str]] = {}
    for kind, what in ("joints", "constraint"), ("forces", "force law"):
        for law in source.content["model"][kind]:
            if law["type"] == "python":
                found.setdefault((what, _function(law)), []).append(law["name"])
    return " ".join(
        f"{_named(f'The {what}', names)} {'is' if len(names) == 1 else 'are'} the authors' own, {function}."
        for (what, function), names in found.items()
    )


def _function(law: Table) -> str:
    """The function of a law: where it stands, and when it is called."""
    file, _, name = law["function"].rpartition(":")
    every = law.get("every")
    level = ", on velocities" if law.get("level") == "velocity" else ""
    rate = (
        f", sampled every {every if isinstance(every, str) else number(every)} s and held in between" if every else ""
    )
    return f"written in Python (the function {name} in {file}{level}{rate})"


def contacts(source: CitedScenario) -> str:
    """Those that are rigid, and those that yield."""
    every = source.content["model"].get("contacts", [])
    rigid = [contact["name"] for contact in every if contact.get("stiffness") is None]
    yielding = [contact["name"] for contact in every if contact.get("stiffness") is not None]
    said = []
    if rigid:
        named, several = _named("The contact", rigid), len(rigid) > 1
        law = f"{'are' if several else 'is'} rigid, with Newton's restitution and Coulomb's friction"
        said.append(f"{named} {law}.")
    if yielding:
        named, several = _named("The contact", yielding), len(yielding) > 1
        said.append(f"{named} {'yield' if several else 'yields'}, with the force of Hunt and Crossley [@hunt1975].")
    return " ".join(said)


def events(source: CitedScenario) -> str:
    """Those that end a run, and those that are recorded."""
    watched = source.content.get("events", [])
    ending = [_event(event) for event in watched if ends_run(event["action"])]
    recorded = [_event(event) for event in watched if not ends_run(event["action"])]
    said = []
    if ending:
        said.append(f"Runs ended at {'the first of ' if len(ending) > 1 else ''}{_named('the event', ending)}.")
    if recorded:
        said.append(f"It was recorded when {_named('the event', recorded)} first occurred, and how often.")
    return " ".join(said)


def _event(event: Table) -> str:
    return f"{event['name']} ({event['when']})"


def _named(what: str, names: list[str]) -> str:
    return f"{what}{'' if len(names) == 1 else 's'} {listed(names)}"
