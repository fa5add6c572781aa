"""Modes of a straight uniform beam along x from two-node elements, as a cloud of nodes.

A section moves as a rigid plane: u = u₀ + θ × (0, y, z). Bending in y and z, torsion and stretching do not couple, so
each is a problem of its own. Bending elements have deflection w and rotation φ of the section at both ends:

    T = ½ ∫ ρA ẇ² + ρI φ̇² dx,   V = ½ ∫ EI φ'² + κGA (w' − φ)² dx

with interpolations that solve the static problem without load, so that there is no locking (Friedman, Kosmatka 1993);
an infinite κGA makes them Hermite polynomials with φ = w' (Euler-Bernoulli with the sections' rotary inertia).
Frequencies converge with h⁴ there; with shear with h² once elements are short beside the section.

Sections of the cloud are at Gauss-Lobatto points of the elements. Five of them integrate the mass matrix exactly, so
the cloud of point masses *is* the beam with its consistent mass matrix, rotary inertia included.
"""

from dataclasses import dataclass

import numpy as np
import scipy.linalg

from sigmafmu import SigmafmuError
from sigmafmu.modes.data import ModalData
from sigmafmu.modes.section import Section

LOBATTO = (
    (1 + np.array((-1, -np.sqrt(3 / 7), 0, np.sqrt(3 / 7), 1))) / 2,
    np.array((9, 49, 64, 49, 9)) / 180,
)
"""Points and weights on [0, 1]; exact to degree 7, and ẇ² has degree 6."""

BOUNDARIES = {
    "clamped": ((("w", 0), ("phi", 0)), (0,)),
    "pinned": ((("w", 0), ("w", 1)), (0,)),
    "fixed": ((("w", 0), ("phi", 0), ("w", 1), ("phi", 1)), (0, 1)),
    "free": ((), ()),
}
"""Where the floating frame holds the beam: what is zero in bending, and at which ends in torsion and stretching."""

THEORIES = ("bernoulli", "timoshenko")


@dataclass(frozen=True)
class Family:
    """Eigenmodes of one kind of motion: value and, in bending, section rotation at every station; unit modal mass."""

    eigenvalues: np.ndarray
    """(k) ω² in 1/s²."""
    value: np.ndarray
    """(stations, k) w, θ or u."""
    rotation: np.ndarray | None = None
    """(stations, k) φ."""


def beam_modes(
    length: float,
    section: Section,
    *,
    E: float,
    nu: float,
    density: float,
    elements: int = 10,
    theory: str = "timoshenko",
    boundary: str = "clamped",
    bending: tuple[int, int] = (2, 2),
    torsion: int = 0,
    axial: int = 0,
    section_nodes: int = 4,
    origin: float = 0.0,
) -> ModalData:
    """Eigenmodes with unit modal mass: `bending` of them in y and z, then torsion and stretching.

    Lengths in m, E in N/m², density in kg/m³. The frame's origin is on the axis at `origin` times the length. With the
    boundary 'free' rigid motions are left out, and the frame follows the body's mean motion (Tisserand's frame).
    """
    _check(length=length, E=E, density=density, nu=nu, elements=elements, theory=theory, boundary=boundary)
    EI = E * np.array((section.Iz, section.Iy))
    G = E / (2 * (1 + nu))
    kGA = np.inf if theory == "bernoulli" else section.shear_coefficient(nu) * G * section.A
    rho_I = density * np.array((section.Iz, section.Iy))
    counts = {"bending y": bending[0], "bending z": bending[1], "torsion": torsion, "axial": axial}
    problems = {
        "bending y": lambda k: bending_family(length, elements, EI[0], kGA, density * section.A, rho_I[0], boundary, k),
        "bending z": lambda k: bending_family(length, elements, EI[1], kGA, density * section.A, rho_I[1], boundary, k),
        "torsion": lambda k: bar_family(length, elements, G * section.torsion, sum(rho_I), boundary, k),
        "axial": lambda k: bar_family(length, elements, E * section.A, density * section.A, boundary, k),
    }
    if sum(counts.values()) == 0:
        raise SigmafmuError("no modes are asked for: give at least one in bending, torsion or axial")
    for name, count in counts.items():
        limit = problem_size(name, elements, boundary)
        if not 0 <= count <= limit:
            raise SigmafmuError(f"{count} modes in {name} with {elements} elements; allowed are 0 to {limit}")
    families = {name: problems[name](count) for name, count in counts.items() if count}

    x, weights = stations(length, elements)
    yz = section.nodes(section_nodes)
    X = np.column_stack((np.repeat(x, len(yz)), np.tile(yz, (len(x), 1))))
    fields = [section_motion(name, family, yz) for name, family in families.items()]
    kind = {"bernoulli": "Euler-Bernoulli", "timoshenko": "Timoshenko"}[theory]
    return ModalData(
        X=X - (origin * length, 0, 0),
        mass=np.repeat(density * section.A * weights, len(yz)) / len(yz),
        Phi=np.concatenate([phi for phi, _ in fields], axis=2),
        Theta=np.concatenate([theta for _, theta in fields], axis=2),
        K=np.diag(np.concatenate([family.eigenvalues for family in families.values()])),
        names=tuple(f"{name} {j + 1}" for name, count in counts.items() for j in range(count)),
        note=f"{kind} beam of {elements} elements, {boundary}; sections of {section_nodes} nodes at Lobatto points",
    ).with_fixed_signs()


