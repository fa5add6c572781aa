"""The command `sigmafmu view`."""

from __future__ import annotations

import webbrowser
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

import sigmafmu
from sigmafmu import SigmafmuError
from sigmafmu.console import err, out, progress_bar, show_message, split_setting, write_text

if TYPE_CHECKING:
    from collections.abc import Callable

    from sigmafmu.contents.scene_of import Scene
    from sigmafmu.model import Model
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
    from sigmafmu.view.subject import mechanism_of_result, model_of, result_of, scene_of_fmu

    if not gltf:
        _check_viewer()
    patterns, failure = tuple(variables or ()), None
    if target.endswith(".csv"):
        result = result_of(Path(target))
        model, scene = (model_of(of), None) if of else mechanism_of_result(result, Path(target))
        scene = scene or scene_of_fmu(model.fmu)
        units = {name: variable.unit for name, variable in model.variables.items()}
        result = replace(result, units=units)
    else:
        model = model_of(target)
        scene = scene_of_fmu(model.fmu)
        try:
            result = _run(model, scene, stop_time, step_size, dict(map(split_setting, settings or ())), patterns)
        except sigmafmu.SimulationError as error:  # what there is until then is worth seeing
            if error.result is None or len(error.result.time) < 2:
                raise
            failure, result = error, error.result
    if gltf:
        write_gltf(scene, result, gltf)
    if output or not gltf:
        path = output or Path(f"{result.model}.html")
        write_page(scene, result, path, patterns)
        if opened and not webbrowser.open(path.absolute().as_uri()):
            out.print(f"no browser was found; open {path} in one", soft_wrap=True)
    if failure:
        raise failure


def write_page(scene: Scene, result: Result, path: Path, patterns: tuple[str, ...]) -> None:
    """Write the page of a result."""
    from sigmafmu.view.page import page

    write_text(path, page(scene, result, patterns))


def write_gltf(scene: Scene, result: Result, path: Path) -> None:
    """Write a result as glTF."""
    from sigmafmu.view.gltf import gltf

    try:
        path.write_bytes(gltf(scene, result))
    except OSError as error:
        raise SigmafmuError(f"cannot write {path}: {error.strerror}") from error
    out.print(f"wrote {path}", soft_wrap=True)


def _check_viewer() -> None:
    """Before a run that takes long: is there a viewer?"""
    from sigmafmu.view.page import viewer_source

    viewer_source()


def _run(
    model: Model,
    scene: Scene,
    stop_time: float | None,
    step_size: float | None,
    parameters: dict[str, str],
    patterns: tuple[str, ...],
) -> Result:
    """Run what is to be seen, and record what that needs."""
    from sigmafmu.steps import communication_steps
    from sigmafmu.view.subject import to_record

    end = communication_steps(model.fmu, stop_time, step_size).end
    with progress_bar(err, model.name, end) as move_to:
        return model.run(
            stop_time,
            step_size=step_size,
            parameters=parameters,
            outputs=to_record(model, scene, patterns),
            on_time=move_to,
            on_message=show_message,
        )


def live_view(target: str) -> tuple[Model, Callable[..., Any]]:
    """What runs, and how it is shown meanwhile."""
    from sigmafmu.view.live import live
    from sigmafmu.view.subject import model_of, scene_of_fmu

    def opening(address: str) -> None:
        out.print(f"see it at {address}", soft_wrap=True)
        webbrowser.open(address)

    model = model_of(target)
    return model, partial(live, scene_of_fmu(model.fmu), opening=opening)
