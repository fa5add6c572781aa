"""Beam modes against analytic eigenfrequencies, and the cloud against the beam it stands for."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.optimize import brentq

from sigmafmu import SigmafmuError
from sigmafmu.modes import Section, beam_modes
from sigmafmu.modes.data import rigid_motions

STEEL = {"E": 210e9, "nu": 0.3, "density": 7850.0}
LENGTH = 2.0
SLENDER = Section.rectangle(2e-4, 3e-4)  # rotary inertia changes ω by (β r / L)² / 2 < 5e-7 up to the third mode
STOUT = Section.rectangle(0.2, 0.3)

CHARACTERISTIC = {
    "clamped": lambda b: np.cos(b) + 1 / np.cosh(b),
    "free": lambda b: np.cos(b) - 1 / np.cosh(b),
    "fixed": lambda b: np.cos(b) - 1 / np.cosh(b),
    "pinned": np.sin,
}
"""Its roots β = k L are the wave numbers of an Euler-Bernoulli beam."""

FIRST = {"clamped": 0, "pinned": 0.5, "fixed": 1, "free": 1}
"""Half waves in front of the first root."""


def wave_numbers(boundary: str, count: int) -> np.ndarray:
    edges = np.pi * (FIRST[boundary] + np.arange(count + 1))
    return np.array([brentq(CHARACTERISTIC[boundary], a, b, xtol=1e-14) for a, b in pairwise(edges)])


def bending_frequencies(section: Section, k: np.ndarray) -> np.ndarray:
    """Euler-Bernoulli, bending in y, Hz."""
    return k**2 * np.sqrt(STEEL["E"] * section.Iz / (STEEL["density"] * section.A)) / (2 * np.pi)


@pytest.mark.parametrize("boundary", CHARACTERISTIC)
def test_slender_beam_has_the_frequencies_of_euler_and_bernoulli(boundary):
    data = beam_modes(LENGTH, SLENDER, **STEEL, elements=40, theory="bernoulli", boundary=boundary, bending=(3, 0))
    beta = wave_numbers(boundary, 3)
    error = data.frequencies / bending_frequencies(SLENDER, beta / LENGTH) - 1
    hermite = (beta / 40) ** 4 / 1440  # of frequencies in a long beam, from above
    rotary = (beta / LENGTH) ** 2 * SLENDER.Iz / SLENDER.A / 2
    assert (error < hermite + 1e-8).all()  # 1e-8: ε times the condition of 40 elements
    assert (error > -rotary - 1e-8).all()


def test_free_beam_leaves_out_six_rigid_motions_and_is_orthogonal_to_them():
    data = beam_modes(LENGTH, STOUT, **STEEL, boundary="free", bending=(3, 3), torsion=2, axial=2, origin=0.5)
    coupling = np.einsum("nip,niq->pq", rigid_motions(data.X), data.weigh(data.Phi))
    assert np.abs(coupling).max() < 1e-10 * np.sqrt(data.total_mass)
    assert data.frequencies.min() > 0.5 * bending_frequencies(STOUT, wave_numbers("free", 1) / LENGTH)[0]
    every = beam_modes(LENGTH, STOUT, **STEEL, elements=2, boundary="free", bending=(4, 4), torsion=2, axial=2)
    assert every.modes == 6 * 3 - 6


def timoshenko(k: np.ndarray) -> np.ndarray:
    """Lower branch of a simply supported Timoshenko beam, Hz."""
    E, nu, rho = STEEL.values()
    A, I = STOUT.A, STOUT.Iz  # noqa: E741
    kGA = STOUT.shear_coefficient(nu) * E / (2 * (1 + nu)) * A
    a, b, c = rho * I * rho * A / kGA, rho * A + rho * I * k**2 + E * I * rho * A / kGA * k**2, E * I * k**4
    return np.sqrt(2 * c / (b + np.sqrt(b**2 - 4 * a * c))) / (2 * np.pi)


def rayleigh(k: np.ndarray) -> np.ndarray:
    """A simply supported Euler-Bernoulli beam with rotary inertia, Hz."""
    return bending_frequencies(STOUT, k) / np.sqrt(1 + k**2 * STOUT.Iz / STOUT.A)


@pytest.mark.parametrize(
    ("theory", "exact", "order", "finest"), [("bernoulli", rayleigh, 4, 2e-6), ("timoshenko", timoshenko, 2, 2e-4)]
)
def test_frequencies_converge(theory, exact, order, finest):
    errors = []
    for elements in (8, 16, 32) if order == 4 else (16, 32, 64):
        data = beam_modes(LENGTH, STOUT, **STEEL, elements=elements, theory=theory, boundary="pinned", bending=(2, 0))
        errors.append(data.frequencies / exact(np.pi * np.arange(1, 3) / LENGTH) - 1)
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert (np.abs(orders - order) < 0.1).all(), orders
    assert np.abs(errors[-1]).max() < finest


@pytest.mark.parametrize(
    ("boundary", "waves"), [("clamped", (0.5, 1.5)), ("pinned", (0.5, 1.5)), ("fixed", (1, 2)), ("free", (1, 2))]
)
def test_torsion_and_stretching(boundary, waves):
    section = Section.circle(0.1)
    E, nu, rho = STEEL.values()
    data = beam_modes(LENGTH, section, **STEEL, elements=64, boundary=boundary, bending=(0, 0), torsion=2, axial=2)
    speeds = np.sqrt(np.array((E / (2 * (1 + nu)), E)) / rho)
    exact = np.outer(speeds, waves) / (2 * LENGTH)
    np.testing.assert_allclose(data.frequencies, exact.ravel(), rtol=(2 * np.pi / 64) ** 2 / 20)  # (k h)² / 24


@pytest.mark.parametrize("section_nodes", [4, 5])
@pytest.mark.parametrize("section", [STOUT, Section.circle(0.2)])
def test_cloud_is_the_beam(section, section_nodes):
    """Mass, inertia and consistent mass matrix to rounding."""
    data = beam_modes(
        LENGTH, section, **STEEL, elements=7, bending=(4, 4), torsion=3, axial=3, section_nodes=section_nodes
    )
    mass = STEEL["density"] * section.A * LENGTH
    np.testing.assert_allclose(data.modal_mass, np.eye(14), atol=1e-9)
    assert data.total_mass == pytest.approx(mass, rel=1e-14)
    np.testing.assert_allclose(data.center_of_mass, (LENGTH / 2, 0, 0), atol=1e-14)
    inertia = np.diag(data.frame_mass)[3:6]
    across = mass * LENGTH**2 / 3 + mass * np.array((section.Iy, section.Iz)) / section.A
    np.testing.assert_allclose(inertia, [mass * (section.Iy + section.Iz) / section.A, *across], rtol=1e-13)


def test_tip_of_a_cantilever_bends_as_statics_tell():
    """With all modes of one element K⁻¹ Φᵀ F is the exact deflection F L³ / 3EI + F L / κGA."""
    data = beam_modes(LENGTH, STOUT, **STEEL, elements=1, bending=(2, 0), section_nodes=5)
    tip = data.Phi[-5, 1]  # on the axis
    E, nu, _ = STEEL.values()
    exact = LENGTH**3 / (3 * E * STOUT.Iz) + LENGTH / (STOUT.shear_coefficient(nu) * E / (2 * (1 + nu)) * STOUT.A)
    assert tip @ np.linalg.solve(data.K, tip) == pytest.approx(exact, rel=1e-12)


def test_rotations_are_those_of_the_nodes():
    """Nodes of a section move as u₀ + θ × r."""
    data = beam_modes(LENGTH, STOUT, **STEEL, bending=(2, 2), torsion=1, axial=1, section_nodes=5)
    X, Phi, Theta = (a.reshape(-1, 5, *a.shape[1:]) for a in (data.X, data.Phi, data.Theta))
    r = X - X[:, :1]
    moved = Phi[:, :1] + np.stack([np.cross(Theta[..., j], r) for j in range(data.modes)], axis=-1)
    np.testing.assert_allclose(Phi, moved, atol=1e-14)


def test_origin_moves_the_frame_along_the_axis():
    data = beam_modes(LENGTH, STOUT, **STEEL, origin=0.25)
    np.testing.assert_allclose((data.X[:, 0].min(), data.X[:, 0].max()), (-0.5, 1.5), rtol=1e-15)


def test_torsion_constants():
    """Timoshenko, Goodier: Theory of Elasticity, table of rectangular bars (four digits)."""
    for ratio, k in ((1, 0.1406), (2, 0.229), (10, 0.312)):
        assert Section.rectangle(1.0, ratio).torsion == pytest.approx(k * ratio, abs=6e-4 * ratio)
    circle = Section.circle(0.3)
    assert circle.torsion == pytest.approx(np.pi * 0.3**4 / 32, rel=1e-15)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"length": -1.0}, "length is -1 m; it must be positive"),
        ({"E": np.nan}, "E is nan N/m²"),
        ({"density": 0.0}, "density is 0 kg/m³"),
        ({"nu": 0.6}, "nu is 0.6; Poisson's ratio is above -1 and at most 0.5"),
        ({"elements": 0}, "elements is 0; a beam has at least 1"),
        ({"theory": "euler"}, "theory is 'euler'; allowed are bernoulli, timoshenko"),
        ({"boundary": "welded"}, "boundary is 'welded'; allowed are clamped, pinned, fixed, free"),
        ({"bending": (5, 0), "elements": 2}, "5 modes in bending y with 2 elements; allowed are 0 to 4"),
        ({"bending": (0, 0)}, "no modes are asked for"),
        ({"section_nodes": 6}, "a section has 4 or 5 nodes, not 6"),
    ],
)
def test_mistakes(change, message):
    with pytest.raises(SigmafmuError, match="^" + message.replace("(", r"\(")):
        beam_modes(**{"length": 1.0, "section": STOUT, **STEEL, **change})


def test_sizes_of_a_section_are_positive():
    with pytest.raises(SigmafmuError, match="section's size in z is 0 m; it must be positive"):
        Section.rectangle(0.1, 0.0)
    with pytest.raises(SigmafmuError, match="the diameter is -1 m"):
        Section.circle(-1.0)
