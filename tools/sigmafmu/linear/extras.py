"""Packages of the extra `linear`, and what to do without them."""

from types import ModuleType

from sigmafmu import SigmafmuError


def scipy_linalg() -> ModuleType:
    """scipy.linalg."""
    try:
        import scipy.linalg
    except ModuleNotFoundError as error:
        raise _missing("discrete time needs SciPy") from error
    return scipy.linalg


def scipy_io() -> ModuleType:
    """scipy.io."""
    try:
        import scipy.io
    except ModuleNotFoundError as error:
        raise _missing(".mat files need SciPy") from error
    return scipy.io


def python_control() -> ModuleType:
    """The package control."""
    try:
        import control
    except ModuleNotFoundError as error:
        raise _missing("to_control() needs python-control") from error
    return control


def _missing(what: str) -> SigmafmuError:
    return SigmafmuError(f"{what}: pip install '.[linear]' in a copy of the repository")
