"""Accuracy of the FMUs against tests/references/<Model>.csv, which share no code with them, and against mechanics.

The references are better than every figure asked for here by two orders of magnitude (see tests/references/README.md).
"""

import math
import re
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from research.reference import History, differences, vector_columns
from sigmafmu.compare import read_reference

from .helpers import (
    CORRECTORS,
    EPS,
    FORMULATIONS,
    JACOBIANS,
    NEWTONS,
    Instance,
    bodies,
    fastest_rotation,
    flexible_bodies,
    orders,
    owners,
    rotation_matrix,
)

REFERENCES = Path(__file__).resolve().parents[1] / "references"
COMMUNICATION_STEP = {"HeavyTop": 0.01, "HighSpeedRotor": 0.005, "SliderCrank": 0.01}  # s, grid of the references
REACTIONS = ("crankPivot", "crankPin", "wristPin", "guide")


@cache
def reference(model: str) -> History:
    return read_reference(REFERENCES / f"{model}.csv")[1]


def run(instance: Instance, stop_time: float, settings: dict, extra: tuple[str, ...] = ()) -> History:
    """History at the times of the reference up to stop_time: the columns of the reference and `extra` ones."""
    model = instance.fmu.name
    H, columns = COMMUNICATION_STEP[model], [name for name in reference(model) if name != "time"] + list(extra)
    count = round(stop_time / H)
    instance.start(settings)
    rows = [instance.reals(columns)]
    for _ in range(count):
        instance.step(H)
        rows.append(instance.reals(columns))
    return {"time": reference(model)["time"][: count + 1], **dict(zip(columns, np.array(rows).T, strict=True))}


def vector(history: History, name: str, size: int = 3) -> np.ndarray:
    return np.column_stack([history[column] for column in vector_columns(name, size)])


def error_at(history: History, name: str, row: int = -1) -> float:
    """Distance of a vector from the reference at one time."""
    other = {k: v[: len(history["time"])] for k, v in reference_of(history).items()}
    return float(np.linalg.norm(vector(history, name)[row] - vector(other, name)[row]))


def reference_of(history: History) -> History:
    return next(r for m in COMMUNICATION_STEP if set(r := reference(m)) <= set(history))


def largest_differences(history: History) -> dict[str, float]:
    """Largest difference from the reference per kind of quantity."""
    other = {name: values[: len(history["time"])] for name, values in reference_of(history).items()}
    return differences({name: history[name] for name in other}, other)


# --- the figures asked for -------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("formulation", "position", "force"),
    [("stabilizedIndex2", 4e-5, 0.1), ("index2", 1e-4, 0.1), ("index3", 2e-4, 0.3)],
)
def test_heavy_top_at_one_second(new, formulation, position, force):
    """ρ∞ = 0.9, σ = 1, h = 2.5e-4 s; the force, 770 N, to 1e-4 of it (index 3: 4e-4)."""
    history = run(new("HeavyTop"), 1.0, {"integrator.stepSize": 2.5e-4, "integrator.formulation": formulation})
    assert error_at(history, "top.position") <= position
    assert error_at(history, "pivot.reactionForce") <= force


@pytest.mark.parametrize("radius", [0.0, 0.3, 0.5, 0.65, 0.8, 0.9, 1.0])
def test_heavy_top_converges_for_every_spectral_radius(new, radius):
    """Stabilised index 2, h from 4e-3 s (0.6 rad of spin a step) to 2.5e-4 s, over 1 s: second order in the end."""
    errors = []
    for h in (4e-3, 2e-3, 1e-3, 5e-4, 2.5e-4):
        settings = {"integrator.stepSize": h, "integrator.spectralRadius": radius}
        history = run(new("HeavyTop"), 1.0, settings)
        assert all(np.isfinite(values).all() for values in history.values())
        errors.append(largest_differences(history)["position"])
    assert (np.diff(errors) < 0).all(), errors
    assert orders(errors)[-1] == pytest.approx(2.0, abs=0.1), errors


