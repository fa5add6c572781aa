"""The command `sigmafmu sigma`."""

from pathlib import Path
from typing import Annotated

import typer

from sigmafmu.console import ModelName, err, out, progress_bar, split_setting


def register(app: typer.Typer) -> None:
    """Add the command to `app`."""
    app.command(epilog="Example: sigmafmu sigma HeavyTop --plot sigma.png")(sigma)


def sigma(
    model: ModelName,
    stop_time: Annotated[float | None, typer.Option(help="Seconds of each run; default: up to 8000 steps.")] = None,
    settings: Annotated[
        list[str] | None, typer.Option("--set", metavar="NAME=VALUE", help="A parameter or input (repeatable).")
    ] = None,
    plot: Annotated[Path | None, typer.Option(metavar="PNG", help="Draw the error over σ here.")] = None,
) -> None:
    """Find the σ for a model: p = J_polar/J_transverse and σ* of each body, a scan, and what to choose."""
    from rich import box
    from rich.table import Table

    from sigmafmu import plots
    from sigmafmu import sigma as chooser
    from sigmafmu.model import load

    loaded = load(model)
    total = chooser.runs(loaded)
    with progress_bar(err, "sigma", total, unit="runs") as move_to:
        done = iter(range(1, total + 1))
        advice = chooser.advise(
            loaded, dict(map(split_setting, settings or [])), stop_time, lambda: move_to(next(done))
        )

    h = advice.step_size
    out.print(f"{advice.model}: h = {h:g} s, {advice.stop_time:g} s, ρ∞ = {advice.rho_inf:g}", soft_wrap=True)
    if advice.spins:
        table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
        for name in ("body", "spin Ω in rad/s", "h Ω in rad", "p", "σ*"):
            table.add_column(name, justify="left" if name == "body" else "right")
        for spin in advice.spins:
            numbers = ("–", "–") if spin.sigma is None else (f"{spin.ratio:.3g}", f"{spin.sigma:.3f}")
            table.add_row(spin.body, f"{spin.rate:.4g}", f"{h * spin.rate:.2g}", *numbers)
        out.print(table)
    for sentence in chooser.sentences(advice):
        out.print(sentence, soft_wrap=True)
    if plot:
        plots.save(chooser.figure(advice), plot)
        out.print(f"wrote {plot}", soft_wrap=True)
