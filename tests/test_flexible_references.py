"""The references of the flexible mechanisms against mechanics, against Exudyn and against chains of rigid segments."""

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp
from scipy.linalg import eigh
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation

from research.reference import (
    FLEXIBLE_MODELS,
    FLEXIBLE_SAMPLE_STEP,
    GRAVITY,
    ROD,
    ROD_LENGTH,
    differences,
    exudyn_flexible,
    flexible,
    group_of,
    rotating_beam,
    vector_columns,
)
from research.reference.clouds import (
    PENDULUM_ANGULAR_VELOCITY,
    PENDULUM_BENDING,
    SpinUp,
    beam_cloud,
    cantilever,
    cantilever_root,
    conrod_cloud,
    free_root,
    pendulum_cloud,
    power,
    power_stiffness,
    sine,
)
from research.reference.exudyn_models import simulate
from research.reference.make import richardson
from research.reference.make_flexible import EXUDYN, sample_times, shared
from research.reference.minimal_coordinates import SliderCrank
from research.reference.segments import pendulum_chain, pendulum_motion, spin_up_chain, spin_up_deflection
from sigmafmu.compare import read_reference

REFERENCES = Path(__file__).parent / "references"
LIVE = {
    "FlexiblePendulum": (0.1, 1e-4),
    "FlexibleSliderCrank": (0.1, 1e-4),
    "SpinUpBeam": (5.0, 2.5e-3),
}  # span, step; s
SHORT = {"FlexiblePendulum": 0.05, "FlexibleSliderCrank": 0.03, "SpinUpBeam": 0.5}  # s


@cache
def reference(name):
    return read_reference(REFERENCES / f"{name}.csv")


def vector(history, name, size=3):
    return np.column_stack([history[column] for column in vector_columns(name, size)])


def figures(header, kind):
    """The header's `kind, group: value unit` lines as {group: value}."""
    start = f"{kind}, "
    return {key.removeprefix(start): float(text.split()[0]) for key, text in header.items() if key.startswith(start)}


def node_motion(history, name, cloud):
    """Nodes' positions and velocities in W, samples × nodes × 3, from the columns of a flexible body."""
    r = Rotation.from_quat(vector(history, f"{name}.quaternion", 4), scalar_first=True).as_matrix()
    count = cloud.stiffness.shape[0]
    p = cloud.nodes + np.einsum("iaf,nf->nia", cloud.modes, vector(history, f"{name}.modal", count))
    flow = np.einsum("iaf,nf->nia", cloud.modes, vector(history, f"{name}.modalRate", count))
    flow = flow + np.cross(vector(history, f"{name}.angularVelocity")[:, None], p)
    position, velocity = vector(history, f"{name}.position"), vector(history, f"{name}.velocity")
    turn = r.transpose(0, 2, 1)
    return position[:, None] + p @ turn, velocity[:, None] + flow @ turn


# --- clouds and eigenfrequencies --------------------------------------------------------------------------------------


def test_sections_hold_the_mass_of_their_length():
    cloud = pendulum_cloud()
    assert cloud.nodes.shape == (44, 3)
    assert cloud.mass == pytest.approx(1.0, rel=1e-15)
    np.testing.assert_allclose(cloud.masses @ cloud.nodes, [0.5, 0.0, 0.0], atol=1e-16)
    np.testing.assert_allclose([cloud.masses[cloud.section(k)].sum() for k in (0, 5, -1)], [0.05, 0.1, 0.05])
    np.testing.assert_allclose(cloud.nodes[cloud.section(-1)].mean(axis=0), [1.0, 0.0, 0.0])


@pytest.mark.parametrize("shape", [power(2), power(3), sine(2), cantilever(1), cantilever(3)])
def test_slope_is_the_derivative_of_the_shape(shape):
    xi, e = np.linspace(0.1, 1.0, 10), 1e-5
    w, slope = shape
    # central differences: e² w‴/6 < 2e-7 for these shapes
    np.testing.assert_allclose(slope(xi), (w(xi + e) - w(xi - e)) / (2 * e), atol=2e-7)


