"""What modelDescription.xml says, grouped by body, joint, support and so on."""

from dataclasses import dataclass, field
from pathlib import Path

from lxml import etree

KINDS = {
    "flexible": "modal",
    "body": "mass",
    "revolute": "motorTorque",
    "support": "stiffness",
    "prismatic": "displacement",
    "joint": "reactionForce",
    "station": "position",
}
"""Kind of an object → a variable that only this kind has; the first that fits counts."""

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
    def owner(self) -> str:
        """`top` of `top.position[1]`; nothing for a variable of the whole mechanism."""
        return self.name.partition(".")[0] if "." in self.name else ""

    @property
    def vector(self) -> str:
        """`top.position` of `top.position[1]`."""
        return self.name.partition("[")[0]


@dataclass
class Group:
    """The variables of one owner; `kind` is one of KINDS or empty."""

    owner: str
    kind: str
    variables: list[Variable]

    def members(self, name: str) -> list[Variable]:
        """The elements of the vector `name` of this owner, or its scalar; none if it has neither."""
        return [v for v in self.variables if v.vector == f"{self.owner}.{name}"]


@dataclass
class Description:
    """An FMU's modelDescription.xml."""

    model: str
    attributes: dict[str, str]
    experiment: dict[str, str]
    variables: list[Variable]
    enumerations: dict[str, list[dict[str, str]]] = field(default_factory=dict)

    @property
    def groups(self) -> list[Group]:
        """Owners in the order of their first variables."""
        owners: dict[str, list[Variable]] = {}
        for variable in self.variables:
            owners.setdefault(variable.owner, []).append(variable)
        return [Group(owner, _kind(owner, variables), variables) for owner, variables in owners.items()]

    def owners(self, *kinds: str) -> list[str]:
        """Names of all objects of these kinds."""
        return [group.owner for group in self.groups if group.kind in kinds]


def _kind(owner: str, variables: list[Variable]) -> str:
    vectors = {v.vector for v in variables}
    return next((kind for kind, own in KINDS.items() if f"{owner}.{own}" in vectors), "")


def read_description(path: Path) -> Description:
    """Reads modelDescription.xml of FMI 2.0."""
    root = etree.parse(path).getroot()
    types = {t.get("name"): t[0] for t in root.iterfind("TypeDefinitions/SimpleType")}
    return Description(
        model=root.get("modelName"),
        attributes=dict(root.attrib),
        experiment=dict(root.find("DefaultExperiment").attrib),
        variables=[_variable(v, types) for v in root.iterfind("ModelVariables/ScalarVariable")],
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
