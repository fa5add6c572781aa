"""What makes matrices and modal data unusable, told in a sentence each."""

import numpy as np
import scipy.linalg
import scipy.sparse as sp
import scipy.sparse.linalg as spl

from sigmafmu import SigmafmuError
from sigmafmu.modes.data import ModalData

SYMMETRY = 1e-8
"""Allowed asymmetry, in parts of the largest entry: what text files with nine digits keep."""

DEFINITENESS = 1e-8
"""Allowed negative eigenvalue, in parts of the largest entry on the diagonal."""

DEPENDENCE = 1e-10
"""Least eigenvalue of the correlation of modes and rigid motions."""

DENSE = 300
"""Rows up to which dense eigensolvers are used."""

Matrix = np.ndarray | sp.sparray


def finite(name: str, values: Matrix) -> None:
    """Raise at the first entry that is NaN or infinite."""
    data = values.tocoo() if sp.issparse(values) else values
    numbers = data.data if sp.issparse(values) else values
    bad = np.argwhere(~np.isfinite(numbers))
    if len(bad):
        k = tuple(bad[0])
        place = (data.coords[0][k], data.coords[1][k]) if sp.issparse(values) else k
        raise SigmafmuError(f"{name}{index(place)} is {numbers[k]}; it must be a finite number")


def symmetric(name: str, A: Matrix) -> None:
    """Raise with the largest asymmetry and its place."""
    difference = abs(A - A.T)
    largest = difference.max() if A.shape[0] else 0.0
    allowed = SYMMETRY * abs(A).max()
    if largest > allowed:
        i, j = np.unravel_index(int(difference.argmax()), A.shape)
        i, j = min(i, j), max(i, j)
        raise SigmafmuError(
            f"{name} is not symmetric: {index((i, j))} and {index((j, i))} are {A[i, j]:.6g} and {A[j, i]:.6g}; "
            f"allowed is a difference of {allowed:.2g}"
        )


def positive_semidefinite(name: str, A: Matrix) -> None:
    """Raise with the smallest eigenvalue if it is negative; A is symmetric."""
    diagonal = A.diagonal()
    scale = abs(diagonal).max() if len(diagonal) else 0.0
    negative = int(np.argmin(diagonal)) if len(diagonal) else 0
    if len(diagonal) and diagonal[negative] < -DEFINITENESS * scale:
        raise SigmafmuError(
            f"{name} is not positive semidefinite: {index((negative, negative))} on its diagonal is "
            f"{diagonal[negative]:.6g}; it must not be negative"
        )
    smallest = smallest_eigenvalue(A, scale * DEFINITENESS)
    if smallest < -DEFINITENESS * scale:
        raise SigmafmuError(
            f"{name} is not positive semidefinite: its smallest eigenvalue is {smallest:.6g}; allowed is "
            f"{-DEFINITENESS * scale:.2g} or more"
        )


def smallest_eigenvalue(A: Matrix, shift: float) -> float:
    """Of a symmetric matrix; of a large sparse one only if A + shift I is indefinite, else 0."""
    if A.shape[0] <= DENSE:
        return float(scipy.linalg.eigvalsh(A.toarray() if sp.issparse(A) else A, subset_by_index=(0, 0))[0])
    # Sylvester: with pivots from the diagonal, U has as many negative ones as A + shift I has negative eigenvalues.
    factors = spl.splu(
        sp.csc_array(A + shift * sp.eye_array(A.shape[0])),
        permc_spec="MMD_AT_PLUS_A",
        diag_pivot_thresh=0.0,
        options={"SymmetricMode": True},
    )
    if np.all(factors.U.diagonal() > 0):
        return 0.0
    return float(spl.eigsh(sp.csc_array(A), k=1, which="SA", tol=1e-3, return_eigenvectors=False)[0])


def validate(data: ModalData, source: str = "modal data") -> ModalData:
    """Return `data` if a flexible body can be made of it, else raise SigmafmuError."""
    try:
        _shapes(data)
        _numbers(data)
        _independence(data)
    except SigmafmuError as error:
        raise SigmafmuError(f"{source}: {error}") from None
    return data


def index(place: tuple[int, ...]) -> str:
    """Zero-based place in a matrix or table."""
    return f"[{', '.join(str(int(i)) for i in place)}]"


def _shapes(data: ModalData) -> None:
    n, n_f = len(data.X), data.Phi.shape[2] if data.Phi.ndim == 3 else 0
    expected = {
        "X": (data.X, (n, 3), "(n, 3)"),
        "Phi": (data.Phi, (n, 3, n_f), "(n, 3, n_f)"),
        "m" if data.mass.ndim == 1 else "M": (
            data.mass,
            (n,) * data.mass.ndim,
            "(n)" if data.mass.ndim == 1 else "(n, n)",
        ),
        "K": (data.K, (n_f, n_f), "(n_f, n_f)"),
        "D": (data.D, (n_f, n_f), "(n_f, n_f)"),
        "Theta": (data.Theta, (n, 3, n_f), "(n, 3, n_f)"),
    }
    for name, (array, shape, meaning) in expected.items():
        if array is not None and (array.shape != shape or 0 in shape):
            found = " × ".join(map(str, array.shape))
            raise SigmafmuError(
                f"{name} is {found}; it must be {meaning} with n = {n} nodes and n_f = {n_f} modes, not 0"
            )
    if data.names and (len(data.names) != n_f or len(set(data.names)) != n_f):
        raise SigmafmuError(f"names are {', '.join(data.names)}; there must be {n_f} different ones")


def _numbers(data: ModalData) -> None:
    mass = "m" if data.mass.ndim == 1 else "M"
    for name in ("X", "Phi", "K", "D", "Theta"):
        if getattr(data, name) is not None:
            finite(name, getattr(data, name))
    finite(mass, data.mass)
    if mass == "m":
        worst = int(np.argmin(data.mass))
        if data.mass[worst] < 0:
            raise SigmafmuError(f"m{index((worst,))} is {data.mass[worst]:.6g} kg; a node's mass must not be negative")
    for name, matrix in (("M", data.mass), ("K", data.K), ("D", data.D)):
        if matrix is not None and matrix.ndim == 2:
            symmetric(name, matrix)
            positive_semidefinite(name, matrix)
    if not data.total_mass > 0:
        raise SigmafmuError(f"the total mass, the sum of {mass}, is {data.total_mass:.6g} kg; it must be positive")


def _independence(data: ModalData) -> None:
    """The mass matrix of frame and modes must be regular."""
    mass = data.frame_mass
    labels = [*(f"translation {a}" for a in "xyz"), *(f"rotation {a}" for a in "xyz"), *labels_of(data)]
    empty = np.flatnonzero(np.diag(mass) <= DEPENDENCE * data.total_mass * np.finfo(float).eps)
    if len(empty):
        raise SigmafmuError(f"{labels[empty[0]]} moves no mass; every mode and every rotation must")
    size = np.sqrt(np.diag(mass))
    values, vectors = np.linalg.eigh(mass / np.outer(size, size))
    if values[0] < DEPENDENCE:
        share = np.abs(vectors[:, 0])
        parts = [label for label, s in zip(labels, share, strict=True) if s > 0.05 * share.max()]
        raise SigmafmuError(
            f"these motions depend on each other: {', '.join(parts)} (least eigenvalue of their correlation "
            f"{values[0]:.1e}, allowed {DEPENDENCE:g} or more); modes must not contain rigid motions or each other"
        )


def labels_of(data: ModalData) -> tuple[str, ...]:
    """Names of the modes, or numbers."""
    return data.names or tuple(f"mode {j + 1}" for j in range(data.modes))
