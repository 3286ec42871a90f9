"""How to cite a dataset or a scenario: a paragraph for a section on methods, and BibTeX of what it refers to."""

import re
from collections.abc import Mapping
from datetime import UTC, datetime
from typing import TYPE_CHECKING, Any

from lienumba.errors import ScenarioError
from lienumba.present.citation import references
from lienumba.present.citation.paragraph import paragraph
from lienumba.present.citation.source import CitedScenario
from lienumba.scenario.base.toml import Tables, table_in
from lienumba.scenario.resolve import written_tables

if TYPE_CHECKING:
    import xarray as xr

    from lienumba.scenario.resolve import Scenario

OWN = "lienumba"


def cite_dataset(dataset: "xr.Dataset") -> str:
    """Of a dataset: what its runs were computed with, and how they ended. No code that it brings is run."""
    attributes = dataset.attrs
    content = written_tables(dataset, "the dataset")
    if not content:
        raise ScenarioError("the dataset brings no scenario, which would say what is to be cited")
    inputs = {str(name): x for name, x in dataset.coords.items() if x.attrs.get("role") == "input"}
    units = {path: _unit(path, inputs) for path in table_in(table_in(content, "sweep"), "vary")}
    ending = "_version"
    versions = {key.removesuffix(ending): str(x) for key, x in attributes.items() if key.endswith(ending)}
    year = re.match(r"\d{4}", str(attributes.get("history", "")))
    return _text(_source(content, units, versions, dataset), int(year[0]) if year else datetime.now(UTC).year)


def cite_scenario(scenario: "Scenario") -> str:
    """Of a scenario that has not been run, with what is installed here."""
    from lienumba.store.provenance import versions

    vary = {path: scenario.units(path) for path in scenario.data.sweep.vary}
    return _text(_source(scenario.to_dict(), vary, versions()), datetime.now(UTC).year)


def _source(
    content: dict[str, Any], units: Mapping[str, str], versions: Mapping[str, str], dataset: "xr.Dataset | None" = None
) -> CitedScenario:
    content["model"] = {kind: [] for kind in ("bodies", "joints", "drivers", "forces")} | content["model"]
    content["sweep"] = {"vary": {}, "correlate": []} | content["sweep"]
    nominal = {path: _nominal(content, path) for path in content["sweep"]["vary"]}
    return CitedScenario(content, units, nominal, versions, dataset)


def _nominal(content: Tables, path: str) -> Any:
    """What the scenario has at a path, None if nothing."""
    from lienumba.scenario.base import paths

    model = {**content["model"], "parameters": content.get("parameters", {})}
    try:
        return paths.get(model, paths.parse(path))
    except (LookupError, ValueError, ScenarioError):
        return None


def _unit(path: str, inputs: Mapping[str, "xr.DataArray"]) -> str:
    """That of an input, or of the first of its components."""
    return next(
        (str(x.attrs.get("units", "1")) for name, x in inputs.items() if name == path or name.startswith(f"{path}[")),
        "1",
    )


def _text(source: CitedScenario, year: int) -> str:
    """The paragraph, then the entries of its references in the order in which they are met."""
    text = paragraph(source)
    keys = list(dict.fromkeys(re.findall(r"@(\w+)", text)))
    own = references.software(source.versions[OWN], year)
    return "\n\n".join([text, own, *references.bibtex(key for key in keys if key != OWN)])
