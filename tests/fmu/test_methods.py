"""Integration methods, groups and coordinates as parameters of the FMUs: each does what it says, by name.

Their orders, accuracy and constraints are examined in tests/core; saving, threads and real time with those of the
other options (integrator_combinations).
"""

import math
from functools import cache
from itertools import product

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from research.reference import GRAVITY, TOP, TOP_PIVOT

from .helpers import (
    ABSOLUTE_COORDINATES,
    EPS,
    GROUPS,
    LOCAL_COORDINATES,
    METHODS,
    Instance,
    assert_same_bits,
    bodies,
    method_combinations,
    orders,
)

ORDER = {"generalizedAlpha": 2, "rkmk4": 4, "rkmk54": 5, "bliedf2": 2}
NEWTON = {"integrator.relativeTolerance": 1e-12, "integrator.absoluteTolerance": 1e-12}
FIXED_STEPS = {"integrator.relativeTolerance": 0.01, "integrator.absoluteTolerance": 1e12}


def names_of(settings: dict) -> str:
    return "-".join(settings.values())


# --- the parameters --------------------------------------------------------------------------------------------------


GROUPS_ALIKE = ("FlexiblePendulum", "SpinUpBeam")
"""A frame that turns about its own origin, where groups are alike; a mechanism at rest."""


def test_every_combination_runs_and_they_agree(new, model):
    """48 of them over ten steps, within a thousandth of the largest number; no two methods, groups or maps alike."""
    ends = {}
    for values in product(METHODS, GROUPS, LOCAL_COORDINATES, ABSOLUTE_COORDINATES):
        names = ("method", "group", "localCoordinates", "absoluteCoordinates")
        settings = {f"integrator.{name}": value for name, value in zip(names, values, strict=True)}
        instance = new(model).start(settings)
        instance.steps(instance.get("integrator.stepSize"), 10)
        observed = [f"{body}.{n}" for body in bodies(instance.fmu) for n in ("quaternion", "velocity")]
        ends[values] = np.concatenate([instance.get(name) for name in observed])
        instance.free()
    exact = ends["rkmk54", "R3xSO3", "exp", "quaternion"]
    for values, end in ends.items():
        assert np.abs(end - exact).max() <= 1e-3 * (1 + np.abs(exact).max()), values
    if model in GROUPS_ALIKE:
        return
    distinct = {values: end.tobytes() for values, end in ends.items() if values[3] == "quaternion"}
    assert len(set(distinct.values())) == len(distinct)


def test_defaults_are_those_of_the_generalized_alpha_method(new, model):
    plain, named = (
        new(model).start(settings)
        for settings in (
            {},
            {
                "integrator.method": "generalizedAlpha",
                "integrator.group": "R3xSO3",
                "integrator.localCoordinates": "exp",
                "integrator.absoluteCoordinates": "quaternion",
            },
        )
    )
    for instance in (plain, named):
        instance.steps(1e-3, 20)
    assert_same_bits(plain.outputs(), named.outputs())


@pytest.mark.parametrize("settings", method_combinations(), ids=names_of)
def test_reset_gives_the_first_run_again(new, model, settings):
    instance = new(model).start(settings)
    H = 2.5 * instance.get("integrator.stepSize")
    first = instance.trajectory(H, 20)
    instance.reset().start(settings)
    assert_same_bits(instance.trajectory(H, 20), first)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("absolute", ABSOLUTE_COORDINATES)
