"""Mass and stiffness matrices of a finite-element program: reading and checking.

Three displacements for each node, ordered x₁ y₁ z₁ x₂ y₂ z₂ …; the stiffness is that of the body without supports.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import scipy.io
import scipy.linalg
import scipy.sparse as sp

from sigmafmu import SigmafmuError
from sigmafmu.modes import checks
from sigmafmu.modes.data import rigid_motions
from sigmafmu.modes.eigen import lowest_modes

MATRIX_FILES = (".mtx", ".mtx.gz", ".npz", ".npy")
NODE_FILES = (".csv", ".txt", ".npy")

RIGID_FORCE = 1e-6
"""Largest entry of K φ for a rigid motion φ, in parts of the entries that cancel in it."""

RIGID_EIGENVALUE = 1e-6
"""Eigenvalues below this part of the estimated lowest flexible one belong to rigid motions."""

AXES = "xyz"


@dataclass(frozen=True)
class FeData:
    """A free body of finite elements."""

    X: np.ndarray
    """(n, 3) in m."""
    M: sp.csr_array
    """(n, n) scalar mass matrix in kg: the full one is M ⊗ I₃."""
    K: sp.csr_array
    """(3n, 3n) in N/m."""
    scale: float
    """Estimate of the lowest positive eigenvalue ω² in 1/s², from above."""

    @property
    def full_mass(self) -> sp.csr_array:
        """M ⊗ I₃."""
        return sp.csr_array(sp.kron(self.M, sp.eye_array(3)))


def read_fe(stiffness: Path | str, mass: Path | str, nodes: Path | str) -> FeData:
    """Read and check the three files."""
    return fe_from_matrices(
        read_matrix(Path(stiffness)),
        read_matrix(Path(mass)),
        read_nodes(Path(nodes)),
        names=(str(stiffness), str(mass), str(nodes)),
    )


def fe_from_matrices(
    K: checks.Matrix, M: checks.Matrix, X: np.ndarray, names: tuple[str, str, str] = ("K", "M", "X")
) -> FeData:
    """A free body from its stiffness K [N/m] and mass M [kg], both (3n, 3n), and its nodes X [m], (n, 3).

    Raises SigmafmuError if these are not those of a free body of solid elements; `names` are for its message.
    """
    K, M, X = sp.csr_array(K), sp.csr_array(M), np.asarray(X, dtype=float)
    if X.ndim != 2 or X.shape[1] != 3 or len(X) < 3:
        raise SigmafmuError(f"{names[2]} is {' × '.join(map(str, X.shape))}; nodes are (n, 3), at least three of them")
    checks.finite(names[2], X)
    for name, A in ((names[0], K), (names[1], M)):
        if A.shape != (3 * len(X), 3 * len(X)):
            raise SigmafmuError(
                f"{name} is {A.shape[0]} × {A.shape[1]}; with the {len(X)} nodes of {names[2]} it must be "
                f"{3 * len(X)} × {3 * len(X)}, three displacements a node"
            )
        checks.finite(name, A)
        checks.symmetric(name, A)
    K, M = sp.csr_array((K + K.T) / 2), sp.csr_array((M + M.T) / 2)
    scalar = _scalar_mass(M, names[1])
    for name, A in ((f"the nodal mass matrix of {names[1]}", scalar), (names[0], K)):
        checks.positive_semidefinite(name, A)
    _sensible_mass(scalar, X, names[1])
    _free(K, X, names[0])
    body = FeData(X, scalar, K, _flexible_estimate(K, scalar, X))
    _six_rigid_modes(body, names[0])
    return body


def read_matrix(path: Path) -> sp.csr_array:
    """Square matrix from Matrix Market or NumPy."""
    try:
        if path.name.endswith((".mtx", ".mtx.gz")):
            result = scipy.io.mmread(path)
        elif path.suffix == ".npz":
            result = _from_npz(path)
        elif path.suffix == ".npy":
            result = np.load(path)
        else:
            raise SigmafmuError(f"{path} has an unknown ending; allowed are {', '.join(MATRIX_FILES)}")
    except OSError as error:
        raise SigmafmuError(f"cannot read {path}: {error.strerror or error}") from error
    except (ValueError, OverflowError) as error:
        raise SigmafmuError(f"cannot read {path} as a matrix: {error}") from error
    if result.ndim != 2 or result.dtype.kind not in "fiu":
        shape = " × ".join(map(str, result.shape))
        raise SigmafmuError(
            f"{path} holds {shape} numbers of type {result.dtype}; it must hold a matrix of real numbers"
        )
    return sp.csr_array(result, dtype=float)


def read_nodes(path: Path) -> np.ndarray:
    """(n, 3) coordinates, from NumPy or text with one node a line (commas or spaces, a heading may be there)."""
    try:
        if path.suffix == ".npy":
            return np.load(path).astype(float)
        if path.suffix not in NODE_FILES:
            raise SigmafmuError(f"{path} has an unknown ending; allowed are {', '.join(NODE_FILES)}")
        lines = path.read_text(encoding="utf-8").replace(",", " ").replace(";", " ").splitlines()
        if lines and not _is_numbers(lines[0]):
            lines = lines[1:]
        return np.loadtxt(lines, ndmin=2)
    except OSError as error:
        raise SigmafmuError(f"cannot read {path}: {error.strerror}") from error
    except ValueError as error:
        raise SigmafmuError(f"cannot read {path} as coordinates: {error}") from error


def _is_numbers(line: str) -> bool:
    try:
        [float(word) for word in line.split()]
    except ValueError:
        return False
    return True


def _from_npz(path: Path) -> np.ndarray | sp.sparray:
    with np.load(path) as archive:
        if "format" not in archive:
            if len(archive.files) != 1:
                raise SigmafmuError(f"{path} holds {', '.join(archive.files) or 'nothing'}; it must hold one matrix")
            return archive[archive.files[0]]
    return sp.load_npz(path)


def _scalar_mass(M: sp.csr_array, name: str) -> sp.csr_array:
    """The matrix A of M = A ⊗ I₃."""
    scalar = sp.csr_array((M[0::3, 0::3] + M[1::3, 1::3] + M[2::3, 2::3]) / 3)
    off = abs(M - sp.csr_array(sp.kron(scalar, sp.eye_array(3))))
    allowed = checks.SYMMETRY * abs(M).max()
    if off.max() > allowed:
        i, j = np.unravel_index(int(off.argmax()), M.shape)
        between = f"{AXES[i % 3]} of node {i // 3} and {AXES[j % 3]} of node {j // 3}"
        raise SigmafmuError(
            f"{name} is not of the form (nodal mass matrix) ⊗ I₃ that solid elements have: the entry between "
            f"{between} is {M[i, j]:.6g} kg, off by {off.max():.2g} kg; allowed is {allowed:.2g}"
        )
    return scalar


def _sensible_mass(M: sp.csr_array, X: np.ndarray, name: str) -> None:
    """Mass positive, centre of mass among the nodes."""
    node_mass = M.sum(axis=0)
    total = node_mass.sum()
    if not total > 0:
        raise SigmafmuError(f"{name}: the total mass is {total:.6g} kg; it must be positive")
    center = node_mass @ X / total
    low, high = X.min(axis=0), X.max(axis=0)
    outside = np.flatnonzero((center < low - 1e-9 * np.ptp(X)) | (center > high + 1e-9 * np.ptp(X)))
    if len(outside):
        k = outside[0]
        raise SigmafmuError(
            f"{name}: the centre of mass has {AXES[k]} = {center[k]:.6g} m, outside the nodes' {low[k]:.6g} to "
            f"{high[k]:.6g} m; the masses belong to other nodes"
        )


def _free(K: sp.csr_array, X: np.ndarray, name: str) -> None:
    """Rigid motions cause no forces."""
    motions = rigid_motions(X, X.mean(axis=0)).reshape(-1, 6)
    force = np.abs(K @ motions)
    cancelling = (abs(K) @ np.abs(motions)).max(axis=0)
    residual = force.max(axis=0) / np.where(cancelling > 0, cancelling, 1.0)
    worst = int(np.argmax(residual))
    if residual[worst] > RIGID_FORCE:
        what = ("translation along ", "rotation about ")[worst // 3] + AXES[worst % 3]
        place = int(np.argmax(force[:, worst]))
        raise SigmafmuError(
            f"{name} is not that of a free body: a unit {what} causes a force of {force[place, worst]:.6g} in "
            f"{AXES[place % 3]} at node {place // 3}, "
            f"{residual[worst]:.1e} of the forces that cancel there; allowed is {RIGID_FORCE:g} "
            "(are supports in the matrix, or is the order of displacements not x₁ y₁ z₁ x₂ …?)"
        )


def _flexible_estimate(K: sp.csr_array, M: sp.csr_array, X: np.ndarray) -> float:
    """Lowest ω² among displacements that are quadratic in the coordinates, beside the rigid ones (Rayleigh-Ritz)."""
    size = np.ptp(X, axis=0).max()
    r = (X - X.mean(axis=0)) / size
    monomials = np.column_stack([np.ones(len(r)), r, *(r[:, i] * r[:, j] for i in range(3) for j in range(i, 3))])
    fields = np.linalg.qr(np.kron(monomials, np.eye(3)))[0]
    stiffness = _congruent(K, fields)
    mass = _congruent(sp.kron(M, sp.eye_array(3)), fields)
    shift = np.trace(stiffness) / np.trace(mass)
    inverse = scipy.linalg.eigvalsh(mass, stiffness + shift * mass)  # 1 / (ω² + shift), ascending; rigid ones are last
    return float(1 / inverse[-7] - shift)


def _congruent(A: sp.sparray, T: np.ndarray) -> np.ndarray:
    return T.T @ (A @ T)


def _six_rigid_modes(body: FeData, name: str) -> None:
    """Exactly the six rigid motions have no stiffness."""
    count = min(12, body.K.shape[0])
    eigenvalues, _ = lowest_modes(body.K, body.full_mass, count, shift=body.scale)
    zeros = int(np.sum(eigenvalues < RIGID_EIGENVALUE * body.scale))
    if zeros != 6:
        at_least = "at least " if zeros == count else ""
        raise SigmafmuError(
            f"{name} has {at_least}{zeros} eigenvalues near zero (below {RIGID_EIGENVALUE * body.scale:.3g} 1/s²); "
            "a free body has 6, its rigid motions (more: parts are not connected; fewer: it is held)"
        )
