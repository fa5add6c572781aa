"""Chains of links on spherical joints against a solution in minimal velocities: accuracy and order at any length."""

from functools import cache

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from sigmafmu import _core

from .helpers import GROUND, Rotation

MASS, INERTIA, GRAVITY = 1.0, np.diag([0.02, 0.09, 0.1]), np.array([0.0, 0.0, -9.81])
LENGTHS = (1, 2, 5, 10)
X = np.array([1.0, 0.0, 0.0])


def start(links):
    """Angular velocities of the links, all of which lie along x at first."""
    return np.array([[0.5 * (-1) ** k, 0.25, 1.0] for k in range(1, links + 1)])


def chain(links, h, **settings):
    """Links of 1 m and 1 kg, their frames in the middle; the first hangs at the origin."""
    mechanism = _core.Mechanism(f"Chain{links}")
    mechanism.multibody.gravity = GRAVITY
    end, joint = np.zeros(3), -0.5 * X
    for k, w in enumerate(start(links)):
        body = _core.RigidBody()
        body.name, body.mass, body.inertia = f"link{k + 1}", MASS, np.diag(INERTIA).copy()
        body.initial_position = (k + 0.5) * X
        body.initial_angular_velocity, body.initial_velocity = w, end + np.cross(w, 0.5 * X)
        end = end + np.cross(w, X)
        mechanism.multibody.add(body)
        before = _core.Frame(np.zeros(3) if k == 0 else 0.5 * X, np.eye(3))
        ends = (k - 1 if k else GROUND, before, k, _core.Frame(joint, np.eye(3)))
        mechanism.multibody.add(_core.Joint(f"joint{k + 1}", _core.JointType.spherical, *ends))
    mechanism.integrator.step_size = h
    for name, value in settings.items():
        setattr(mechanism.integrator, name, value)
    return mechanism


def accelerations(turns, w):
    """ω' in W by Jourdain's principle, for velocities that are the ω of all links: no joint, no multiplier.

    The centre of link k moves with Σ_j ω_j × r_kj, r_kj being the whole of link j before it and half of its own.
    """
    links = len(w)
    along = turns.apply(X)
    J = np.zeros((3 * links, 3 * links))  # of the centres
    bias = np.zeros((links, 3))  # their accelerations at ω' = 0
    for k in range(links):
        for j in range(k + 1):
            r = along[j] * (0.5 if j == k else 1.0)
            J[3 * k : 3 * k + 3, 3 * j : 3 * j + 3] = -_core.lie.hat(r)
            bias[k] += np.cross(w[j], np.cross(w[j], r))
    mass = MASS * J.T @ J
    force = MASS * J.T @ (GRAVITY - bias).ravel()
    R = turns.as_matrix()
    for k in range(links):
        inertia = R[k] @ INERTIA @ R[k].T
        mass[3 * k : 3 * k + 3, 3 * k : 3 * k + 3] += inertia
        force[3 * k : 3 * k + 3] -= np.cross(w[k], inertia @ w[k])
    return np.linalg.solve(mass, force).reshape(-1, 3)


@cache
def reference(links):
    """The chain's tip after 1 s; DOP853 on quaternions, whose length is that of rounding."""

    def rates(_, y):
        q, w = y[: 4 * links].reshape(-1, 4), y[4 * links :].reshape(-1, 3)
        spin = np.column_stack([np.zeros(links), w])
        turn = np.array([_product(s, p) for s, p in zip(spin, q, strict=True)])
        wdot = accelerations(Rotation.from_quat(q, scalar_first=True), w)
        return np.concatenate([0.5 * turn.ravel(), wdot.ravel()])

    y0 = np.concatenate([np.tile([1.0, 0, 0, 0], links), start(links).ravel()])
    solution = solve_ivp(rates, (0.0, 1.0), y0, method="DOP853", rtol=1e-12, atol=1e-12)
    turns = Rotation.from_quat(solution.y[: 4 * links, -1].reshape(-1, 4), scalar_first=True)
    return turns.apply(X).sum(axis=0)


def _product(p, q):
    """Of quaternions (w, x, y, z)."""
    return np.concatenate([[p[0] * q[0] - p[1:] @ q[1:]], p[0] * q[1:] + q[0] * p[1:] + np.cross(p[1:], q[1:])])


@cache
def tip_error(links, h):
    simulation = _core.Simulation(chain(links, h))
    simulation.run(1.0, round(1.0 / h))
    q = simulation.state.q[7 * (links - 1) :]
    tip = q[:3] + Rotation.from_quat(q[3:7], scalar_first=True).apply(0.5 * X)
    return np.linalg.norm(tip - reference(links))


@pytest.mark.parametrize("links", LENGTHS)
def test_the_tip_is_where_it_belongs(links):
    assert tip_error(links, 2.5e-4) <= 5e-6


@pytest.mark.parametrize("links", LENGTHS)
def test_the_error_is_of_second_order(links):
    assert np.log2(tip_error(links, 5e-4) / tip_error(links, 2.5e-4)) == pytest.approx(2.0, abs=0.1)
