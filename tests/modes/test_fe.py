"""Modes from finite-element matrices, against the full eigenproblem and statics, and the checks of the matrices."""

import gzip
from pathlib import Path

import numpy as np
import pytest
import scipy.io
import scipy.linalg
import scipy.sparse as sp
import scipy.sparse.linalg as spl

import sigmafmu.modes as package
from sigmafmu import SigmafmuError
from sigmafmu.modes import FeData, checks, craig_bampton, fe_from_matrices, fixed_modes, free_modes, read_fe
from sigmafmu.modes.data import rigid_motions

from .hexahedra import block

SIZE, CELLS = (1.0, 0.1, 0.15), (10, 2, 2)
LEFT, RIGHT = range(9), range(90, 99)


@pytest.fixture(scope="session")
def matrices():
    return block(SIZE, CELLS, E=210e9, nu=0.3, density=7850.0)


@pytest.fixture(scope="session")
def body(matrices) -> FeData:
    return fe_from_matrices(*matrices)


def test_names_of_the_package_are_there_and_documented():
    """They are looked up when they are used: a wrong one would be noticed late."""
    assert [name for name in package.__all__ if not getattr(package, name).__doc__] == []


def dofs(nodes) -> np.ndarray:
    return (3 * np.array(nodes)[:, None] + np.arange(3)).ravel()


def full_frequencies(matrices, held=()) -> np.ndarray:
    """All frequencies [Hz] of the full problem with LAPACK's solver, rigid ones left out."""
    K, M, X = matrices
    free = np.setdiff1d(np.arange(3 * len(X)), dofs(held) if len(held) else [])
    values = scipy.linalg.eigh(K.toarray()[np.ix_(free, free)], M.toarray()[np.ix_(free, free)], eigvals_only=True)
    return np.sqrt(values[0 if len(held) else 6 :]) / (2 * np.pi)


def test_mass_and_inertia_are_those_of_the_block(body):
    data = free_modes(body, 1)
    mass = 7850.0 * np.prod(SIZE)
    a, b, c = np.square(SIZE)
    assert data.total_mass == pytest.approx(mass, rel=1e-13)
    np.testing.assert_allclose(data.center_of_mass, np.array(SIZE) / 2, rtol=1e-13)
    np.testing.assert_allclose(np.diag(data.frame_mass)[3:6], mass / 3 * np.array((b + c, a + c, a + b)), rtol=1e-12)


def test_free_modes_are_those_of_the_full_problem(body, matrices):
    data = free_modes(body, 8)
    np.testing.assert_allclose(data.frequencies, full_frequencies(matrices)[:8], rtol=1e-8)
    np.testing.assert_allclose(data.modal_mass, np.eye(8), atol=1e-8)
    coupling = np.einsum("nip,niq->pq", rigid_motions(data.X), data.weigh(data.Phi))
    assert np.abs(coupling).max() < 1e-7 * np.sqrt(data.total_mass)  # Tisserand's frame


def test_fixed_modes_are_those_of_the_full_problem(body, matrices):
    data = fixed_modes(body, [LEFT], 6)
    np.testing.assert_allclose(data.frequencies, full_frequencies(matrices, LEFT)[:6], rtol=1e-9)
    np.testing.assert_array_equal(data.Phi[list(LEFT)], 0.0)


@pytest.mark.parametrize("size", [20, 10**6])
def test_dense_and_sparse_solvers_agree(matrices, monkeypatch, size):
    monkeypatch.setattr("sigmafmu.modes.eigen.DENSE", size)
    monkeypatch.setattr(checks, "DENSE", size)
    data = free_modes(fe_from_matrices(*matrices), 8)
    np.testing.assert_allclose(data.frequencies, full_frequencies(matrices)[:8], rtol=1e-8)


def test_nodes_without_mass_do_no_harm(matrices):
    """Lumped mass on the corners of the sections only."""
    K, M, X = matrices
    lumped = M.sum(axis=0)
    lumped[dofs(range(4, 99, 9))] = 0.0
    data = free_modes(fe_from_matrices(K, sp.diags_array(lumped), X), 4)
    heavy = lumped > 0
    condensed = spl.splu(sp.csc_array(K[~heavy][:, ~heavy])).solve(K[~heavy][:, heavy].toarray())
    reduced = K[heavy][:, heavy].toarray() - K[heavy][:, ~heavy] @ condensed
    exact = scipy.linalg.eigh(reduced, np.diag(lumped[heavy]), eigvals_only=True)[6:10]
    np.testing.assert_allclose(data.frequencies, np.sqrt(exact) / (2 * np.pi), rtol=1e-8)


