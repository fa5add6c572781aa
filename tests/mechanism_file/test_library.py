"""The library: files that say the same as the compiled mechanisms, and mechanisms against independent solutions."""

import json
import re
from itertools import pairwise

import numpy as np
import pytest
from scipy.linalg import expm

from research.reference import linkage_motions
from research.reference.iftomm import ANDREWS, flyball_motion
from sigmafmu import _core
from sigmafmu.mechanism_file.load import load

from .helpers import LIBRARY

FILES = sorted(path.stem for path in LIBRARY.glob("*.yaml"))
DEGREES = {
    "AndrewsSqueezer": 1,
    "BevelDifferential": 2,
    "Bicycle": 3,
    "Bricard": 1,
    "CardanShaft": 0,
    "Chain10": 30,
    "CrankRocker": 0,
    "DoubleFourBar": 1,
    "DoubleWishbone": 7,
    "FlexibleSliderCrank": 5,
    "Flyball": 4,
    "FreeBody": 6,
    "GearTrain": 2,
    "HeavyTop": 3,
    "HighSpeedRotor": 6,
    "JeffcottRotor": 2,
    "PlanarFourBar": 1,
    "PlanetaryGear": 2,
    "RobotArm": 7,
    "RollingCoin": 3,
    "SliderCrank": 1,
    "StewartPlatform": 6,
}


def assert_same(found, expected, where=""):
    """Texts and structure the same, numbers to 1e-12 of their size."""
    if isinstance(expected, dict):
        assert found.keys() == expected.keys(), where
        for key in expected:
            assert_same(found[key], expected[key], f"{where}.{key}")
    elif isinstance(expected, list):
        assert len(found) == len(expected), where
        for i, (one, two) in enumerate(zip(found, expected, strict=True)):
            assert_same(one, two, f"{where}[{i}]")
    elif isinstance(expected, float):
        assert found == pytest.approx(expected, rel=1e-12, abs=1e-12), where
    else:
        assert found == expected, where


def data(mechanism):
    """All of a definition but initial coordinates of joints, which follow from the bodies."""
    content = json.loads(_core.to_json(mechanism))
    for joint in content["joints"]:
        for key in [key for key in joint if re.fullmatch(r"(coordinate|rate|displacement|displacement_rate)\d?", key)]:
            del joint[key]
    return content


@pytest.mark.parametrize("model", [name for name in FILES if name in _core.mechanisms()])
def test_a_file_says_what_the_compiled_mechanism_says(model):
    assert_same(data(load(LIBRARY / f"{model}.yaml").mechanism), data(_core.mechanism(model)))


def test_the_compiled_mechanisms_that_are_files_too():
    assert {"HeavyTop", "HighSpeedRotor", "SliderCrank", "FlexibleSliderCrank"} <= set(FILES)


@pytest.mark.parametrize("name", FILES)
def test_every_file_runs_with_its_degrees_of_freedom(name):
    found = load(LIBRARY / f"{name}.yaml")
    assert found.definition["name"] == name
    assert _core.freedom(found.mechanism.multibody).degrees == DEGREES[name]
    slave = _core.Slave(found.mechanism)
    slave.start()
    energy = slave.get("energy.total")
    H = min(found.mechanism.communication_step, 1e-3)
    for i in range(20):
        slave.do_step(i * H, H)
    assert np.isfinite([slave.get("energy.total"), energy]).all()


def changed(name, h):
    """A mechanism of the library with internal steps of h."""
    mechanism = load(LIBRARY / f"{name}.yaml").mechanism
    mechanism.integrator.step_size = h
    return mechanism


def run(name, names, times, h=1e-3):
    """Values of variables at equal times, with internal steps of h."""
    slave = _core.Slave(changed(name, h))
    slave.start()
    rows = [[slave.get(n) for n in names]]
    for t, after in pairwise(times):
        slave.do_step(t, after - t)
        rows.append([slave.get(n) for n in names])
    return np.array(rows)


def test_the_planar_four_bar_moves_as_its_independent_solution():
    times = np.linspace(0, 0.5, 51)
    found = run("PlanarFourBar", ["hinge1.angle", "hinge1.angularRate"], times, 1e-4)
    expected = linkage_motions.four_bar_motion(times).T
    assert np.abs(found[0] - expected[0]).max() < 1e-12
    assert np.abs(found - expected).max() < 1e-4  # (h w)^2 = 1e-6 at 10 rad/s, of rates up to 30 rad/s


