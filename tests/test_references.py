"""The reference files against an independent solution, and against Exudyn run live."""

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from research.reference import (
    CRANK,
    CRANK_CENTRE,
    GRAVITY,
    MODELS,
    ROD,
    SAMPLE_STEP,
    SLIDER,
    STOP_TIME,
    TOP,
    TOP_PIVOT,
    Rotor,
    add_vector,
    differences,
    exudyn_models,
    quaternions_from_matrices,
    vector_columns,
)
from research.reference.make import RECIPES, richardson
from research.reference.minimal_coordinates import SliderCrank, integrate, solve
from sigmafmu.compare import read_reference

REFERENCES = Path(__file__).parent / "references"
LIVE_HORIZON = {"HeavyTop": 0.2, "HighSpeedRotor": 0.05, "SliderCrank": 0.5}  # s


@cache
def reference(name):
    return read_reference(REFERENCES / f"{name}.csv")


@cache
def independent(name):
    return solve(name, reference(name)[1]["time"])


def vector(history, name, size=3):
    return np.column_stack([history[column] for column in vector_columns(name, size)])


def figures(header, kind):
    """The header's `kind, group: value unit` lines as {group: value}."""
    start = f"{kind}, "
    return {key.removeprefix(start): float(text.split()[0]) for key, text in header.items() if key.startswith(start)}


def excess(history, other, allowed):
    """Groups whose difference is larger than allowed: {group: (difference, allowed)}."""
    found = differences({column: history[column] for column in other}, other)
    assert set(found) == set(allowed)
    return {group: (found[group], allowed[group]) for group in found if not found[group] <= allowed[group]}


# --- the files -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", MODELS)
def test_file_covers_its_span_and_says_how_it_was_made(name):
    header, history = reference(name)
    samples = round(STOP_TIME[name] / SAMPLE_STEP[name])
    np.testing.assert_allclose(history["time"], np.arange(samples + 1) * SAMPLE_STEP[name], rtol=1e-11)
    assert header["solver"].startswith("Exudyn 1.13")
    assert header["model"] == name
    assert all(np.isfinite(values).all() for values in history.values())
    assert (REFERENCES / f"{name}.csv").stat().st_size < 400_000


@pytest.mark.parametrize("name", MODELS)
def test_quaternions_are_unit_and_keep_their_sign(name):
    history = reference(name)[1]
    bodies = [column.removesuffix(".quaternion[1]") for column in history if column.endswith(".quaternion[1]")]
    assert bodies
    for body in bodies:
        q = vector(history, f"{body}.quaternion", 4)
        np.testing.assert_allclose(np.linalg.norm(q, axis=1), 1.0, atol=1e-12)  # 13 digits are written
        assert (np.einsum("ij,ij->i", q[1:], q[:-1]) >= 0).all()


@pytest.mark.parametrize("name", MODELS)
def test_file_agrees_with_minimal_coordinates(name):
    header, history = reference(name)
    assert excess(independent(name), history, figures(header, "stated error")) == {}
    # The header's own deviation again; the factor leaves room for rounding on another machine.
    assert excess(independent(name), history, {g: 2 * v for g, v in figures(header, "deviation").items()}) == {}


@pytest.mark.parametrize("name", MODELS)
def test_stated_errors_are_small(name):
    """What the acceptance of the FMUs needs: 1e-8 m and 1e-4 N at least."""
    stated = figures(reference(name)[0], "stated error")
    assert stated["position"] <= 1e-8
    assert stated.get("reactionForce", 0.0) <= 1e-4


# --- Exudyn, live ----------------------------------------------------------------------------------------------------


def live(name, build=None):
    """The coarser runs of the file again, on a short horizon: their distance to the file is its stated error."""
    recipe, span, sample = RECIPES[name], LIVE_HORIZON[name], SAMPLE_STEP[name]
    steps = [factor * recipe.settings.step_size for factor in ((4, 2) if recipe.extrapolate else (2,))]
    runs = [
        exudyn_models.simulate(name, replace(recipe.settings, step_size=step), span, sample, build=build).history
        for step in steps
    ]
    return richardson(*runs) if recipe.extrapolate else runs[0]


def start_of(history, other):
    """The rows of `history` at the times of `other`, whose times differ by rounding at most."""
    rows = len(other["time"])
    np.testing.assert_allclose(history["time"][:rows], other["time"], atol=1e-12)
    return {column: values[:rows] if column != "time" else other["time"] for column, values in history.items()}