def test_rotor_bearings_at_a_fifth_of_a_second(new):
    """h = 5e-6 s, 0.1 rad of spin a step: the σ-modification pays off where rotation dominates."""
    errors = {}
    for sigma in (0.0, 1.0, 1.7):
        settings = {"integrator.stepSize": 5e-6, "integrator.sigma": sigma}
        history = run(new("HighSpeedRotor"), 0.2, settings)
        errors[sigma] = max(error_at(history, f"{side}Support.position") for side in ("left", "right"))
    assert errors[1.0] <= 8e-8
    assert errors[1.0] <= errors[0.0] / 2
    assert errors[1.7] <= errors[0.0] / 20


def test_slider_crank_over_five_seconds(new):
    """h = 1e-4 s, stabilised index 2."""
    residuals = ("constraint.positionResidual", "constraint.velocityResidual")
    history = run(new("SliderCrank"), 5.0, {"integrator.stepSize": 1e-4}, extra=residuals)
    other, two_seconds = reference("SliderCrank"), 200
    error = np.abs(history["guide.displacement"] - other["guide.displacement"])
    assert error[: two_seconds + 1].max() <= 1e-6
    assert error.max() <= 1e-5
    for name in residuals:
        assert history[name].max() <= 1e-10
    for joint in REACTIONS:
        forces = [vector(h, f"{joint}.reactionForce") for h in (history, other)]
        error = np.linalg.norm(forces[0] - forces[1], axis=1)
        assert error[: two_seconds + 1].max() <= 1e-3, joint  # N
        assert error.max() <= 1e-3 * np.linalg.norm(forces[1], axis=1).max(), joint


# --- every combination of the integrator's options -------------------------------------------------------------------

COMBINED = {  # horizon [s], step size [s], largest error in position that any scheme may have [m]
    "HeavyTop": (0.2, 2.5e-4, 1e-4),
    "HighSpeedRotor": (0.01, 5e-6, 1e-8),
    "SliderCrank": (0.5, 5e-4, 1e-5),
}


@pytest.mark.parametrize("formulation", FORMULATIONS)
@pytest.mark.parametrize("corrector", CORRECTORS)
@pytest.mark.parametrize("model", COMBINED)
def test_jacobian_and_newton_do_not_change_the_result(new, model, formulation, corrector):
    """They decide how fast Newton's method converges, not whereto. And every scheme is accurate.

    What remains of the tolerance, summed up over the steps, is 1e-9 m.
    """
    stop_time, h, allowed = COMBINED[model]
    positions = []
    for jacobian in JACOBIANS:
        for newton in NEWTONS:
            settings = {
                "integrator.stepSize": h,
                "integrator.formulation": formulation,
                "integrator.corrector": corrector,
                "integrator.jacobian": jacobian,
                "integrator.newton": newton,
                "integrator.relativeTolerance": 1e-11,
                "integrator.absoluteTolerance": 1e-12,
            }
            history = run(new(model), stop_time, settings)
            assert largest_differences(history)["position"] <= allowed, settings
            positions.append(np.column_stack([values for name, values in history.items() if ".position[" in name]))
            np.testing.assert_allclose(positions[-1], positions[0], rtol=0, atol=1e-9, err_msg=str(settings))


# --- outputs that say the same thing in different ways ---------------------------------------------------------------


@pytest.fixture
def motion(new, model) -> Instance:
    """An instance in the midst of a motion, with all loads and inputs of its own."""
    instance = new(model).start()
    instance.steps(1e-3, 37)
    return instance


def test_quaternions_are_unit_and_rotation_vectors_the_same_rotation(motion):
    for _ in range(20):
        motion.step(1.7e-3)
        for body in bodies(motion.fmu):
            q, psi = motion.get(f"{body}.quaternion"), motion.get(f"{body}.rotationVector")
            assert np.linalg.norm(q) == pytest.approx(1.0, abs=4 * EPS)
            angle = np.linalg.norm(psi)
            assert angle <= math.pi + 4 * EPS
            expected = np.array([math.cos(angle / 2), *(0.5 * np.sinc(angle / (2 * math.pi)) * psi)])
            sign = 1.0 if expected @ q >= 0 else -1.0
            np.testing.assert_allclose(sign * expected, q, rtol=0, atol=8 * EPS)


