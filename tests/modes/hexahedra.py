"""A block of eight-node hexahedra: small finite-element matrices for the tests, from the textbook formulas."""

from itertools import product

import numpy as np
import scipy.sparse as sp

CORNERS = np.array(list(product((-1, 1), repeat=3)))
GAUSS = CORNERS / np.sqrt(3)


def block(
    size: tuple[float, float, float], cells: tuple[int, int, int], E: float, nu: float, density: float
) -> tuple[sp.csr_array, sp.csr_array, np.ndarray]:
    """K (3n, 3n), consistent M (3n, 3n) and X (n, 3) of a free block with a corner at the origin; x varies slowest."""
    X = np.array(list(product(*(np.linspace(0, s, c + 1) for s, c in zip(size, cells, strict=True)))))
    number = np.arange(len(X)).reshape([c + 1 for c in cells])
    ke, me = _element(np.array(size) / cells, E, nu, density)
    rows, columns, k, m = [], [], [], []
    for cell in product(*map(range, cells)):
        nodes = [number[tuple(np.array(cell) + (corner + 1) // 2)] for corner in CORNERS]
        dofs = (3 * np.array(nodes)[:, None] + np.arange(3)).ravel()
        rows.append(np.repeat(dofs, 24))
        columns.append(np.tile(dofs, 24))
        k.append(ke.ravel())
        m.append(me.ravel())
    place = np.concatenate(rows), np.concatenate(columns)
    shape = (3 * len(X), 3 * len(X))
    K, M = (sp.coo_array((np.concatenate(v), place), shape=shape).tocsr() for v in (k, m))
    return sp.csr_array((K + K.T) / 2), sp.csr_array((M + M.T) / 2), X


def _element(size: np.ndarray, E: float, nu: float, density: float) -> tuple[np.ndarray, np.ndarray]:
    lame, G = E * nu / ((1 + nu) * (1 - 2 * nu)), E / (2 * (1 + nu))
    C = np.diag([2 * G] * 3 + [G] * 3)
    C[:3, :3] += lame
    volume = np.prod(size) / 8  # of a Gauss point
    ke, scalar = np.zeros((24, 24)), np.zeros((8, 8))
    for xi in GAUSS:
        factors = 1 + CORNERS * xi
        N = factors.prod(axis=1) / 8
        scalar += density * volume * np.outer(N, N)
        others = np.column_stack([np.delete(factors, a, axis=1).prod(axis=1) for a in range(3)])
        d = CORNERS * others / 8 * 2 / size
        B = np.zeros((6, 24))
        for a in range(3):
            B[a, a::3] = d[:, a]
        for row, (a, b) in zip((3, 4, 5), ((0, 1), (1, 2), (0, 2)), strict=True):
            B[row, a::3], B[row, b::3] = d[:, b], d[:, a]
        ke += B.T @ C @ B * volume
    return ke, np.kron(scalar, np.eye(3))
