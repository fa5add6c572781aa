"""The page docs/elements.md: every element with its law, variables, figure and source.

Meanings come from the loader's table, laws from the comments above the definitions in C++, variables from the
description of an FMU with the element, figures from its drawing.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from research.elements import examples
from research.elements.examples import ACTING, Element
from sigmafmu import _core, packing
from sigmafmu.contents.description import Variable
from sigmafmu.markdown import markdown_table
from sigmafmu.mechanism_file.table import joints

if TYPE_CHECKING:
    from matplotlib.figure import Figure

ROOT = Path(__file__).resolve().parents[3]
DEFINITION, LAWS, FORCES = "fmu_src/model/definition.h", "fmu_src/model/elements", "fmu_src/multibody/forces"
SECTIONS = {
    "joints": ("Joints", "J", "[How joints work](joints.md): reactions, counting of turns, initial values."),
    ACTING: ("On coordinates of joints", "J", "Keys of a joint; [more](joints.md#on-every-coordinate)."),
    "forces": ("Forces", "F", "[More on each](forces.md), with defaults and limits."),
    "loads": ("Loads", "L", ""),
    "couplings": (
        "Couplings",
        "C",
        "[More](joints.md#couplings-of-coordinates). i counts the coordinates: torques are on angles, forces on "
        "displacements.",
    ),
    "drives": ("Drives", "J", "Numbers, tables or inputs: [more](joints.md#drives)."),
    "motions": ("Moving frames", "M", "Tables or inputs: [more](joints.md#drives)."),
    "sensors": ("Sensors", "S", "[More](sensors.md)."),
}
"""Title, what stands for the name of an element in names of variables, and where there is more."""
FILES = {
    "joints": "fmu_src/multibody/constraints/joint.h",
    "couplings": "fmu_src/model/elements/coupling.h",
    "drives": "fmu_src/multibody/constraints/drive.h",
    "motions": "fmu_src/multibody/moving_frame.h",
    "sensors": "fmu_src/model/sensor.h",
    "motor": "fmu_src/model/elements/rotation_motor.h",
}
"""Where the law of a section, or of an element, stands if not in a file of its name."""
CONTACT = "fmu_src/multibody/forces/contact_law.h"
CONTACTS = ("plane_contact", "sphere_contact", "cloud_contact")
"""They share a law, which is shown with the first."""
COORDINATES = {"An angle": "revolute", "A displacement": "prismatic"}
"""Joints with one of these alone."""
USUAL = 0.75
"""What so many of a section have is told once."""
EXAMPLES = re.compile(r"\b(\w+Shaft|rail|hinge)\b")
"""Names of joints of the examples, in meanings."""
HERTZ = "H. Hertz, J. reine angew. Math. 92 (1882) 156; K. H. Hunt, F. R. E. Crossley, J. Appl. Mech. 42 (1975) 440"
LITERATURE = dict.fromkeys(CONTACTS, HERTZ) | {
    "table_spring": "F. N. Fritsch, J. Butland, SIAM J. Sci. Stat. Comput. 5 (1984) 300"
}
Row = tuple[str, str, str, str]
"""Of a table of variables: name, unit, what it is, meaning."""
WIDTH = 420
"""Of figures, in pixels."""
INTRODUCTION = """\
# Elements