def test_rotations_are_continuous_over_many_turns(new, method, absolute):
    """24 turns: quaternions do not jump to their negatives; rotation vectors stay within π and say the same."""
    instance = new("HeavyTop").start(
        {"integrator.method": method, "integrator.group": "SE3", "integrator.absoluteCoordinates": absolute}
    )
    rows = [np.concatenate([instance.get("top.quaternion"), instance.get("top.rotationVector")])]
    for _ in range(1000):
        instance.step(1e-3)
        rows.append(np.concatenate([instance.get("top.quaternion"), instance.get("top.rotationVector")]))
    quaternions, vectors = np.split(np.array(rows), [4], axis=1)
    assert (np.einsum("ij,ij->i", quaternions[1:], quaternions[:-1]) > 0.9).all()
    assert quaternions[:, 0].min() < -0.9
    np.testing.assert_allclose(np.linalg.norm(quaternions, axis=1), 1.0, rtol=0, atol=4 * EPS)
    angles = np.linalg.norm(vectors, axis=1)
    assert 3.0 < angles.max() <= math.pi * (1 + 4 * EPS)
    np.testing.assert_allclose(np.cos(angles / 2), np.abs(quaternions[:, 0]), rtol=0, atol=8 * EPS)


# --- inputs ----------------------------------------------------------------------------------------------------------

SPAN, COUNT = 0.12, 6  # s, communication steps


def torque(t: float) -> tuple[float, float, float]:
    """N m about body x: at each communication point it jumps, in between it is a quadratic polynomial; with rates."""
    i = min(int(t / SPAN * COUNT + 1e-9), COUNT - 1)
    s = t - i * SPAN / COUNT
    a, b, c = 300.0 * (i % 2), 5e3 * (i % 3 - 1), 4e5 * (i - 2)
    return a + b * s + 0.5 * c * s * s, b + c * s, c


@cache
def heavy_top_velocities(derivatives: int) -> np.ndarray:
    """Angular velocity (B) and velocity (W) of the top at SPAN, driven by `torque` or by its values held.

    Euler's equations about the pivot and the quaternion's kinematics with DOP853, from jump to jump.
    """
    d = -TOP_PIVOT
    inertia = np.diag(TOP.inertia) + TOP.mass * (d @ d * np.eye(3) - np.outer(d, d))

    def turned(p: np.ndarray) -> np.ndarray:
        w, u = p[0], p[1:]
        tilde = np.cross(np.eye(3), u)
        return np.eye(3) + 2 / (p @ p) * (w * tilde + tilde @ tilde)

    y = np.concatenate([[1.0, 0, 0, 0], TOP.angular_velocity])
    for i in range(COUNT):
        begin, end = i * SPAN / COUNT, (i + 1) * SPAN / COUNT
        u = torque(begin)

        def rhs(t: float, y: np.ndarray, begin: float = begin, u: tuple = u) -> np.ndarray:
            p, omega, s = y[:4], y[4:], t - begin
            load = u[0] + (u[1] * s + 0.5 * u[2] * s * s if derivatives == 2 else 0.0)
            moment = TOP.mass * np.cross(d, turned(p).T @ GRAVITY) + [load, 0, 0]
            rate = np.linalg.solve(inertia, moment - np.cross(omega, inertia @ omega))
            return np.array([*(0.5 * np.array([-p[1:] @ omega, *(p[0] * omega + np.cross(p[1:], omega))])), *rate])

        y = solve_ivp(rhs, (begin, end), y, method="DOP853", rtol=1e-13, atol=1e-13).y[:, -1]
    return np.concatenate([y[4:], turned(y[:4]) @ np.cross(y[4:], d)])


def driven(instance: Instance, derivatives: int) -> np.ndarray:
    for i in range(COUNT):
        u = torque(i * SPAN / COUNT)
        instance.set({"top.torque[1]": u[0]})
        for order in range(1, derivatives + 1):
            instance.set_input_derivatives(order, {"top.torque[1]": u[order]})
        instance.slave.doStep(i * SPAN / COUNT, SPAN / COUNT)
    return np.concatenate([instance.get("top.angularVelocity"), instance.get("top.velocity")])


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("group", GROUPS)
@pytest.mark.parametrize("derivatives", [0, 2], ids=["held", "quadratic"])
def test_order_with_inputs_that_jump(new, method, group, derivatives):
    """Communication points end internal steps, so that no method meets the jumps; between them it sees the derivatives.

    Errors of a method of order 5 or 4 are those of its order only if it takes the input at its stages.
    """
    exact = heavy_top_velocities(derivatives)
    first = {"generalizedAlpha": 200, "bliedf2": 200, "rkmk4": 40, "rkmk54": 30}[method]
    found = []
    for steps in (first, 2 * first):
        settings = {"integrator.method": method, "integrator.group": group, "integrator.stepSize": SPAN / COUNT / steps}
        instance = new("HeavyTop").start(settings | (FIXED_STEPS if method == "rkmk54" else NEWTON))
        found.append(np.abs(driven(instance, derivatives) - exact).max())
        assert instance.integer("integrator.steps") == steps * COUNT
    assert orders(found) == pytest.approx([ORDER[method]], abs=0.1)
    assert found[-1] > 1e-11, "above rounding"


