"""What modelDescription.xml says, grouped by the elements that the variables belong to."""

import json
from dataclasses import dataclass, field
from pathlib import Path

from lxml import etree

ATTRIBUTES = ("unit", "displayUnit", "min", "max", "nominal")


@dataclass
class Variable:
    """A scalar variable; `type` is Real, Integer or Enumeration, attributes of its declared type included."""

    name: str
    description: str
    causality: str
    variability: str
    type: str
    declared_type: str = ""
    start: str = ""
    unit: str = ""
    displayUnit: str = ""
    min: str = ""
    max: str = ""
    nominal: str = ""

    @property
    def vector(self) -> str:
        """`top.position` of `top.position[1]`."""
        return self.name.partition("[")[0]


@dataclass
class Group:
    """The variables of one element; `kind` is body, joint, force, station or empty, `type` what of its kind it is."""

    owner: str
    kind: str
    type: str
    variables: list[Variable]
    terminal: str  # what other FMUs connect to it for, or empty
    members: list[Variable]  # of the terminal


@dataclass
class Description:
    """An FMU's modelDescription.xml, and what its variables belong to."""

    model: str
    attributes: dict[str, str]
    experiment: dict[str, str]
    variables: list[Variable]
    groups: list[Group]
    enumerations: dict[str, list[dict[str, str]]] = field(default_factory=dict)

    def owners(self, kind: str, *types: str) -> list[str]:
        """Names of all elements of a kind, or of some types of it."""
        return [group.owner for group in self.groups if group.kind == kind and (not types or group.type in types)]


def read_description(path: Path, elements: Path) -> Description:
    """Reads modelDescription.xml of FMI 2.0 and the elements.json that the build has written beside it."""
    root = etree.parse(path).getroot()
    types = {t.get("name"): t[0] for t in root.iterfind("TypeDefinitions/SimpleType")}
    variables = {v.get("name"): _variable(v, types) for v in root.iterfind("ModelVariables/ScalarVariable")}
    groups = [
        Group(
            element["name"],
            element["kind"],
            element["type"],
            [variables[name] for name in element["variables"]],
            element["terminal"],
            [variables[name] for name in element["members"]],
        )
        for element in json.loads(elements.read_text(encoding="utf-8"))
    ]
    return Description(
        model=root.get("modelName"),
        attributes=dict(root.attrib),
        experiment=dict(root.find("DefaultExperiment").attrib),
        variables=list(variables.values()),
        groups=groups,
        enumerations={
            name: [dict(item.attrib) for item in t.iterfind("Item")]
            for name, t in types.items()
            if t.tag == "Enumeration"
        },
    )


def _variable(scalar: etree._Element, types: dict[str, etree._Element]) -> Variable:
    own = scalar[0]
    declared = own.get("declaredType", "")
    inherited = types[declared] if declared else own
    return Variable(
        name=scalar.get("name"),
        description=scalar.get("description", ""),
        causality=scalar.get("causality"),
        variability=scalar.get("variability"),
        type=own.tag,
        declared_type=declared,
        start=own.get("start", ""),
        **{name: own.get(name) or inherited.get(name, "") for name in ATTRIBUTES},
    )
