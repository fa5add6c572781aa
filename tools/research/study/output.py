"""Files of a chapter: CSV and figures in one style."""

import csv
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import matplotlib as mpl
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from PIL import Image

from sigmafmu.plots import STYLE

DPI = 100
COLORS = 128
"""A palette makes the files a third as large."""


def write_csv(path: Path, rows: Iterable[Mapping[str, Any]], header: Sequence[str]) -> None:
    """One line for each row; what a row does not have stays empty."""
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, header, extrasaction="ignore")
        writer.writeheader()
        for row in rows:
            writer.writerow({k: f"{v:.6g}" if isinstance(v, float) else v for k, v in row.items()})


@contextmanager
def figure(path: Path, size: tuple[float, float]) -> Iterator[Figure]:
    """A figure of `size` in inches, saved when the block ends."""
    with mpl.rc_context(STYLE):
        result = Figure(figsize=size, layout="constrained")
        FigureCanvasAgg(result)
        yield result
        result.savefig(path, dpi=DPI)
    Image.open(path).convert("RGB").quantize(COLORS, method=Image.Quantize.MAXCOVERAGE).save(path, optimize=True)
