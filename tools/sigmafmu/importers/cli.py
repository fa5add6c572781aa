"""The command `sigmafmu convert`."""

from enum import Enum
from pathlib import Path
from typing import Annotated

import typer

from sigmafmu import SigmafmuError
from sigmafmu.console import out, write_text


class Base(str, Enum):
    """What the root of a URDF file is."""

    fixed = "fixed"
    free = "free"


def register(app: typer.Typer) -> None:
    """Add the command to `app`."""
    app.command(epilog="Example: sigmafmu convert robot.urdf -o Robot.yaml")(convert)


def convert(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="A robot: URDF, MJCF or SDF.")],
    output: Annotated[
        Path | None, typer.Option("--output", "-o", metavar="YAML", help="Default: the robot's name, here.")
    ] = None,
    base: Annotated[
        Base | None, typer.Option(help="Of URDF: whether the root is the ground; default: if it has no mass.")
    ] = None,
) -> None:
    """Make a mechanism file of a robot's description, and tell what is different or not in it."""
    from sigmafmu.importers.convert import convert as converted
    from sigmafmu.importers.robot import valid_name
    from sigmafmu.mechanism_file.load import load_text
    from sigmafmu.mechanism_file.report import report

    folder = output.parent if output else Path()
    text, robot = converted(file, folder, base.value if base else None)
    path = output or Path(f"{valid_name(robot.name)}.yaml")
    if path.exists() and output is None:
        raise SigmafmuError(f"{path} exists; -o {path} overwrites it")
    write_text(path, text)
    mechanism = load_text(text, path)
    if robot.told:
        out.print("different, or not in the file:")
        for sentence in robot.told:
            out.print(f"- {sentence}", markup=False, soft_wrap=True)
    for line in list(report(mechanism))[:2]:
        out.print(line, markup=False, soft_wrap=True)
