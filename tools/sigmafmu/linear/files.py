"""Linear models as files."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from sigmafmu import SigmafmuError, extras

if TYPE_CHECKING:
    from sigmafmu.linear.model import LinearModel

MATRICES = ("A", "B", "C", "D", "x0", "u0", "y0", "dx0")
NAMES = ("states", "inputs", "outputs", "state_units", "input_units", "output_units")
SCALARS = ("name", "time", "frame", "sample_time")


def check(path: Path) -> None:
    """Complain about a file that `save` cannot write, before there is anything to save."""
    if path.suffix not in WRITERS:
        raise SigmafmuError(f"cannot write {path}: its name must end with {', '.join(list(WRITERS)[:-1])} or .json")
    if not path.absolute().parent.is_dir():
        raise SigmafmuError(f"cannot write {path}: there is no folder {path.parent}")


def save(model: "LinearModel", path: Path) -> None:
    """Write `model` in the format that the suffix names."""
    check(path)
    try:
        WRITERS[path.suffix](model, path)
    except OSError as error:
        raise SigmafmuError(f"cannot write {path}: {error.strerror}") from error


def _content(model: "LinearModel") -> dict[str, Any]:
    return {key: getattr(model, key) for key in (*MATRICES, *NAMES, *SCALARS)}


def _npz(model: "LinearModel", path: Path) -> None:
    np.savez(path, **_content(model))


def _mat(model: "LinearModel", path: Path) -> None:
    content = _content(model)
    for key in NAMES:  # cell arrays of strings
        content[key] = np.array(content[key], dtype=object).reshape(-1, 1)
    for key in ("x0", "u0", "y0", "dx0"):
        content[key] = content[key].reshape(-1, 1)
    extras.need("scipy.io", "linear").savemat(path, content)


def _json(model: "LinearModel", path: Path) -> None:
    content = _content(model) | {key: getattr(model, key).tolist() for key in MATRICES}
    content["start_values"] = dict(model.start_values)
    path.write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")


WRITERS: dict[str, Callable[["LinearModel", Path], None]] = {".npz": _npz, ".mat": _mat, ".json": _json}