@pytest.mark.parametrize("group", GROUPS)
@pytest.mark.parametrize("derivatives", [0, 2], ids=["held", "quadratic"])
def test_error_control_copes_with_inputs_that_jump(new, group, derivatives):
    """The step before a jump proposes the first one after it; if that is too long it is repeated."""
    for tolerance in (1e-6, 1e-9):
        settings = {"integrator.method": "rkmk54", "integrator.group": group, "integrator.stepSize": SPAN / COUNT}
        settings |= {"integrator.relativeTolerance": tolerance, "integrator.absoluteTolerance": tolerance}
        instance = new("HeavyTop").start(settings)
        error = np.abs(driven(instance, derivatives) - heavy_top_velocities(derivatives)).max()
        assert error <= 10 * tolerance


# --- error control ---------------------------------------------------------------------------------------------------


def test_a_tolerance_that_cannot_be_met_is_told(new, model):
    """With the estimated error, the body and the last successful time; the outputs stay."""
    settings = {"integrator.method": "rkmk54", "integrator.relativeTolerance": 0.0}
    instance = new(model).start(settings | {"integrator.absoluteTolerance": 1e-200})
    if instance.get("energy.kinetic") == 0.0:
        pytest.skip("at rest, which every tolerance allows")
    before = instance.reals(instance.all_outputs[0])
    message = instance.refusal(instance.slave.doStep, 0.0, 1e-3)
    assert (message.status, message.category) == ("discard", "logStatusDiscard")
    for part in (
        "its error is estimated as",
        "times the tolerance, largest in body",
        "the last successful time is 0 s.",
    ):
        assert part in message.text
    assert_same_bits(instance.reals(instance.all_outputs[0]), before)
    assert instance.integer("integrator.steps") == 0
    assert instance.last_successful_time() == 0.0


def test_an_explicit_method_needs_no_newton_iterations(new):
    """Nothing to iterate where there are no joints; four accelerations a step; the options of Newton's method idle."""
    ends = []
    for options in ({}, {"integrator.newton": "modified", "integrator.formulation": "index3", "integrator.sigma": 0.0}):
        instance = new("HighSpeedRotor").start({"integrator.method": "rkmk4", "integrator.stepSize": 1e-5, **options})
        instance.steps(1e-4, 5)
        assert instance.integer("integrator.newtonIterations") == 0
        assert instance.integer("integrator.jacobianEvaluations") == 4 * instance.integer("integrator.steps") == 200
        ends.append(instance.outputs())
    assert_same_bits(*ends)


@pytest.mark.parametrize("cut", [1, 4, 9])
def test_an_interrupted_run_of_steps_under_error_control(new, cut):
    """Saved while step sizes vary, continued in an instance that has a step size of its own in mind."""
    settings = {"integrator.method": "rkmk54", "integrator.stepSize": 0.05}
    one, two = (new("SliderCrank").start(settings) for _ in range(2))
    one.steps(0.03, cut)
    data = one.serialized()
    expected = one.trajectory(0.03, 10)
    two.steps(0.013, 3)
    two.deserialize(data)
    two.time = cut * 0.03
    assert_same_bits(two.trajectory(0.03, 10), expected, one.all_outputs[0] + one.all_outputs[1])
    assert one.integer("integrator.retries") > 0