@pytest.mark.exudyn
@pytest.mark.parametrize("name", MODELS)
def test_exudyn_live_agrees_with_the_file_and_with_minimal_coordinates(name):
    header, history = reference(name)
    allowed = {group: 1.5 * value for group, value in figures(header, "stated error").items()}
    run = live(name)
    assert excess(start_of(history, run), run, allowed) == {}
    assert excess(start_of(independent(name), run), run, allowed) == {}


@pytest.mark.exudyn
def test_live_comparison_notices_a_slightly_different_top():
    """One part in a million more mass moment of inertia must not pass."""
    header, history = reference("HeavyTop")
    heavier = replace(TOP, inertia=tuple(1.000001 * moment for moment in TOP.inertia))

    def build(model):
        top = model.add_body(heavier, GRAVITY)
        origin = model.marker(model.add_ground(), np.zeros(3))
        pivot = model.joint(origin, model.marker(top, TOP_PIVOT), [1, 1, 1, 0, 0, 0])
        model.forces.append(("pivot.reactionForce", pivot, "Force", -1.0, None))

    run = live("HeavyTop", build)
    assert "position" in excess(start_of(history, run), run, figures(header, "stated error"))


@pytest.mark.exudyn
def test_exudyn_keeps_the_axes_of_the_universal_joint_perpendicular():
    settings = replace(RECIPES["SliderCrank"].settings, step_size=1e-3, scheme="index3")
    history = exudyn_models.simulate("SliderCrank", settings, 0.5, 0.01).history
    rod = Rotation.from_quat(vector(history, "rod.quaternion", 4), scalar_first=True).as_matrix()
    slider = Rotation.from_quat(vector(history, "slider.quaternion", 4), scalar_first=True).as_matrix()
    np.testing.assert_allclose(np.einsum("ni,ni->n", slider[:, :, 0], rod[:, :, 1]), 0.0, atol=1e-9)
    assert np.abs(rod - rod[0]).max() > 0.1


@pytest.mark.exudyn
@pytest.mark.parametrize("rotation", ["lieGroup", "taitBryan"])
def test_every_rotation_formulation_builds_and_counts(rotation):
    settings = exudyn_models.Settings(step_size=1e-3, rotation=rotation, scheme="index3", rho_inf=0.65)
    run = exudyn_models.simulate("SliderCrank", settings, 0.1)
    assert run.steps == 100
    assert run.newton_iterations >= 100
    assert run.cpu_time > 0
    assert len(run.history["time"]) == 1
    end = np.searchsorted(reference("SliderCrank")[1]["time"], 0.1 - 1e-9)
    np.testing.assert_allclose(
        run.history["guide.displacement"], reference("SliderCrank")[1]["guide.displacement"][end], atol=1e-5
    )


# --- the independent solution ----------------------------------------------------------------------------------------


def test_heavy_top_keeps_its_invariants():
    """Energy, angular momentum about the vertical through the pivot and the spin about the axis of symmetry."""
    history = independent("HeavyTop")
    omega, velocity = vector(history, "top.angularVelocity"), vector(history, "top.velocity")
    position = vector(history, "top.position")
    rotations = Rotation.from_quat(vector(history, "top.quaternion", 4), scalar_first=True).as_matrix()
    energy = 0.5 * TOP.mass * (velocity**2).sum(1) + 0.5 * omega**2 @ TOP.inertia - TOP.mass * position @ GRAVITY
    momentum = TOP.mass * np.cross(position, velocity) + np.einsum("nij,nj->ni", rotations, omega * TOP.inertia)
    np.testing.assert_allclose(energy, energy[0], rtol=1e-12)
    np.testing.assert_allclose(momentum[:, 2], momentum[0, 2], atol=1e-11 * np.abs(momentum).max())
    np.testing.assert_allclose(omega[:, 1], 150.0, rtol=1e-14)
    assert position[:, 2].min() < -0.99  # the configuration where Euler angles are singular


