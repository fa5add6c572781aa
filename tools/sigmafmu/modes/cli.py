"""The commands `sigmafmu modes …`."""

from enum import Enum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.markup import escape

from sigmafmu import SigmafmuError
from sigmafmu.console import out

if TYPE_CHECKING:
    from sigmafmu.modes.data import ModalData

Theory = Enum("Theory", {name: name for name in ("bernoulli", "timoshenko")}, type=str)
Boundary = Enum("Boundary", {name: name for name in ("clamped", "pinned", "fixed", "free")}, type=str)
Shape = Enum("Shape", {name: name for name in ("polynomial", "sine")}, type=str)
Method = Enum("Method", {name: name for name in ("craig-bampton", "fixed", "free")}, type=str)
Frame = Enum("Frame", {name: name for name in ("first", "free")}, type=str)
Scale = Enum("Scale", {name: name for name in ("mass", "displacement", "none")}, type=str)

Output = Annotated[Path | None, typer.Option(metavar="JSON", help="Write the modal data here.")]
Plot = Annotated[Path | None, typer.Option(metavar="PNG", help="Draw the mode shapes here.")]
Damping = Annotated[str | None, typer.Option(metavar="A,B", help="Rayleigh damping A M + B K, in 1/s and s.")]
Scaling = Annotated[
    Scale, typer.Option(help="Orthonormal in mass, or the largest displacement is 1 m, or as they come.")
]

modes = typer.Typer(no_args_is_help=True, rich_markup_mode="rich")


def register(app: typer.Typer) -> None:
    """Add the commands to `app`."""
    app.add_typer(modes, name="modes")


@modes.callback(epilog="Example: sigmafmu modes beam --length 1 --rectangle 0.02,0.03 --output beam.json")
def main() -> None:
    """Modal data of flexible bodies: from a beam, from shape functions or from FE matrices."""
    import scipy  # noqa: F401, without it a command fails here and not half way


@modes.command(
    epilog="Example: sigmafmu modes beam --length 1 --rectangle 0.02,0.03 --boundary free --bending 3,3 --torsion 1 "
    "--output beam.json --plot beam.png"
)
def beam(
    length: Annotated[float, typer.Option(help="In m.")],
    rectangle: Annotated[str | None, typer.Option(metavar="Y,Z", help="Sizes of a rectangular section in m.")] = None,
    diameter: Annotated[float | None, typer.Option(help="Diameter of a circular section in m.")] = None,
    youngs_modulus: Annotated[float, typer.Option("--E", help="Young's modulus in N/m²; default: steel.")] = 210e9,
    nu: Annotated[float, typer.Option(help="Poisson's ratio.")] = 0.3,
    density: Annotated[float, typer.Option(help="In kg/m³.")] = 7850.0,
    elements: Annotated[int, typer.Option(help="Number of elements.")] = 10,
    theory: Annotated[Theory, typer.Option(help="With or without shear.")] = Theory.timoshenko,
    boundary: Annotated[
        Boundary, typer.Option(help="What the floating frame holds: the end at 0, both ends, or nothing.")
    ] = Boundary.clamped,
    bending: Annotated[str, typer.Option(metavar="Y,Z", help="Number of modes that bend in y and in z.")] = "2,2",
    torsion: Annotated[int, typer.Option(help="Number of torsional modes.")] = 0,
    axial: Annotated[int, typer.Option(help="Number of modes that stretch.")] = 0,
    section_nodes: Annotated[int, typer.Option(help="4, or 5 with one on the axis.")] = 4,
    origin: Annotated[float, typer.Option(help="Origin of the frame on the axis, in parts of the length.")] = 0.0,
    scale: Scaling = Scale.mass,
    damping: Damping = None,
    output: Output = None,
    plot: Plot = None,
) -> None:
    """A straight uniform beam along x, from beam elements."""
    from sigmafmu.modes.beam import beam_modes
    from sigmafmu.modes.section import Section

    if (rectangle is None) == (diameter is None):
        raise SigmafmuError("the section is missing or given twice; give either --rectangle Y,Z or --diameter")
    section = Section.rectangle(*_pair("--rectangle", rectangle)) if rectangle else Section.circle(diameter)
    data = beam_modes(
        length,
        section,
        E=youngs_modulus,
        nu=nu,
        density=density,
        elements=elements,
        theory=theory.value,
        boundary=boundary.value,
        bending=_counts("--bending", bending),
        torsion=torsion,
        axial=axial,
        section_nodes=section_nodes,
        origin=origin,
    )
    _finish(data, scale, damping, output, plot)


