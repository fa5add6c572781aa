"""Modal data of flexible bodies: made from beams, shape functions or FE matrices, checked, and written as JSON.

>>> from sigmafmu.modes import Section, beam_modes, write
>>> body = beam_modes(1.0, Section.rectangle(0.02, 0.03), E=210e9, nu=0.3, density=7850.0)
>>> write(body, "beam.json")  # doctest: +SKIP

Names are looked up when they are used: the command line imports this package, and SciPy is an extra.
"""

from importlib import import_module
from typing import Any

_MODULES = {
    "FeData": "fe_data",
    "ModalData": "data",
    "Section": "section",
    "beam_modes": "beam",
    "craig_bampton": "reduction",
    "fe_from_matrices": "fe_data",
    "fixed_modes": "reduction",
    "free_modes": "reduction",
    "read": "file",
    "read_fe": "fe_data",
    "shape_modes": "shapes",
    "write": "file",
}

__all__ = list(_MODULES)


def __getattr__(name: str) -> Any:
    if name not in _MODULES:
        raise AttributeError(f"module {__name__} has no attribute {name}")
    return getattr(import_module(f"{__name__}.{_MODULES[name]}"), name)
