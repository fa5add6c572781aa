"""terminalsAndIcons/terminalsAndIcons.xml: which variables belong to one place where other FMUs connect.

FMI 2.0.4 took over this folder and its format from FMI 3.0, section 2.4.9; so `fmiVersion` is FMI 3.0's. A terminal is
named like its element, its members like the variables behind that name. Matching rule `bus`: members of
equal names are connected, also if the other side has fewer. Every member is a signal: the FMU's inputs are commands,
and the sign rules for flows do not cover forces in space.
"""

from pathlib import Path

from lxml import etree

from .description import Description, Group


def write(description: Description, out: Path) -> None:
    """Writes the terminals of a model into the FMU's folder `out`."""
    # The schema wants 3.x here, and validators (VDMCheck2) check it. FMI Library (PyFMI) drops the terminals then, as
    # it is not the version of modelDescription.xml: no number satisfies both.
    root = etree.Element("fmiTerminalsAndIcons", fmiVersion="3.0")
    terminals = etree.SubElement(root, "Terminals")
    for group in description.groups:
        if group.terminal and group.members:
            terminals.append(_terminal(group))
    folder = out / "terminalsAndIcons"
    folder.mkdir(parents=True)
    etree.indent(root)
    etree.ElementTree(root).write(folder / "terminalsAndIcons.xml", encoding="UTF-8", xml_declaration=True)


def _terminal(group: Group) -> etree._Element:
    terminal = etree.Element("Terminal", name=group.owner, matchingRule="bus", description=group.terminal)
    for variable in group.members:
        etree.SubElement(
            terminal,
            "TerminalMemberVariable",
            variableName=variable.name,
            memberName=variable.name.removeprefix(f"{group.owner}."),
            variableKind="signal",
        )
    return terminal
