"""Mechanisms go through positions in which two motions branch, again and again, and keep to theirs.

In such a position a joint equation more follows from the others. A linkage of cranks and couplers of equal length lies
in one line there and might fold instead; the slider of a crank and a rod of equal length is over the crank's pivot,
where it might stay. Inertia takes both straight on, and so do their solutions in one coordinate.
"""

import re
from functools import cache

import numpy as np
import pytest

from research.mechanisms.linkages import CYLINDRICAL, GRAVITY, four_bar_row
from research.mechanisms.parts import REVOLUTE, SPHERICAL, Z, add_bar, add_body, add_joint
from research.reference.linkage_motions import four_bar_row_motion, reduced_motion
from sigmafmu import _core

from .helpers import GROUND, INDEX2, INDEX3, MODIFIED, STABILIZED, TANGENT_FREE, Rotation, simulation
from .methods import BLIEDF2, RKMK4

PRISMATIC, UNIVERSAL = _core.JointType.prismatic, _core.JointType.universal


def flat_row(count: int, speeds: np.ndarray) -> _core.Mechanism:
    """The same row at the start in one line along x, each crank with a speed of its tip upwards [m/s]."""
    m = _core.Mechanism()
    m.name = "FlatRow"
    m.multibody.gravity = GRAVITY
    inertia = np.array([1e-4, 1 / 12, 1 / 12])
    points, up = np.array([[float(i), 0, 0] for i in range(count + 3)]), speeds[:, None] * np.array([0, 1.0, 0])
    for i in range(count + 1):
        add_bar(m.multibody, f"crank{i + 1}", points[i : i + 2], 1.0, inertia, np.array([0 * up[i], up[i]]))
    for i in range(count):
        add_bar(m.multibody, f"coupler{i + 1}", points[i + 1 : i + 3], 1.0, inertia, up[i : i + 2])
    for i in range(count + 1):
        add_joint(m.multibody, f"pivot{i + 1}", REVOLUTE, GROUND, i, points[i])
    for i in range(count):
        add_joint(m.multibody, f"left{i + 1}", REVOLUTE, i, count + 1 + i, points[i + 1])
        add_joint(m.multibody, f"right{i + 1}", REVOLUTE, count + 1 + i, i + 1, points[i + 2])
    return m


def largest_change_of_energy(definition: _core.Mechanism, q: np.ndarray, v: np.ndarray) -> float:
    system = _core.System(definition.multibody)
    found = np.array([system.energy(*row) for row in zip(q, v, strict=True)])
    return float(np.abs(found - found[0]).max())


# --- rows of cranks --------------------------------------------------------------------------------------------------

STOP = 10.0  # s; the row lies flat every 0.5 or 1.4 s
SAMPLES = 100


@cache
def row_angles(count: int) -> np.ndarray:
    return four_bar_row_motion(count, np.linspace(0, STOP, SAMPLES + 1))[0]


