"""The command `sigmafmu view`, and the option --animate of `run`."""

import webbrowser
from pathlib import Path
from typing import Annotated

import typer

from sigmafmu import SigmafmuError
from sigmafmu.console import err, out, progress_bar, show_message, split_setting, write_text
from sigmafmu.result import Result


def register(app: typer.Typer) -> None:
    """Add the command to `app`."""
    app.command(epilog="Example: sigmafmu view SliderCrank --stop-time 2")(view)


def view(
    target: Annotated[
        str,
        typer.Argument(
            metavar="MODEL|FILE|FMU|CSV",
            help="What is run: a model, a mechanism file, an FMU; or a result of `run`.",
        ),
    ],
    of: Annotated[
        str | None,
        typer.Option(metavar="MODEL|FILE|FMU", help="The mechanism of a result, if its names do not tell it."),
    ] = None,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", metavar="HTML", help="Default: the mechanism's name, here.")
    ] = None,
    gltf: Annotated[
        Path | None, typer.Option(metavar="GLB", help="Write an animation for Blender and others here, and no page.")
    ] = None,
    opened: Annotated[bool, typer.Option("--open/--no-open", help="Show the page in the browser.")] = True,
    stop_time: Annotated[float | None, typer.Option(help="Seconds to simulate; default: the model's own.")] = None,
    step_size: Annotated[float | None, typer.Option(help="Communication step in s; default: the model's own.")] = None,
    settings: Annotated[
        list[str] | None, typer.Option("--set", metavar="NAME=VALUE", help="Set a parameter or input.")
    ] = None,
    variables: Annotated[
        list[str] | None,
        typer.Option(metavar="PATTERN", help="Plot these (repeatable); default: what moves, and energies."),
    ] = None,
) -> None:
    """Show a mechanism in motion: one HTML file that needs no network, opened in the browser."""
    from sigmafmu.simulate import SimulationError
    from sigmafmu.view.subject import mechanism_of_result, result_of, subject_of

    if not gltf:
        _check_viewer()
    patterns, failure = tuple(variables or ()), None
    if target.endswith(".csv"):
        result = result_of(Path(target))
        subject = subject_of(of) if of else mechanism_of_result(result, Path(target))
    else:
        subject = subject_of(target)
        values = dict(map(split_setting, settings or ()))
        try:
            result = _run(subject, target, stop_time, step_size, values, patterns)
        except SimulationError as error:  # what there is until then is worth seeing
            if error.result is None or len(error.result.time) < 2:
                raise
            failure, result = error, error.result
    if gltf:
        write_gltf(subject.scene, result, gltf)
    if output or not gltf:
        path = output or Path(f"{result.model}.html")
        write_page(subject.scene, result, path, patterns)
        if opened and not webbrowser.open(path.absolute().as_uri()):
            out.print(f"no browser was found; open {path} in one", soft_wrap=True)
    if failure:
        raise failure


def animate(source, result: Result, path: Path, patterns: tuple[str, ...] = ()) -> None:
    """Write the page of a run of an open FMU or a loaded mechanism file."""
    from sigmafmu.view.subject import drawn

    write_page(drawn(source).scene, result, path, patterns)


def write_page(scene, result: Result, path: Path, patterns: tuple[str, ...]) -> None:
    """Write the page of a result."""
    from sigmafmu.view.page import page

    write_text(path, page(scene, result, patterns))


def write_gltf(scene, result: Result, path: Path) -> None:
    """Write a result as glTF."""
    from sigmafmu.view.gltf import gltf

    data = gltf(scene, result)
    try:
        path.write_bytes(data)
    except OSError as error:
        raise SigmafmuError(f"cannot write {path}: {error.strerror}") from error
    out.print(f"wrote {path}", soft_wrap=True)


def _check_viewer() -> None:
    """Before a run that takes long: is there a viewer?"""
    from sigmafmu.view.page import viewer_source

    viewer_source()


def _run(subject, label: str, stop_time, step_size, settings: dict[str, str], patterns: tuple[str, ...]) -> Result:
    """Run what is to be seen, and record what that needs."""
    from sigmafmu.fmu import Fmu
    from sigmafmu.mechanism_file.run import simulate_file, steps_of_file
    from sigmafmu.simulate import communication_steps, simulate

    ours = isinstance(subject.source, Fmu)
    steps = (communication_steps if ours else steps_of_file)(subject.source, stop_time, step_size)
    with progress_bar(err, label, sum(steps[-1])) as move_to:
        return (simulate if ours else simulate_file)(
            subject.source,
            stop_time=stop_time,
            step_size=step_size,
            settings=settings,
            variables=subject.recorded(patterns),
            on_time=move_to,
            on_message=show_message,
        )
