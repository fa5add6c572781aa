"""Readable account of a model, made from its modelDescription.xml alone."""

from collections.abc import Iterable, Iterator
from xml.etree import ElementTree

from fmpy.model_description import ModelVariable
from rich import box
from rich.console import Group
from rich.markup import escape
from rich.table import Table
from rich.text import Text

from sigmafmu.fmu import Fmu
from sigmafmu.variables import split_element

CAPABILITIES = {
    "canHandleVariableCommunicationStepSize": "variable communication step",
    "canInterpolateInputs": "input interpolation",
    "maxOutputDerivativeOrder": "output derivatives up to order",
    "canGetAndSetFMUstate": "save and restore state",
    "canSerializeFMUstate": "serialize state",
    "providesDirectionalDerivative": "directional derivatives",
}
SETTINGS_PREFIX = "integrator."


def summary(fmu: Fmu) -> Group:
    """What the model is, what it can do, and its variables with vectors on one line."""
    variables = fmu.description.modelVariables
    settings = [v for v in variables if v.causality == "parameter" and v.name.startswith(SETTINGS_PREFIX)]
    parameters = [v for v in variables if v.causality == "parameter" and v not in settings]
    fixed = [v for v in parameters if v.variability != "tunable"]
    tunable = [v for v in parameters if v.variability == "tunable"]
    sections = (
        ("Parameters", fixed, ("start", "unit", "allowed")),
        ("Tunable parameters (can be set while running)", tunable, ("start", "unit", "allowed")),
        ("Integrator settings", settings, ("start", "unit", "allowed")),
        ("Inputs", [v for v in variables if v.causality == "input"], ("start", "unit")),
        ("Outputs", [v for v in variables if v.causality == "output"], ("unit",)),
    )
    tables = [_table(title, chosen, columns) for title, chosen, columns in sections if chosen]
    return Group(_head(fmu), *(part for table in tables for part in ("", table)))


def every_variable(fmu: Fmu) -> Group:
    """The model's head and one line for each scalar variable with its value reference."""
    table = _new_table("All variables")
    for title in ("reference", "causality", "variability", "start", "unit", "allowed"):
        table.add_column(title, no_wrap=title != "allowed", justify="right" if title == "reference" else "left")
    for v in fmu.description.modelVariables:
        cells = (v.name, str(v.valueReference), v.causality, v.variability, _start([v]), v.unit or "", _allowed(v))
        table.add_row(*(escape(cell or "") for cell in cells))
    return Group(_head(fmu), "", table)


def _head(fmu: Fmu) -> Group:
    d, slave = fmu.description, fmu.description.coSimulation
    capabilities = []
    for attribute, label in CAPABILITIES.items():
        value = getattr(slave, attribute)
        if value:
            capabilities.append(label if value is True else f"{label} {value}")
    facts = {
        "FMU": f"{fmu.path} (FMI {d.fmiVersion} co-simulation, version {d.version})",
        "Degrees of freedom": _freedom(fmu),
        "Stop time": f"{d.defaultExperiment.stopTime} s" if d.defaultExperiment else "not given",
        "Can": ", ".join(capabilities),
    }
    grid = Table.grid(padding=(0, 2))
    for key, value in facts.items():
        grid.add_row(Text(key, style="dim"), Text(value, overflow="fold"))
    return Group(Text.assemble((fmu.name, "bold"), f": {d.description or ''}"), grid)


def _freedom(fmu: Fmu) -> str:
    """What the build found out about the joints' equations."""
    root = ElementTree.parse(fmu.directory / "modelDescription.xml").getroot()
    found = root.find("VendorAnnotations/Tool[@name='sigmafmu']/DegreesOfFreedom")
    return "not given" if found is None else found.get("value", "")


def _new_table(title: str) -> Table:
    table = Table(
        title=title, title_justify="left", title_style="bold", box=box.SIMPLE_HEAD, show_edge=False, pad_edge=False
    )
    table.add_column("name", no_wrap=True, style="cyan")
    return table


def _table(title: str, variables: Iterable[ModelVariable], columns: tuple[str, ...]) -> Table:
    table = _new_table(title)
    for column in columns:
        table.add_column(column, no_wrap=column == "unit")
    table.add_column("meaning")
    for name, elements in _vectors(variables):
        first = elements[0]
        cells = {
            "start": _start(elements),
            "unit": first.unit or "",
            "allowed": _allowed(first),
        }
        table.add_row(*(escape(text) for text in (name, *(cells[c] for c in columns), first.description or "")))
    return table


def _vectors(variables: Iterable[ModelVariable]) -> Iterator[tuple[str, list[ModelVariable]]]:
    """Group `b[1]`, `b[2]`, … under `b[1..n]`; a scalar is a group of its own."""
    groups: dict[str, list[ModelVariable]] = {}
    for v in variables:
        element = split_element(v.name)
        groups.setdefault(element[0] if element else v.name, []).append(v)
    for base, elements in groups.items():
        yield (f"{base}[1..{len(elements)}]" if split_element(elements[0].name) else base), elements


def _start(elements: list[ModelVariable]) -> str:
    v = elements[0]
    if v.type == "Enumeration":
        return next((item.name for item in v.declaredType.items if item.value == v.start), v.start or "")
    return ", ".join(_short(e.start) for e in elements if e.start is not None)


def _short(number: str) -> str:
    try:
        return f"{float(number) + 0.0:.7g}"  # + 0.0: no "-0"
    except ValueError:
        return number


def _allowed(v: ModelVariable) -> str:
    if v.type == "Enumeration":
        return ", ".join(item.name for item in v.declaredType.items)
    low, high = v.min, v.max
    if low is not None and high is not None:
        return f"{_short(low)} … {_short(high)}"
    return f"≥ {_short(low)}" if low is not None else f"≤ {_short(high)}" if high is not None else ""
