"""The commands `sigmafmu couple` and `sigmafmu sampling`."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich import box
from rich import table as rich_table

from sigmafmu import SigmafmuError, __version__
from sigmafmu.console import err, out, progress_bar
from sigmafmu.markdown import markdown_table

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from sigmafmu.loop.studies import Table

Sizes = Annotated[
    list[float] | None, typer.Option("--step-size", metavar="SECONDS", help="Communication step H (repeatable).")
]
Page = Annotated[
    Path | None, typer.Option(metavar="FILE", help="Markdown page whose part between this command's marks to rewrite.")
]
Plot = Annotated[Path | None, typer.Option(metavar="PNG", help="Draw the results here.")]


def register(app: typer.Typer) -> None:
    """Add the commands to `app`."""
    app.command(epilog="Example: sigmafmu couple --stiffness 1e5 --step-size 2e-3 --plot spring.png")(couple)
    app.command(epilog="Example: sigmafmu sampling --step-size 8e-3 --step-size 4e-3 --plot speed.png")(sampling)


def couple(
    stiffnesses: Annotated[
        list[float] | None, typer.Option("--stiffness", metavar="N/M", help="Stiffness of the spring (repeatable).")
    ] = None,
    sizes: Sizes = None,
    output: Page = None,
    plot: Plot = None,
) -> None:
    """Tie two heavy tops by a stiff spring, with masters that iterate and that do not (needs the extra `loop`)."""
    from sigmafmu.loop import studies

    stiffnesses, sizes = stiffnesses or studies.STIFFNESSES, sizes or studies.SPRING_STEPS
    total = len(stiffnesses) * len(sizes) * len(studies.SCHEMES)
    with progress_bar(err, "couple", total, unit="runs") as move_to:
        done = iter(range(1, total + 1))
        runs = studies.spring_runs(stiffnesses, sizes, lambda: move_to(next(done)))
    _present("couple", studies.spring_tables(runs), output)
    if plot:
        _draw(studies.spring_figure(runs), plot)


def sampling(sizes: Sizes = None, output: Page = None, plot: Plot = None) -> None:
    """Control the slider-crank by a sampled law, with masters that iterate and that do not (needs `loop`)."""
    from sigmafmu.loop import studies

    sizes = sizes or studies.SAMPLING_STEPS
    total = len(sizes) * len(studies.SCHEMES)
    with progress_bar(err, "sampling", total, unit="runs") as move_to:
        done = iter(range(1, total + 1))
        runs = studies.sampling_runs(sizes, lambda: move_to(next(done)))
    _present("sampling", studies.sampling_tables(runs), output)
    if plot:
        _draw(studies.sampling_figure(runs), plot)


def _present(command: str, tables: "Sequence[Table]", output: Path | None) -> None:
    for each in tables:
        shown = rich_table.Table(title=each.caption, title_justify="left", box=box.SIMPLE_HEAD)
        for i, name in enumerate(each.header):
            shown.add_column(name, justify="left" if i == 0 else "right")
        for row in each.rows:
            shown.add_row(*row)
        out.print(shown)
    if output:
        text = f"Written by `sigmafmu {command}`, sigmafmu {__version__}.\n"
        text += "".join(f"\n{t.caption}\n\n{markdown_table(t.header, t.rows)}" for t in tables)
        rewrite_part(output, command, text)
        out.print(f"wrote {output}", soft_wrap=True)


def rewrite_part(page: Path, command: str, text: str) -> None:
    """Replace what stands between the marks of `command` in `page`; other text stays."""
    begin, end = f"<!-- {command} -->\n", f"<!-- end of {command} -->\n"
    try:
        before, found, rest = page.read_text(encoding="utf-8").partition(begin)
        _, closed, after = rest.partition(end)
        if not (found and closed):
            raise SigmafmuError(f"{page} has no lines '{begin.strip()}' and '{end.strip()}' to write between")
        page.write_text(before + begin + text + end + after, encoding="utf-8")
    except OSError as error:
        raise SigmafmuError(f"cannot write {page}: {error.strerror}") from error


def _draw(figure: "Figure", path: Path) -> None:
    try:
        figure.savefig(path, dpi=130)
    except (OSError, ValueError) as error:
        raise SigmafmuError(f"cannot write {path}: {error}") from error
    out.print(f"wrote {path}", soft_wrap=True)
