"""The commands `sigmafmu linearize`, `campbell` and `trim`."""

import json
from enum import Enum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from sigmafmu import SigmafmuError
from sigmafmu.console import ModelName, err, out, progress_bar, split_setting

if TYPE_CHECKING:
    from sigmafmu.linear import LinearModel, OperatingPoint

Frame = Enum("Frame", {name: name for name in ("world", "body")}, type=str)

At = Annotated[float, typer.Option(metavar="TIME", help="Time of the motion in s.")]
Settings = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="NAME=VALUE", help="A parameter or a constant input, as in `run`."),
]
Free = Annotated[list[str] | None, typer.Option(metavar="INPUT", help="An input that the search for rest may change.")]
Hold = Annotated[
    list[str] | None,
    typer.Option(metavar="NAME=VALUE", help="An output that has this value at rest, or a rate in a steady motion."),
]
Axes = Annotated[Frame, typer.Option(help="Axes in which rotations of bodies are measured.")]


def register(app: typer.Typer) -> None:
    """Add the commands to `app`."""
    app.command(
        epilog="Example: sigmafmu linearize SliderCrank --at 0.3 --input crankPivot.motorTorque "
        "--output guide.displacement --file crank.npz"
    )(linearize)
    app.command(
        epilog="Example: sigmafmu campbell HighSpeedRotor --rate 'rotor.angularVelocityW[1]' --to 600 "
        "--set 'load.torque[3]=0' --plot campbell.png"
    )(campbell)
    app.command(
        epilog="Example: sigmafmu trim SliderCrank --free crankPivot.motorTorque --hold crankPivot.angle=0.5 "
        "--file start.json"
    )(trim)


def campbell(
    model: ModelName,
    rate: Annotated[
        str, typer.Option(metavar="RATE", help="Rate of the coordinate that spins, such as rotor.angularVelocityW[1].")
    ],
    highest: Annotated[float, typer.Option("--to", metavar="SPEED", help="Highest speed in rad/s.")],
    lowest: Annotated[float, typer.Option("--from", metavar="SPEED", help="Lowest speed in rad/s.")] = 0.0,
    points: Annotated[int, typer.Option(min=2, help="Speeds; poles are followed from one to the next.")] = 41,
    settings: Settings = None,
    plot: Annotated[Path | None, typer.Option(metavar="PNG", help="Draw frequencies over the speed here.")] = None,
    output: Annotated[Path | None, typer.Option(metavar="CSV", help="Write poles and whirl over the speed.")] = None,
) -> None:
    """Frequencies of a rotor over its speed, and its critical speeds."""
    import numpy as np

    import sigmafmu

    loaded = sigmafmu.load(model)
    if not (np.isfinite([lowest, highest]).all() and 0 <= lowest < highest):
        raise SigmafmuError(f"--from {lowest:g} --to {highest:g}: speeds must be finite, not negative, and increase")
    speeds = np.linspace(lowest, highest, points)
    with progress_bar(err, loaded.name, highest, unit="rad/s") as move_to:
        found = loaded.campbell(rate, speeds, parameters=dict(map(split_setting, settings or [])), on_speed=move_to)
    if not found.critical:
        out.print(f"{found.model}: no critical speed between {lowest:g} and {highest:g} rad/s", soft_wrap=True)
    for critical in found.critical:
        out.print(f"critical: {critical}", soft_wrap=True)
    for path, save in ((plot, found.plot), (output, found.to_csv)):
        if path:
            save(path)
            out.print(f"wrote {path}", soft_wrap=True)


