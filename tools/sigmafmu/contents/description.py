"""The description of a mechanism: its variables, grouped by the elements that they belong to.

Numbers are texts, as modelDescription.xml has them.
"""

from dataclasses import dataclass
from typing import Any


@dataclass
class Variable:
    """A scalar variable; `type` is Real, Integer or Enumeration, `attributes` are its own of that type."""

    name: str
    description: str
    causality: str
    variability: str
    type: str
    attributes: dict[str, str]
    declared: dict[str, str]
    """Attributes of the declared type."""

    @property
    def vector(self) -> str:
        """`top.position` of `top.position[1]`."""
        return self.name.partition("[")[0]

    @property
    def declared_type(self) -> str:
        """Name of the declared type, or empty."""
        return self.attributes.get("declaredType", "")

    def __getitem__(self, attribute: str) -> str:
        """An attribute, its own or its type's, or empty."""
        return self.attributes.get(attribute) or self.declared.get(attribute, "")


@dataclass
class Group:
    """The variables of one element; `kind` is body, joint, force, station or empty, `type` what of its kind it is."""

    owner: str
    kind: str
    type: str
    variables: list[Variable]
    terminal: str  # what other FMUs connect to it for, or empty
    members: list[Variable]  # of the terminal


class Description:
    """A mechanism as `describe` (modelDescription/describe.h) tells it."""

    def __init__(self, told: dict[str, Any]):
        self.told = told
        self.model: str = told["name"]
        self.experiment: dict[str, str] = told["experiment"]
        self.mechanism: str = told["mechanism"]
        """The text of mechanism.json."""
        types = {entry["name"]: entry for entry in told["types"]}
        self.variables = [
            Variable(**entry, declared=types.get(entry["attributes"].get("declaredType"), {}))
            for entry in told["variables"]
        ]
        by_name = {variable.name: variable for variable in self.variables}
        self.groups = [
            Group(
                element["name"],
                element["kind"],
                element["type"],
                [by_name[name] for name in element["variables"]],
                element["terminal"],
                [by_name[name] for name in element["members"]],
            )
            for element in told["elements"]
            if element["variables"]
        ]
        self.enumerations: dict[str, list[dict[str, str]]] = {e["name"]: e["items"] for e in told["enumerations"]}

    def owners(self, kind: str, *types: str) -> list[str]:
        """Names of all elements of a kind, or of some types of it."""
        return [e["name"] for e in self.told["elements"] if e["kind"] == kind and (not types or e["type"] in types)]