def row_run(h: float, **settings: object) -> tuple[float, float, int]:
    """Largest error of the first coupler's corner, of the energy [J], and repeated steps."""
    definition = four_bar_row(2)
    steps = SAMPLES * round(STOP / h / SAMPLES)
    run = simulation(definition, step_size=STOP / steps, **settings)
    _, q, v, _ = run.trajectory(STOP, steps)
    every = slice(None, None, steps // SAMPLES)
    corner = q[every, 21:23] - [0.5, 0.0]
    theta = row_angles(2)
    error = np.abs(corner - np.stack([np.cos(theta), np.sin(theta)], axis=-1)).max()
    return float(error), largest_change_of_energy(definition, q, v), run.state.counters.retries


# Accuracies: generalized-alpha is to stay below 2e-4 m; the other methods have the errors that they have between two
# passages, over ten seconds. 1.5e-3 J are a ten-thousandth of what gravity and motion exchange.
ROWS = {
    "stabilizedIndex2": ({}, 2e-4, 1.5e-3),
    "index3": ({"formulation": INDEX3}, 2e-4, 1.5e-3),
    "index2": ({"formulation": INDEX2}, 2e-4, 1.5e-3),
    "tangent-free": ({"jacobian": TANGENT_FREE}, 2e-4, 1.5e-3),
    "modified": ({"newton": MODIFIED}, 2e-4, 1.5e-3),
    "bliedf2": ({"method": BLIEDF2}, 3e-3, 1e-2),
    "bliedf2, index3": ({"method": BLIEDF2, "formulation": INDEX3}, 3e-3, 1e-2),
    "rkmk4": ({"method": RKMK4}, 1e-4, 1e-3),
}


@pytest.mark.parametrize("case", ROWS)
def test_double_four_bar(case):
    settings, accuracy, energy = ROWS[case]
    error, change, retries = row_run(1e-3, **settings)
    assert error <= accuracy
    assert change <= energy
    assert retries <= (20 if case == "modified" else 1)  # a matrix of the step before is of little use there


def test_wherever_steps_end_near_the_flat_position():
    """17 step sizes around 1 ms, 15 passages each: errors are of the method's order, and no run takes the other way."""
    for h in np.linspace(0.8e-3, 1.2e-3, 17):
        error, change, _ = row_run(float(h))
        assert error <= 2.5e-4 * (h / 1e-3) ** 2 + 5e-5, h
        assert change <= 2e-3, h


def test_many_loops_pass_together():
    """Ten loops, of which each might fold, during 2 s with three passages."""
    count, stop = 10, 2.0
    run = simulation(four_bar_row(count), step_size=1e-3)
    run.advance(1e-3, 2000)
    theta = four_bar_row_motion(count, np.array([0.0, stop]))[0][-1]
    turn = Rotation.from_quat(run.state.q.reshape(-1, 7)[: count + 1, 3:], scalar_first=True).as_rotvec()[:, 2]
    assert np.abs(np.remainder(turn - theta + np.pi, 2 * np.pi) - np.pi).max() <= 2e-4


def test_a_parallelogram_passes_whatever_the_step():
    """One loop, three passages in 2 s. Near them steps are repeated with halves, in which joints get no stiffer."""
    exact = four_bar_row_motion(1, np.array([0.0, 2.0]))[0][-1]
    for steps in range(1200, 6000, 148):
        run = simulation(four_bar_row(1), step_size=2 / steps)
        run.advance(2 / steps, steps)
        turn = Rotation.from_quat(run.state.q[3:7], scalar_first=True).as_rotvec()[2]
        assert abs(np.remainder(turn - exact + np.pi, 2 * np.pi) - np.pi) <= 2e-5 * (1000 / steps) ** 2 + 1e-6, steps


# --- starts in the flat position -------------------------------------------------------------------------------------


@pytest.mark.parametrize("formulation", [INDEX3, STABILIZED], ids=["index3", "stabilizedIndex2"])
@pytest.mark.parametrize("count", [1, 2, 6])
def test_a_start_in_a_singular_position_goes_on_along_its_velocities(count, formulation):
    """All cranks lie along x and turn alike, up and down again through the line."""
    exact = four_bar_row_motion(count, np.array([0.0, 0.5]), (0.0, 1.0))[0][-1]
    errors = []
    for steps in (500, 1000):
        run = simulation(flat_row(count, np.ones(count + 1)), step_size=0.5 / steps, formulation=formulation)
        run.advance(0.5 / steps, steps)
        turns = Rotation.from_quat(run.state.q.reshape(-1, 7)[: count + 1, 3:], scalar_first=True).as_rotvec()[:, 2]
        errors.append(np.abs(turns - exact).max())
    assert errors[0] <= 1e-5
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2.0, abs=0.1)


@pytest.mark.parametrize("speeds", [[0, 0, 0], [1.0, 0.5, 1.0], [1.0, 0, -0.5]], ids=["rest", "bent", "any"])
def test_a_start_in_a_singular_position_needs_velocities_of_one_motion(speeds):
    """At rest gravity pulls bars apart, and cranks of unlike speeds would have to stretch the couplers. (Couplers turn
    with their ends.)"""
    with pytest.raises(RuntimeError) as caught:
        simulation(flat_row(2, np.array(speeds)))
    assert re.fullmatch(
        r"The position is singular: 8 of the 35 equations of joints pivot1, .* and right2 follow from the others in it "
        r"alone; choose a start at some distance from it, or velocities that lead through it\.",
        str(caught.value),
    )


def test_a_singular_start_is_told():
    slave = _core.Slave(flat_row(1, np.ones(2)))
    slave.start()
    assert slave.messages == [
        "Joint equations are dependent: 4 of the 20 equations of joints pivot1, pivot2, left1 and right1 follow from "
        "the others in this position alone; the reactions of these joints are one choice of many that fit the motion."
    ]


