"""modelDescription.xml of FMI 2.0."""

import uuid
from typing import Any

from lxml import etree

from .description import Description, Variable

AUTHOR = "sigmafmu authors"
LICENSE = "BSD-3-Clause"
CAPABILITIES = {
    "canHandleVariableCommunicationStepSize": "true",
    "canInterpolateInputs": "true",
    "maxOutputDerivativeOrder": "1",
    "canGetAndSetFMUstate": "true",
    "canSerializeFMUstate": "true",
    "providesDirectionalDerivative": "true",
    "canNotUseMemoryManagementFunctions": "true",
}
LOG_CATEGORIES = {
    "logStatusError": "Refused calls and failed computations",
    "logStatusDiscard": "Communication steps that could not be finished",
    "logStatusWarning": "Settings that deserve a second thought",
    "logEvents": "Repeated internal steps",
}


def model_description(description: Description, sources: list[str], made_of: str = "") -> tuple[str, str]:
    """The file's text and its GUID, a hash of the text without it.

    `sources` are the files to compile, as they are named in the FMU's folder `sources`. `made_of` is a checksum of the
    files of a user's mechanism, which stands in the text; a mechanism of this project has our name instead.
    """
    root = _tree(description, sources, made_of)
    guid = f"{{{uuid.uuid5(uuid.NAMESPACE_OID, _text(root))}}}"
    root.set("guid", guid)
    return _text(root), guid


def _text(root: etree._Element) -> str:
    body = etree.tostring(root, encoding="unicode").replace("'", "&apos;")
    return f'<?xml version="1.0" encoding="UTF-8"?>\n{body}\n'


def _tree(description: Description, sources: list[str], made_of: str) -> etree._Element:
    told = description.told
    signed = {} if made_of else {"author": AUTHOR, "version": told["version"]}
    root = etree.Element(
        "fmiModelDescription",
        {
            "fmiVersion": "2.0",
            "modelName": description.model,
            "guid": "",
            "description": told["description"],
            **signed,
            "license": LICENSE,
            "generationTool": told["generationTool"],
            "variableNamingConvention": "structured",
            "numberOfEventIndicators": "0",
        },
    )
    simulation = etree.SubElement(root, "CoSimulation", {"modelIdentifier": description.model, **CAPABILITIES})
    if sources:
        files = etree.SubElement(simulation, "SourceFiles")
        for name in sources:
            etree.SubElement(files, "File", name=name)
    _units(root, told["units"])
    _types(root, description)
    categories = etree.SubElement(root, "LogCategories")
    for name, text in LOG_CATEGORIES.items():
        etree.SubElement(categories, "Category", name=name, description=text)
    etree.SubElement(root, "DefaultExperiment", description.experiment)
    annotations = etree.SubElement(root, "VendorAnnotations")  # each can have one element
    tool = etree.SubElement(annotations, "Tool", name="sigmafmu")
    etree.SubElement(tool, "DegreesOfFreedom", value=told["degreesOfFreedom"])
    if made_of:
        tool = etree.SubElement(annotations, "Tool", name="sigmafmu.build_fmu")
        etree.SubElement(tool, "MechanismFile", checksum=made_of)
    variables = etree.SubElement(root, "ModelVariables")
    for reference, variable in enumerate(description.variables):
        _variable(variables, variable, reference)
    _structure(root, told["outputs"])
    etree.indent(root, space="    ")
    return root


def _units(root: etree._Element, units: list[dict[str, Any]]) -> None:
    definitions = etree.SubElement(root, "UnitDefinitions")
    for unit in units:
        element = etree.SubElement(definitions, "Unit", name=unit["name"])
        etree.SubElement(element, "BaseUnit", unit["base"])
        for display in unit["displays"]:
            etree.SubElement(element, "DisplayUnit", display)


def _types(root: etree._Element, description: Description) -> None:
    definitions = etree.SubElement(root, "TypeDefinitions")
    for told in description.told["types"]:
        attributes = {name: value for name, value in told.items() if name != "name"}
        etree.SubElement(etree.SubElement(definitions, "SimpleType", name=told["name"]), "Real", attributes)
    used = {variable.declared_type for variable in description.variables}
    for told in description.told["enumerations"]:
        if told["name"] in used:
            named = {name: told[name] for name in ("name", "description")}
            enumeration = etree.SubElement(etree.SubElement(definitions, "SimpleType", named), "Enumeration")
            for item in told["items"]:
                etree.SubElement(enumeration, "Item", item)


def _variable(parent: etree._Element, variable: Variable, reference: int) -> None:
    initial = {"parameter": {"initial": "exact"}, "input": {}}  # inputs must not have it
    scalar = etree.SubElement(
        parent,
        "ScalarVariable",
        {
            "name": variable.name,
            "valueReference": str(reference),
            "description": variable.description,
            "causality": variable.causality,
            "variability": variable.variability,
            **initial.get(variable.causality, {"initial": "calculated"}),
        },
    )
    etree.SubElement(scalar, variable.type, variable.attributes)


def _structure(root: etree._Element, outputs: list[dict[str, str]]) -> None:
    structure = etree.SubElement(root, "ModelStructure")
    if not outputs:
        return
    direct = etree.SubElement(structure, "Outputs")
    initial = etree.SubElement(structure, "InitialUnknowns")
    for output in outputs:
        etree.SubElement(direct, "Unknown", output)
        # No list here: after projection and consistent accelerations an initial value depends on all parameters.
        etree.SubElement(initial, "Unknown", index=output["index"])
