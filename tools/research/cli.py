"""The command `python -m research`."""

from importlib.util import find_spec
from pathlib import Path
from typing import Annotated

import typer

from research.study.cli import study
from sigmafmu import SigmafmuError
from sigmafmu.console import OneLineErrors, err, out, progress_bar, write_text

app = typer.Typer(cls=OneLineErrors, no_args_is_help=True, add_completion=False, rich_markup_mode="rich")


@app.callback(epilog="Example: python -m research bench")
def main() -> None:
    """Study, measurements and reference solutions of sigmafmu's integrators."""


def _need(*modules: str) -> None:
    """SigmafmuError if one of the packages of `make bench` is missing."""
    if missing := [name for name in modules if find_spec(name) is None]:
        raise SigmafmuError(f"this needs {', '.join(missing)}; `make bench` installs what it needs")


app.command(epilog="Example: python -m research study heavy-top --quick --output build/study-quick")(study)


@app.command(epilog="Example: python -m research bench --quick --output build/bench/speed.md")
def bench(
    quick: Annotated[bool, typer.Option("--quick", help="Some mechanisms, few sizes, one round: a minute.")] = False,
    rounds: Annotated[int, typer.Option(min=1, help="Rounds; each candidate keeps its fastest one.")] = 5,
    output: Annotated[Path, typer.Option(metavar="FILE", help="Markdown file to write.")] = Path("docs/speed.md"),
    only: Annotated[
        list[str] | None,
        typer.Option(metavar="SECTION", help="Measure this alone (repeatable), take the rest from its CSV files."),
    ] = None,
    redraw: Annotated[bool, typer.Option("--redraw", help="Measure nothing: page and figures from CSV files.")] = False,
) -> None:
    """Time steps beside Exudyn, MuJoCo, Pinocchio, sparse solvers and limit kernels; minutes.

    CSV files and figures go into a folder beside the page. The environment variable SIGMAFMU_LIMITS may name a folder
    with limit kernels.
    """
    from research.bench import Effort
    from research.bench.page import write

    effort = Effort(quick, 1 if quick else rounds, lambda what: err.print(f"bench: {what}"))
    write(output, () if redraw else only, effort)


@app.command(epilog="Example: python -m research measure --output docs/accuracy.md")
def measure(
    output: Annotated[Path, typer.Option(metavar="FILE", help="Markdown file to write.")] = Path("accuracy.md"),
) -> None:
    """Measure orders, errors and energy of all mechanisms (takes minutes)."""
    from research import measure as measurements

    with progress_bar(err, "measure", measurements.runs(), unit="runs") as move_to:
        done = iter(range(1, measurements.runs() + 1))
        text = "".join(measurements.page(lambda: move_to(next(done))))
    write_text(output, text)


@app.command(epilog="Example: python -m research mechanisms Chain250 Bricard --output build/mechanisms")
def mechanisms(
    names: Annotated[list[str] | None, typer.Argument(metavar="[NAME]...", help="Which; without names: all.")] = None,
    output: Annotated[Path, typer.Option(help="Folder that gets the files.")] = Path("build/mechanisms"),
) -> None:
    """Write the mechanisms of tests and benchmarks as JSON files."""
    from research.mechanisms import WRITTEN, write

    paths = write(tuple(names or WRITTEN), output)
    out.print(f"{len(paths)} files in {output}")


@app.command(epilog="Example: python -m research elements")
def elements(
    output: Annotated[Path, typer.Option(metavar="FILE", help="Markdown file to write.")] = Path("docs/comparison.md"),
) -> None:
    """Compare joints, forces and a robot arm with Exudyn, MuJoCo and Pinocchio; half a minute."""
    _need("exudyn", "mujoco", "pinocchio")
    from research.elements.page import page

    write_text(output, page(lambda what: err.print(f"elements: {what}")))


@app.command(epilog="Example: python -m research catalogue")
def catalogue(
    output: Annotated[Path, typer.Option(metavar="FILE", help="Markdown file to write.")] = Path("docs/elements.md"),
) -> None:
    """Write the page of all elements, with a figure of each."""
    from research.elements.catalogue import write

    write(output)
    out.print(f"wrote {output}")


@app.command(epilog="Example: python -m research view")
def view(
    document: Annotated[Path, typer.Option(metavar="FILE", help="The page with the table.")] = Path("docs/view.md"),
    images: Annotated[Path, typer.Option(metavar="FOLDER", help="Gets the pictures.")] = Path("docs/images"),
) -> None:
    """Measure pages of `sigmafmu view` in headless Chromium, and take their pictures."""
    from research.view import write

    write(document, images, lambda what: err.print(f"view: {what}"))


