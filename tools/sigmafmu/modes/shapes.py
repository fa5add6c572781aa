"""Beams as clouds whose modes are given functions: polynomials of a cantilever, sines of a beam on two supports.

With ξ = x / L a mode in y moves the node (x, y, z) by (−y w′, w, 0), one in z by (−z w′, 0, w), w′ = dw/dx;
K_ij = EI/L³ ∫ w_i″ w_j″ dξ. Sections are equidistant, inner ones weigh twice as much as those at the ends.
"""

from collections.abc import Callable

import numpy as np

from sigmafmu import SigmafmuError
from sigmafmu.modes.beam import Family, section_motion
from sigmafmu.modes.data import ModalData


def _polynomial(xi: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """ξ², ξ³, …"""
    p = np.arange(2, count + 2)
    bending = np.outer(p * (p - 1), p * (p - 1)) / (p[:, None] + p - 3)
    return xi[:, None] ** p, p * xi[:, None] ** (p - 1), bending


def _sine(xi: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """sin πξ, sin 2πξ, …"""
    k = np.pi * np.arange(1, count + 1)
    return np.sin(xi[:, None] * k), k * np.cos(xi[:, None] * k), np.diag(k**4 / 2)


SHAPES: dict[str, Callable[[np.ndarray, int], tuple[np.ndarray, np.ndarray, np.ndarray]]] = {
    "polynomial": _polynomial,
    "sine": _sine,
}
"""Value and derivative of `count` functions at ξ, each (points, count), and ∫ w_i″ w_j″ dξ."""

LABELS = {"polynomial": lambda j: f"xi^{j + 2}", "sine": lambda j: f"sin {j + 1} pi xi"}


def shape_modes(
    shape: str,
    length: float,
    mass: float,
    *,
    EI: tuple[float, float],
    half_size: tuple[float, float],
    modes: tuple[int, int] = (2, 2),
    sections: int = 11,
) -> ModalData:
    """Cloud of `sections` with nodes at (±half_size[0], ±half_size[1]).

    EI [N m²] and the number of `modes` are given for bending in y, then in z.
    """
    if shape not in SHAPES:
        raise SigmafmuError(f"shape is '{shape}'; allowed are {', '.join(SHAPES)}")
    for name, unit, value in (("length", "m", length), ("mass", "kg", mass), *(("EI", "N m²", x) for x in EI)):
        if not (np.isfinite(value) and value > 0):
            raise SigmafmuError(f"{name} is {value:g} {unit}; it must be positive")
    if sections < 2:
        raise SigmafmuError(f"sections is {sections}; a beam has at least 2")
    if min(modes) < 0 or sum(modes) == 0:
        raise SigmafmuError(
            f"modes are {modes[0]} in y and {modes[1]} in z; at least one in all is needed, none negative"
        )

    xi = np.arange(sections) / (sections - 1)
    yz = np.array([(a * half_size[0], b * half_size[1]) for a in (1, -1) for b in (1, -1)])
    section_mass = np.full(sections, mass / (sections - 1))
    section_mass[[0, -1]] /= 2
    K = np.zeros((sum(modes), sum(modes)))
    fields, names = [], []
    for k, (direction, count) in enumerate(zip("yz", modes, strict=True)):
        value, slope, bending = SHAPES[shape](xi, count)
        family = Family(np.diag(bending), value, slope / length)
        fields.append(section_motion(f"bending {direction}", family, yz))
        own = slice(k * modes[0], k * modes[0] + count)
        K[own, own] = bending * EI[k] / length**3
        names += [f"{direction} {LABELS[shape](j)}" for j in range(count)]
    return ModalData(
        X=np.column_stack((np.repeat(xi * length, 4), np.tile(yz, (sections, 1)))),
        mass=np.repeat(section_mass / 4, 4),
        Phi=np.concatenate([phi for phi, _ in fields], axis=2),
        Theta=np.concatenate([theta for _, theta in fields], axis=2),
        K=K,
        names=tuple(names),
        note=f"beam with {shape} shape functions, {sections} sections of 4 nodes",
    )