def test_stiffness_is_the_bending_energy():
    """K_ij = EI ∫ w_i″ w_j″ dx by quadrature, for powers, sines and cantilever modes."""
    e, length = 1e-4, 0.7

    def curvature(shape, x):
        return (shape[1](x / length + e) - shape[1](x / length - e)) / (2 * e * length**2)

    def energy(a, b):
        return quad(lambda x: curvature(a, x) * curvature(b, x), 0.0, length)[0]

    powers = power_stiffness([2, 3], 5.0, length)
    expected = [[5.0 * energy(power(i), power(j)) for j in (2, 3)] for i in (2, 3)]
    np.testing.assert_allclose(powers, expected, rtol=1e-6)
    rod = conrod_cloud(0.7, 1.0).stiffness
    np.testing.assert_allclose(rod[:2, :2], np.diag([4.0 * energy(sine(n), sine(n)) for n in (1, 2)]), rtol=1e-6)
    beam = SpinUp(length=0.7)
    expected = np.diag([beam.bending * energy(cantilever(n), cantilever(n)) for n in (1, 2, 3)])
    np.testing.assert_allclose(beam.cloud.stiffness, expected, rtol=1e-5)


def test_roots_of_uniform_beams():
    """cos β cosh β = ∓1; the table of every textbook."""
    np.testing.assert_allclose([cantilever_root(n) for n in (1, 2, 3)], [1.87510407, 4.69409113, 7.85475744], atol=5e-9)
    np.testing.assert_allclose([free_root(n) for n in (1, 2, 3)], [4.73004074, 7.85320462, 10.99560784], atol=5e-9)


def test_cantilever_frequencies_of_the_clouds():
    """The frame held: ξ², ξ³ give the first frequency to 0.5 % (Ritz), the lumped masses of ten sections add 1 %."""
    cloud = pendulum_cloud()
    squares = eigh(cloud.stiffness, cloud.modal_mass, eigvals_only=True)
    expected = cantilever_root(1) ** 2 * np.sqrt(PENDULUM_BENDING)
    np.testing.assert_allclose(np.sqrt(squares[:2]), expected, rtol=0.015)
    errors = []
    for intervals in (40, 80):
        beam = SpinUp(intervals=intervals, second_moment=1e-14)  # hardly any rotary inertia
        scale = np.sqrt(beam.bending / (beam.mass * beam.length**3))
        squares = eigh(beam.cloud.stiffness, beam.cloud.modal_mass, eigvals_only=True)
        found = np.sqrt(squares) / scale
        errors.append(found / [cantilever_root(n) ** 2 for n in (1, 2, 3)] - 1.0)
    assert np.abs(errors[0]).max() < 2e-3
    np.testing.assert_allclose(errors[0] / errors[1], 4.0, rtol=0.05)  # the trapezoidal rule of the masses


def test_rod_frequencies_are_those_of_a_pinned_beam_with_rotary_inertia():
    """ω² = EI k⁴ / (ρA (1 + k² c²)), k = nπ/L: the sums over ten sections are exact for these sines."""
    cloud = conrod_cloud(ROD_LENGTH, ROD.mass)
    wave = np.array([1, 2]) * np.pi / ROD_LENGTH
    line = ROD.mass / ROD_LENGTH * (1.0 + wave**2 * 0.02**2)
    expected = np.concatenate([bending * wave**4 / line for bending in (4.0, 6.0)])
    np.testing.assert_allclose(np.diag(cloud.stiffness) / np.diag(cloud.modal_mass), expected, rtol=1e-12)


def test_free_free_frequencies():
    """A free frame and shapes ξ² … ξ⁸: rigid modes and the free-free frequencies; the error falls with 1/sections²."""
    powers = range(2, 9)
    stiffness = power_stiffness(list(powers), 1.0, 1.0)
    errors = []
    for intervals in (50, 100):
        cloud = beam_cloud(1.0, 1.0, intervals, 1e-4, [power(n) for n in powers], [], stiffness)
        rigid = np.zeros((*cloud.nodes.shape, 2))
        rigid[:, 1, 0], rigid[:, 1, 1], rigid[:, 0, 1] = 1.0, cloud.nodes[:, 0], -cloud.nodes[:, 1]
        modes = np.concatenate([rigid, cloud.modes], axis=2)
        mass = np.einsum("i,iaf,iag->fg", cloud.masses, modes, modes)
        full = np.zeros_like(mass)
        full[2:, 2:] = stiffness
        squares = eigh(full, mass, eigvals_only=True)
        np.testing.assert_allclose(squares[:2], 0.0, atol=1e-6)
        errors.append(np.sqrt(squares[2]) / free_root(1) ** 2 - 1.0)
        assert np.sqrt(squares[3]) == pytest.approx(free_root(2) ** 2, rel=0.01)
    assert abs(errors[0]) < 5e-3
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.1)


