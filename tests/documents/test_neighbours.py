"""The neighbour test finds programs that mix their runs, and none in lienumba. Its page's rival fails as it says."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.documents.pages import ROOT, blocks
from tests.rigs.places import SCENARIOS, scripts_on_path

with scripts_on_path():
    import neighbours

PAGE = ROOT / "docs" / "neighbours.md"
INPUTS = {"a": np.linspace(1, 2, 5), "b": np.linspace(3, 4, 5)}
CALLS: list[int] = []


def right(inputs: Mapping[str, Any]) -> dict[str, Any]:
    return {"x": inputs["a"] * inputs["b"], "y": np.stack([inputs["a"], np.sqrt(inputs["b"])], axis=1)}


def mean(inputs: Mapping[str, Any]) -> dict[str, Any]:
    return {"x": inputs["a"] * inputs["b"] + 0.1 * inputs["a"].mean()}


def ignored(inputs: Mapping[str, Any]) -> dict[str, Any]:
    return {"x": 2 * inputs["a"]}


def unrepeated(inputs: Mapping[str, Any]) -> dict[str, Any]:
    CALLS.append(1)
    return {"x": inputs["a"] * inputs["b"] + len(CALLS)}


def by_place(inputs: Mapping[str, Any]) -> dict[str, Any]:
    return {"x": inputs["a"] * inputs["b"] + np.arange(len(inputs["a"]))}


def poisoned(inputs: Mapping[str, Any]) -> dict[str, Any]:
    """Fails as a whole where one number is not finite."""
    x = inputs["a"] * inputs["b"]
    return {"x": x if np.isfinite(x).all() else np.full_like(x, np.nan)}


def refusing(inputs: Mapping[str, Any]) -> dict[str, Any]:
    if not np.isfinite([*inputs.values()]).all():
        raise ValueError("not finite")
    return right(inputs)


def broken(simulate: Any, inputs: Mapping[str, Any] = INPUTS) -> set[str]:
    return {one.rule for one in neighbours.check(simulate, inputs) if not one.passed}


@pytest.mark.parametrize(
    ("simulate", "rules"),
    [
        (right, set()),
        (refusing, set()),
        (mean, {"alone", "poisoned", "varied: neighbours"}),
        (ignored, {"varied: own run"}),
        (by_place, {"alone", "reversed"}),
        (poisoned, {"poisoned"}),
    ],
)
def test_programs_that_mix_their_runs_are_found(simulate: Any, rules: set[str]) -> None:
    assert broken(simulate) == rules


def test_a_program_that_repeats_nothing_is_found() -> None:
    assert {"repeated", "alone", "reversed"} <= broken(unrepeated)


def test_findings_name_the_run_and_the_input() -> None:
    found = {one.rule: one.text for one in neighbours.check(poisoned, INPUTS)}
    assert found["poisoned"] == "a = nan in run 0: run 1 moves, run 2 moves, run 3 moves, run 4 moves"


def test_the_rival_of_the_page_shares_its_steps(tmp_path: Path) -> None:
    (rival,) = (block for block in blocks(PAGE.read_text(encoding="utf-8")) if block.name == "rival.py")
    file = tmp_path / "rival.py"
    file.write_text(rival.text, encoding="utf-8")
    simulate, inputs = neighbours.of_file(file)
    assert broken(simulate, inputs) == {"alone", "reversed", "poisoned", "varied: neighbours"}

    def each(inputs: Mapping[str, Any]) -> dict[str, Any]:
        own = [simulate({name: x[n : n + 1] for name, x in inputs.items()}) for n in range(len(inputs["angle"]))]
        return {name: np.concatenate([one[name] for one in own]) for name in own[0]}

    finite = {name: x[:4] for name, x in inputs.items()}
    assert broken(each, finite) == set()


def test_the_page_has_every_rule() -> None:
    text = PAGE.read_text(encoding="utf-8")
    assert all(f"\n| {one.rule} |" in text for one in neighbours.check(right, INPUTS))


@pytest.mark.release
@pytest.mark.parametrize("name", ["bouncing_ball", "heavy_top_monte_carlo"])
def test_runs_of_lienumba_do_not_feel_their_neighbours(name: str) -> None:
    assert broken(*neighbours.of_scenario(SCENARIOS / f"{name}.toml")) == set()