def test_the_double_four_bar_moves_as_its_independent_solution():
    times = np.linspace(0, 1, 101)
    found = run("DoubleFourBar", ["crank2.position[1]", "crank2.position[2]"], times)
    angle = linkage_motions.four_bar_row_motion(2, times)[0]
    expected = np.column_stack([1 + np.cos(angle) / 2, np.sin(angle) / 2])
    assert np.abs(found - expected).max() < 1e-5


def test_bricards_mechanism_moves_as_its_independent_solution():
    times = np.linspace(0, 1, 101)
    names = [f"bar{i}.position[{k}]" for i in range(1, 6) for k in (1, 2, 3)]
    found = run("Bricard", names, times)
    expected = linkage_motions.bricard_motion(times).reshape(len(times), -1)
    assert np.abs(found - expected).max() < 1e-5


def test_andrews_squeezing_mechanism_against_the_test_set():
    """Angles at 0.03 s, where the first of them is unwrapped."""
    start = {
        "pivotB.angle": 0.455279819163070380,
        "pivotA5.angle": 0.48736497954384255,
        "pivotA7.angle": 1.2305474445498212,
    }
    errors = []
    for h in (2e-5, 1e-5):
        slave = _core.Slave(changed("AndrewsSqueezer", h))
        slave.start()
        for i in range(300):
            slave.do_step(1e-4 * i, 1e-4)
        errors.append([slave.get(n) + start.get(n, 0.0) - value for n, value in ANDREWS.items()])
    coarse, fine = np.array(errors)
    assert np.abs(fine).max() < 1e-3  # h w = 0.02 at 1900 rad/s
    assert np.abs((4 * fine - coarse) / 3).max() < 1e-5  # without the leading term of second order


def test_the_flyball_governor_moves_as_its_independent_solution():
    times = np.linspace(0, 0.5, 51)
    found = run("Flyball", ["sleeve.displacement", "hinge1.angle", "hinge2.angle"], times, 2e-4)
    s, a, *_ = flyball_motion(times)
    assert np.abs(s - s[0]).max() > 0.05  # it moves
    assert np.abs(found - np.column_stack([s, a, np.pi - a])).max() < 1e-5


def test_the_gear_train_moves_as_its_independent_solution():
    """Rates of the wheels from linear equations: the motor has -4 times the carrier's rate, that is half their sum."""
    carrier, motor = np.array([0.5, 0.5]), np.array([-2.0, -2.0])
    M = 2e-3 * np.outer(motor, motor) + 0.03 * np.outer(carrier, carrier) + 0.2 * np.eye(2)
    A, b = -np.linalg.solve(M, np.diag([0, 0.5])), np.linalg.solve(M, 0.5 * motor)
    times = np.linspace(0, 2, 21)
    expected = [expm(np.block([[A, b[:, None]], [np.zeros((1, 3))]]) * t)[:2, 2] for t in times]
    found = run("GearTrain", ["leftShaft.angularRate", "rightShaft.angularRate", "motorShaft.angularRate"], times)
    assert np.abs(found[:, :2] - expected).max() < 1e-5
    assert np.abs(found[:, 2] - np.array(expected) @ motor).max() < 1e-4


def test_the_chain_starts_as_its_recursion_says():
    found = load(LIBRARY / "Chain10.yaml").definition["bodies"]
    joint = np.zeros(3)
    for k, body in enumerate(found, 1):
        w = np.array([0.5 * (-1) ** k, 0.25, 1])
        assert body["position"] == [k - 0.5, 0, 0]
        np.testing.assert_allclose(body["angular_velocity"], w, atol=0)
        np.testing.assert_allclose(body["velocity"], joint + np.cross(w, [0.5, 0, 0]), atol=1e-14)
        joint = joint + np.cross(w, [1, 0, 0])


def test_the_arm_starts_at_the_angles_of_its_file():
    slave = _core.Slave(load(LIBRARY / "RobotArm.yaml").mechanism)
    slave.start()
    angles = np.radians([20, -35, 10, 70, 0, 45, 0])
    rates = np.radians([0, 10, 0, -20, 0, 0, 60])
    np.testing.assert_allclose([slave.get(f"joint{i}.angle") for i in range(1, 8)], angles, atol=1e-13)
    np.testing.assert_allclose([slave.get(f"joint{i}.angularRate") for i in range(1, 8)], rates, atol=1e-12)