def pinned_frequencies(cloud):
    """Eigenfrequencies in the plane x, y with the frame free to turn about its origin, the rigid one first."""
    turn = np.zeros((*cloud.nodes.shape, 1))
    turn[:, 1, 0], turn[:, 0, 0] = cloud.nodes[:, 0], -cloud.nodes[:, 1]
    modes = np.concatenate([turn, cloud.modes], axis=2)
    full = np.zeros((modes.shape[2],) * 2)
    full[1:, 1:] = cloud.stiffness
    squares = eigh(full, np.einsum("i,iaf,iag->fg", cloud.masses, modes, modes), eigvals_only=True)
    return np.sqrt(np.abs(squares))


def test_pinned_free_frequency_of_the_pendulum():
    """tan β = tanh β, β = 3.9266. ξ² and ξ³ alone give it 14 % too high; with two more shapes it is right."""
    expected = brentq(lambda beta: np.tan(beta) - np.tanh(beta), 3.8, 4.0) ** 2
    two, four = (
        pinned_frequencies(
            beam_cloud(1.0, 1.0, 200, 1e-4, [power(n) for n in powers], [], power_stiffness(powers, 1.0, 1.0))
        )[1]
        for powers in ([2, 3], [2, 3, 4, 5])
    )
    assert 1.13 < two / expected < 1.145
    assert four == pytest.approx(expected, rel=2e-3)


# --- the files --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", FLEXIBLE_MODELS)
def test_file_covers_its_span_and_states_a_small_error(name):
    header, history = reference(name)
    np.testing.assert_allclose(history["time"], sample_times(name), rtol=1e-11)
    assert header["model"] == name
    assert all(np.isfinite(values).all() for values in history.values())
    assert (REFERENCES / f"{name}.csv").stat().st_size < 400_000
    stated = figures(header, "stated error")
    assert stated["position"] <= 1e-11
    assert stated["modal"] <= 1e-11
    assert stated["quaternion"] <= 1e-11


def excess(name, times, factor):
    """Groups by which DOP853 differs from the file more than `factor` times what its header states."""
    header, history = reference(name)
    found = differences(*shared(flexible.solve(name, times), history))
    allowed = {group: factor * value for group, value in figures(header, "stated error").items()}
    for column, values in history.items():
        if column != "time":  # 13 digits are written: 5e-13; 1e-15 is rounding
            group = group_of(column)
            allowed[group] = max(allowed[group], 5e-13 * np.abs(values).max() + 1e-15)
    return {group: (value, allowed[group]) for group, value in found.items() if value > allowed[group]}


@pytest.mark.parametrize("name", FLEXIBLE_MODELS)
def test_file_agrees_with_the_equations_solved_in_double_precision(name):
    assert excess(name, sample_times(name, 10 * FLEXIBLE_SAMPLE_STEP[name]), 1) == {}


@pytest.mark.heavy
@pytest.mark.parametrize("name", FLEXIBLE_MODELS)
def test_whole_file_agrees_with_the_equations_solved_in_double_precision(name):
    """The factor leaves room for rounding on another machine."""
    assert excess(name, sample_times(name), 2) == {}


@pytest.mark.skipif(np.finfo(np.longdouble).eps > 2e-19, reason="NumPy's longdouble is not an extended precision here")
@pytest.mark.parametrize("name", FLEXIBLE_MODELS)
def test_extrapolation_has_converged(name, monkeypatch):
    """Half the steps change nothing that a double could show, with room for 1/horizon as much on the whole span."""
    times = np.array([0.0, SHORT[name]])
    once = flexible.precise(name, times)
    plain = flexible.extrapolate
    monkeypatch.setattr(flexible, "extrapolate", lambda rhs, y0, t, step: plain(rhs, y0, t, 0.5 * step))
    twice = flexible.precise(name, times)
    # positions in the last digits; rates and the turn about the thin beam's axis (inertia 8e-4 kg m2) lose some
    room = {"angularVelocity": 2e-14, "modalRate": 2e-14, "energy": 1e-14}
    found = differences(once, twice)
    assert {g: v for g, v in found.items() if v > room.get(g, 1e-15)} == {}


