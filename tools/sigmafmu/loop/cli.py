"""The commands `sigmafmu loop` and `sigmafmu ssp`."""

from pathlib import Path
from typing import Annotated

import typer

from sigmafmu.console import out, split_setting

LoopName = Annotated[str, typer.Argument(metavar="MODEL", help="SliderCrank, HighSpeedRotor or HeavyTop.")]
Settings = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="NAME=VALUE", help="A parameter of the model, or controller.NAME (repeatable)."),
]


def register(app: typer.Typer) -> None:
    """Add the commands to `app`."""
    app.command(epilog="Example: sigmafmu loop SliderCrank --set controller.setPoint=8 --plot loop.png")(loop)
    app.command(epilog="Example: sigmafmu ssp SliderCrank --output crank.ssp")(ssp)


def loop(
    model: LoopName,
    step: Annotated[float | None, typer.Option(metavar="SECONDS", help="Sampling period; default: the loop's.")] = None,
    stop_time: Annotated[float | None, typer.Option(help="Seconds to simulate; default: the loop's own.")] = None,
    settings: Settings = None,
    hold: Annotated[str, typer.Option(help="Inputs between samples: 'zero' (constant) or 'linear'.")] = "zero",
    delay: Annotated[int, typer.Option(min=0, help="Samples until the controller's answer reaches the model.")] = 0,
    output: Annotated[Path | None, typer.Option(metavar="CSV", help="Write the controlled run here.")] = None,
    plot: Annotated[Path | None, typer.Option(metavar="PNG", help="Draw both runs here.")] = None,
) -> None:
    """Run a model with its controller and without, and show what the controller achieves."""
    from rich import box
    from rich.table import Table

    from sigmafmu.loop import loops
    from sigmafmu.loop.closed_loop import off, run_closed_loop, split_start_values
    from sigmafmu.loop.performance import PERFORMANCE

    chosen = loops.find(model)
    start_values = _start_values(settings)
    own = f"{loops.CONTROLLER}."
    others = {name: value for name, value in start_values.items() if not name.startswith(own)}
    closed = run_closed_loop(chosen, step, stop_time, hold=hold, delay=delay, start_values=start_values)
    uncontrolled = run_closed_loop(chosen, step, stop_time, off, hold=hold, delay=delay, start_values=others)

    values = split_start_values(chosen, start_values)[1][loops.CONTROLLER]
    law = chosen.parts[loops.CONTROLLER].law(**values)
    title = f"{model}: {closed.time[-1]:g} s in samples of {closed.time[1]:g} s"
    table = Table("", title=title, title_justify="left", box=box.SIMPLE_HEAD)
    for column in (type(law).__name__, "controller off"):
        table.add_column(column, justify="right")
    measure = PERFORMANCE[model]
    for with_law, without in zip(measure(closed, law), measure(uncontrolled, law), strict=True):
        table.add_row(with_law.label, str(with_law), str(without))
    out.print(table)
    if output:
        closed.to_csv(output)
        out.print(f"wrote {output}", soft_wrap=True)
    if plot:
        from sigmafmu.loop.figures import plot as draw

        draw(closed, uncontrolled, law, plot)
        out.print(f"wrote {plot}", soft_wrap=True)


def ssp(
    model: LoopName,
    output: Annotated[Path, typer.Option(metavar="SSP", help="File to write.")],
    settings: Settings = None,
) -> None:
    """Write a model and its controller as an SSP system for other masters (needs the extra `loop`)."""
    from sigmafmu.loop import loops
    from sigmafmu.loop.ssp import write_ssp

    write_ssp(loops.find(model), output, _start_values(settings))
    out.print(f"wrote {output}", soft_wrap=True)


def _start_values(settings: list[str] | None) -> dict[str, str]:
    return dict(map(split_setting, settings or []))