def linearize(
    model: ModelName,
    at: At = 0.0,
    settings: Settings = None,
    inputs: Annotated[list[str] | None, typer.Option("--input", help="An input or a vector (default: all).")] = None,
    outputs: Annotated[list[str] | None, typer.Option("--output", help="An output or a vector (default: all).")] = None,
    frame: Axes = Frame.world,
    coordinates: Annotated[
        list[str] | None, typer.Option("--coordinate", help="A coordinate that is wanted among the states.")
    ] = None,
    at_rest: Annotated[bool, typer.Option("--trim", help="Search an equilibrium first, from where it is.")] = False,
    free: Free = None,
    hold: Hold = None,
    sample_time: Annotated[float | None, typer.Option(metavar="T", help="Discrete time: inputs hold for T s.")] = None,
    file: Annotated[Path | None, typer.Option(metavar="FILE", help="Write the model: .npz, .mat or .json.")] = None,
    bode: Annotated[Path | None, typer.Option(metavar="PNG", help="Draw the frequency response.")] = None,
    pole_map: Annotated[Path | None, typer.Option(metavar="PNG", help="Draw the poles.")] = None,
) -> None:
    """Linear model of a mechanism about a point of its motion, or about an equilibrium; prints its poles."""
    from sigmafmu.linear import files, report
    from sigmafmu.linear import linearize as linearise

    if file:
        files.check(file)
    point = _point(model, at, settings, free, hold) if at_rest or free or hold else _moving(model, at, settings)
    result = linearise(point, inputs=inputs, outputs=outputs, coordinates=coordinates or (), frame=frame.value)
    if sample_time is not None:
        result = result.to_discrete(sample_time)
    out.print(report.headline(result), soft_wrap=True)
    _print_point(point, result)
    out.print(report.poles(result))
    for path, save in ((file, result.save), (bode, result.bode), (pole_map, result.pole_map)):
        if path:
            save(path)
            out.print(f"wrote {path}", soft_wrap=True)


def trim(
    model: ModelName,
    at: At = 0.0,
    settings: Settings = None,
    free: Free = None,
    hold: Hold = None,
    file: Annotated[
        Path | None, typer.Option(metavar="JSON", help="Write the values that start the FMU at rest there.")
    ] = None,
) -> None:
    """Search an equilibrium of a mechanism, or a steady motion, from where it is at a time of its motion.

    Without --hold, positions stay if there are free inputs, and are sought if there are none.
    """
    from sigmafmu.linear import linearize as linearise

    point = _point(model, at, settings, free, hold)
    result = linearise(point)
    out.print(result.title, soft_wrap=True)
    _print_point(point, result)
    growth = float(result.poles().real.max())
    if growth > 1e-3:
        out.print(f"unstable: neighbours leave with {growth:.4g} 1/s", soft_wrap=True)
    if file:
        try:
            file.write_text(json.dumps(point.start_values(), indent=1) + "\n", encoding="utf-8")
        except OSError as error:
            raise SigmafmuError(f"cannot write {file}: {error.strerror}") from error
        out.print(f"wrote {file}", soft_wrap=True)


def _moving(model: str, at: float, settings: list[str] | None) -> "OperatingPoint":
    from sigmafmu.linear import operating_point

    with progress_bar(err, model, at) as move_to:
        return operating_point(model, at, parameters=dict(map(split_setting, settings or [])), on_time=move_to)


def _point(
    model: str, at: float, settings: list[str] | None, free: list[str] | None, hold: list[str] | None
) -> "OperatingPoint":
    from sigmafmu.linear import trim as search

    return search(
        model,
        at,
        parameters=dict(map(split_setting, settings or [])),
        inputs=free or (),
        hold=dict(map(_held, hold or [])),
    )


def _held(text: str) -> tuple[str, float]:
    name, equals, value = text.partition("=")
    try:
        if not (name and equals):
            raise ValueError
        return name.strip(), float(value)
    except ValueError:
        raise SigmafmuError(f"--hold {text}: write it as NAME=NUMBER, for example crankPivot.angle=0.5") from None


def _print_point(point: "OperatingPoint", model: "LinearModel") -> None:
    from sigmafmu.linear import report

    out.print(report.states(model))
    if values := report.inputs(point):
        out.print(values, soft_wrap=True)
    for warning in report.warnings(model):
        err.print(f"warning: {warning}", style="yellow", markup=False, soft_wrap=True)