Written by `python -m research catalogue`: what mechanisms are made of, one by one. Laws are the comments above the
definitions in C++, variables those of an FMU with the element; `J`, `F`, … stand for its name. Keys, their units and
defaults are on the page of [mechanism files](mechanism-file.md#all-keys), costs on that of
[steps](speed.md#what-elements-cost), and [beside other codes](comparison.md) they are compared.
"""


def write(page: Path) -> None:
    """The page, and its figures in a folder of its name beside it."""
    folder = page.with_suffix("")
    folder.mkdir(parents=True, exist_ok=True)
    for old in folder.glob("*.png"):
        old.unlink()
    for element in examples.elements():
        figure(element, folder / f"{element.id}.png")
    page.write_text(text(), encoding="utf-8")


def text() -> str:
    """The page."""
    return "\n".join(_parts()).rstrip() + "\n"


def _parts() -> Iterator[str]:
    yield INTRODUCTION
    for section in dict.fromkeys(element.section for element in examples.elements()):
        yield from _section(section)


def _section(section: str) -> Iterator[str]:
    """What all of it have in common, and each element."""
    title, letter, more = SECTIONS.get(section, (section.capitalize(), section[0].upper(), ""))
    members = [element for element in examples.elements() if element.section == section]
    yield f"## {title}\n"
    if more:
        yield f"{more}\n"
    variables = {element.name: new_variables(element) for element in members}
    told: set[Row] = set()
    for lacking, rows in _common(variables):
        told |= {*rows}
        yield f"All{_but(lacking)} have\n\n{_table(rows, letter)}"
    if section == "joints":
        for what, joint in COORDINATES.items():
            rows = [row for row in variables[joint] if row not in told]
            meanings = {row[-1] for row in rows}
            told |= {row for others in variables.values() for row in others if row[-1] in meanings}
            yield f"{what} has\n\n{_table(rows, letter)}"
    laws = {element.name: law_of(element) for element in members}
    shared = Law(_same([law.lines for law in laws.values()]), _same([law.files for law in laws.values()]))
    if shared.lines:
        yield _quoted(shared.lines)
    if shared.files:
        yield f"Source: {_links(shared.files)}.\n"
    for element in members:
        law = laws[element.name]
        own = Law([] if shared.lines else law.lines, [] if shared.files else law.files)
        yield from _element(element, [row for row in variables[element.name] if row not in told], own, letter)


def _same(lists: list[list[Any]]) -> list[Any]:
    """What several elements have alike; nothing if they do not, or if there is one."""
    return lists[0] if len(lists) > 1 and lists.count(lists[0]) == len(lists) else []


def _common(variables: dict[str, list[Row]]) -> list[tuple[tuple[str, ...], list[Row]]]:
    """Rows that most elements have, by those that do not."""
    if len(variables) < 3:
        return []
    found: dict[tuple[str, ...], list[Row]] = {}
    for row in dict.fromkeys(row for rows in variables.values() for row in rows):
        lacking = tuple(name for name, rows in variables.items() if row not in rows)
        if len(lacking) <= (1 - USUAL) * len(variables):
            found.setdefault(lacking, []).append(row)
    return [*found.items()]


def _but(names: tuple[str, ...]) -> str:
    return " but " + ", ".join(f"`{name}`" for name in names) if names else ""


def _element(element: Element, rows: list[Row], law: Law, letter: str) -> Iterator[str]:
    yield f"### `{element.name}`\n"
    meaning = element.meaning[0].upper() + element.meaning[1:]
    yield f"![{element.name}](elements/{element.id}.png)\n"
    yield f"{meaning}.\n"
    if law.lines:
        yield _quoted(law.lines)
    if element.section == "joints" and (free := joints.JOINT_TYPES[element.name].coordinates):
        yield f"Coordinates: {', '.join(f'`{letter}.{c.word}`' for c in free)}.\n"
    if rows:
        yield _table(rows, letter)
    if law.files:
        literature = f"; {LITERATURE[element.name]}" if element.name in LITERATURE else ""
        yield f"Source: {_links(law.files)}{literature}.\n"


def _quoted(lines: list[str]) -> str:
    """As they are."""
    return "".join(f"    {line}".rstrip() + "\n" for line in lines)


def _links(files: list[Path]) -> str:
    """To files of the repository, by folder and name."""
    return ", ".join(f"[{path.parent.name}/{path.name}](../{path.relative_to(ROOT).as_posix()})" for path in files)


def _table(rows: list[Row], letter: str) -> str:
    return markdown_table(
        ("variable", "unit", "", "meaning"),
        [(f"`{letter}.{name}`", unit, kind, meaning) for name, unit, kind, meaning in rows],
    )


# --- variables -------------------------------------------------------------------------------------------------------


@cache
def _variables(element: Element, present: bool) -> tuple[Variable, ...]:
    content = examples.load(examples.mechanism(element, present)).definition
    return tuple(packing.describe(json.dumps(content), Path()).variables)


def new_variables(element: Element) -> list[Row]:
    """Name without the element's own, unit, what it is, and meaning of what an FMU has with the element alone."""
    before = {variable.name for variable in _variables(element, False)}
    rows: dict[str, list[Variable]] = {}
    for variable in _variables(element, True):
        if variable.name not in before:
            rows.setdefault(variable.vector.partition(".")[2], []).append(variable)
    found = [_row(name, variables) for name, variables in rows.items()]
    if element.section == "couplings":  # the like for each of its coordinates
        found = [(re.sub(r"\d$", "i", name), *more) for name, *more in found]
    return [*dict.fromkeys(found)]


def _row(name: str, variables: list[Variable]) -> Row:
    first = variables[0]
    span = f"[1..{len(variables)}]" if "[" in first.name else ""
    tunable = first.causality == "parameter" and first.variability == "tunable"
    kind = "tunable parameter" if tunable else first.causality
    return name + span, _unit(first["unit"]), kind, EXAMPLES.sub("that joint", first.description).rstrip(": ")


def _unit(unit: str) -> str:
    return re.sub(r"([a-z])2", r"\1²", unit).replace(".", " ")


# --- laws ------------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Law:
    """Lines of it, and the files that have it and what follows from it; both may be empty."""

    lines: list[str]
    files: list[Path]


def law_of(element: Element) -> Law:
    """Of the comments in the definition of an element."""
    if element.section == "joints":
        return Law([_joint_law(element.name)], [ROOT / DEFINITION, ROOT / FILES["joints"]])
    special = FILES.get(element.name) or FILES.get(element.section)
    places = [f"{folder}/{element.name.removesuffix('s')}.h" for folder in (LAWS, FORCES)]
    files = [path for name in ([special] if special else places) if (path := ROOT / name).exists()]
    lines = comment_of(files[0]) if files else []
    if element.name in CONTACTS:
        files.append(ROOT / CONTACT)
        lines += ["", *comment_of(files[-1])] if element.name == CONTACTS[0] else ["", f"Force: as of {CONTACTS[0]}."]
    return Law(lines, files)


def comment_of(path: Path) -> list[str]:
    """The comment at the top of a file."""
    lines = []
    for line in path.read_text(encoding="utf-8").splitlines():
        if not line.startswith("//"):
            break
        lines.append(line.removeprefix("//").removeprefix(" "))
    return lines


def _joint_law(name: str) -> str:
    """What it holds, as the enumeration of joints says."""
    definition = (ROOT / DEFINITION).read_text(encoding="utf-8")
    enumeration = re.search(r"enum class JointType \{(.*?)\};", definition, re.DOTALL)
    found = enumeration and re.search(rf"^\s*{name},?\s*// (.*)$", enumeration[1], re.MULTILINE)
    return found[1] if found else ""


# --- figures ---------------------------------------------------------------------------------------------------------


def figure(element: Element, path: Path) -> None:
    """A PNG: a curve of what acts on a coordinate, else the drawing of a mechanism with the element."""
    from PIL import Image

    if element.name in CURVES:
        CURVES[element.name](element).savefig(path, metadata={"Software": None})
    else:
        from sigmafmu.contents.draw import draw_figure

        mechanism = examples.load(examples.mechanism(element)).mechanism
        draw_figure(json.loads(_core.to_json(mechanism)), path.parent).save(path)
    with Image.open(path) as image:
        small = image.convert("RGB")
        small.thumbnail((WIDTH, WIDTH), Image.Resampling.LANCZOS)
        small.quantize(64, dither=Image.Dither.NONE).save(path, optimize=True)


def _curve(
    element: Element, output: str, label: str, by: str, values: np.ndarray, others: dict[str, float] | None = None
) -> Figure:
    """An output over an initial value of the hinge, for other values of another one."""
    from matplotlib.figure import Figure

    plot = Figure(figsize=(4.2, 2.6), dpi=100, layout="constrained")
    axes = plot.add_subplot()
    name, _, unit = by.partition("|")
    for other, x in (others or {"": 0.0}).items():
        rows = []
        for value in values:
            slave = _core.Slave(examples.load(examples.mechanism(element)).mechanism)
            slave.set(f"hinge.{name}", float(value))
            if other:
                slave.set("hinge.initialAngularRate", x)
            slave.start()
            rows.append(slave.get(f"hinge.{output}"))
        axes.plot(values, rows, label=other)
    axes.set(xlabel=unit, ylabel=label)
    axes.grid(alpha=0.3)
    if others:
        axes.legend(fontsize=8)
    return plot


CURVES: dict[str, Callable[[Element], Figure]] = {
    "joint_springs": lambda e: _curve(
        e, "springTorque", "torque [N m]", "initialAngle|angle [rad]", np.linspace(-1, 3, 41)
    ),
    "joint_frictions": lambda e: _curve(
        e, "frictionTorque", "torque [N m]", "initialAngularRate|rate [rad/s]", np.linspace(-4, 4, 161)
    ),
    "joint_stops": lambda e: _curve(
        e,
        "stopTorque",
        "torque [N m]",
        "initialAngle|angle [rad]",
        np.linspace(0.49, 0.52, 61),
        {"inwards at 1 rad/s": 1.0, "at rest": 0.0, "outwards": -1.0},
    ),
}
"""Of a key of a joint → what its law looks like."""