def test_rotor_axis_formulation_agrees_with_quaternion_and_angular_velocity():
    """The rotor again, its spin resolved: ẋ = v, m v̇ = F, ṗ = ½ p ∘ (0, ω), J ω̇ + ω × J ω = M, 6 turns."""
    rotor = Rotor()
    inertia = np.array(rotor.inertia)
    supports = ((np.array([-rotor.left, 0, 0]), np.ones(3)), (np.array([rotor.right, 0, 0]), np.array([0, 1, 1])))

    def rhs(_t, y):
        x, v, q, omega = np.split(y, [3, 6, 10])
        w, u = q[0], q[1:]
        r = Rotation.from_quat(q, scalar_first=True).as_matrix()
        force, moment = np.zeros(3), r.T @ rotor.torque
        for point, axes in supports:
            arm, arm_rate = r @ point, r @ np.cross(omega, point)
            f = -axes * (rotor.stiffness * (x + arm - point) + rotor.damping * (v + arm_rate))
            force, moment = force + f, moment + np.cross(point, r.T @ f)
        q_dot = 0.5 * np.array([-u @ omega, *(w * omega + np.cross(u, omega))])
        return np.concatenate([v, force / rotor.mass, q_dot, (moment - np.cross(omega, inertia * omega)) / inertia])

    times = np.linspace(0.0, 2e-3, 3)
    y0 = np.array([0.0] * 6 + [1.0, 0.0, 0.0, 0.0, rotor.spin, 0.0, 0.0])
    states = integrate(rhs, y0, times, np.array([1e-16] * 3 + [1e-14] * 3 + [1e-15] * 4 + [1e-12] * 3), 1e-6)
    ours = solve("HighSpeedRotor", times)
    theirs = {"time": times}
    for name, columns, size in (
        ("rotor.position", states[:, :3], 3),
        ("rotor.quaternion", states[:, 6:10] / np.linalg.norm(states[:, 6:10], axis=1, keepdims=True), 4),
        ("rotor.velocity", states[:, 3:6], 3),
        ("rotor.angularVelocity", states[:, 10:], 3),
    ):
        assert columns.shape[1] == size
        add_vector(theirs, name, columns)
    found = differences({column: ours[column] for column in theirs}, theirs)
    assert found["position"] < 1e-15
    assert found["velocity"] < 1e-12
    assert found["quaternion"] < 1e-11
    assert found["angularVelocity"] < 1e-8


def test_slider_crank_starts_as_defined():
    """Its closed-form kinematics at θ = 0, θ̇ = 6 rad/s give the initial values that Exudyn is given as numbers."""
    mechanism = SliderCrank(np.zeros(1))
    for body in (CRANK, ROD, SLIDER):
        motion = mechanism.bodies[body.name]
        np.testing.assert_allclose(motion.x[0][0], body.position, atol=1e-15)
        np.testing.assert_allclose(6.0 * motion.x[1][0], body.velocity, atol=1e-15)
        np.testing.assert_allclose(6.0 * motion.w[0], body.angular_velocity, atol=1e-14)
        np.testing.assert_allclose(np.stack([e[0][0] for e in motion.axes], axis=1), body.rotation, atol=1e-15)


def test_slider_crank_quadrature_agrees_with_the_equation_of_motion():
    """θ(t) of the energy integral against DOP853 on θ̈ from the projected Newton-Euler equations."""
    times = reference("SliderCrank")[1]["time"][:11]

    def rhs(_t, y):
        return [y[1], SliderCrank(y[0]).acceleration(y[1:])[0]]

    states = integrate(rhs, np.array([0.0, CRANK.angular_velocity[0]]), times, 1e-14, 1e-3)
    np.testing.assert_allclose(states[:, 0], independent("SliderCrank")["crankPivot.angle"][:11], atol=1e-13)
    np.testing.assert_allclose(states[:, 1], independent("SliderCrank")["crank.angularVelocity[1]"][:11], atol=1e-12)


def test_slider_crank_reactions_satisfy_the_moment_equation_left_over():
    """Nothing drives the crank about its pivot: the moments about W x at A balance. Not used to find the reactions."""
    history = independent("SliderCrank")
    rate = history["crank.angularVelocity[1]"]
    mechanism = SliderCrank(history["crankPivot.angle"])
    crank = mechanism.bodies["crank"]
    second = mechanism.acceleration(rate)
    arm_pivot, arm_pin = CRANK_CENTRE - crank.x[0], mechanism.b - crank.x[0]
    moment = np.cross(arm_pivot, vector(history, "crankPivot.reactionForce"))
    moment -= np.cross(arm_pin, vector(history, "crankPin.reactionForce"))
    balance = moment - crank.inertial_torque(rate, second)
    np.testing.assert_allclose(balance[:, 0], 0.0, atol=1e-12)


def test_quaternions_of_matrices():
    rotations = Rotation.random(200, rng=np.random.default_rng(7))
    half_turns = Rotation.from_rotvec(np.pi * np.eye(3))
    for expected in (rotations, half_turns):
        q = quaternions_from_matrices(expected.as_matrix())
        q *= np.sign(np.einsum("ij,ij->i", q, expected.as_quat(scalar_first=True)))[:, None]
        np.testing.assert_allclose(q, expected.as_quat(scalar_first=True), atol=1e-15)
