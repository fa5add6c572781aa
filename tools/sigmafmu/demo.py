"""The demonstration: two benchmark mechanisms through FMPy, compared with an independent reference."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from rich import box
from rich.console import Console
from rich.table import Table

from sigmafmu import plots
from sigmafmu.compare import distance, find_reference
from sigmafmu.console import progress_bar, show_message
from sigmafmu.model import load


@dataclass(frozen=True)
class Case:
    """A run of the demonstration; `position` is the vector whose error the table shows."""

    model: str
    stop_time: float
    position: str


CASES = (Case("HeavyTop", 2.0, "top.position"), Case("SliderCrank", 5.0, "slider.position"))
STEP_SIZE = 1e-3


def run_demo(folder: Path, console: Console) -> list[Path]:
    """Run every case, print the comparison and return the files written into `folder`."""
    folder.mkdir(parents=True, exist_ok=True)
    table = _new_table()
    written: list[Path] = []
    for case in CASES:
        with progress_bar(console, f"{case.model:<12}", case.stop_time) as move_to:
            result = load(case.model).run(case.stop_time, step_size=STEP_SIZE, on_time=move_to, on_message=show_message)
        reference = find_reference(case.model)
        csv_path, png_path = folder / f"{case.model}.csv", folder / f"{case.model}.png"
        result.to_csv(csv_path)
        plots.save(plots.figure(result, reference), png_path)
        written += [csv_path, png_path]

        error = stated = "no reference"
        if reference:
            error = f"{np.max(distance(result, reference.history, case.position)[1]):.1e} m"
            stated = reference.stated_position_error
        s = result.statistics
        table.add_row(
            f"{case.model}, {case.stop_time:g} s",
            error,
            stated,
            f"{s.steps}",
            f"{s.newton_per_step:.2f}",
            f"{s.wall_time * 1e3:.0f} ms",
            f"{s.real_time_factor:.0f}",
        )
    console.print(table)
    return written


def _new_table() -> Table:
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    table.add_column("run")
    for title in (
        "max position error\nagainst Exudyn",
        "error of that\nreference",
        "internal\nsteps",
        "Newton iterations\nper step",
        "wall time\nof doStep",
        "times\nreal time",
    ):
        table.add_column(title, justify="right")
    return table
