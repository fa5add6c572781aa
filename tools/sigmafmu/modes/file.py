"""The file of modal data that an FMU carries: JSON, SI units, numbers with all their digits.

A sparse M is written as {"rows": …, "columns": …, "values": …} with its upper triangle, zero-based.
"""

import json
from pathlib import Path
from typing import Any

import numpy as np
import scipy.sparse as sp

from sigmafmu import SigmafmuError
from sigmafmu.modes.checks import validate
from sigmafmu.modes.data import ModalData

FORMAT = "sigmafmu modes"
VERSION = 1
UNITS = "SI"
REQUIRED = ("X", "Phi", "K")
KEYS = ("format", "version", "units", "note", "names", "frequencies", "X", "m", "M", "Phi", "Theta", "K", "D")
SPARSE_KEYS = ("rows", "columns", "values")
FREQUENCY_TOLERANCE = 1e-6


def write(data: ModalData, path: Path | str) -> None:
    """Check `data` and write it, a key a line."""
    validate(data)
    content: dict[str, Any] = {"format": FORMAT, "version": VERSION, "units": UNITS, "note": data.note}
    if data.names:
        content["names"] = list(data.names)
    content["frequencies"] = data.frequencies.tolist()
    content["X"] = data.X.tolist()
    content["m" if data.mass.ndim == 1 else "M"] = (
        _triplets(data.mass) if sp.issparse(data.mass) else data.mass.tolist()
    )
    content |= {
        name: getattr(data, name).tolist() for name in ("Phi", "Theta", "K", "D") if getattr(data, name) is not None
    }
    lines = (f"{json.dumps(key)}: {json.dumps(value, allow_nan=False)}" for key, value in content.items())
    try:
        Path(path).write_text("{\n" + ",\n".join(lines) + "\n}\n", encoding="utf-8")
    except OSError as error:
        raise SigmafmuError(f"cannot write {path}: {error.strerror}") from error


def read(path: Path | str) -> ModalData:
    """Read and check a file."""
    try:
        content = json.loads(Path(path).read_text(encoding="utf-8"))
    except OSError as error:
        raise SigmafmuError(f"cannot read {path}: {error.strerror}") from error
    except ValueError as error:
        raise SigmafmuError(f"{path} is not a JSON file: {error}") from error
    try:
        data = _parse(content)
    except SigmafmuError as error:
        raise SigmafmuError(f"{path}: {error}") from None
    validate(data, str(path))
    _check_frequencies(content, data, path)
    return data


def _parse(content: Any) -> ModalData:
    if not isinstance(content, dict):
        raise SigmafmuError(
            f"the file holds a {type(content).__name__}; it must hold an object with the keys {_list(KEYS)}"
        )
    for key in content:
        if key not in KEYS:
            raise SigmafmuError(f"unknown key '{key}'; allowed are {_list(KEYS)}")
    for key, allowed in (("format", FORMAT), ("version", VERSION), ("units", UNITS)):
        if content.get(key, allowed) != allowed:
            raise SigmafmuError(f"{key} is {content[key]!r}; allowed is {allowed!r}")
    for key in REQUIRED:
        if key not in content:
            raise SigmafmuError(f"the key '{key}' is missing; {_list(REQUIRED)} and m or M are needed")
    if ("m" in content) == ("M" in content):
        raise SigmafmuError("there must be either m (a mass for each node) or M (a mass matrix), exactly one of them")
    names, note = content.get("names", []), content.get("note", "")
    if not (isinstance(names, list) and all(isinstance(name, str) for name in names)):
        raise SigmafmuError("names must be a list of texts, one for each mode")
    if not isinstance(note, str):
        raise SigmafmuError(f"note is {note!r}; it must be a text")
    X = _array("X", content["X"], 2)
    return ModalData(
        X=X,
        mass=_array("m", content["m"], 1) if "m" in content else _mass_matrix(content["M"], len(X)),
        Phi=_array("Phi", content["Phi"], 3),
        K=_array("K", content["K"], 2),
        D=_array("D", content["D"], 2) if "D" in content else None,
        Theta=_array("Theta", content["Theta"], 3) if "Theta" in content else None,
        names=tuple(names),
        note=note,
    )


def _array(key: str, value: Any, dimensions: int) -> np.ndarray:
    kind = {1: "a list", 2: "a list of rows", 3: "a list of 3 rows for each node"}[dimensions]
    try:
        result = np.array(value)
    except ValueError as error:
        raise SigmafmuError(f"{key} has rows of different lengths; it must be {kind} of numbers") from error
    if result.ndim != dimensions or result.dtype.kind not in "fi":
        raise SigmafmuError(f"{key} must be {kind} of numbers")
    return result.astype(float)


def _mass_matrix(value: Any, n: int) -> np.ndarray | sp.sparray:
    if not isinstance(value, dict):
        return _array("M", value, 2)
    if set(value) != set(SPARSE_KEYS):
        raise SigmafmuError(f"M has the keys {_list(value)}; a sparse M has {_list(SPARSE_KEYS)}")
    rows, columns, values = (_array(f"M.{key}", value[key], 1) for key in SPARSE_KEYS)
    if not len(rows) == len(columns) == len(values):
        raise SigmafmuError(
            f"M has {len(rows)} rows, {len(columns)} columns, {len(values)} values; their numbers must agree"
        )
    wrong = np.flatnonzero((rows < 0) | (rows > columns) | (columns >= n) | (rows % 1 != 0) | (columns % 1 != 0))
    if len(wrong):
        k = wrong[0]
        raise SigmafmuError(
            f"M has an entry at [{rows[k]:g}, {columns[k]:g}]; allowed are whole numbers with 0 ≤ row ≤ column < {n}"
        )
    upper = sp.coo_array((values, (rows.astype(int), columns.astype(int))), shape=(n, n)).tocsr()
    return sp.csr_array(upper + sp.triu(upper, 1).T)


def _triplets(M: sp.sparray) -> dict[str, list]:
    upper = sp.triu(M).tocoo()
    return dict(
        zip(SPARSE_KEYS, (upper.coords[0].tolist(), upper.coords[1].tolist(), upper.data.tolist()), strict=True)
    )


def _check_frequencies(content: dict, data: ModalData, path: Path | str) -> None:
    """Frequencies are there for the reader; they must be those of the matrices."""
    if "frequencies" not in content:
        return
    given, found = _array("frequencies", content["frequencies"], 1), data.frequencies
    if given.shape != found.shape:
        raise SigmafmuError(
            f"{path}: there are {len(given)} frequencies; there must be one for each of {data.modes} modes"
        )
    off = np.abs(given - found) > FREQUENCY_TOLERANCE * found.max()
    if off.any():
        j = int(np.argmax(off))
        raise SigmafmuError(
            f"{path}: frequencies[{j}] is {given[j]:.6g} Hz; from K and the masses it is {found[j]:.6g} Hz"
        )


def _list(names: Any) -> str:
    return ", ".join(names)