@pytest.mark.parametrize("frame", ["first", "free"])
def test_craig_bampton_with_all_modes_is_the_full_problem(body, matrices, frame):
    inner = 3 * (99 - 18)
    data = craig_bampton(body, [LEFT, RIGHT], inner, frame=frame).scaled("mass")
    full = full_frequencies(matrices, LEFT if frame == "first" else ())
    assert data.modes == len(full)
    np.testing.assert_allclose(data.frequencies, full, rtol=1e-7)


@pytest.mark.parametrize("frame", ["first", "free"])
def test_craig_bampton_converges_from_above(body, matrices, frame):
    """By Rayleigh's principle; errors stay below the squared ratio to the last fixed-interface frequency in use."""
    full = full_frequencies(matrices, LEFT if frame == "first" else ())[:4]
    fixed = full_frequencies(matrices, [*LEFT, *RIGHT])
    before = np.full(4, np.inf)
    for modes in (4, 8, 16, 24):
        found = craig_bampton(body, [LEFT, RIGHT], modes, frame=frame).scaled("mass").frequencies[:4]
        error = found / full - 1
        assert (error > -1e-9).all()
        assert (error < before + 1e-9).all()
        assert (error < (full / fixed[modes - 1]) ** 2).all()
        before = error


@pytest.mark.parametrize("rigid", [False, True])
def test_constraint_modes_are_exact_in_statics(body, matrices, rigid):
    """Forces on the second interface, the first one held: displacements of every node."""
    K, _, X = matrices
    data = craig_bampton(body, [LEFT, RIGHT], 0, rigid=rigid)
    assert data.modes == (6 if rigid else 27)
    force = np.zeros((len(X), 3))
    force[list(RIGHT)] = np.random.default_rng(1).standard_normal((9, 3))
    reduced = data.Phi @ np.linalg.solve(data.K, np.einsum("nip,ni->p", data.Phi, force))

    free = np.setdiff1d(np.arange(3 * len(X)), dofs(LEFT))
    basis = sp.eye_array(3 * len(X)).tocsc()[:, free].toarray()
    if rigid:  # the interface's displacements are T q
        moves = np.setdiff1d(free, dofs(RIGHT))
        T = np.zeros((3 * len(X), 6))
        T[dofs(RIGHT)] = rigid_motions(X[list(RIGHT)]).reshape(-1, 6)
        basis = np.hstack([np.eye(3 * len(X))[:, moves], T])
    exact = basis @ np.linalg.solve(basis.T @ (K @ basis), basis.T @ force.ravel())
    np.testing.assert_allclose(reduced.ravel(), exact, atol=1e-9 * np.abs(exact).max())


def test_rigid_interface_of_nodes_in_a_line_has_five_modes(body):
    data = craig_bampton(body, [LEFT, [90, 91, 92]], 0, rigid=True)
    assert data.modes == 5
    assert craig_bampton(body, [LEFT, [90]], 0, rigid=True).modes == 3


@pytest.mark.parametrize("kind", ["mtx", "mtx.gz", "npz", "sparse npz", "npy"])
def test_every_kind_of_file(tmp_path, matrices, kind):
    K, M, X = matrices
    ending = kind.split()[-1]
    files = [tmp_path / f"{name}.{ending}" for name in "KM"]
    for file, A in zip(files, (K, M), strict=True):
        write_matrix(file, A, sparse=kind == "sparse npz")
    np.savetxt(tmp_path / "nodes.csv", X, delimiter=",", header="x,y,z", comments="")
    np.save(tmp_path / "nodes.npy", X)
    for nodes in ("nodes.csv", "nodes.npy"):
        body = read_fe(*files, tmp_path / nodes)
        assert abs(body.K - K).max() <= 1e-14 * abs(K).max()
        assert abs(body.full_mass - M).max() <= 1e-14 * abs(M).max()
        np.testing.assert_array_equal(body.X, X)