# --- slider-crank with equal crank and rod ---------------------------------------------------------------------------

LENGTH, BAR_INERTIA, SLIDER = 0.5, np.array([1e-3, 1 / 48 + 1e-3, 1 / 48 + 1e-3]), 0.5
START, SPIN = 1.0, 8.0


def equal_slider_crank(kinds: tuple) -> _core.Mechanism:
    """Crank and rod of 0.5 m and 1 kg, a slider of 0.5 kg on the x axis: x = 2 LENGTH cos θ."""
    m = _core.Mechanism()
    m.multibody.gravity = GRAVITY
    direction, across = np.array([np.cos(START), np.sin(START), 0]), np.array([-np.sin(START), np.cos(START), 0])
    pivot, pin, end = np.zeros(3), LENGTH * direction, np.array([2 * LENGTH * np.cos(START), 0, 0])
    speeds = 0 * pin, LENGTH * SPIN * across, np.array([-2 * LENGTH * SPIN * np.sin(START), 0, 0])
    add_bar(m.multibody, "crank", np.array([pivot, pin]), 1.0, BAR_INERTIA, np.array(speeds[:2]))
    add_bar(m.multibody, "rod", np.array([pin, end]), 1.0, BAR_INERTIA, np.array(speeds[1:]))
    add_body(m.multibody, "slider", SLIDER, np.full(3, 1e-3), end, velocity=speeds[2])
    places = [(GROUND, 0, pivot, Z), (0, 1, pin, Z), (1, 2, end, Z), (GROUND, 2, end, np.array([1.0, 0, 0]))]
    for i, (kind, place) in enumerate(zip(kinds, places, strict=True)):
        add_joint(m.multibody, f"joint{i + 1}", kind, *place)
    return m


SLIDERS = {
    "redundant": ((REVOLUTE, REVOLUTE, REVOLUTE, PRISMATIC), 3),
    "regular": ((REVOLUTE, SPHERICAL, CYLINDRICAL, PRISMATIC), 0),
}


def crank_angles(times: np.ndarray) -> np.ndarray:
    """The rod's center is at (3 cos θ, sin θ) LENGTH/2 and it turns by -θ."""
    half, J, g = LENGTH / 2, BAR_INERTIA[2], -GRAVITY[1]
    return reduced_motion(
        lambda a: 2 * J + half**2 * (1 + 9 * np.sin(a) ** 2 + np.cos(a) ** 2) + SLIDER * (4 * half * np.sin(a)) ** 2,
        lambda a: (16 * half**2 + 32 * SLIDER * half**2) * np.sin(a) * np.cos(a),
        lambda a: 2 * g * half * np.cos(a),
        (START, SPIN),
        times,
    )[0]


OVER_THE_PIVOT = {
    "stabilizedIndex2": {},
    "index3": {"formulation": INDEX3},
    "index2": {"formulation": INDEX2},
    "modified": {"newton": MODIFIED},
    "bliedf2": {"method": BLIEDF2},
    "rkmk4": {"method": RKMK4},
}


@pytest.mark.parametrize(
    ("kind", "case"), [(k, c) for k in SLIDERS for c in OVER_THE_PIVOT if (k, c) != ("regular", "index2")]
)
def test_slider_over_the_pivot(kind, case):
    """Six passages in 2 s: the order is that of motion anywhere else. Exact joints pass as well as soft ones, but in
    index 2: near a passage they take what positions have drifted for a motion."""
    settings, order = OVER_THE_PIVOT[case], 4 if case == "rkmk4" else 2
    kinds, dependent = SLIDERS[kind]
    stop = 2.0
    times = np.linspace(0, stop, 51)
    exact = 2 * LENGTH * np.cos(crank_angles(times))
    errors = []
    for steps in (2000, 4000):
        definition = equal_slider_crank(kinds)
        assert _core.System(definition.multibody).redundant == dependent
        run = simulation(definition, step_size=stop / steps, **settings)
        _, q, _, _ = run.trajectory(stop, steps)
        assert run.state.counters.retries == 0
        errors.append(float(np.abs(q[:: steps // 50, 14] - exact).max()))
    assert max(errors) <= (1e-5 if case == "rkmk4" else 2e-2)
    # What a passage adds depends on how near to it a step ends.
    assert np.log2(errors[0] / errors[1]) >= order - 0.5
