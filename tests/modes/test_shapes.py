"""The clouds of FlexiblePendulum and FlexibleSliderCrank, written out by formula node by node."""

import numpy as np
import pytest

from sigmafmu import SigmafmuError
from sigmafmu.modes import shape_modes

EPS = np.finfo(float).eps
PENDULUM = {"length": 1.0, "mass": 1.0, "EI": (8.0, 12.0), "half_size": (0.02, 0.02)}
CONROD = {"length": 0.3, "mass": 0.5, "EI": (4.0, 6.0), "half_size": (0.02, 0.02)}

POLYNOMIAL = [(lambda s: s**2, lambda s: 2 * s), (lambda s: s**3, lambda s: 3 * s**2)]
SINE = [(lambda s, k=k: np.sin(k * np.pi * s), lambda s, k=k: k * np.pi * np.cos(k * np.pi * s)) for k in (1, 2)]


@pytest.mark.parametrize(("shape", "beam", "functions"), [("polynomial", PENDULUM, POLYNOMIAL), ("sine", CONROD, SINE)])
def test_nodes_masses_and_displacements(shape, beam, functions):
    data = shape_modes(shape, **beam)
    L, m = beam["length"], beam["mass"]
    node = 0
    for k in range(11):
        for y in (0.02, -0.02):
            for z in (0.02, -0.02):
                np.testing.assert_allclose(data.X[node], (L * k / 10, y, z), rtol=EPS)
                assert data.mass[node] == pytest.approx(m / (20 if k in (0, 10) else 10) / 4, rel=2 * EPS)
                for j, (w, dw) in enumerate(functions):
                    value, slope = w(k / 10), dw(k / 10) / L
                    np.testing.assert_allclose(data.Phi[node, :, j], (-y * slope, value, 0), atol=4 * EPS)
                    np.testing.assert_allclose(data.Phi[node, :, 2 + j], (-z * slope, 0, value), atol=4 * EPS)
                    np.testing.assert_allclose(data.Theta[node, :, j], (0, 0, slope), rtol=4 * EPS, atol=4 * EPS)
                    np.testing.assert_allclose(data.Theta[node, :, 2 + j], (0, -slope, 0), rtol=4 * EPS, atol=4 * EPS)
                node += 1
    assert node == len(data.X) == 44


def test_stiffness_of_the_pendulum():
    block = np.array([[4.0, 6.0], [6.0, 12.0]])
    expected = np.block([[8 * block, np.zeros((2, 2))], [np.zeros((2, 2)), 12 * block]])
    np.testing.assert_array_equal(shape_modes("polynomial", **PENDULUM).K, expected)


def test_stiffness_of_the_rod():
    expected = [EI * (j * np.pi / 0.3) ** 4 * 0.3 / 2 for EI in (4, 6) for j in (1, 2)]
    np.testing.assert_allclose(shape_modes("sine", **CONROD).K, np.diag(expected), rtol=8 * EPS)


@pytest.mark.parametrize(("counts", "names"), [((1, 3), 4), ((3, 0), 3), ((0, 2), 2)])
def test_numbers_of_functions(counts, names):
    data = shape_modes("polynomial", **PENDULUM, modes=counts)
    assert data.modes == len(data.names) == names
    assert np.linalg.eigvalsh(data.K).min() > 0


@pytest.mark.parametrize("shape", ["polynomial", "sine"])
def test_frequencies_come_near_the_beam(shape):
    """Ritz with five functions and fine sections; nodes on the axis, so that there is no rotary inertia."""
    beam = {"length": 1.0, "mass": 1.0, "EI": (8.0, 12.0), "half_size": (0.0, 0.0)}
    data = shape_modes(shape, **beam, modes=(5, 0), sections=2001).scaled("mass")
    beta = {"polynomial": 1.8751040687119611, "sine": np.pi}[shape]
    assert data.frequencies[0] == pytest.approx(beta**2 * np.sqrt(8.0) / (2 * np.pi), rel=1e-4)


@pytest.mark.parametrize(
    ("shape", "change", "message"),
    [
        ("spline", {}, "shape is 'spline'; allowed are polynomial, sine"),
        ("sine", {"mass": 0.0}, "mass is 0 kg; it must be positive"),
        ("sine", {"EI": (4.0, -6.0)}, "EI is -6 N m²; it must be positive"),
        ("sine", {"sections": 1}, "sections is 1; a beam has at least 2"),
        ("sine", {"modes": (0, 0)}, "modes are 0 in y and 0 in z; at least one"),
    ],
)
def test_mistakes(shape, change, message):
    with pytest.raises(SigmafmuError, match="^" + message):
        shape_modes(shape, **{**CONROD, **change})
