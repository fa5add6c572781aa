"""The commands for mechanism files: `sigmafmu init`, `check` and `build`."""

import re
from importlib.resources import files
from pathlib import Path
from typing import Annotated

import typer

from sigmafmu import SigmafmuError
from sigmafmu.console import out, write_text

MechanismPath = Annotated[Path, typer.Argument(metavar="FILE", help="A mechanism file: YAML or JSON.")]


def register(app: typer.Typer) -> None:
    """Add the commands to `app`."""
    app.command(epilog="Example: sigmafmu init Pendulum")(init)
    app.command(epilog="Example: sigmafmu check Pendulum.yaml")(check)
    app.command(epilog="Example: sigmafmu build Pendulum.yaml -o pendulum.fmu")(build)


def init(
    name: Annotated[str, typer.Argument(metavar="NAME", help="Of the mechanism and of its file.")] = "Pendulum",
) -> None:
    """Write a small mechanism file with comments, to begin with."""
    path = Path(f"{name}.yaml")
    if not re.fullmatch(r"[A-Za-z_][A-Za-z0-9_]*", name):
        raise SigmafmuError(f'"{name}" is no name of a model; allowed are letters, digits and _, no digit first')
    if path.exists():
        raise SigmafmuError(f"{path} exists; nothing was written")
    template = files("sigmafmu.mechanism_file").joinpath("example.yaml").read_text(encoding="utf-8")
    write_text(path, template.format(name=name))


def check(
    file: MechanismPath,
    plot: Annotated[Path | None, typer.Option(metavar="PNG", help="Draw the mechanism at its start here.")] = None,
) -> None:
    """Read, place and assemble a mechanism; tell its degrees of freedom, masses and what had to move."""
    from sigmafmu.mechanism_file.load import load
    from sigmafmu.mechanism_file.report import report

    mechanism = load(file)
    for line in report(mechanism):
        out.print(line, markup=False, soft_wrap=True)
    if plot:
        from sigmafmu.mechanism_file.drawing import draw

        draw(mechanism, plot)
        out.print(f"wrote {plot}", soft_wrap=True)


def build(
    file: MechanismPath,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", metavar="FMU", help="Default: the mechanism's name, here.")
    ] = None,
) -> None:
    """Make an FMU of a mechanism file; no compiler is needed."""
    from sigmafmu.packing import build_fmu

    out.print(f"wrote {build_fmu(file, output)}", soft_wrap=True)
