"""A short attack on the scenario language, always the same; scripts/fuzz is the long one."""

from dataclasses import replace

import pytest

from lienumba.mechanics.elements.forces import FORCES
from tests.facade import JOINTS
from tests.rigs.places import scripts_on_path

with scripts_on_path():
    from fuzzing import trial
    from fuzzing.cases import case, gallery
    from fuzzing.drawing import Drawing, nested
    from fuzzing.mutations import copied, mutated

SEED, CASES, PARTS = 2026, 120, 5


@pytest.mark.parametrize("part", range(PARTS))
def test_nothing_but_success_or_a_sentence(part: int) -> None:
    outcomes = [trial.tried(replace(case(SEED, n), act="")) for n in range(part, CASES, PARTS)]
    assert not [outcome.failure for outcome in outcomes if outcome.failure]
    assert {trial.VALIDATED, trial.REFUSED} == {outcome.what for outcome in outcomes}


@pytest.mark.campaign(3)
def test_new_cases(seed: int) -> None:
    outcomes = [trial.tried(replace(case(seed, n), act="")) for n in range(CASES)]
    assert not [outcome.failure for outcome in outcomes if outcome.failure]


def test_new_elements_are_drawn_without_a_word() -> None:
    from random import Random

    draw, drawn = Drawing(Random(1)), set()
    for _ in range(300):
        tree = (
            mutated({"model": {}}, draw, 1, "joints") if len(drawn) % 2 else mutated({"model": {}}, draw, 1, "forces")
        )
        item = next(iter(tree["model"].values()))[0]
        drawn |= {item["type"]} if isinstance(item, dict) and isinstance(item.get("type"), str) else set()
    assert len(drawn & {*JOINTS, *FORCES}) > 0.8 * len({*JOINTS, *FORCES})


def test_the_same_case_again() -> None:
    assert repr(case(7, 3)) == repr(case(7, 3)) != repr(case(7, 4))
    assert len(gallery()) > 20
    deep = {"a": nested([], 5000)}
    assert copied(deep)["a"] is not deep["a"]


def test_the_trial_sees_what_is_wrong(monkeypatch: pytest.MonkeyPatch) -> None:
    valid = next(found for n in range(100) if trial.tried(found := replace(case(SEED, n), act="")).what == "validated")

    def fails(*_: object, **__: object) -> None:
        raise KeyError("name")

    monkeypatch.setattr(trial, "resolve", fails)
    outcome = trial.tried(valid)
    assert outcome.what == "traceback"
    assert "KeyError" in outcome.failure

    def endless(*_: object, **__: object) -> None:
        while True:
            pass

    monkeypatch.setattr(trial, "resolve", endless)
    monkeypatch.setattr(trial, "SECONDS", 0.05)
    assert trial.tried(valid).what == "slow"