def test_pendulum_keeps_energy_and_vertical_angular_momentum():
    """From the nodes' positions and velocities, not from the file's energies."""
    history = reference("FlexiblePendulum")[1]
    cloud = pendulum_cloud()
    r, v = node_motion(history, "beam", cloud)
    zeta = vector(history, "beam.modal", 4)
    kinetic = 0.5 * np.einsum("i,nia,nia->n", cloud.masses, v, v)
    potential = 0.5 * np.einsum("nf,fg,ng->n", zeta, cloud.stiffness, zeta)
    potential -= np.einsum("i,nia,a->n", cloud.masses, r, GRAVITY)
    energy = kinetic + potential
    momentum = np.einsum("i,nia->na", cloud.masses, np.cross(r, v))[:, 2]
    np.testing.assert_allclose(energy, energy[0], atol=2e-12)  # 13 digits of rates of up to 12 rad/s
    np.testing.assert_allclose(momentum, momentum[0], atol=2e-12)
    np.testing.assert_allclose(history["energy.kinetic"], kinetic, atol=2e-12)
    np.testing.assert_allclose(history["energy.potential"], potential, atol=2e-12)
    np.testing.assert_allclose(r[:, cloud.section(-1)].mean(axis=1), vector(history, "tip.position"), atol=1e-12)
    assert np.abs(zeta).max() > 0.01  # it does bend


def test_pendulum_starts_with_the_acceleration_of_its_nodes():
    """d'Alembert's principle at a bent state: the nodes' r̈ along the solution, by differences, balances the forces."""
    cloud = pendulum_cloud()
    system = flexible.Pendulum(cloud)
    y = system.start(PENDULUM_ANGULAR_VELOCITY)
    y[4:8], y[11:15] = [0.03, -0.02, 0.01, 0.02], [0.5, -1.0, 0.7, 0.2]
    y[:4] = [0.5, -0.5, 0.1, 0.7]
    y[:4] /= np.linalg.norm(y[:4])

    def nodes(state):
        r = Rotation.from_quat(state[:4] / np.linalg.norm(state[:4]), scalar_first=True).as_matrix()
        return (cloud.nodes + cloud.modes @ state[4:8]) @ r.T, r

    h, slope = 1e-4, system.rhs(0.0, y)

    def shifted(t):  # y + t ẏ + ½ t² ÿ, ÿ along the solution
        e = 1e-6
        second = (system.rhs(0.0, y + e * slope) - system.rhs(0.0, y - e * slope)) / (2 * e)
        return y + t * slope + 0.5 * t * t * second

    before, now, after = (nodes(shifted(t))[0] for t in (-h, 0.0, h))
    force = cloud.masses[:, None] * ((after - 2.0 * now + before) / h**2 - GRAVITY)
    r = nodes(y)[1]
    # virtual displacements: turns about W's axes and the modes
    scale = np.abs(force).sum()
    np.testing.assert_allclose(np.cross(now, force).sum(axis=0), 0.0, atol=1e-6 * scale)
    elastic = np.einsum("ia,iaf->f", force @ r, cloud.modes) + cloud.stiffness @ y[4:8]
    np.testing.assert_allclose(elastic, 0.0, atol=1e-6 * scale)