def write_matrix(file: Path, A: sp.csr_array, *, sparse: bool = False) -> None:
    if file.suffix == ".npy":
        np.save(file, A.toarray())
    elif file.suffix == ".npz":
        (sp.save_npz if sparse else np.savez)(file, A if sparse else A.toarray())
    else:
        plain = file.with_suffix("") if file.suffix == ".gz" else file
        scipy.io.mmwrite(plain, sp.coo_matrix(A), precision=17)
        if file.suffix == ".gz":
            file.write_bytes(gzip.compress(plain.read_bytes()))


def at(A: sp.csr_array, i: int, j: int, value: float, *, both: bool = True) -> sp.csr_array:
    result = A.tolil(copy=True)
    result[i, j] += value
    if both and i != j:
        result[j, i] += value
    return result.tocsr()


def spring(K: sp.csr_array) -> sp.csr_array:
    """A support at one node, too weak for the check of forces."""
    return at(K, 0, 0, 1e-7 * abs(K).max())


def torn(K: sp.csr_array) -> sp.csr_array:
    """Two halves that are not connected."""
    left = dofs(range(45))
    mask = np.zeros(K.shape[0], dtype=bool)
    mask[left] = True
    dense = K.toarray()
    dense[np.ix_(mask, ~mask)] = dense[np.ix_(~mask, mask)] = 0.0
    for half in (mask, ~mask):  # remove the forces of rigid motions that the cut leaves
        own = dense[np.ix_(half, half)]
        R = np.linalg.qr(rigid_motions(X_OF_BLOCK[half[::3]]).reshape(-1, 6))[0]
        P = np.eye(len(own)) - R @ R.T
        dense[np.ix_(half, half)] = P @ own @ P
    return sp.csr_array(dense)


X_OF_BLOCK = np.array([(x, y, z) for x in range(11) for y in range(3) for z in range(3)]) / (10, 20, 40 / 3)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda K, M, X: (K[:-3, :-3], M, X), "K is 294 × 294; with the 99 nodes of X it must be 297 × 297"),
        (lambda K, M, X: (K, M[:, :-3], X), "M is 297 × 294; with the 99 nodes of X it must be 297 × 297"),
        (lambda K, M, X: (K, M, X[:, :2]), "X is 99 × 2; nodes are (n, 3)"),
        (lambda K, M, X: (K, M, np.where(X == 1.0, np.inf, X)), "X[90, 0] is inf; it must be a finite number"),
        (lambda K, M, X: (at(K, 5, 7, np.nan), M, X), "K[5, 7] is nan; it must be a finite number"),
        (
            lambda K, M, X: (at(K, 5, 250, 1e6, both=False), M, X),
            "K is not symmetric: [5, 250] and [250, 5] are 1e+06 and 0",
        ),
        (lambda K, M, X: (K, at(M, 4, 9, 1.0, both=False), X), "M is not symmetric: [4, 9] and [9, 4] are"),
        (lambda K, M, X: (-K, M, X), "K is not positive semidefinite: "),
        (
            lambda K, M, X: (at(K, 0, 9, 2 * abs(K).max()), M, X),
            "K is not positive semidefinite: its smallest eigenvalue is -",
        ),
        (
            lambda K, M, X: (K, -M, X),
            "the nodal mass matrix of M is not positive semidefinite: [13, 13] on its diagonal is -",
        ),
        (
            lambda K, M, X: (K, at(M, 3, 7, 0.1), X),
            "M is not of the form (nodal mass matrix) ⊗ I₃ that solid elements have: "
            "the entry between x of node 1 and y of node 2 is 0.1 kg",
        ),
        (lambda K, M, X: (K, 0 * M, X), "M: the total mass is 0 kg; it must be positive"),
        (lambda K, M, X: (at(K, 0, 0, abs(K).max()), M, X), "K is not that of a free body: a unit "),
        (lambda K, M, X: (K, M, X[::-1] * (1, 2, 3)), "K is not that of a free body: a unit rotation about "),
        (lambda K, M, X: (spring(K), M, X), "K has 5 eigenvalues near zero"),
        (lambda K, M, X: (torn(K), M, X), "K has at least 12 eigenvalues near zero"),
    ],
)
def test_bad_data(matrices, change, message):
    with pytest.raises(SigmafmuError) as error:
        fe_from_matrices(*change(*matrices))
    assert str(error.value).startswith(message)