def stations(length: float, elements: int) -> tuple[np.ndarray, np.ndarray]:
    """Lobatto points of all elements, shared ends once, and their weights (sum: `length`); both (4 elements + 1)."""
    points, weights = LOBATTO
    x, w = np.zeros(4 * elements + 1), np.zeros(4 * elements + 1)
    for e in range(elements):
        x[4 * e : 4 * e + 5] = (e + points) * length / elements
        w[4 * e : 4 * e + 5] += weights * length / elements
    return x, w


def section_motion(name: str, family: Family, yz: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Displacement and rotation, each (stations · nodes, 3, k), of the nodes yz of all sections."""
    (sections, k), nodes = family.value.shape, len(yz)
    u, theta = np.zeros((sections, nodes, 3, k)), np.zeros((sections, nodes, 3, k))
    y, z = yz[:, 0, None], yz[:, 1, None]
    value = family.value[:, None, :]
    if name == "axial":
        u[:, :, 0] = value
    elif name == "torsion":
        u[:, :, 1], u[:, :, 2] = -z * value, y * value
        theta[:, :, 0] = value
    else:
        phi = family.rotation[:, None, :]
        in_y = name == "bending y"
        u[:, :, 0] = -(y if in_y else z) * phi
        u[:, :, 1 if in_y else 2] = value
        theta[:, :, 2 if in_y else 1] = phi if in_y else -phi
    return u.reshape(sections * nodes, 3, k), theta.reshape(sections * nodes, 3, k)


def bending_family(
    length: float, elements: int, EI: float, kGA: float, rho_A: float, rho_I: float, boundary: str, count: int
) -> Family:
    """Lowest modes of bending in one plane; degrees of freedom w_0, φ_0, w_1, φ_1, …"""
    h = length / elements
    shear = 12 * EI / (kGA * h**2)
    w, phi = _bending_shapes(LOBATTO[0], h, shear)
    mass = np.einsum("s,si,sj->ij", LOBATTO[1] * h, w, w) * rho_A
    mass += np.einsum("s,si,sj->ij", LOBATTO[1] * h, phi, phi) * rho_I
    a, b = 4 + shear, 2 - shear
    stiffness = np.array(
        [
            [12, 6 * h, -12, 6 * h],
            [6 * h, a * h**2, -6 * h, b * h**2],
            [-12, -6 * h, 12, -6 * h],
            [6 * h, b * h**2, -6 * h, a * h**2],
        ]
    )
    held = [2 * elements * end + (what == "phi") for what, end in BOUNDARIES[boundary][0]]
    eigenvalues, vectors = _modes(stiffness * EI / (h**3 * (1 + shear)), mass, elements, held, 2, count, boundary)
    return Family(eigenvalues, _at_stations(w, vectors, 2), _at_stations(phi, vectors, 2))


def bar_family(length: float, elements: int, stiffness: float, mass: float, boundary: str, count: int) -> Family:
    """Lowest modes of torsion (GJ, ρI_p) or stretching (EA, ρA) with linear elements."""
    h = length / elements
    N = np.column_stack((1 - LOBATTO[0], LOBATTO[0]))
    M = np.einsum("s,si,sj->ij", LOBATTO[1] * h, N, N) * mass
    K = np.array([[1, -1], [-1, 1]]) * stiffness / h
    held = [elements * end for end in BOUNDARIES[boundary][1]]
    eigenvalues, vectors = _modes(K, M, elements, held, 1, count, boundary)
    return Family(eigenvalues, _at_stations(N, vectors, 1))


def problem_size(name: str, elements: int, boundary: str) -> int:
    """Number of flexible modes that the elements have."""
    width = 2 if name.startswith("bending") else 1
    held = len(BOUNDARIES[boundary][0 if width == 2 else 1])
    return width * (elements + 1) - (held or width)  # a free beam has as many rigid motions as a node has freedoms


def _bending_shapes(s: np.ndarray, h: float, shear: float) -> tuple[np.ndarray, np.ndarray]:
    """w and φ, each (points, 4), at s in [0, 1] (Friedman, Kosmatka 1993, Eqs. 8 and 9)."""
    w = [
        1 - 3 * s**2 + 2 * s**3 + shear * (1 - s),
        h * (s - 2 * s**2 + s**3 + shear / 2 * (s - s**2)),
        3 * s**2 - 2 * s**3 + shear * s,
        h * (-(s**2) + s**3 - shear / 2 * (s - s**2)),
    ]
    phi = [
        6 / h * (s**2 - s),
        1 - 4 * s + 3 * s**2 + shear * (1 - s),
        6 / h * (s - s**2),
        3 * s**2 - 2 * s + shear * s,
    ]
    return np.column_stack(w) / (1 + shear), np.column_stack(phi) / (1 + shear)


def _modes(
    K: np.ndarray, M: np.ndarray, elements: int, held: list[int], width: int, count: int, boundary: str
) -> tuple[np.ndarray, np.ndarray]:
    """Eigenvalues and mass-normalised vectors on all degrees of freedom; those `held` are zero."""
    size = width * (elements + 1)
    stiffness, mass = np.zeros((size, size)), np.zeros((size, size))
    for e in range(elements):
        own = slice(width * e, width * (e + 2))
        stiffness[own, own] += K
        mass[own, own] += M
    free = np.setdiff1d(np.arange(size), held)
    rigid = width if boundary == "free" else 0
    subset = (rigid, rigid + count - 1)
    eigenvalues, inner = scipy.linalg.eigh(
        stiffness[np.ix_(free, free)], mass[np.ix_(free, free)], subset_by_index=subset
    )
    vectors = np.zeros((size, count))
    vectors[free] = inner
    return eigenvalues, vectors


def _at_stations(shapes: np.ndarray, vectors: np.ndarray, width: int) -> np.ndarray:
    """(stations, k): element shape functions (5, 2 width) times nodal values."""
    elements = len(vectors) // width - 1
    result = np.zeros((4 * elements + 1, vectors.shape[1]))
    for e in range(elements):
        result[4 * e : 4 * e + 5] = shapes @ vectors[width * e : width * (e + 2)]
    return result


def _check(*, elements: int, theory: str, boundary: str, nu: float, **positive: float) -> None:
    units = {"length": "m", "E": "N/m²", "density": "kg/m³"}
    for name, value in positive.items():
        if not (np.isfinite(value) and value > 0):
            raise SigmafmuError(f"{name} is {value:g} {units[name]}; it must be positive")
    if not -1 < nu <= 0.5:
        raise SigmafmuError(f"nu is {nu:g}; Poisson's ratio is above -1 and at most 0.5")
    if elements < 1:
        raise SigmafmuError(f"elements is {elements}; a beam has at least 1")
    for name, value, allowed in (("theory", theory, THEORIES), ("boundary", boundary, tuple(BOUNDARIES))):
        if value not in allowed:
            raise SigmafmuError(f"{name} is '{value}'; allowed are {', '.join(allowed)}")