def test_slider_crank_keeps_its_energy_and_its_loop():
    history = reference("FlexibleSliderCrank")[1]
    energy = history["energy.kinetic"] + history["energy.potential"]
    np.testing.assert_allclose(energy, energy[0], atol=1e-12)
    rigid = SliderCrank(history["crankPivot.angle"])
    rod = np.stack([e[0] for e in rigid.bodies["rod"].axes], axis=2)
    ours = Rotation.from_quat(vector(history, "rod.quaternion", 4), scalar_first=True).as_matrix()
    np.testing.assert_allclose(ours, rod, atol=2e-12)
    np.testing.assert_allclose(vector(history, "rod.position"), rigid.b, atol=1e-14)
    np.testing.assert_allclose(history["guide.displacement"], rigid.c[:, 0], atol=1e-14)
    cloud = conrod_cloud(ROD_LENGTH, ROD.mass)
    _, v = node_motion(history, "rod", cloud)
    rod_energy = 0.5 * np.einsum("i,nia,nia->n", cloud.masses, v, v)
    others = [b.body for n, b in rigid.bodies.items() if n != "rod"]
    rate = history["crankPivot.angularRate"]
    for body in others:
        motion = rigid.bodies[body.name]
        speed, spin = motion.x[1] * rate[:, None], motion.w * rate[:, None]
        rod_energy = rod_energy + 0.5 * body.mass * (speed**2).sum(1) + 0.5 * body.inertia[0] * spin[:, 0] ** 2
    np.testing.assert_allclose(history["energy.kinetic"], rod_energy, atol=1e-12)


def test_stiff_rod_moves_as_a_rigid_one():
    """Ten thousand times the stiffness: deflections fall as much; the frame's motion tends to that of ζ = 0."""
    times = np.array([0.0, 0.02, 0.04])
    cloud = conrod_cloud(ROD_LENGTH, ROD.mass)
    rigid = replace(cloud, modes=cloud.modes[:, :, :0], stiffness=np.zeros((0, 0)))
    expected = flexible.flexible_slider_crank(times, cloud=rigid)["crankPivot.angle"]
    errors = []
    for factor in (10.0, 100.0):
        history = flexible.flexible_slider_crank(times, cloud=replace(cloud, stiffness=factor * cloud.stiffness))
        errors.append(np.abs(history["crankPivot.angle"] - expected).max())
    assert 0 < errors[0] < 1e-4
    assert errors[1] < 0.2 * errors[0]


# --- Exudyn -----------------------------------------------------------------------------------------------------------


@pytest.mark.exudyn
@pytest.mark.parametrize("name", EXUDYN)
def test_exudyn_live_converges_to_the_file(name):
    """Newmark's method: second order towards the reference, and extrapolated within its own error."""
    build, settings = EXUDYN[name]
    history, sample = reference(name)[1], FLEXIBLE_SAMPLE_STEP[name]
    span, finest = LIVE[name]
    steps = [replace(settings, step_size=factor * finest) for factor in (4, 2, 1)]
    runs = [simulate(name, step, span, sample, build=build).history for step in steps]
    errors = [differences(*shared(run, history)) for run in runs]
    for group in ("position", "quaternion", "modal"):
        assert errors[1][group] / errors[2][group] == pytest.approx(4.0, abs=0.4)
    coarse, fine = richardson(*runs[:2]), richardson(*runs[1:])
    own, found = differences(fine, coarse), differences(*shared(fine, history))
    assert {g: (v, own[g]) for g, v in found.items() if v > own[g]} == {}


@pytest.mark.exudyn
def test_live_comparison_notices_a_slightly_different_beam(monkeypatch):
    """A thousandth more stiffness must not pass."""
    build, settings = EXUDYN["FlexiblePendulum"]
    stiffer = tuple(1.001 * b for b in PENDULUM_BENDING)
    monkeypatch.setattr(exudyn_flexible, "pendulum_cloud", lambda: pendulum_cloud(stiffer))
    runs = [
        simulate("FlexiblePendulum", replace(settings, step_size=h), 0.1, 0.01, build=build).history
        for h in (4e-4, 2e-4, 1e-4)
    ]
    coarse, fine = richardson(*runs[:2]), richardson(*runs[1:])
    own, found = differences(fine, coarse), differences(*shared(fine, reference("FlexiblePendulum")[1]))
    assert found["position"] > own["position"]
    assert found["modal"] > own["modal"]


# --- spin-up ----------------------------------------------------------------------------------------------------------


def test_hub_and_beam_take_up_the_angular_momentum_of_the_law():
    """H(t) = ∫ T dt = J Ω(t), exactly, whatever the beam does."""
    spin_up = SpinUp()
    history = reference("SpinUpBeam")[1]
    cloud = spin_up.cloud
    r, v = node_motion(history, "beam", cloud)
    momentum = np.einsum("i,nia->na", cloud.masses, np.cross(r, v))[:, 2]
    momentum += spin_up.hub_inertia * history["hubPivot.angularRate"]
    expected = spin_up.inertia * spin_up.speed(history["time"])
    np.testing.assert_allclose(momentum, expected, atol=1e-12 * expected.max())


