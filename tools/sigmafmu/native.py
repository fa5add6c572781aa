"""The library `describe`, which answers questions about mechanisms in JSON on every platform, without `_core`.

modelDescription/describe_library.cpp has its functions. Each raises ValueError for a mechanism that is wrong,
RuntimeError for one that cannot do what is asked, and SigmafmuError where the library is missing.
"""

import ctypes
import json
import os
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import Any

import fmpy
import numpy as np

from sigmafmu import SigmafmuError
from sigmafmu.platform import PLATFORM

PARTS = Path(__file__).parent / "slave"
"""A folder for each platform with its slave and describe libraries, and `sources`."""


def describe(mechanism: str, resources: Path | str) -> dict[str, Any]:
    """All that an FMU tells of a mechanism in JSON whose modal data are in a folder."""
    return _ask("sigmafmu_describe", mechanism, resources)


def check(mechanism: str, resources: Path | str) -> None:
    """Nothing, for one that is in order."""
    _ask("sigmafmu_check", mechanism, resources)


def start(mechanism: str, resources: Path | str, values: dict[str, float] | None = None) -> dict[str, np.ndarray]:
    """`q`, `v`, `coordinates` and `rates` of its start with these parameters (SI)."""
    told = _ask("sigmafmu_start", mechanism, resources, json.dumps(values or {}))
    return {name: np.array(numbers, dtype=float) for name, numbers in told.items()}


def closure(mechanism: str, resources: Path | str, q: np.ndarray, coordinates: Sequence[int]) -> dict[str, np.ndarray]:
    """What joints miss at positions q: `gaps` (n) and `rows`, their gradients by velocities (n, m).

    `values` (k) and `value_rows` (k, m) are the same of the joint coordinates with these indices.
    """
    told = _ask("sigmafmu_closure", mechanism, resources, json.dumps(q.tolist()), json.dumps(list(coordinates)))
    return {name: np.array(numbers, dtype=float) for name, numbers in told.items()}


def mobility(mechanism: str, resources: Path | str, coordinates: Sequence[int]) -> list[float]:
    """At the start: accelerations of the joint coordinates with these indices by a unit of force on each."""
    return _ask("sigmafmu_mobility", mechanism, resources, json.dumps(list(coordinates)))["mobility"]


def poses(mechanism: str, motion: int, times: np.ndarray, added: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Of a frame of the ground that moves, at n times [s]: positions in W [m], (n, 3), and quaternions R_WB, (n, 4).

    Displacements [m] and rotation vectors [rad], (n, 6), are added to the tables of the motion with this index.
    """
    numbers = [json.dumps(np.ravel(x).tolist()) for x in (times, added)]
    told = _ask("sigmafmu_poses", mechanism, str(motion), *numbers)
    return np.array(told["positions"], dtype=float), np.array(told["quaternions"], dtype=float)


def freedom(mechanism: str, resources: Path | str) -> dict[str, Any]:
    """`freedom` as a sentence, `groups` of dependent joints and `masses` [kg] of the bodies."""
    return _ask("sigmafmu_freedom", mechanism, resources)


def default() -> dict[str, Any]:
    """The mechanism that has nothing but defaults."""
    return _ask("sigmafmu_default")


def _ask(function: str, *arguments: Path | str) -> dict[str, Any]:
    library = _library()
    encoded = [os.fsencode(a) if isinstance(a, Path) else a.encode(errors="surrogatepass") for a in arguments]
    question = getattr(library, function)
    question.argtypes, question.restype = (ctypes.c_char_p,) * len(encoded), ctypes.c_void_p
    answer = question(*encoded)
    if not answer:
        raise MemoryError
    try:
        told = json.loads(ctypes.string_at(answer))
    finally:
        library.sigmafmu_free(answer)
    if "error" in told:
        raise ValueError(told["error"])
    if "failure" in told:
        raise RuntimeError(told["failure"])
    return told


@cache
def _library() -> ctypes.CDLL:
    path = PARTS / PLATFORM / f"describe{fmpy.sharedLibraryExtension}"
    try:
        library = ctypes.CDLL(str(path))
    except OSError as error:
        raise SigmafmuError(f"this installation cannot read mechanisms on {PLATFORM}: {error}") from error
    library.sigmafmu_free.argtypes, library.sigmafmu_free.restype = (ctypes.c_void_p,), None
    return library
