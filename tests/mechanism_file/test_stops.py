"""Stops that do not say how stiff they are: their coordinate would swing on them with a period of 20 ms."""

import numpy as np
import pytest

from sigmafmu import _core

from .helpers import HEAD, read

W0 = 2 * np.pi / 0.02  # rad/s


def stiffnesses(text: str) -> list[float]:
    return [stop["stop_stiffness"] for stop in read(HEAD + text).definition["joint_stops"]]


def two_digits(x: float) -> float:
    return float(f"{x:.2g}")


@pytest.mark.parametrize("size", [1e-3, 1.0, 1e3])
def test_of_a_hinge_it_is_that_of_the_inertia_about_it(size):
    inertia = [1e-3 * size**5, 0.02 * size**5, 0.021 * size**5]
    text = (
        f"bodies:\n  a: {{mass: {2 * size**3}, inertia: {inertia}, center_of_mass: [{0.3 * size}, 0, 0]}}\n"
        "joints:\n  j: {type: revolute, bodies: [ground, a], frame1: {}, limits: [-1, 1]}\n"
    )
    about_hinge = (0.021 + 2 * 0.3**2) * size**5
    assert stiffnesses(text) == [two_digits(about_hinge * W0**2)]


def test_armatures_and_what_is_carried_count():
    text = (
        "bodies:\n  a: {mass: 3, inertia: [1, 1, 1]}\n  b: {mass: 2, inertia: [1, 1, 1]}\n"
        "joints:\n  x: {type: prismatic, bodies: [ground, a], frame1: {}, limits: [0, 1], armature: 4}\n"
        "  y: {type: prismatic, bodies: [a, b], frame1: {orientation: {rotation_vector: [90 deg, 0, 0]}}, "
        "limits: [0, 1]}"
    )
    assert stiffnesses(text) == [two_digits((3 + 2 + 4) * W0**2), two_digits(2 * W0**2)]


def test_in_a_loop_all_that_moves_counts():
    """A piston at half a turn of its crank: crank r, rod l, in a line; a rod's end stands still there."""
    r, rod, piston = 0.1, 0.3, 2.0
    far = np.sqrt(rod**2 - r**2)
    text = (
        "gravity: [0, 0, 0]\nbodies:\n"
        f"  crank: {{mass: 1, inertia: [0.01, 0.01, 0.01], position: [0, 0, {r / 2}]}}\n"
        f"  rod: {{mass: 1, inertia: [0.01, 0.01, 0.01], position: [{far / 2}, 0, {r / 2}]}}\n"
        f"  piston: {{mass: {piston}, inertia: [1, 1, 1], position: [{far}, 0, 0]}}\n"
        "joints:\n  main: {type: revolute, bodies: [ground, crank], point: [0, 0, 0], axis: [0, 1, 0]}\n"
        f"  pin: {{type: revolute, bodies: [crank, rod], point: [0, 0, {r}], axis: [0, 1, 0]}}\n"
        f"  wrist: {{type: revolute, bodies: [rod, piston], point: [{far}, 0, 0], axis: [0, 1, 0]}}\n"
        "  bore: {type: prismatic, bodies: [ground, piston], point: [0, 0, 0], axis: [1, 0, 0], limits: [-1, 1]}\n"
    )
    # at this angle all of the rod and the piston move along x with r w, and the crank turns with w
    about = piston + 1 + (0.01 + r**2 / 4) / r**2
    assert stiffnesses(text) == [two_digits(about * W0**2)]


def test_a_driven_coordinate_has_no_stops_of_its_own():
    text = (
        "bodies:\n  a: {mass: 2, inertia: [1, 1, 1]}\njoints:\n"
        "  j: {type: revolute, bodies: [ground, a], frame1: {}, limits: [-1, 1]}\n"
        "drives: {j: {motion: rate, value: 1}}\n"
    )
    assert stiffnesses(text) == [0.0]


def test_what_the_file_says_stays():
    text = (
        "bodies:\n  a: {mass: 2, inertia: [1, 1, 1]}\njoints:\n  j: {type: planar, bodies: [ground, a], frame1: {}, "
        "limits: [-1, 1], stop_stiffness: 7, displacement_limits2: [0, 1]}\n"
    )
    assert stiffnesses(text) == [7.0, two_digits(2 * W0**2)]


def test_it_swings_with_that_period():
    """Deep in its stop, where that is linear."""
    text = (
        "gravity: [0, 0, 0]\nbodies:\n  a: {mass: 2, inertia: [1, 1, 1.5], center_of_mass: [1, 0, 0]}\njoints:\n"
        "  j: {type: revolute, bodies: [ground, a], frame1: {}, limits: [-1, 0], coordinate: 0.1}\n"
        "integrator: {stepSize: 1.0e-5}\n"
    )
    slave = _core.Slave(read(HEAD + text).mechanism)
    slave.start()
    steps = 0
    while slave.get("j.angle") > 0.01:
        slave.do_step(1e-5 * steps, 1e-5)
        steps += 1
    # from rest at p0 to p: cos(w t) = (p - w/2)/(p0 - w/2), with the stop's depth of 1 mrad
    expected = np.arccos((0.01 - 0.0005) / (0.1 - 0.0005)) / W0
    assert 1e-5 * steps == pytest.approx(expected, rel=0.02)