def test_spin_up_law():
    spin_up, e = SpinUp(), 1e-4
    t = np.linspace(0.5, 20.0, 40)
    for function, derivative in ((spin_up.angle, spin_up.speed), (spin_up.speed, spin_up.acceleration)):
        np.testing.assert_allclose((function(t + e) - function(t - e)) / (2 * e), derivative(t), atol=1e-5)
    assert spin_up.speed(np.array(15.0)) == spin_up.speed(np.array(99.0)) == spin_up.final_speed


def test_heavy_hub_follows_the_law():
    """To 2e-4 of the final speed."""
    spin_up, history = SpinUp(), reference("SpinUpBeam")[1]
    lag = history["hubPivot.angularRate"] - spin_up.speed(history["time"])
    assert 0 < np.abs(lag).max() < 2e-4 * spin_up.final_speed


def free_end(speed, square, terms=120):
    """det of (w″, w‴) at the free end over the two solutions clamped at the hub, by power series in ξ (Frobenius).

    w⁗ − ½ Ω² ((1 − ξ²) w′)′ − ω² w = 0 as in Wright, Smith, Thresher, Wang (J. Appl. Mech. 49 (1982) 197).
    """
    ends = []
    for start in ((1.0, 0.0), (0.0, 1.0)):
        a = np.zeros(terms)
        a[2:4] = start
        for k in range(terms - 4):
            bent = 0.5 * speed**2 * ((k + 2) * (k + 1) * a[k + 2] - k * (k + 1) * a[k]) + square * a[k]
            a[k + 4] = bent / ((k + 4) * (k + 3) * (k + 2) * (k + 1))
        k = np.arange(terms)
        ends.append(((k * (k - 1) * a).sum(), (k * (k - 1) * (k - 2) * a).sum()))
    return np.linalg.det(ends)


@pytest.mark.parametrize("speed", [0.0, 1.0, 2.0, 4.0, 8.0])
def test_rotating_beam_frequencies(speed):
    for in_plane in (False, True):
        for square in rotating_beam.frequencies(speed, in_plane)[:2] + in_plane * speed**2:
            root = brentq(lambda x: free_end(speed, x), 0.999 * square, 1.001 * square, xtol=1e-12)
            assert square == pytest.approx(root, rel=1e-8)


def test_southwell_coefficient():
    assert rotating_beam.southwell(0) == pytest.approx(1.193, abs=5e-4)
    speed = 0.1
    rise = rotating_beam.frequencies(speed, in_plane=False)[0] - cantilever_root(1) ** 4
    assert rise / speed**2 == pytest.approx(rotating_beam.southwell(0), rel=1e-4)


def test_linear_modes_soften_where_a_beam_stiffens():
    """K − Ω² M: negative above the first eigenfrequency at rest; with the centrifugal stretching it never is."""
    first = cantilever_root(1) ** 2
    for speed in (0.9 * first, 1.1 * first):
        linear = rotating_beam.frequencies(speed, in_plane=True, stiffening=False)[0]
        assert linear == pytest.approx(first**2 - speed**2, abs=1e-6)
        assert rotating_beam.frequencies(speed, in_plane=True)[0] > first**2
    beam = SpinUp()
    held = beam.cloud
    limit = np.sqrt(eigh(held.stiffness, held.modal_mass, eigvals_only=True)[0])
    assert limit == pytest.approx(first * np.sqrt(beam.bending / (beam.mass * beam.length**3)), rel=1e-3)
    assert SpinUp().final_speed < 0.2 * limit


def linearised_chain(speed, segments, beam):
    """Smallest eigenfrequency in the plane of a chain on a hub that turns steadily, rad/s."""
    chain = spin_up_chain(replace(beam, hub_inertia=1e9), segments)
    y = chain.start(np.array([0.0, 0.0, speed]))
    angles = slice(4, 4 + segments)
    e, columns = 1e-6, []
    for k in range(segments):
        change = np.zeros_like(y)
        change[angles.start + k] = e
        columns.append((chain.rhs(99.0, y + change) - chain.rhs(99.0, y - change))[5 + segments :] / (2 * e))
    return np.sqrt(np.linalg.eigvals(-np.array(columns).T).real.min())


