"""The order of elimination: minimum degree under precedence, regular pivots, work that grows as a tree does."""

from collections.abc import Sequence
from functools import cache

import numpy as np
import pytest
from hypothesis import strategies as st

from sigmafmu import _core

from .closed_chains import FIXED, PRISMATIC, REVOLUTE, SPHERICAL, UNIVERSAL
from .helpers import EPS, GROUND, Rotation, property_test, seeds

FORMS = [_core.Kkt.index1, _core.Kkt.newton, _core.Kkt.stabilized]


def eliminated(sizes, blocks, after, order):
    """Neighbours of each node at its turn, and whether the turn was its own: by elimination in a graph of sets."""
    beside = {i: {j for pair in blocks for j in pair if i in pair} - {i} for i in range(len(sizes))}
    pattern = [[] for _ in sizes]
    done = set()
    for pivot in order:
        allowed = [i for i in beside if set(after[i]) <= done]
        assert pivot == min(allowed, key=lambda i: (sum(sizes[j] for j in beside[i]), i))
        neighbours = beside.pop(pivot)
        pattern[pivot] = sorted(neighbours)
        for i in neighbours:
            beside[i] |= neighbours - {i}
            beside[i].discard(pivot)
        done.add(pivot)
    return pattern


@property_test(300, seed=seeds, nodes=st.integers(1, 25), density=st.floats(0, 1))
def test_order_is_that_of_minimum_degree(seed, nodes, density):
    rng = np.random.default_rng(seed)
    sizes = rng.integers(1, 13, nodes).tolist()
    blocks = [(i, j) for i in range(nodes) for j in range(i + 1) if rng.uniform() < density]
    rank = rng.permutation(nodes)  # precedence without circles
    after = [[j for j in range(nodes) if rank[j] < rank[i] and rng.uniform() < 0.1] for i in range(nodes)]
    order, pattern, cost = _core.eliminate(sizes, blocks, after)
    assert sorted(order) == list(range(nodes))
    assert pattern == eliminated(sizes, blocks, after, order)
    beside = [sum(sizes[j] for j in neighbours) for neighbours in pattern]
    assert cost == pytest.approx(sum(n**3 / 3 + n**2 * d + n * d**2 for n, d in zip(sizes, beside, strict=True)))


# --- mechanisms ------------------------------------------------------------------------------------------------------


KINDS = [REVOLUTE, PRISMATIC, UNIVERSAL, SPHERICAL, FIXED]


def joined(rng: np.random.Generator, bodies: int, ends: Sequence[tuple[int, int]]) -> _core.Multibody:
    """Bodies of 1 kg and about 1 m with joints between these of them: `bodies` of any types, then spherical ones."""
    d = _core.Mechanism().multibody
    turns = [Rotation.random(rng=rng) for _ in range(bodies)]
    places = np.cumsum(rng.normal(size=(bodies, 3)), axis=0)
    for i in range(bodies):
        body = _core.RigidBody()
        body.name, body.mass, body.inertia = f"body{i + 1}", 1.0, rng.uniform(0.2, 0.3, 3)
        body.initial_position, body.initial_quaternion = places[i], turns[i].as_quat(scalar_first=True)
        d.add(body)
    for k, pair in enumerate(ends):
        kind = KINDS[rng.integers(len(KINDS))] if k < bodies else SPHERICAL
        point, axes = places[pair[1]] + rng.normal(size=3), Rotation.random(rng=rng).as_matrix()
        sides = []
        for i in pair:
            position, R = (np.zeros(3), np.eye(3)) if i == GROUND else (places[i], turns[i].as_matrix())
            left, _, right = np.linalg.svd(R.T @ axes)  # orthonormal to rounding
            sides += [i, _core.Frame(R.T @ (point - position), left @ right)]
        d.add(_core.Joint(f"joint{k + 1}", kind, *sides))
    return d


def tree(rng: np.random.Generator, bodies: int, *, chain: bool = False, loops: int = 0) -> _core.Multibody:
    """In a row or at random, some of them without a joint to the ground, and `loops` of more joints."""
    ends = [(i - 1 if chain else int(rng.integers(-1, i)), i) for i in range(rng.uniform() < 0.2, bodies)]
    more = [tuple(sorted(rng.choice(np.arange(-1, bodies), 2, replace=False).tolist())) for _ in range(loops)]
    return joined(rng, bodies, ends + more)


def equations(rng: np.random.Generator, d: _core.Multibody, form: _core.Kkt) -> np.ndarray:
    """The matrix of newton_matrix.h at the initial position, for a step of 1 ms and mechanisms of any velocities."""
    system = _core.System(d)
    n, h = system.velocity_size, 1e-3
    q = np.concatenate([np.concatenate([b.initial_position, b.initial_quaternion]) for b in d.bodies])
    v, lambda_ = rng.normal(size=n), rng.normal(size=system.constraint_size)
    M, C, K = system.linearization(q, v, lambda_, np.zeros(system.input_size))
    _, _, B, Z = system.constraints(q, v)
    zero = np.zeros((len(B), len(B)))
    if form == _core.Kkt.index1:
        return np.block([[M, B.T], [B, zero]])
    S = M + h * C
    if form == _core.Kkt.newton:
        return np.block([[S + h**2 * K, B.T], [B + h * Z, zero]])
    start = system.constraints(system.compose(q, h * rng.normal(size=n)), v)[2]
    D = np.kron(np.eye(len(d.bodies)), np.ones((6, 6))) * S
    return np.block([[S + h**2 * K, B.T, D @ start.T], [B, zero, zero], [h * Z, zero, B @ start.T]])


@pytest.mark.parametrize("form", FORMS, ids=lambda form: form.name)
@pytest.mark.parametrize("loops", [0, 1, 3])
def test_pivots_are_regular(form, loops):
    """Elimination of blocks loses hardly more than elimination with any pivots."""
    for seed in range(100):
        rng = np.random.default_rng(seed)
        d = tree(rng, int(rng.integers(2, 13)), chain=seed % 4 == 0, loops=loops)
        if loops > 0 and _core.freedom(d).margin < 1e-2:  # chance may tie bodies that are tied already
            continue
        A = equations(rng, d, form)
        b = rng.normal(size=len(A))
        x = _core.KktSolver(d, form).solve(A, b)
        assert np.abs(A @ x - b).max() <= 100 * EPS * (np.abs(A) @ np.abs(x)).max(), seed


def row_of_loops(loops: int) -> list[tuple[int, int]]:
    """Four-bars, each on a link of the one before."""
    return [(a + 3 * k, b + 3 * k) for k in range(loops) for a, b in ((-1, 0), (0, 1), (1, 2), (-1, 2))]


@cache
def grown(shape: str, bodies: int) -> _core.Multibody:
    """A mechanism of that many bodies."""
    rng = np.random.default_rng(1)
    if shape == "loops":
        return joined(rng, bodies, row_of_loops(bodies // 3))
    return tree(rng, bodies, chain=shape == "chain")


@pytest.mark.parametrize("form", FORMS, ids=lambda form: form.name)
@pytest.mark.parametrize("shape", ["chain", "tree", "loops"])
def test_work_and_memory_grow_with_the_number_of_bodies(form, shape):
    """And with the most joints at a body, whose number grows as the logarithm of that in a random tree."""
    bodies = np.array([99, 198, 396, 792, 1584])
    solvers = [_core.KktSolver(grown(shape, n), form) for n in bodies.tolist()]
    for count in ([s.cost for s in solvers], [s.values for s in solvers]):
        assert np.polyfit(np.log(bodies), np.log(count), 1)[0] < 1.15