def test_quaternions_stay_unit_over_many_steps(new):
    """100 000 internal steps: no drift to be corrected."""
    instance = new("HighSpeedRotor").start()
    instance.steps(1e-2, 50)
    assert instance.integer("integrator.steps") == 100_000
    assert np.linalg.norm(instance.get("rotor.quaternion")) == pytest.approx(1.0, abs=4 * EPS)


def test_crank_angle_counts_turns(new):
    """And is the turn of the crank: its rate is the crank's angular velocity, its remainder the orientation."""
    instance = new("SliderCrank").start()
    angles = [instance.get("crankPivot.angle")]
    assert angles[0] == 0.0
    for _ in range(100):
        instance.step(0.05)
        angle = instance.get("crankPivot.angle")
        q = instance.get("crank.quaternion")
        turned = 2 * math.atan2(q[1], q[0])
        assert math.remainder(angle - turned, 2 * math.pi) == pytest.approx(0.0, abs=64 * EPS * abs(angle))
        rate = instance.get("crank.angularVelocity[1]")
        assert instance.get("crankPivot.angularRate") == pytest.approx(rate, rel=8 * EPS)
        angles.append(angle)
    assert angles[-1] > 8 * 2 * math.pi
    assert (np.diff(angles) > 0).all()
    np.testing.assert_allclose(angles, reference("SliderCrank")["crankPivot.angle"][::5], atol=1e-4)


def test_crank_angle_counts_turns_backwards_and_over_long_communication_steps(new):
    """More than a turn in each of few steps: no getter could count that."""
    forwards, backwards = new("SliderCrank").start(), new("SliderCrank")
    velocity = re.compile(r".*\.initial(Angular)?Velocity\[\d\]")
    starts = {name: v.start for name, v in backwards.fmu.variables.items() if velocity.fullmatch(name)}
    backwards.start({name: -float(start) for name, start in starts.items()})
    for instance in (forwards, backwards):
        instance.steps(0.7, 7)
    history = reference("SliderCrank")
    row = np.searchsorted(history["time"], 4.9 - 1e-9)
    assert forwards.get("crankPivot.angle") == pytest.approx(history["crankPivot.angle"][row], abs=1e-4)
    assert backwards.get("crankPivot.angle") < -8 * 2 * math.pi


@pytest.mark.parametrize("model", ["SliderCrank"])
def test_slider_crank_coordinates_fit_together(motion):
    assert motion.get("guide.displacement") == pytest.approx(motion.get("slider.position[1]"), abs=4 * EPS)
    assert motion.get("guide.rate") == pytest.approx(motion.get("slider.velocity[1]"), abs=4 * EPS)
    # Points of the joints, from either body.
    r = {body: rotation_matrix(motion.get(f"{body}.quaternion")) for body in ("crank", "rod", "slider")}
    p = {body: motion.get(f"{body}.position") for body in r}
    np.testing.assert_allclose(p["crank"] - 0.04 * r["crank"][:, 2], [0, 0.1, 0.12], atol=8 * EPS)
    np.testing.assert_allclose(p["crank"] + 0.04 * r["crank"][:, 2], p["rod"] - 0.15 * r["rod"][:, 0], atol=8 * EPS)
    np.testing.assert_allclose(p["rod"] + 0.15 * r["rod"][:, 0], p["slider"], atol=8 * EPS)
    assert r["slider"][:, 0] @ r["rod"][:, 1] == pytest.approx(0.0, abs=8 * EPS)


