"""The command `sigmafmu`."""

import sys
from pathlib import Path
from typing import Annotated

import typer
from rich.markup import escape

import sigmafmu
from sigmafmu import SigmafmuError
from sigmafmu.console import (
    ModelName,
    OneLineErrors,
    agreed,
    err,
    out,
    progress_bar,
    show_message,
    split_setting,
    write_text,
)
from sigmafmu.importers.cli import register as register_importers
from sigmafmu.linear_cli import register as register_linear
from sigmafmu.loop.cli import register as register_loop
from sigmafmu.loop.coupling_cli import register as register_coupling
from sigmafmu.mechanism_file.cli import register as register_mechanism_file
from sigmafmu.modes.cli import register as register_modes
from sigmafmu.sigma_cli import register as register_sigma
from sigmafmu.sweeps.cli import register as register_sweep
from sigmafmu.view.cli import register as register_view

app = typer.Typer(cls=OneLineErrors, no_args_is_help=True, add_completion=False, rich_markup_mode="rich")

PLOTTED_ROWS = 20_000
"""A figure shows no more; a longer run is written row by row and thinned out for the figure."""


def _show_version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"sigmafmu {sigmafmu.__version__}")
        raise typer.Exit


@app.callback(epilog="Example: sigmafmu run HeavyTop --plot top.png")
def main(
    version: Annotated[
        bool, typer.Option("--version", callback=_show_version, is_eager=True, help="Print the version and exit.")
    ] = False,
) -> None:
    """Multibody mechanisms as FMI 2.0 co-simulation FMUs."""


@app.command("list", epilog="Example: sigmafmu list")
def list_models() -> None:
    """List the models with a line about each."""
    names = sigmafmu.models()
    if not names:
        raise SigmafmuError(f"there are no FMUs in {sigmafmu.fmus_dir()}")
    for name in names:
        description = sigmafmu.load(name).description
        out.print(f"[cyan]{name:<{max(map(len, names))}}[/cyan]  {escape(description)}", soft_wrap=True)


@app.command(epilog="Example: sigmafmu path HeavyTop")
def path(model: Annotated[str, typer.Argument(metavar="MODEL", help="Name of a model, see `sigmafmu list`.")]) -> None:
    """Print the path of a model's FMU, for scripts and other masters."""
    typer.echo(sigmafmu.fmu_path(model))


@app.command(epilog="Example: sigmafmu info SliderCrank --all --descriptions | less")
def info(
    model: ModelName,
    every: Annotated[bool, typer.Option("--all", help="One line for every scalar variable.")] = False,
    descriptions: Annotated[bool, typer.Option("--descriptions", "-v", help="Tell what each variable means.")] = False,
) -> None:
    """Describe a model: capabilities, parameters, integrator settings, inputs and outputs."""
    from sigmafmu.info import every_variable, summary

    out.print((every_variable if every else summary)(sigmafmu.load(model).fmu, descriptions))