@pytest.mark.parametrize("speed", [0.0, 2.0, 6.0])
def test_chain_has_the_frequencies_of_a_rotating_beam(speed):
    """With 1/segments² to the exact one: also at 6 rad/s, far above what linear modes can do."""
    beam = SpinUp()
    scale = np.sqrt(beam.bending / (beam.mass * beam.length**3))
    exact = np.sqrt(rotating_beam.frequencies(speed / scale, in_plane=True)[0]) * scale
    errors = [linearised_chain(speed, n, beam) / exact - 1.0 for n in (10, 20)]
    assert abs(errors[1]) < 1e-2
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.1)


def deflections(factor, powers, times):
    """Tip in the frame of the root: chain of ten segments, modes of the same sections; `factor` times the stiffness."""
    bending = tuple(factor * b for b in PENDULUM_BENDING)
    chain = pendulum_motion(pendulum_chain(bending), times, rtol=1e-6)[1]
    zero = np.zeros((len(powers), len(powers)))
    k = [power_stiffness(powers, b, 1.0) for b in bending]
    shapes = [power(n) for n in powers]
    cloud = beam_cloud(1.0, 1.0, 10, 0.02, shapes, shapes, np.block([[k[0], zero], [zero, k[1]]]))
    system = flexible.Pendulum(cloud)
    start = system.start(PENDULUM_ANGULAR_VELOCITY)
    states = solve_ivp(system.rhs, times[[0, -1]], start, "DOP853", t_eval=times, rtol=1e-9, atol=1e-11).y.T
    zeta = states[:, 4 : 4 + system.nodes.modes]
    modes = zeta @ cloud.modes[cloud.section(-1)].mean(axis=0).T
    return chain[:, 1:], modes[:, 1:]


@pytest.mark.heavy
def test_pendulum_with_more_modes_and_a_stiffer_beam_moves_as_a_chain():
    """Two of its slowest periods, 16 times the stiffness. What is left with four shapes in each plane is the error of
    ten segments (3 %, by twenty) and the missing stiffening, which falls with 1/stiffness. Two shapes are 14 % off in
    frequency: the phase is lost.
    """
    times = np.linspace(0.0, 0.06, 13)
    chain, four = deflections(16.0, [2, 3, 4, 5], times)
    _, two = deflections(16.0, [2, 3], times)
    size = np.abs(chain).max()
    assert size > 1e-3
    assert np.abs(four - chain).max() < 0.08 * size
    assert np.abs(two - chain).max() > 0.3 * size


@pytest.mark.heavy
def test_pendulum_as_defined_bends_more_than_a_chain():
    """What linear modes cannot do, with any number of shapes: the stiffening by the centrifugal force is missing."""
    times = np.linspace(0.0, 0.24, 13)
    for powers in ([2, 3], [2, 3, 4, 5]):
        chain, modes = deflections(1.0, powers, times)
        assert 1.3 < np.abs(modes).max() / np.abs(chain).max() < 1.6


@pytest.mark.slow
def test_spin_up_is_softer_than_a_chain_by_what_linear_modes_neglect():
    """y_modes/y_chain = (ω_1² + (c − 1) Ω²)/(ω_1² − Ω²) half way of the rise, where the deflection is largest.

    The deflection swings a little about the mean taken here: within 20 % of the difference, which is 1 % and 4 %.
    """
    beam, times = SpinUp(), np.linspace(0.0, 10.0, 51)
    first = cantilever_root(1) ** 4 * beam.bending / (beam.mass * beam.length**3)
    stiffening = rotating_beam.southwell(0) - 1.0
    for final_speed in (0.5, 1.0):
        spin_up = replace(beam, final_speed=final_speed)
        coarse, fine = (spin_up_deflection(spin_up, n, times) for n in (8, 16))
        chain = (4.0 * fine - coarse) / 3.0
        modes = flexible.spin_up_beam(times, spin_up=spin_up)["tip.deflection"]
        middle = (times >= 6.0) & (times <= 9.0)
        square = spin_up.speed(np.array(7.5)) ** 2
        expected = (first + stiffening * square) / (first - square) - 1.0
        assert modes[middle].mean() / chain[middle].mean() - 1.0 == pytest.approx(expected, rel=0.2)