@app.command(epilog="Example: python -m research gallery SliderCrank RobotArm")
def gallery(
    names: Annotated[list[str] | None, typer.Argument(metavar="[NAME]...", help="Which; without names: all.")] = None,
    document: Annotated[Path, typer.Option(metavar="FILE", help="The page to write.")] = Path("docs/gallery.md"),
    images: Annotated[Path, typer.Option(metavar="FOLDER", help="Gets the pictures.")] = Path("docs/images"),
) -> None:
    """Take moving pictures of all mechanisms in headless Chromium, and write their page; minutes."""
    from research.gallery import TAKES, write

    if wrong := [name for name in names or () if name not in TAKES]:
        raise SigmafmuError(f"no such mechanism: {wrong[0]}; there are {', '.join(TAKES)}")
    write(document, images, names or (), lambda what: err.print(f"gallery: {what}"))


@app.command(epilog="Example: python -m research newcomer")
def newcomer(
    page: Annotated[Path, typer.Option(metavar="FILE", help="Markdown file with the place for it.")] = Path(
        "docs/start.md"
    ),
) -> None:
    """Time a newcomer's way: clone, `make demo`, a file of their own, in motion in headless Chromium; minutes."""
    from research.newcomer import write

    write(page, lambda what: err.print(f"newcomer: {what}"))
    out.print(f"wrote {page}", soft_wrap=True)


@app.command(epilog="Example: python -m research linear")
def linear() -> None:
    """Compare linear models with differences of what the FMUs do."""
    from research.linear import page

    typer.echo(page())


@app.command(epilog="Example: python -m research robots --output docs/robots.md")
def robots(
    output: Annotated[Path, typer.Option(metavar="FILE", help="Markdown file to write.")] = Path("docs/robots.md"),
) -> None:
    """Convert robots of packages, build their FMUs, compare accelerations with Pinocchio and MuJoCo; minutes."""
    from research.robots import page

    with progress_bar(err, "robots", len(page.runs()), unit="robots") as move_to:
        done = iter(range(1, len(page.runs()) + 1))
        text = page.page(lambda: move_to(next(done)))
    write_text(output, text)


@app.command(epilog="Example: python -m research sweeps --runs 1000")
def sweeps(
    runs: Annotated[int, typer.Option(min=500, help="Of the long study.")] = 10_000,
    page: Annotated[Path, typer.Option(metavar="FILE", help="Markdown file with the place for it.")] = Path(
        "docs/sweep.md"
    ),
) -> None:
    """Measure sweeps beside FMPy, through a kill, and simulate many workers; minutes."""
    from research.sweep_costs.page import write

    write(page, runs, lambda what: err.print(f"sweeps: {what}"))
    out.print(f"wrote {page}", soft_wrap=True)


@app.command(epilog="Example: python -m research gym --rounds 5")
def gym(
    rounds: Annotated[int, typer.Option(min=1, help="Of all ways in turn; medians count.")] = 15,
    page: Annotated[Path, typer.Option(metavar="FILE", help="Markdown file with the place for it.")] = Path(
        "docs/gym.md"
    ),
) -> None:
    """Time steps of environments beside Gymnasium's of MuJoCo; seconds."""
    _need("gymnasium", "mujoco", "imageio")
    from research.gym import write

    write(page, rounds, lambda what: err.print(f"gym: {what}"))
    out.print(f"wrote {page}", soft_wrap=True)


@app.command(epilog="Example: python -m research compare --rounds 3")
def compare(
    rounds: Annotated[int, typer.Option(min=1, help="Of all codes in turn; medians count.")] = 5,
    page: Annotated[Path, typer.Option(metavar="FILE", help="Markdown file with the place for it.")] = Path(
        "docs/compare.md"
    ),
    redraw: Annotated[bool, typer.Option("--redraw", help="Measure nothing: page and figure from CSV files.")] = False,
) -> None:
    """Measure problems of the IFToMM library of benchmarks beside Exudyn and MuJoCo; minutes."""
    _need("exudyn", "mujoco")
    from research.compare import page as measured

    if redraw:
        measured.redraw(page)
    else:
        measured.write(page, rounds, lambda what: err.print(f"compare: {what}"))
    out.print(f"wrote {page}", soft_wrap=True)


@app.command(epilog="Example: python -m research references --only HeavyTop")
def references(
    only: Annotated[list[str] | None, typer.Option(help="Make the reference of this model only (repeatable).")] = None,
    output: Annotated[Path, typer.Option(help="Folder that gets the files.")] = Path("tests/references"),
) -> None:
    """Make the reference solutions of the benchmark mechanisms with Exudyn and in minimal coordinates."""
    from research.reference import FLEXIBLE_MODELS, MODELS
    from research.reference.make import make
    from research.reference.make_flexible import make_flexible

    makers = {**dict.fromkeys(MODELS, make), **dict.fromkeys(FLEXIBLE_MODELS, make_flexible)}
    for name in only or ():
        if name not in makers:
            raise SigmafmuError(f"no such model: {name}; there are {', '.join(makers)}")
    output.mkdir(parents=True, exist_ok=True)
    for name in only or makers:
        makers[name](name, output)
