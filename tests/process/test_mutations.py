"""The faults of scripts/mutate can still be put in."""

import ast
import tomllib

import pytest

from tests.rigs.places import ROOT

MUTATIONS = tomllib.loads((ROOT / "scripts" / "mutations.toml").read_text(encoding="utf-8"))


@pytest.mark.parametrize("name", MUTATIONS)
def test_its_old_text_stands_once_in_its_file(name: str) -> None:
    mutation = MUTATIONS[name]
    assert mutation.keys() == {"file", "old", "new", "breaks"}
    text = (ROOT / mutation["file"]).read_text(encoding="utf-8")
    assert text.count(mutation["old"]) == 1, "the code has moved: write the mutation anew"
    mutated = text.replace(mutation["old"], mutation["new"])
    assert ast.dump(ast.parse(mutated)) != ast.dump(ast.parse(text))