@app.command(
    epilog="Example: sigmafmu run HeavyTop --stop-time 2 --set integrator.formulation=index3 "
    "--set integrator.sigma=1.6 --set gravity=0,0,-1.62 --output out.csv --plot out.png"
)
def run(
    model: ModelName,
    stop_time: Annotated[float | None, typer.Option(help="Seconds to simulate; default: the model's own.")] = None,
    step_size: Annotated[float | None, typer.Option(help="Communication step in s; default: the model's own.")] = None,
    settings: Annotated[
        list[str] | None,
        typer.Option("--set", metavar="NAME=VALUE", help="Set a parameter or input; enumerations by item name."),
    ] = None,
    variables: Annotated[
        list[str] | None,
        typer.Option(metavar="PATTERN", help="Record only these, e.g. 'top.*' (repeatable); default: all outputs."),
    ] = None,
    output: Annotated[Path | None, typer.Option(metavar="CSV", help="Write the recorded variables here.")] = None,
    plot: Annotated[
        Path | None, typer.Option(metavar="PNG", help="Draw here: what matters, or the variables that are named.")
    ] = None,
    animation: Annotated[
        Path | None, typer.Option("--animate", metavar="HTML", help="Write a page here that shows the motion.")
    ] = None,
    phase: Annotated[
        Path | None, typer.Option(metavar="PNG", help="Draw rates of joint coordinates over the coordinates here.")
    ] = None,
    yes: Annotated[bool, typer.Option("--yes", help="Do not ask before a run of over ten minutes or 1 GB.")] = False,
) -> None:
    """Simulate a model, and write or plot its variables."""
    from sigmafmu.estimate import cost
    from sigmafmu.result import CsvWriter
    from sigmafmu.steps import communication_steps

    for file in (output, plot, phase, animation):
        if file and not file.absolute().parent.is_dir():
            raise SigmafmuError(f"cannot write {file}: there is no folder {file.parent}")
    values, names = dict(split_setting(s) for s in settings or ()), variables or ()
    loaded = sigmafmu.load(model)
    expected = cost(loaded, stop_time, step_size, values, names, output)
    if expected.is_large and not agreed(f"this run takes {expected}", yes):
        raise SigmafmuError(f"not run: it takes {expected}; --yes runs it all the same")
    steps = communication_steps(loaded.fmu, stop_time, step_size)
    keep_every = -(-len(steps) // PLOTTED_ROWS)
    failure, result = None, None
    with progress_bar(err, loaded.name, steps.end) as move_to, CsvWriter(output or Path()) as writer:
        try:
            result = loaded.run(
                stop_time,
                step_size=step_size,
                parameters=values,
                outputs=names,
                keep_every=keep_every,
                on_rows=writer.write if output else None,
                on_time=move_to,
                on_message=show_message,
            )
        except sigmafmu.SimulationError as error:
            failure, result = error, error.result
    if result:
        out.print(result.summary(), soft_wrap=True)
        if output:
            out.print(f"wrote {output} ({writer.rows} rows, {len(result.names)} variables)", soft_wrap=True)
        thinned = f" (every {keep_every}th row)" if keep_every > 1 else ""
        for picture in (plot, phase):
            if picture:
                result.plot(picture, names and result.names, phase=picture is phase)
                out.print(f"wrote {picture}{thinned}", soft_wrap=True)
        if animation:
            from sigmafmu.view.cli import write_page
            from sigmafmu.view.subject import scene_of_fmu

            write_page(scene_of_fmu(loaded.fmu), result, animation, tuple(names))
    if failure:
        raise failure


@app.command(epilog="Example: sigmafmu demo --output demo")
def demo(
    output: Annotated[Path, typer.Option(metavar="FOLDER", help="Folder for the plots and CSV files.")] = Path("demo"),
) -> None:
    """Run HeavyTop and SliderCrank, compare them with the reference and draw plots."""
    from sigmafmu.demo import run_demo

    for file in run_demo(output, out):
        out.print(f"wrote {file}", soft_wrap=True)


@app.command(epilog="Example: sigmafmu realtime HeavyTop --rate 1000 --duration 10 --plot latency.png")
def realtime(
    model: ModelName,
    rate: Annotated[float, typer.Option(metavar="HZ", help="Communication steps per second.")] = 1000.0,
    duration: Annotated[float, typer.Option(metavar="SECONDS", help="Length of the run.")] = 5.0,
    settings: Annotated[list[str] | None, typer.Option("--set", metavar="NAME=VALUE", help="A parameter.")] = None,
    plot: Annotated[Path | None, typer.Option(metavar="FILE", help="Write a histogram as PNG.")] = None,
    seen: Annotated[bool, typer.Option("--view", help="Show the motion in the browser while it runs.")] = False,
) -> None:
    """Pace fmi2DoStep with the wall clock and show how long the steps take."""
    from sigmafmu.realtime import run as run_paced

    parameters = dict(map(split_setting, settings or []))
    if seen:
        from sigmafmu.view.cli import live_view

        loaded, live = live_view(model)
        latency = run_paced(loaded, rate, duration, parameters, live)
    else:
        latency = run_paced(sigmafmu.load(model), rate, duration, parameters)
    out.print(latency.table())
    if plot:
        latency.plot(plot)
        out.print(f"wrote {plot}", soft_wrap=True)


@app.command(epilog="Example: sigmafmu compat --output docs/compatibility.md")
def compat(
    chosen: Annotated[
        list[str] | None, typer.Option("--tool", metavar="NAME", help="Only this tool (repeatable); default: all.")
    ] = None,
    output: Annotated[Path | None, typer.Option(metavar="FILE", help="Write the result as Markdown.")] = None,
    yes: Annotated[bool, typer.Option("--yes", help="Do not ask before tools are downloaded.")] = False,
) -> None:
    """Check and simulate every FMU with other people's tools (those of the extra `masters`, and two that need Java)."""
    from sigmafmu import compat as compatibility

    models, tools = sigmafmu.models(), compatibility.choose(chosen or ())
    absent = [tool for tool in tools if tool.download()]
    if absent and agreed(f"this downloads {', '.join(str(tool.download()) for tool in absent)}", yes):
        for tool in absent:
            err.print(f"downloading {tool.download()}", soft_wrap=True)
            tool.fetch()
    total = len(models) * len(tools)
    with progress_bar(err, "compat", total, unit="checks") as move_to:
        done = iter(range(1, total + 1))
        columns = compatibility.check(models, tools, lambda: move_to(next(done)))
    out.print(compatibility.table(models, columns))
    for note in compatibility.notes(columns):
        out.print(note, soft_wrap=True)
    if output:
        write_text(output, compatibility.page(models, columns))


register_linear(app)
register_importers(app)
register_loop(app)
register_coupling(app)
register_mechanism_file(app)
register_modes(app)
register_sigma(app)
register_sweep(app)
register_view(app)

if __name__ == "__main__":
    sys.exit(app())
