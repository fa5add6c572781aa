"""Modal data of flexible bodies: made from beams, shape functions or FE matrices, checked, and written as JSON.

>>> from sigmafmu.modes import Section, beam_modes, write
>>> body = beam_modes(1.0, Section.rectangle(0.02, 0.03), E=210e9, nu=0.3, density=7850.0)
>>> write(body, "beam.json")  # doctest: +SKIP
"""

from sigmafmu.modes.beam import beam_modes
from sigmafmu.modes.data import ModalData
from sigmafmu.modes.fe_data import FeData, read_fe
from sigmafmu.modes.file import read, write
from sigmafmu.modes.reduction import craig_bampton, fixed_modes, free_modes
from sigmafmu.modes.section import Section
from sigmafmu.modes.shapes import shape_modes

__all__ = [
    "FeData",
    "ModalData",
    "Section",
    "beam_modes",
    "craig_bampton",
    "fixed_modes",
    "free_modes",
    "read",
    "read_fe",
    "shape_modes",
    "write",
]
