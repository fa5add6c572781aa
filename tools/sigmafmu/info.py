"""Readable account of a model, made from its modelDescription.xml alone."""

import textwrap
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from xml.etree import ElementTree

from fmpy.model_description import ModelVariable
from rich.console import Console, ConsoleOptions, Group, RenderResult
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
WIDTH = 80
"""Columns, whatever the terminal has: a listing is often piped to a pager."""
GAP, INDENT = 2, 4
START, ALLOWED = "start", "start (allowed)"


def summary(fmu: Fmu, descriptions: bool = False) -> Group:
    """What the model is, what it can do, and its variables with vectors on one line."""
    variables = fmu.description.modelVariables
    settings = [v for v in variables if v.causality == "parameter" and v.name.startswith(SETTINGS_PREFIX)]
    parameters = [v for v in variables if v.causality == "parameter" and v not in settings]
    fixed = [v for v in parameters if v.variability != "tunable"]
    tunable = [v for v in parameters if v.variability == "tunable"]
    sections = (
        ("Parameters", fixed, ("name", "unit", ALLOWED)),
        ("Tunable parameters (can be set while running)", tunable, ("name", "unit", ALLOWED)),
        ("Integrator settings", settings, ("name", "unit", ALLOWED)),
        ("Inputs", [v for v in variables if v.causality == "input"], ("name", "unit", START)),
        ("Outputs", [v for v in variables if v.causality == "output"], ("name", "unit")),
        ("Local variables", [v for v in variables if v.causality == "local"], ("name", "unit")),
    )
    listings = [
        Listing(title, columns, [_entry(name, elements, columns) for name, elements in _vectors(chosen)], descriptions)
        for title, chosen, columns in sections
        if chosen
    ]
    return Group(_head(fmu), *(part for listing in listings for part in ("", listing)), *_hint(descriptions))


def every_variable(fmu: Fmu, descriptions: bool = False) -> Group:
    """The model's head and one line for each scalar variable with its value reference."""
    columns = ("name", "ref", "kind", "unit", ALLOWED if descriptions else START)
    entries = [_entry(v.name, [v], columns) for v in fmu.description.modelVariables]
    listing = Listing("All variables (parameters are fixed or tunable)", columns, entries, descriptions)
    return Group(_head(fmu), "", listing, *_hint(descriptions))


def _hint(descriptions: bool) -> tuple[str, ...]:
    return () if descriptions else ("", "-v tells what each variable means.")


Entry = tuple[list[str], str]
"""Cells, and the description of a variable."""


@dataclass(frozen=True)
class Listing:
    """A table that is never wider than `WIDTH`: its last column and the descriptions go on in further lines."""

    title: str
    columns: tuple[str, ...]
    entries: list[Entry]
    descriptions: bool

    def __rich_console__(self, _console: Console, _options: ConsoleOptions) -> RenderResult:
        *fixed, _ = zip(self.columns, *(cells for cells, _ in self.entries), strict=True)
        sizes = [max(map(len, column)) for column in fixed]
        before = sum(sizes) + GAP * len(sizes)

        yield Text(self.title, style="bold")
        yield Text(self._row(self.columns, sizes), style="dim")
        for cells, description in self.entries:
            first, *more = _words(cells[-1], WIDTH - before) or [""]
            line = Text(self._row([*cells[:-1], first], sizes), no_wrap=True, overflow="ignore")
            line.stylize("cyan", 0, len(cells[0]))
            yield line
            yield from (Text(" " * before + piece) for piece in more)
            if self.descriptions:
                yield from (Text(" " * INDENT + part, style="dim") for part in _words(description, WIDTH - INDENT))

    @staticmethod
    def _row(cells: Sequence[str], sizes: Sequence[int]) -> str:
        padded = [f"{cell:<{size}}" for cell, size in zip(cells, sizes, strict=False)]
        return (" " * GAP).join([*padded, cells[-1]]).rstrip()


def _words(text: str, width: int) -> list[str]:
    """Lines of at most `width` characters; words stay whole."""
    return textwrap.wrap(text, width, break_long_words=False, break_on_hyphens=False)


def _head(fmu: Fmu) -> Group:
    d, slave = fmu.description, fmu.description.coSimulation
    capabilities = []
    for attribute, label in CAPABILITIES.items():
        value = getattr(slave, attribute)
        if value:
            capabilities.append(label if value is True else f"{label} {value}")
    facts = {
        "FMU" if fmu.path.suffix == ".fmu" else "File": str(fmu.path),
        "Version": ", ".join(filter(None, (d.version, f"FMI {d.fmiVersion} co-simulation"))),
        "Degrees of freedom": _freedom(fmu),
        "Stop time": f"{d.defaultExperiment.stopTime} s" if d.defaultExperiment else "not given",
        "Can": ", ".join(capabilities),
    }
    size = max(map(len, facts)) + GAP
    title = Text("\n".join(_words(f"{fmu.name}: {d.description or ''}", WIDTH)))
    title.stylize("bold", 0, len(fmu.name))
    lines = [title]
    for key, value in facts.items():
        first, *more = _words(value, WIDTH - size)
        line = Text(f"{key:<{size}}{first}", no_wrap=True, overflow="ignore")  # a long path can still be copied
        line.stylize("dim", 0, size)
        lines += [line, *(Text(" " * size + piece) for piece in more)]
    return Group(*lines)


def _freedom(fmu: Fmu) -> str:
    """What the build found out about the joints' equations."""
    root = ElementTree.parse(fmu.directory / "modelDescription.xml").getroot()
    found = root.find("VendorAnnotations/Tool[@name='sigmafmu']/DegreesOfFreedom")
    return "not given" if found is None else found.get("value", "")


def _entry(name: str, elements: list[ModelVariable], columns: tuple[str, ...]) -> Entry:
    first = elements[0]
    start, allowed = _start(elements), _allowed(first)
    cells = {
        "name": name,
        "ref": str(first.valueReference),
        "kind": first.variability if first.causality == "parameter" else first.causality,
        "unit": first.unit or "",
        START: start,
        ALLOWED: f"{start} ({allowed})" if allowed else start,
    }
    return [cells[c] or "" for c in columns], first.description or ""


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
    space = "\N{NO-BREAK SPACE}"
    if low is not None and high is not None:
        return f"{_short(low)}{space}…{space}{_short(high)}"
    return f"≥{space}{_short(low)}" if low is not None else f"≤{space}{_short(high)}" if high is not None else ""
