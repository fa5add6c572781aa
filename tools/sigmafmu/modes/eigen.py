"""Lowest eigenmodes of K v = λ M v, dense or sparse; K and M may both be singular, but not in the same direction."""

import numpy as np
import scipy.linalg
import scipy.sparse as sp
import scipy.sparse.linalg as spl

from sigmafmu.modes.checks import DENSE, Matrix


def lowest_modes(K: Matrix, M: Matrix, count: int, shift: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """Eigenvalues (count) in ascending order and mass-normalised vectors (size, count).

    Solves M v = μ (K + shift M) v for the largest μ = 1 / (λ + shift): nodes without mass (μ = 0) and, with a
    positive shift, rigid motions (λ = 0) do no harm. `shift` should have the size of the lowest positive λ.
    """
    n = K.shape[0]
    if n <= DENSE or count > n // 3:
        A, B = _dense(M), _dense(K) + shift * _dense(M)
        mu, vectors = scipy.linalg.eigh(A, B, subset_by_index=(n - count, n - 1))
    else:
        shifted = spl.splu(sp.csc_array(K + shift * M))
        inverse = spl.LinearOperator((n, n), matvec=shifted.solve, dtype=float)
        start = np.random.default_rng(0).standard_normal(n)  # the same answer every time
        mu, vectors = spl.eigsh(sp.csc_array(M), k=count, M=sp.csc_array(K + shift * M), Minv=inverse, v0=start)
    order = np.argsort(-mu)
    mu, vectors = mu[order], vectors[:, order]
    return 1 / mu - shift, vectors / np.sqrt(mu)


def _dense(A: Matrix) -> np.ndarray:
    return A.toarray() if sp.issparse(A) else A
