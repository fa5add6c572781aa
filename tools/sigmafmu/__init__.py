"""Multibody mechanisms as FMI 2.0 co-simulation FMUs, and their Python interface.

>>> import sigmafmu
>>> model = sigmafmu.load("SliderCrank")  # doctest: +SKIP
>>> result = model.run(2.0, parameters={"crank.mass": 0.5})  # doctest: +SKIP
>>> result["guide.displacement"]  # doctest: +SKIP

What is in `__all__` is public and stays (docs/development.md); everything else may change with any version. The names
are imported when they are asked for.
"""

import importlib
import os
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from sigmafmu.fmu import LogMessage as LogMessage
    from sigmafmu.instance import Instance as Instance
    from sigmafmu.instance import SimulationError as SimulationError
    from sigmafmu.instance import State as State
    from sigmafmu.linear import Campbell as Campbell
    from sigmafmu.linear import CriticalSpeed as CriticalSpeed
    from sigmafmu.linear import LinearModel as LinearModel
    from sigmafmu.linear import OperatingPoint as OperatingPoint
    from sigmafmu.linear import linearize as linearize
    from sigmafmu.linear import trim as trim
    from sigmafmu.model import Model as Model
    from sigmafmu.model import load as load
    from sigmafmu.packing import build_fmu as build_fmu
    from sigmafmu.result import NotRecordedError as NotRecordedError
    from sigmafmu.result import Result as Result
    from sigmafmu.result import Statistics as Statistics
    from sigmafmu.sweeps.study import sweep as sweep
    from sigmafmu.variables import Variable as Variable

_MODULES = {
    "Campbell": "sigmafmu.linear",
    "CriticalSpeed": "sigmafmu.linear",
    "Instance": "sigmafmu.instance",
    "LinearModel": "sigmafmu.linear",
    "LogMessage": "sigmafmu.fmu",
    "Model": "sigmafmu.model",
    "NotRecordedError": "sigmafmu.result",
    "OperatingPoint": "sigmafmu.linear",
    "Result": "sigmafmu.result",
    "SimulationError": "sigmafmu.instance",
    "State": "sigmafmu.instance",
    "Statistics": "sigmafmu.result",
    "Variable": "sigmafmu.variables",
    "build_fmu": "sigmafmu.packing",
    "linearize": "sigmafmu.linear",
    "load": "sigmafmu.model",
    "sweep": "sigmafmu.sweeps.study",
    "trim": "sigmafmu.linear",
}
"""Public names that are imported when they are asked for, and where they are."""

__all__ = ["SigmafmuError", "__version__", "fmu_path", "fmus_dir", "models", *_MODULES]  # noqa: PLE0604

__version__ = version("sigmafmu")

FMUS_VARIABLE = "SIGMAFMU_FMUS"
"""Environment variable that names another directory of FMUs than the installed one."""


class SigmafmuError(Exception):
    """An error that its one-sentence message explains to a user. All errors of this package are of this type."""


def fmus_dir() -> Path:
    """Directory that holds the FMUs: $SIGMAFMU_FMUS, else that of the installed package.

    The wheel for all platforms has them in an archive, which is unpacked into the user's cache the first time.
    """
    package = Path(__file__).parent
    if not os.environ.get(FMUS_VARIABLE) and (package / "fmus.tar.xz").is_file():
        from sigmafmu.packed_fmus import unpacked_fmus

        return unpacked_fmus()
    return Path(os.environ.get(FMUS_VARIABLE) or package / "fmus").resolve()


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


def __getattr__(name: str) -> Any:
    if name == "_core":
        return _compiled_module()
    if name not in _MODULES:
        raise AttributeError(f"module 'sigmafmu' has no attribute '{name}'")
    return getattr(importlib.import_module(_MODULES[name]), name)


def _compiled_module() -> Any:
    """`_core`, for `from sigmafmu import _core`: SigmafmuError with what to do where it is missing."""
    try:
        return importlib.import_module("sigmafmu._core")
    except ModuleNotFoundError as error:
        raise SigmafmuError(
            "this needs sigmafmu's compiled module, which the wheel for all platforms has not; "
            "`pip install --no-binary sigmafmu sigmafmu` compiles it and needs a C++ compiler"
        ) from error


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