@pytest.mark.parametrize("model", ["HighSpeedRotor"])
def test_spring_dampers_obey_their_law(motion):
    """f = −k (p − g) − d ṗ with p = x + R s and ṗ = v + R (ω × s)."""
    motion.set({"rotor.force": (1.0, 2.0, 3.0)})
    motion.steps(1e-4, 20)
    x, v, omega = (motion.get(f"rotor.{name}") for name in ("position", "velocity", "angularVelocity"))
    rotation = rotation_matrix(motion.get("rotor.quaternion"))
    for side, s in (("left", np.array([-0.11, 0, 0])), ("right", np.array([0.09, 0, 0]))):
        p, p_dot = x + rotation @ s, v + rotation @ np.cross(omega, s)
        np.testing.assert_allclose(motion.get(f"{side}Support.position"), p, rtol=0, atol=4 * EPS)
        k, d = motion.get(f"{side}Support.stiffness"), motion.get(f"{side}Support.damping")
        expected = -k * (p - s) - d * p_dot
        assert np.linalg.norm(expected) > 1e-3
        rounding = 8 * EPS * (k.max() * 0.1 + d.max() * np.linalg.norm(omega) * 0.1)
        np.testing.assert_allclose(motion.get(f"{side}Support.force"), expected, rtol=0, atol=rounding)


GROUND_POINTS = {"leftSupport": np.array([-0.11, 0, 0]), "rightSupport": np.array([0.09, 0, 0])}


def test_energies_are_those_of_the_motion(motion):
    """Kinetic ½ m v² + ½ ω·Jω of every body, potential −m g·x and ½ k (p − g)²."""
    if flexible_bodies(motion.fmu):
        pytest.skip("the energy of a flexible body is that of its nodes; the references have it")
    kinetic = potential = 0.0
    gravity = motion.get("gravity")
    for body in bodies(motion.fmu):
        mass, v, omega = (motion.get(f"{body}.{name}") for name in ("mass", "velocity", "angularVelocity"))
        moments = [motion.get(f"{body}.inertia.{m}") for m in ("xx", "yy", "zz")]
        kinetic += 0.5 * mass * v @ v + 0.5 * omega @ (moments * omega)
        potential -= mass * gravity @ motion.get(f"{body}.position")
    assert motion.get("energy.kinetic") == pytest.approx(kinetic, rel=8 * EPS)
    supports = owners(motion.fmu, ".stiffness[1]")
    for support in supports:  # of a new mechanism it is not known where they hang
        if support in GROUND_POINTS:
            stretch = motion.get(f"{support}.position") - GROUND_POINTS[support]
            potential += 0.5 * motion.get(f"{support}.stiffness") @ stretch**2
    if set(supports) <= set(GROUND_POINTS):
        assert motion.get("energy.potential") == pytest.approx(potential, rel=64 * EPS)
    total = motion.get("energy.kinetic") + motion.get("energy.potential")
    assert motion.get("energy.total") == pytest.approx(total, rel=4 * EPS)


@pytest.mark.parametrize("model", ["HeavyTop", "SliderCrank"])
def test_energy_is_conserved(new, model):
    """No damping: what the method gains or loses in 2 s is small and of second order."""
    worst = []
    default = float(new(model).fmu.variables["integrator.stepSize"].start)
    for h in (default, default / 2):
        instance = new(model).start({"integrator.stepSize": h})
        first, kinetic = instance.get("energy.total"), instance.get("energy.kinetic")
        energies = []
        for _ in range(200):
            instance.step(0.01)
            energies.append(instance.get("energy.total"))
        worst.append(np.abs(np.array(energies) - first).max())
    assert worst[0] <= 1e-4 * kinetic
    assert orders(worst)[0] == pytest.approx(2.0, abs=0.1)