def test_masses_of_other_nodes():
    """A mass matrix whose centre of mass is outside the body."""
    M = np.array([[1.0, -0.9, 0], [-0.9, 1.0, 0], [0, 0, 1e-3]])
    X = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]])
    M[0, 0] = 0.82  # column sums −0.08, 0.1, 0.001
    with pytest.raises(SigmafmuError, match=r"^M: the centre of mass has x = 4\.\d+ m, outside the nodes' 0 to 1 m"):
        fe_from_matrices(np.zeros((9, 9)), np.kron(M, np.eye(3)), X)


def test_large_indefinite_matrix_is_found(monkeypatch):
    monkeypatch.setattr(checks, "DENSE", 10)
    A = sp.diags_array([np.full(50, 2.0), np.full(49, -1.2), np.full(49, -1.2)], offsets=[0, 1, -1]).tocsr()
    smallest = 2 - 2.4 * np.cos(np.pi / 51)
    with pytest.raises(SigmafmuError, match=f"its smallest eigenvalue is {smallest:.3f}"):
        checks.positive_semidefinite("A", A)
    checks.positive_semidefinite("A", A - 1.01 * smallest * sp.eye_array(50))


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda b: fixed_modes(b, [], 3), "there are no interface nodes; give them with --interface"),
        (lambda b: fixed_modes(b, [[99]], 3), "interface node 99 is not there; nodes are 0 to 98"),
        (lambda b: fixed_modes(b, [[1, 2, 1]], 3), "interface node 1 is given twice"),
        (lambda b: fixed_modes(b, [range(99)], 3), "all 99 nodes are interface nodes"),
        (lambda b: fixed_modes(b, [[0, 1, 2]], 3), "the interfaces cannot hold the body with 3 nodes in a line"),
        (lambda b: fixed_modes(b, [LEFT], 0), "0 modes are asked for; allowed are 1 to 270"),
        (lambda b: free_modes(b, 292), "292 modes are asked for; allowed are 1 to 291"),
        (lambda b: craig_bampton(b, [LEFT], 3), "with the frame on the first interface there must be a second one"),
        (lambda b: craig_bampton(b, [[0], RIGHT], 3), "the first interface cannot hold the body with 1 node in a line"),
        (lambda b: craig_bampton(b, [LEFT, RIGHT], 3, frame="last"), "frame is 'last'; allowed are first, free"),
        (
            lambda b: craig_bampton(b, [LEFT], 0, frame="free", rigid=True),
            "the interfaces have the six rigid motions alone",
        ),
    ],
)
def test_mistakes(body, call, message):
    with pytest.raises(SigmafmuError) as error:
        call(body)
    assert str(error.value).startswith(message)


def test_unreadable_files(tmp_path, matrices):
    K, _, X = matrices
    write_matrix(tmp_path / "K.npy", K)
    (tmp_path / "bad.mtx").write_text("no matrix", encoding="utf-8")
    (tmp_path / "bad.csv").write_text("x,y,z\n1,2,3\n1,2\n", encoding="utf-8")
    np.savez(tmp_path / "two.npz", a=X, b=X)
    np.save(tmp_path / "complex.npy", np.eye(3) * 1j)
    good = tmp_path / "K.npy"
    for stiffness, nodes, message in (
        ("none.mtx", "n.csv", "cannot read "),
        ("K.dat", "n.csv", "has an unknown ending; allowed are .mtx, .mtx.gz, .npz, .npy"),
        ("bad.mtx", "n.csv", "as a matrix"),
        ("two.npz", "n.csv", "holds a, b; it must hold one matrix"),
        ("complex.npy", "n.csv", "it must hold a matrix of real numbers"),
        ("K.npy", "n.xls", "has an unknown ending; allowed are .csv, .txt, .npy"),
        ("K.npy", "none.csv", "cannot read "),
        ("K.npy", "bad.csv", "as coordinates"),
    ):
        with pytest.raises(SigmafmuError) as error:
            read_fe(tmp_path / stiffness, good, tmp_path / nodes)
        assert message in str(error.value)
