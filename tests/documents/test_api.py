"""docs/api.md is what the docstrings say, and these say everything."""

import inspect
from importlib.machinery import SourceFileLoader
from importlib.util import module_from_spec, spec_from_loader
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest
from docstring_parser import DocstringStyle, parse

ROOT = Path(__file__).parents[2]
VECTORS = "lienumba.groups.so3"  # what its vectors and matrices are stands at its head


def load() -> ModuleType:
    loader = SourceFileLoader("api", str(ROOT / "scripts" / "api"))
    module = module_from_spec(spec_from_loader(loader.name, loader))
    loader.exec_module(module)
    return module


api = load()
THINGS = [pytest.param(thing, id=title) for name in api.MODULES for title, thing, _ in api.things(name)]


def test_the_page_is_what_the_docstrings_say() -> None:
    assert api.PAGE.read_text(encoding="utf-8") == api.page(), "run scripts/api"


def test_what_is_imported_by_name_is_on_the_page() -> None:
    page = api.PAGE.read_text(encoding="utf-8")
    for name in ("run(", "prepare(", "merge(", "replay(", "report(", "System(", "ScenarioError"):
        assert f"### `lienumba.{name}" in page
    for name in ("summarise", "sensitivity", "orders", "mean_rotation", "rotation_covariance", "ellipsoid"):
        assert f"### `lienumba.analysis.{name}(" in page


@pytest.mark.parametrize("thing", THINGS)
def test_every_parameter_has_words(thing: Any) -> None:
    doc = parse(inspect.getdoc(thing) or "", DocstringStyle.NUMPYDOC)
    assert doc.short_description, "has no summary"
    assert doc.short_description.endswith((".", ":")), doc.short_description
    if not callable(thing) or (inspect.isclass(thing) and issubclass(thing, Exception)):
        return
    told = {name.strip().lstrip("*") for p in doc.params for name in p.arg_name.split(",")}
    parameters = inspect.signature(thing).parameters.values()
    unknown = [p.name for p in parameters if p.name != "self" and p.name not in told and p.kind != p.VAR_KEYWORD]
    assert unknown == [] or thing.__module__ == VECTORS, f"says nothing of {unknown}"
    assert all(p.description for p in doc.params), "names parameters without words"
