"""What the cells of the tests do; the worker processes of the study import it."""

from pathlib import Path

import numpy as np


def count(file: str, value: float) -> dict[str, object]:
    """Leaves a line for every call."""
    with Path(file).open("a", encoding="utf-8") as log:
        log.write("called\n")
    return {"value": np.float64(value), "array": np.arange(3), "missing": np.nan}


def timed(file: str) -> dict[str, object]:
    """Takes 3 s, then 2 s, then 5 s."""
    count(file, 0.0)
    calls = Path(file).read_text().count("called")
    return {"runs": [{"seconds": (3.0, 2.0, 5.0)[calls - 1], "call": calls}]}


def raise_error() -> dict[str, object]:
    """A bug in a chapter."""
    raise ZeroDivisionError("a bug")
