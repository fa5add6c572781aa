"""The command `sigmafmu sweep`."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from enum import Enum
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeRemainingColumn

from sigmafmu import SigmafmuError
from sigmafmu.console import ModelName, err, out, split_setting


class Sampling(str, Enum):
    """Of `sampling.SAMPLINGS`, which needs no import here."""

    random = "random"
    latin = "latin"
    sobol = "sobol"


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command(
        epilog="Example: sigmafmu sweep SliderCrank --vary crank.mass=0.1:0.2:11 --sample 'rod.mass~N(0.5,0.01)' "
        "--runs 1000 --scalar 'max(crankPivot.reactionForce)' --output study.nc"
    )(sweep)


def sweep(
    model: ModelName,
    vary: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME=VALUES", help="0.1:0.2:11, or 0,1, or names; of vectors 0,0,1;0,0,2. All are crossed."
        ),
    ] = None,
    together: Annotated[
        list[str] | None, typer.Option("--zip", metavar="NAME=VALUES", help="Vary with the other --zip, not crossed.")
    ] = None,
    sample: Annotated[
        list[str] | None,
        typer.Option(metavar="NAME~DIST", help="N(mean,deviation), U(low,high), T(low,mode,high), LN(median,sigma)."),
    ] = None,
    runs: Annotated[int | None, typer.Option(help="Samples of the distributions.")] = None,
    sampling: Annotated[Sampling, typer.Option(help="How they are drawn.")] = Sampling.random,
    seed: Annotated[int, typer.Option(help="Of the samples.")] = 0,
    settings: Annotated[
        list[str] | None, typer.Option("--set", metavar="NAME=VALUE", help="A parameter or input of all runs.")
    ] = None,
    variables: Annotated[
        list[str] | None,
        typer.Option(metavar="PATTERN", help="Record these over time; default: all outputs, or none with --scalar."),
    ] = None,
    scalar: Annotated[
        list[str] | None,
        typer.Option(metavar="WHAT(VARIABLE)", help="max, min, maxabs, final, mean, rms or argmax; NAME=… names it."),
    ] = None,
    stop_time: Annotated[float | None, typer.Option(help="Seconds of each run; default: the model's own.")] = None,
    step_size: Annotated[float | None, typer.Option(help="Communication step in s; default: the model's own.")] = None,
    output: Annotated[Path, typer.Option(metavar="FILE", help="Dataset to write: .nc or .zarr.")] = Path("study.nc"),
    resume: Annotated[bool, typer.Option("--resume", help="Go on with a study that was stopped.")] = False,
    workers: Annotated[int | None, typer.Option(min=1, help="Processes; default: one for each core.")] = None,
    scheduler: Annotated[str | None, typer.Option(metavar="ADDRESS", help="Run on this Dask scheduler.")] = None,
    chunk: Annotated[int | None, typer.Option(min=1, help="Runs that a worker takes at once.")] = None,
) -> None:
    """Run a model with many parameters, on all cores or on a cluster, into one dataset."""
    from sigmafmu.sweeps.study import need

    need()
    from sigmafmu.sweeps.sampling import distribution
    from sigmafmu.sweeps.study import sweep as run_study

    parameters: dict[Any, Any] = {}

    def add(name: Any, value: Any) -> None:
        if name in parameters:
            raise SigmafmuError(f"'{name}' is given twice")
        parameters[name] = value

    for name, value in map(split_setting, settings or ()):
        add(name, value)
    for name, value in map(split_setting, vary or ()):
        add(name, values(value))
    if together:
        names, rows = zip(*((name, values(text)) for name, text in map(split_setting, together)), strict=True)
        if len(set(map(len, rows))) > 1:
            counts = ", ".join(f"{name} has {len(row)}" for name, row in zip(names, rows, strict=True))
            raise SigmafmuError(f"--zip needs as many values of each, but {counts}")
        add(names, list(zip(*rows, strict=True)))
    for text in sample or ():
        name, tilde, what = text.partition("~")
        if not (name and tilde):
            raise SigmafmuError(f"--sample {text}: write it as NAME~DISTRIBUTION, for example 'crank.mass~N(0.1,0.01)'")
        add(name.strip(), distribution(what))
    with _bar(model) as show:
        try:
            data = run_study(
                model,
                parameters,
                runs=runs,
                sampling=sampling.value,
                seed=seed,
                outputs=variables,
                scalars=_named(scalar or ()),
                stop_time=stop_time,
                step_size=step_size,
                output=output,
                resume=resume,
                workers=workers,
                scheduler=scheduler,
                chunk=chunk,
                on_progress=show,
            )
        except KeyboardInterrupt:
            raise SigmafmuError("stopped; --resume goes on with what is not finished") from None
    out.print(f"wrote {output} ({_told(data)})", soft_wrap=True)


def values(text: str) -> list[Any]:
    """`first:last:number` → equal distances; `a;b` → vectors; `a,b` → numbers or names."""
    if text.count(":") == 2:
        import numpy as np

        try:
            first, last, number = text.split(":")
            return np.linspace(float(first), float(last), int(number)).tolist()
        except ValueError as error:
            raise SigmafmuError(f"'{text}' is no range; write first:last:number, for example 0.1:0.2:11") from error
    return text.split(";" if ";" in text else ",")


def _named(texts: Any) -> dict[str, str]:
    """`name=max(x)`, or the text is its own name."""
    pairs = (text.partition("=") for text in texts)
    return {name.strip(): (what or name).strip() for name, _, what in pairs}


def _told(data: Any) -> str:
    statuses = data["status"].values
    failed = int((statuses > 0).sum())
    first = f", {failed} of them failed; the first: {data['message'].values[statuses > 0][0]}" if failed else ""
    return f"{len(statuses)} runs of {data.sizes['time']} rows{first}"


@contextmanager
def _bar(label: str) -> Iterator[Callable[[int, int, int], None]]:
    """A bar with the rate and the time left."""
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        TaskProgressColumn(),
        TextColumn("{task.completed:.0f} of {task.total:.0f} runs{task.fields[failed]}, {task.fields[rate]}"),
        TimeRemainingColumn(elapsed_when_finished=True),
    )
    with Progress(*columns, console=err) as progress:
        task = progress.add_task(label, total=None, visible=False, failed="", rate="")

        def show(finished: int, total: int, failed: int) -> None:
            speed = progress.tasks[0].finished_speed or progress.tasks[0].speed
            progress.update(
                task,
                completed=finished,
                total=total,
                visible=True,
                failed=f" ({failed} failed)" if failed else "",
                rate=f"{speed:.3g} runs/s" if speed else "starting",
            )

        yield show
