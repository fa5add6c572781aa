"""Cross-sections of beams."""

from dataclasses import dataclass

import numpy as np

from sigmafmu import SigmafmuError


@dataclass(frozen=True)
class Section:
    """A cross-section with principal axes y and z."""

    A: float
    """Area in m²."""
    Iy: float
    """∫ z² dA in m⁴: resists bending in z."""
    Iz: float
    """∫ y² dA in m⁴: resists bending in y."""
    torsion: float
    """St. Venant's torsion constant in m⁴."""
    shear: str
    """Shape whose shear coefficient Cowper (1966) gives: 'rectangle' or 'circle'."""

    @classmethod
    def rectangle(cls, y: float, z: float) -> "Section":
        """Solid, with its sizes in y and z in m."""
        for name, size in (("y", y), ("z", z)):
            _positive(f"the section's size in {name}", size, "m")
        return cls(y * z, y * z**3 / 12, z * y**3 / 12, _rectangle_torsion(max(y, z), min(y, z)), "rectangle")

    @classmethod
    def circle(cls, diameter: float) -> "Section":
        """Solid, with its diameter in m."""
        _positive("the diameter", diameter, "m")
        I = np.pi * diameter**4 / 64  # noqa: E741
        return cls(np.pi * diameter**2 / 4, I, I, 2 * I, "circle")

    def shear_coefficient(self, nu: float) -> float:
        """κ, for Poisson's ratio ν (Cowper 1966)."""
        if self.shear == "rectangle":
            return 10 * (1 + nu) / (12 + 11 * nu)
        return 6 * (1 + nu) / (7 + 6 * nu)

    def nodes(self, count: int) -> np.ndarray:
        """(count, 2) positions y, z of equal masses with the section's second moments; five: with the centre."""
        corners = np.array([(1, 1), (1, -1), (-1, 1), (-1, -1)])
        if count not in (4, 5):
            raise SigmafmuError(f"a section has 4 or 5 nodes, not {count}")
        corners = corners * np.sqrt(count / 4 * np.array((self.Iz, self.Iy)) / self.A)
        return corners if count == 4 else np.vstack(([0.0, 0.0], corners))


def _rectangle_torsion(long: float, short: float) -> float:
    """Saint-Venant's series; its terms fall with n⁻⁵."""
    n = np.arange(1, 200, 2)
    series = np.sum(np.tanh(n * np.pi * long / (2 * short)) / n**5.0)
    return long * short**3 / 3 * (1 - 192 / np.pi**5 * short / long * series)


def _positive(what: str, value: float, unit: str) -> None:
    if not (np.isfinite(value) and value > 0):
        raise SigmafmuError(f"{what} is {value:g} {unit}; it must be positive")
