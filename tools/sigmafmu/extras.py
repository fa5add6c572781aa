"""Packages that only some commands need, and what to install when they are not there."""

import importlib
from typing import Any

from sigmafmu import SigmafmuError

EXTRAS = {
    "control": "linear",
    "dask": "sweep",
    "distributed": "sweep",
    "fastparquet": "data",
    "gymnasium": "gym",
    "h5netcdf": "sweep",
    "lxml": "loop",
    "mujoco": "mjcf",
    "pandas": "data",
    "pythonfmu": "loop",
    "scipy": "loop",
    "trimesh": "meshes",
    "xarray": "data",
    "zarr": "zarr",
}
"""Package → extra that brings it."""
EXTRA_OF_COMMAND = {"modes": "modes", "sweep": "sweep"}
"""Commands that have an extra of their own."""


def need(module: str, extra: str = "") -> Any:
    """Import a module; SigmafmuError with what to install if its package is not there."""
    try:
        return importlib.import_module(module)
    except ModuleNotFoundError as error:
        raise SigmafmuError(_sentence(module.partition(".")[0], extra)) from error


def missing(package: str, command: str = "") -> str:
    """A sentence about the absent `package`, and how `command` gets it; empty if no extra brings it."""
    name = package.partition(".")[0]
    return _sentence(name, EXTRA_OF_COMMAND.get(command, "")) if name in EXTRAS else ""


def _sentence(package: str, extra: str) -> str:
    extra = extra or EXTRAS[package]
    return f"{package} is not installed; pip install 'sigmafmu[{extra}]' brings it"
