"""Multibody mechanisms as FMI 2.0 co-simulation FMUs: where the FMUs are, and the tools around them.

>>> import sigmafmu
>>> sigmafmu.models()  # doctest: +SKIP
['HeavyTop', 'HighSpeedRotor', 'SliderCrank']
>>> fmpy.simulate_fmu(sigmafmu.fmu_path("HeavyTop"))  # doctest: +SKIP
"""

import importlib
import os
from importlib.metadata import version
from pathlib import Path
from typing import Any

__version__ = version("sigmafmu")

FMUS_VARIABLE = "SIGMAFMU_FMUS"
"""Environment variable that names another directory of FMUs than the installed one."""


class SigmafmuError(Exception):
    """An error that its one-sentence message explains to a user."""


def fmus_dir() -> Path:
    """Directory that holds the FMUs: $SIGMAFMU_FMUS, else the one inside the installed package."""
    return Path(os.environ.get(FMUS_VARIABLE) or Path(__file__).parent / "fmus").resolve()


def models() -> list[str]:
    """Names of the available FMUs, sorted."""
    return sorted(path.stem for path in fmus_dir().glob("*.fmu"))


def fmu_path(model: str) -> Path:
    """Path of the FMU of `model`; raises SigmafmuError with the known models if there is none."""
    path = fmus_dir() / f"{model}.fmu"
    known = models()
    if model not in known:
        hint = f"known models: {', '.join(known)}" if known else f"there are no FMUs in {fmus_dir()}"
        raise SigmafmuError(f"unknown model '{model}'; {hint}")
    return path


_MODULES = {"build_fmu": "sigmafmu.packing", "linearize": "sigmafmu.linear", "trim": "sigmafmu.linear"}
"""What is imported when it is asked for."""


def __getattr__(name: str) -> Any:
    if name not in _MODULES:
        raise AttributeError(f"module 'sigmafmu' has no attribute '{name}'")
    return getattr(importlib.import_module(_MODULES[name]), name)
