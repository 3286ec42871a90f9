"""What of a model is the authors' own: laws written in Python; its contacts, and the events that were watched for."""

from collections.abc import Mapping
from typing import Any

from lienumba.mechanics.elements.events import ACTIONS, ends_run
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
    """Those that end a run, those that change the mechanism, and those that are recorded."""
    watched = source.content.get("events", [])
    ending = [_event(event) for event in watched if ends_run(event["action"])]
    acting = [f"{_event(event)} {_did(event)}" for event in watched if ACTIONS[event["action"]].did]
    recorded = [_event(event) for event in watched if not (ends_run(event["action"]) or ACTIONS[event["action"]].did)]
    said = []
    if ending:
        said.append(f"Runs ended at {'the first of ' if len(ending) > 1 else ''}{_named('the event', ending)}.")
    if acting:
        said.append(f"{_named('The event', acting)}.")
    if recorded:
        said.append(f"It was recorded when {_named('the event', recorded)} first occurred, and how often.")
    return " ".join(said)


def _did(event: Table) -> str:
    """What an event did, and to what."""
    if event.get("joint") is not None:
        whole = f"the {event['coordinate']} of " if event.get("coordinate") is not None else ""
        what = f"{whole}the joint {event['joint']}"
    else:
        what = listed(
            [f"{name} to {x if isinstance(x, str) else number(x)}" for name, x in event["parameters"].items()]
        )
    return f"{ACTIONS[event['action']].did} {what}{' (once in a run)' if event.get('once') else ''}"


def _event(event: Table) -> str:
    return f"{event['name']} ({event['when']})"


def _named(what: str, names: list[str]) -> str:
    return f"{what}{'' if len(names) == 1 else 's'} {listed(names)}"
