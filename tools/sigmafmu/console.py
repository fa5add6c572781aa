"""What commands share: consoles, the progress bar, errors in one line, files of text and the option --set."""

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.console import Console
from rich.markup import escape
from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeElapsedColumn
from typer.core import TyperGroup

from sigmafmu import SigmafmuError, extras
from sigmafmu.mechanism_file.problems import FileError

if TYPE_CHECKING:
    from sigmafmu import LogMessage

ModelName = Annotated[
    str, typer.Argument(metavar="MODEL|FILE", help="A model, see `sigmafmu list`, a mechanism file, or an FMU.")
]

PLAIN_WIDTH = 120
"""Columns when the output is not a terminal, so that a log or a file gets readable tables."""

REFRESH_SECONDS = 0.05


def _console(*, stderr: bool = False) -> Console:
    console = Console(stderr=stderr, highlight=False, emoji=False)  # :x: is text
    if not console.is_terminal:
        console.width = PLAIN_WIDTH
    return console


@contextmanager
def progress_bar(console: Console, label: str, total: float, unit: str = "s") -> Iterator[Callable[[float], None]]:
    """Show a bar from 0 to `total` seconds (or other units); yields the function that moves it."""
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        TaskProgressColumn(),
        TextColumn(f"{{task.completed:.3g}} of {{task.total:.3g}} {unit}"),
        TimeElapsedColumn(),
    )
    progress = Progress(*columns, console=console, auto_refresh=False)
    task = progress.add_task(label, total=total)
    reached, drawn = 0.0, 0.0

    def move_to(now: float) -> None:
        nonlocal reached, drawn
        progress.start()  # only now: a run that cannot start shows no bar
        reached = now
        if time.monotonic() - drawn > REFRESH_SECONDS:
            progress.update(task, completed=reached, refresh=True)
            drawn = time.monotonic()

    try:
        yield move_to
    finally:
        if reached > 0:
            progress.update(task, completed=reached)
            progress.stop()


out = _console()
err = _console(stderr=True)


class OneLineErrors(TyperGroup):
    """Turns an error that is meant for the user, and a package that is not installed, into one line and exit code 1."""

    def invoke(self, ctx: typer.Context) -> Any:
        """Call the command."""
        try:
            return super().invoke(ctx)
        except FileError as error:  # lines that editors understand
            err.print(str(error), markup=False, soft_wrap=True)
            raise typer.Exit(1) from error
        except SigmafmuError as error:
            sentence, cause = str(error), error
        except ModuleNotFoundError as error:
            sentence, cause = extras.missing(error.name or "", ctx.invoked_subcommand or ""), error
            if not sentence:
                raise
        err.print(f"[red]Error:[/red] {escape(sentence)}", soft_wrap=True)
        raise typer.Exit(1) from cause


def show_message(message: "LogMessage") -> None:
    """Print what an FMU reports while it runs; its complaints come with the error that ends the run."""
    if not message.is_complaint:
        err.print(str(message), style="yellow", markup=False, soft_wrap=True)


def agreed(what: str, yes: bool) -> bool:
    """Whether to go on: with --yes always, else if a user at the terminal says so."""
    return yes or (sys.stdin.isatty() and typer.confirm(f"{what}; go on?", err=True))


def write_text(path: Path, text: str) -> None:
    """Write a file and say so."""
    try:
        path.write_text(text, encoding="utf-8")
    except OSError as error:
        raise SigmafmuError(f"cannot write {path}: {error.strerror}") from error
    out.print(f"wrote {path}", soft_wrap=True)


def split_setting(text: str) -> tuple[str, str]:
    """Name and value of an option `--set NAME=VALUE`."""
    name, equals, value = text.partition("=")
    if not (name and equals and value):
        raise SigmafmuError(f"--set {text}: write it as NAME=VALUE, for example integrator.sigma=1.6")
    return name.strip(), value.strip()
