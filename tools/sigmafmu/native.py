"""The library `describe`, which answers questions about mechanisms in JSON on every platform, without `_core`.

modelDescription/describe_library.cpp has its functions.
"""

import ctypes
import json
import os
from functools import cache
from pathlib import Path
from typing import Any

import fmpy

from sigmafmu import SigmafmuError
from sigmafmu.platform import PLATFORM

PARTS = Path(__file__).parent / "slave"
"""A folder for each platform with its slave and describe libraries, and `sources`."""


def describe(mechanism: str, resources: Path | str) -> dict[str, Any]:
    """All that an FMU tells of a mechanism in JSON whose modal data are in a folder; raises ValueError."""
    return _ask("sigmafmu_describe", mechanism, resources)


def start(mechanism: str, resources: Path | str, values: dict[str, float] | None = None) -> dict[str, Any]:
    """`q`, `v`, `coordinates` and `rates` of its start with these parameters (SI); raises ValueError."""
    return _ask("sigmafmu_start", mechanism, resources, json.dumps(values or {}))


def freedom(mechanism: str, resources: Path | str) -> dict[str, Any]:
    """`freedom` as a sentence, `groups` of dependent joints and `masses` [kg] of the bodies; raises ValueError."""
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