def test_accelerations_are_the_derivatives_of_the_velocities(new, model):
    """Third-order one-sided differences over small steps; the internal step is finer still."""
    speed = fastest_rotation(new(model).start())
    delta = 0.0025 / speed
    instance = new(model).start({"integrator.stepSize": delta / 50})
    instance.step(0.3 / speed)
    names = [f"{body}.{n}[{i}]" for body in bodies(instance.fmu) for n in MOTION for i in (1, 2, 3)]
    rates = [f"{body}.{n}[{i}]" for body in bodies(instance.fmu) for n in MOTION.values() for i in (1, 2, 3)]
    values = [instance.reals(names)]
    expected = instance.reals(rates).reshape(-1, 2, 3)
    for _ in range(3):
        instance.step(delta)
        values.append(instance.reals(names))
    found = ((-11 * values[0] + 18 * values[1] - 9 * values[2] + 2 * values[3]) / (6 * delta)).reshape(-1, 2, 3)
    scale = np.abs(expected).max(axis=(0, 2), keepdims=True)
    if not scale.any():
        pytest.skip("at rest")
    scale = np.maximum(scale, 1e-6 * scale.max())  # a joint may prevent all accelerations of a kind
    # Truncation: (δ ω)³ / 4 = 4e-9 of the acceleration, for the small bodies of a mechanism a hundred times more.
    np.testing.assert_allclose(found / scale, expected / scale, rtol=0, atol=1e-6)


MOTION = {"velocity": "acceleration", "angularVelocity": "angularAcceleration"}


@pytest.mark.parametrize("model", ["SliderCrank"])
def test_reactions_balance_the_motion(motion):
    """Newton and Euler for every body of the slider-crank, in W, from the outputs alone: m (ẍ − g) = Σ f and so on."""
    inputs = {"crank.force": (1, 2, 3), "rod.torque": (0.1, 0.2, 0.3), "slider.force": (5, 6, 7)}
    motion.set(inputs)
    motion.set({"crankPivot.motorTorque": 0.7, "guide.actuatorForce": -2.0})
    motion.step(1e-3)
    joints = {  # joint: (first body, its arm), (second body, its arm), in body axes
        "crankPivot": (None, ("crank", (0, 0, -0.04))),
        "crankPin": (("crank", (0, 0, 0.04)), ("rod", (-0.15, 0, 0))),
        "wristPin": (("rod", (0.15, 0, 0)), ("slider", (0, 0, 0))),
        "guide": (None, ("slider", (0, 0, 0))),
    }
    r = {b: rotation_matrix(motion.get(f"{b}.quaternion")) for b in bodies(motion.fmu)}
    force = {b: motion.get(f"{b}.force") + motion.get(f"{b}.mass") * motion.get("gravity") for b in r}
    moment = {b: r[b] @ motion.get(f"{b}.torque") for b in r}
    moment["crank"] = moment["crank"] + [0.7, 0, 0]
    force["slider"] = force["slider"] + [-2.0, 0, 0]
    for joint, sides in joints.items():
        f, t = motion.get(f"{joint}.reactionForce"), motion.get(f"{joint}.reactionTorque")
        for sign, side in zip((-1.0, 1.0), sides, strict=True):
            if side:
                body, arm = side
                force[body] = force[body] + sign * f
                moment[body] = moment[body] + sign * (t + np.cross(r[body] @ arm, f))
    for body in r:
        inertia = np.diag([motion.get(f"{body}.inertia.{m}") for m in ("xx", "yy", "zz")])
        omega, alpha = motion.get(f"{body}.angularVelocity"), motion.get(f"{body}.angularAcceleration")
        expected = motion.get(f"{body}.mass") * motion.get(f"{body}.acceleration")
        np.testing.assert_allclose(force[body], expected, rtol=0, atol=1e-11)  # N, of 50
        expected = r[body] @ (inertia @ alpha + np.cross(omega, inertia @ omega))
        np.testing.assert_allclose(moment[body], expected, rtol=0, atol=1e-12)  # N m, of 5
    # A joint transmits nothing along what it leaves free.
    assert np.abs(motion.get("crankPin.reactionTorque")).max() == 0.0
    assert motion.get("crankPivot.reactionTorque[1]") == pytest.approx(0.0, abs=1e-13)
    assert motion.get("guide.reactionForce[1]") == pytest.approx(0.0, abs=1e-12)
