"""The JSON schema of a scenario, by which editors help to write one."""

from typing import Any

from lienumba.keys.types import Section
from lienumba.scenario.base import paths
from lienumba.scenario.schema.scenario import ScenarioData
from lienumba.scenario.schema.sweep import SampleFile
from lienumba.scenario.schema.tables import InputFile, Recording, TableFile


def json_schema() -> dict[str, Any]:
    """The JSON schema of a scenario as people write it: quantities and events beside the model, tables with files."""
    schema = ScenarioData.model_json_schema()
    model = schema["$defs"]["ModelSection"]["properties"]
    for kind in paths.BESIDE:
        schema["properties"][kind] = model.pop(kind)
    schema["$defs"]["TableFile"] = TableFile.model_json_schema()
    schema["properties"]["tables"]["additionalProperties"] = {
        "anyOf": [{"$ref": "#/$defs/TableFile"}, {"$ref": "#/$defs/TableSection"}]
    }
    inputs = schema["properties"][paths.INPUTS]
    inputs["additionalProperties"] = {"anyOf": [*inputs["additionalProperties"]["oneOf"], _defined(schema, InputFile)]}
    recording = _defined(schema, Recording)
    inputs["properties"] = {paths.RECORDING: {"anyOf": [recording, {"type": "array", "items": recording}]}}
    schema["$defs"]["SampleFile"] = SampleFile.model_json_schema()
    schema["$defs"]["Sweep"]["properties"]["table"]["anyOf"].append({"$ref": "#/$defs/SampleFile"})
    return schema


def _defined(schema: dict[str, Any], section: type[Section]) -> dict[str, str]:
    """A reference to a section that is added to the definitions of a schema."""
    own = section.model_json_schema()
    schema["$defs"] |= {**own.pop("$defs", {}), section.__name__: own}
    return {"$ref": f"#/$defs/{section.__name__}"}
