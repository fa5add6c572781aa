"""Random trees and loops, rigid and flexible: what the solver of blocks finds against dense solutions of the same
equations."""

import numpy as np
import pytest
from hypothesis import strategies as st

from research.mechanisms.linkages import bricard, door, four_bar_row, planar_four_bar
from sigmafmu import _core

from .clouds import FLOATING
from .helpers import FORMULATIONS, JOINT_TYPES, assert_close, frame_pose, property_test, random_frame, seeds
from .test_flexible import random_tree

SPHERICAL = _core.JointType.spherical
DENSE = 1e-10
"""Condition numbers of what chance makes are below 1e5."""
every_formulation = pytest.mark.parametrize("formulation", FORMULATIONS.values(), ids=FORMULATIONS)
loops = st.integers(0, 2)
flexible = st.sets(st.integers(0, 5), max_size=3)


def closed_tree(rng, loops, flexible):
    """A tree of up to six bodies, some of them flexible, and ball joints between any two bodies or nodes of it."""
    bodies = int(rng.integers(2, 7))
    kinds = [JOINT_TYPES[rng.integers(len(JOINT_TYPES))] for _ in range(bodies)]
    tree = random_tree(rng, kinds, {i for i in flexible if i < bodies})
    system = tree.system()
    for k in range(loops):
        one, two = (int(i) for i in rng.choice(range(-1, bodies), 2, replace=False))
        node1, node2 = (int(rng.integers(-1, 6)) if body in tree.clouds else FLOATING for body in (one, two))
        frame = random_frame(rng)
        place = tree.frame(system, tree.q, one, node1) @ frame_pose(frame)
        local = np.linalg.inv(tree.frame(system, tree.q, two, node2)) @ place
        left, _, right = np.linalg.svd(local[:3, :3])  # orthonormal to rounding
        sides = one, _core.Frame(frame.origin, frame.axes, node1), two, _core.Frame(local[:3, 3], left @ right, node2)
        tree.definition.add(_core.Joint(f"loop{k}", SPHERICAL, *sides))
    return tree


def independent(tree):
    """Whether the solver sees exact joints alone, none of which nearly follows from others."""
    system = tree.system()
    return system.redundant == 0 and system.freedom(tree.q).margin > 5e-2


@property_test(150, seed=seeds, loops=loops, flexible=flexible)
def test_accelerations_and_multipliers(seed, loops, flexible):
    rng = np.random.default_rng(seed)
    tree = closed_tree(rng, loops, flexible)
    if not independent(tree):
        return
    system, q = tree.system(), tree.q
    n, m = system.velocity_size, system.constraint_size
    v = system.project_velocities(q, rng.uniform(-1, 1, n))
    inputs = rng.uniform(-5, 5, system.input_size)
    vdot, multipliers = system.accelerations(q, v, inputs)
    mass, _, _ = system.linearization(q, v, np.zeros(m), inputs, vdot)
    _, _, B, Z = system.constraints(q, v)
    force = system.residual(q, v, np.zeros(n), np.zeros(m), inputs)
    matrix = np.block([[mass, B.T], [B, np.zeros((m, m))]])
    expected = np.linalg.solve(matrix, -np.concatenate([force, Z @ v]))
    scale = np.abs(expected).max()
    assert_close(vdot, expected[:n], DENSE, scale)
    assert_close(multipliers, expected[n:], DENSE, scale)


def near_identity(rng, rows):
    return np.eye(6)[:rows] * (rows == 6) + 0.2 * rng.uniform(-1, 1, (rows, 6))


def tangents(rng, bodies, rotations_only):
    """U, P^-1, E, F of each body, whatever they are."""
    U, P_inverse = ([near_identity(rng, 6) for _ in range(bodies)] for _ in range(2))
    E, F = ([near_identity(rng, 3) for _ in range(bodies)] for _ in range(2))
    if rotations_only:
        for A in U + P_inverse:
            A[:3], A[3:, :3] = np.eye(6)[:3], 0
        for A in E + F:
            A[:] = 0
    return U, P_inverse, E, F


def embedded(blocks, size, identity):
    """Blocks of bodies on the diagonal, modes unchanged."""
    result = np.eye(size) if identity else np.zeros((size, size))
    for i, block in enumerate(blocks):
        result[6 * i : 6 * i + len(block), 6 * i : 6 * i + 6] = block
    return result


def own_blocks(tree, system):
    """Which entries belong to one body: its pose and modes."""
    bodies = len(tree.definition.bodies)
    owner = list(np.repeat(range(bodies), 6))
    for i in sorted(tree.clouds, key=system.modal_index):
        owner += [i] * system.modes(i)
    return np.equal.outer(owner, owner)