@modes.command(
    epilog="Example: sigmafmu modes shapes polynomial --length 1 --mass 1 --stiffness 8,12 --half-size 0.02,0.02 "
    "--output beam.json"
)
def shapes(
    shape: Annotated[Shape, typer.Argument(metavar="polynomial|sine", help="Of a cantilever, or of two supports.")],
    length: Annotated[float, typer.Option(help="In m.")],
    mass: Annotated[float, typer.Option(help="In kg.")],
    stiffness: Annotated[str, typer.Option(metavar="Y,Z", help="EI for bending in y and in z, in N m².")],
    half_size: Annotated[str, typer.Option(metavar="Y,Z", help="The nodes of a section are at ±Y, ±Z in m.")],
    bending: Annotated[str, typer.Option(metavar="Y,Z", help="Number of functions in y and in z.")] = "2,2",
    sections: Annotated[int, typer.Option(help="Number of sections.")] = 11,
    scale: Scaling = Scale.none,
    damping: Damping = None,
    output: Output = None,
    plot: Plot = None,
) -> None:
    """A beam with the shape functions ξ², ξ³, … or sin πξ, sin 2πξ, …"""
    from sigmafmu.modes.shapes import shape_modes

    data = shape_modes(
        shape.value,
        length,
        mass,
        EI=_pair("--stiffness", stiffness),
        half_size=_pair("--half-size", half_size),
        modes=_counts("--bending", bending),
        sections=sections,
    )
    _finish(data, scale, damping, output, plot)


@modes.command(
    epilog="Example: sigmafmu modes fe --stiffness K.mtx --mass M.mtx --nodes nodes.csv --method craig-bampton "
    "--interface 0-8 --interface 450-458 --rigid-interfaces --modes 6 --output body.json"
)
def fe(
    stiffness: Annotated[Path, typer.Option(metavar="FILE", help="Of the free body: .mtx, .mtx.gz, .npz or .npy.")],
    mass: Annotated[Path, typer.Option(metavar="FILE", help="Mass matrix, likewise.")],
    nodes: Annotated[Path, typer.Option(metavar="FILE", help="Coordinates x, y, z, a node a line: .csv, .txt, .npy.")],
    method: Annotated[Method, typer.Option(help="Which modes.")] = Method.free,
    interface: Annotated[
        list[str] | None, typer.Option(metavar="NODES", help="Nodes from 0, as 0-8,12 (one option per interface).")
    ] = None,
    rigid_interfaces: Annotated[bool, typer.Option("--rigid-interfaces", help="Interfaces move rigidly.")] = False,
    frame: Annotated[
        Frame, typer.Option(help="Craig-Bampton: the frame is on the first interface, or free.")
    ] = Frame.first,
    count: Annotated[int, typer.Option("--modes", help="Number of vibration modes.")] = 6,
    scale: Scaling = Scale.mass,
    damping: Damping = None,
    output: Output = None,
    plot: Plot = None,
) -> None:
    """A body of solid elements, from its matrices; displacements are ordered x₁ y₁ z₁ x₂ …"""
    from sigmafmu.modes import reduction
    from sigmafmu.modes.fe_data import read_fe

    interfaces = [_nodes(text) for text in interface or ()]
    if method is Method.free and interfaces:
        raise SigmafmuError("free modes have no interface; leave --interface out or choose another --method")
    body = read_fe(stiffness, mass, nodes)
    if method is Method.free:
        data = reduction.free_modes(body, count)
    elif method is Method.fixed:
        data = reduction.fixed_modes(body, interfaces, count)
    else:
        data = reduction.craig_bampton(body, interfaces, count, frame=frame.value, rigid=rigid_interfaces)
    _finish(data, scale, damping, output, plot)


@modes.command(epilog="Example: sigmafmu modes check beam.json --plot modes.png")
def check(
    file: Annotated[Path, typer.Argument(metavar="JSON", help="File of modal data.")],
    plot: Plot = None,
) -> None:
    """Check a file of modal data and tell what is in it."""
    from sigmafmu.modes.file import read

    _show(read(file), plot)


def _finish(data: "ModalData", scale: Scale, damping: str | None, output: Path | None, plot: Path | None) -> None:
    from sigmafmu.modes.checks import validate
    from sigmafmu.modes.file import write

    data = validate(data.scaled(scale.value))
    if damping:
        a, b = _pair("--damping", damping)
        if a < 0 or b < 0:
            raise SigmafmuError(f"--damping {damping}: both numbers must not be negative")
        data = data.damped(a, b)
    if output:
        write(data, output)
    _show(data, plot)
    if output:
        out.print(f"wrote {output}", soft_wrap=True)


def _show(data: "ModalData", plot: Path | None) -> None:
    from sigmafmu.modes import report

    out.print(escape(report.summary(data)), soft_wrap=True)
    out.print(report.table(data))
    if plot:
        from sigmafmu.modes.figure import draw

        draw(data, plot)
        out.print(f"wrote {plot}", soft_wrap=True)


def _pair(option: str, text: str) -> tuple[float, float]:
    try:
        first, second = map(float, text.split(","))
    except ValueError as error:
        raise SigmafmuError(
            f"{option} {text}: write two numbers with a comma between them, for example 0.02,0.03"
        ) from error
    return first, second


def _counts(option: str, text: str) -> tuple[int, int]:
    try:
        first, second = map(int, text.split(","))
    except ValueError as error:
        raise SigmafmuError(
            f"{option} {text}: write two whole numbers with a comma between them, for example 2,2"
        ) from error
    return first, second


def _nodes(text: str) -> list[int]:
    """0-8,12 → 0, 1, …, 8, 12."""
    result: list[int] = []
    try:
        for part in text.split(","):
            first, _, last = part.partition("-")
            result += range(int(first), int(last or first) + 1)
    except ValueError as error:
        raise SigmafmuError(f"--interface {text}: write nodes as 0-8,12") from error
    return result
