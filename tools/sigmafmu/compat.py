"""Which tools accept the FMUs, and whether they get the results that FMPy gets.

Every master takes 64 communication steps of H = 2⁻⁹ s and sets two parameters before. That H has an exact value both as
a binary number and in whole nanoseconds, so every master passes the same times to the FMU however it computes them, and
has to get the same bits. Another H, such as 1 ms, gives steps that differ in their last bit from master to master, and
results that differ by the consequences of that.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass

from rich import box
from rich.table import Table

from sigmafmu import SigmafmuError, __version__
from sigmafmu.fmu import Fmu
from sigmafmu.markdown import markdown_table
from sigmafmu.masters import Master, Run, Tool, ToolError, Trajectory, Validator, comparable, largest_difference, tools
from sigmafmu.masters.fmpy import FmpyMaster

H = 2.0**-9  # s
STEPS = 64
PARAMETERS = {"integrator.spectralRadius": 0.8, "gravity[2]": 0.5}
"""Two Real parameters that every mechanism has, with other values than their start values."""

NOTE_MARKS = "¹²³⁴⁵"
"""In a cell: what the note of this mark says is true of the master."""

NOT_RUN = """OMSimulator, FMU Compliance Checker, PyFMI and fmusim are not run here, since no package registry
has binaries of them; the XML keeps clear of what is known to break them."""


@dataclass(frozen=True)
class Column:
    """What one tool said: its version (None: not installed), a cell for each model, and the mark of its note."""

    tool: Tool
    version: str | None
    cells: list[str]
    mark: str = ""


def standard_run(fmu: Fmu) -> Run:
    """What every master is asked to do."""
    return Run(fmu, H, STEPS, PARAMETERS)


def choose(names: Iterable[str]) -> list[Tool]:
    """The tools with these names (upper or lower case), all of them if there are no names."""
    known = {tool.name.casefold(): tool for tool in tools()}
    names = list(names)
    for name in names:
        if name.casefold() not in known:
            raise SigmafmuError(f"unknown tool '{name}'; known tools: {', '.join(t.name for t in known.values())}")
    return [known[name.casefold()] for name in names] if names else list(known.values())


def check(models: list[str], chosen: list[Tool], advance: Callable[[], None]) -> list[Column]:
    """Run every tool on every model; `advance` is called after each cell."""
    fmus = [Fmu.of_model(model) for model in models]
    expected: dict[str, Trajectory] = {}
    columns = []
    marks = iter(NOTE_MARKS)
    for tool in chosen:
        reason = tool.missing()
        mark = next(marks) if isinstance(tool, Master) and tool.note and not reason else ""
        cells = []
        for fmu in fmus:
            if not reason and isinstance(tool, Master) and fmu.name not in expected:
                expected[fmu.name] = FmpyMaster().simulate(standard_run(fmu))
            cells.append(" ".join(filter(None, (reason or _cell(tool, fmu, expected), mark))))
            advance()
        columns.append(Column(tool, None if reason else tool.version(), cells, mark))
    return columns


def _cell(tool: Tool, fmu: Fmu, expected: dict[str, Trajectory]) -> str:
    try:
        if isinstance(tool, Validator):
            findings = tool.validate(fmu)
            return f"{len(findings)} findings: {findings[0]}" if findings else "finds nothing wrong"
        if isinstance(tool, FmpyMaster):
            return "simulates"
        run = standard_run(fmu)
        difference = largest_difference(tool.simulate(run), comparable(expected[fmu.name], run, tool))
        return "same bits as FMPy" if difference == 0 else f"equal to FMPy's to {difference:.1e}"
    except ToolError as error:
        return f"fails: {error}"


def notes(columns: list[Column]) -> list[str]:
    """What a user of these masters has to do."""
    return [f"{c.mark} {c.tool.note}." for c in columns if isinstance(c.tool, Master) and c.mark]


def table(models: list[str], columns: list[Column]) -> Table:
    """The result for the terminal, a line for each tool."""
    result = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    for name in ("tool", "version", *models):
        result.add_column(name)
    for column in columns:
        result.add_row(column.tool.name, column.version or "–", *column.cells)
    return result


def page(models: list[str], columns: list[Column]) -> str:
    """The result as a Markdown page."""
    matrix = markdown_table(
        ("", *(c.tool.name for c in columns)),
        ([f"`{model}`", *(c.cells[i] for c in columns)] for i, model in enumerate(models)),
    )
    commands = markdown_table(
        ("tool", "version", "from", "command"),
        ((c.tool.name, c.version or "–", c.tool.source, f"`{c.tool.command}`") for c in columns),
    )
    introduction = __doc__.split("\n", 2)[2].strip()
    return (
        f"# Tools that run the FMUs\n\nWritten by `sigmafmu compat`, sigmafmu {__version__}.\n\n{matrix}\n"
        + "\n\n".join([introduction, *notes(columns), NOT_RUN, "## Versions and commands", commands])
    )