def newton(rng, definition, q, formulation, own):
    """(what NewtonIteration finds, what the equations of newton_matrix.h give): motion, lambda and mu after it."""
    system = _core.System(definition)
    n, m, bodies = system.velocity_size, system.constraint_size, len(definition.bodies)
    h = 10.0 ** rng.uniform(-4, -1)
    gamma, beta = rng.uniform(1.5, 2.5) / h, rng.uniform(3, 5) / h**2
    scale = rng.uniform(0.8, 1.2) / beta
    q_n = system.compose(q, 0.1 * rng.uniform(-1, 1, n))
    v, vdot = rng.uniform(-1, 1, (2, n))
    multipliers, mu = rng.uniform(-1, 1, (2, m))
    rotations_only = rng.random() < 0.5
    U, P_inverse, E, F = tangents(rng, bodies, rotations_only)
    iteration = _core.NewtonIteration(definition, formulation)
    iteration.set_tangents(U, P_inverse, E, F, rotations_only)
    found = iteration.solve(q_n, q, v, vdot, multipliers, mu, gamma, beta, scale)

    u = np.zeros(system.input_size)
    M, C, K = system.linearization(q, v, multipliers, u, vdot)
    r = system.residual(q, v, vdot, multipliers, u)
    phi, rate, B, Z = system.constraints(q, v)
    start = system.constraints(q_n, v)[2]
    of_velocities = system.velocity_equations  # alone: rows of rates in every form, and no mu
    start[of_velocities] = 0
    U, P_inverse = embedded(U, n, True), embedded(P_inverse, n, True)
    E, F = embedded(E, n, False), embedded(F, n, False)
    kappa, damping = scale * beta, scale * gamma
    dynamics = kappa * M @ (U + E) + damping * C @ U + scale * K
    rates = Z / gamma + B @ U
    none, e, d = np.zeros((m, m)), np.zeros((m, m)), np.zeros((m, m))
    for row, of_force, of_motion in system.compliance:
        e[row, row], d[row, row] = of_force, of_motion
    yielding = e @ multipliers * scale
    if formulation == FORMULATIONS["stabilizedIndex2"]:
        D = kappa * M @ (P_inverse + F) + damping * np.where(own, C, 0) @ P_inverse  # of bodies, not between them
        matrix = np.block([[dynamics, B.T, D @ start.T], [B, -e, none], [rates, none, B @ P_inverse @ start.T + d]])
        right = np.concatenate([-scale * r, yielding - phi, -rate / gamma - d @ mu])
        for row in of_velocities:
            second, third = n + row, n + m + row
            matrix[second, :n], matrix[second, n + m :] = matrix[third, :n], matrix[third, n + m :]
            right[second] = (yielding - rate / gamma)[row]
            matrix[third], right[third] = np.eye(len(matrix))[third], 0.0
    else:
        index3 = formulation == FORMULATIONS["index3"]
        matrix = np.block([[dynamics, B.T], [B if index3 else rates, -e]])
        right = np.concatenate([-scale * r, yielding - (phi if index3 else rate / gamma)])
        for row in of_velocities:
            matrix[n + row, :n], right[n + row] = rates[row], (yielding - rate / gamma)[row]
    x = np.linalg.solve(matrix, right)
    return found, (x[:n], multipliers + x[n : n + m] / scale, mu + (x[n + m :] if len(x) > n + m else 0)), scale


def check_newton(found, expected, scale):
    """Multipliers are unknown as `scale` times their increment."""
    size = max(np.abs(x).max(initial=0.0) for x in (expected[0], scale * expected[1], expected[2]))
    assert_close(found[0], expected[0], DENSE, size)
    assert_close(scale * found[1], scale * expected[1], DENSE, size)
    assert_close(found[2], expected[2], DENSE, size)


@every_formulation
@property_test(100, seed=seeds, loops=loops, flexible=flexible)
def test_newtons_equations(formulation, seed, loops, flexible):
    """Away from the joints, where Newton's method comes from, with any tangents."""
    rng = np.random.default_rng(seed)
    tree = closed_tree(rng, loops, flexible)
    if not independent(tree):
        return
    system = tree.system()
    q = system.compose(tree.q, 1e-2 * rng.uniform(-1, 1, system.velocity_size))
    check_newton(*newton(rng, tree.definition, q, formulation, own_blocks(tree, system)))


REDUNDANT = {
    "PlanarFourBar": planar_four_bar,
    "FourBarRow(3)": lambda: four_bar_row(3),
    "Bricard": bricard,
    "Door": door,
}


@every_formulation
@pytest.mark.parametrize("name", REDUNDANT)
def test_newtons_equations_of_redundant_joints(name, formulation):
    """Their compliance of 1e-7 is in the matrix, which has that condition: four digits less."""
    definition = REDUNDANT[name]().multibody
    q, _ = _core.assemble(definition)
    own = np.kron(np.eye(len(definition.bodies)), np.ones((6, 6))) > 0
    for seed in range(20):
        found, expected, _ = newton(np.random.default_rng(seed), definition, q, formulation, own)
        assert_close(found[0], expected[0], 1e-6, np.abs(expected[2]).max())


@pytest.mark.parametrize("name", REDUNDANT)
def test_accelerations_of_redundant_joints(name):
    """Those of least constraint by a pseudo-inverse; multipliers that push no joint apart: the shortest, weighed by the
    compliance."""
    definition = REDUNDANT[name]().multibody
    system = _core.System(definition)
    q, v = _core.assemble(definition)
    n, m = system.velocity_size, system.constraint_size
    inputs = np.random.default_rng(1).uniform(-1, 1, system.input_size)
    vdot, multipliers = system.accelerations(q, v, inputs)
    mass, _, _ = system.linearization(q, v, np.zeros(m), inputs)
    _, _, B, Z = system.constraints(q, v)
    force = system.residual(q, v, np.zeros(n), np.zeros(m), inputs)
    weights = np.ones(m)
    for row, e, _ in system.compliance:
        weights[row] = np.sqrt(e)
    flexibility = B @ np.linalg.solve(mass, B.T)
    right = Z @ v - B @ np.linalg.solve(mass, force)
    scaled = flexibility / np.outer(weights, weights)
    expected = np.linalg.lstsq(scaled, right / weights, rcond=1e-9)[0] / weights
    accelerations = -np.linalg.solve(mass, force + B.T @ expected)
    assert_close(vdot, accelerations, DENSE, np.abs(accelerations).max())
    assert_close(multipliers, expected, 1e-6, np.abs(expected).max())
