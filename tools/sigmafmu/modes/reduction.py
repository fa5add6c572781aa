"""Modes of a finite-element body: fixed interfaces, free, or Craig-Bampton.

With the displacements split into those of interfaces (b) and the others (i), Craig and Bampton (1968) take

    constraint modes  u_b = I, u_i = −K_ii⁻¹ K_ib     static shapes for unit displacements of the interfaces
    fixed modes       u_b = 0, K_ii φ = ω² M_ii φ     vibrations while the interfaces are held

Among them are the body's six rigid motions, which the floating frame has already. Two ways to leave them out:
'first' fixes the frame to the first interface, 'free' takes the eigenmodes of the reduced body without the six of
frequency zero (Tisserand's frame, which follows the body's mean motion).
"""

from collections.abc import Sequence
from itertools import combinations

import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg as spl

from sigmafmu import SigmafmuError
from sigmafmu.modes.data import ModalData, rigid_motions
from sigmafmu.modes.eigen import lowest_modes
from sigmafmu.modes.fe_data import AXES, FeData

FRAMES = ("first", "free")


def free_modes(body: FeData, modes: int) -> ModalData:
    """The lowest eigenmodes of the free body without the six rigid ones."""
    _limit(modes, body.K.shape[0] - 6, least=1)
    _, vectors = lowest_modes(body.K, body.full_mass, modes + 6, shift=body.scale)
    names = [f"free {j + 1}" for j in range(modes)]
    return _modal_data(body, vectors[:, 6:], names, "free modes").with_fixed_signs()


def fixed_modes(body: FeData, interfaces: Sequence[Sequence[int]], modes: int) -> ModalData:
    """The lowest eigenmodes with all nodes of `interfaces` held; the frame is fixed to them."""
    held = _held(body, interfaces)
    _limit(modes, body.K.shape[0] - len(held), least=1)
    names = [f"fixed {j + 1}" for j in range(modes)]
    return _modal_data(body, _fixed_vectors(body, held, modes), names, "fixed-interface modes").with_fixed_signs()


def craig_bampton(
    body: FeData,
    interfaces: Sequence[Sequence[int]],
    modes: int,
    *,
    frame: str = "first",
    rigid: bool = False,
) -> ModalData:
    """Constraint modes of `interfaces` (lists of nodes) and `modes` fixed-interface modes.

    `rigid` interfaces move as rigid bodies: six constraint modes each (fewer for a node or nodes in a line), about
    the centre of their nodes; otherwise each of their displacements has a mode.
    """
    if frame not in FRAMES:
        raise SigmafmuError(f"frame is '{frame}'; allowed are {', '.join(FRAMES)}")
    held = _held(body, interfaces)
    if frame == "first" and len(interfaces) < 2:
        raise SigmafmuError(
            "with the frame on the first interface there must be a second one; give --interface twice, or --frame free"
        )
    if frame == "first":
        _holds(body, np.asarray(interfaces[0], dtype=int), "the first interface")
    _limit(modes, body.K.shape[0] - len(held), least=0)

    first = 1 if frame == "first" else 0
    motions = [_interface_motions(body.X, nodes, k + 1, rigid) for k, nodes in enumerate(interfaces)][first:]
    boundary = np.hstack([motion for motion, _ in motions])
    constraint = _static(body, held, boundary)
    fixed = _fixed_vectors(body, held, modes)
    labels = [name for _, group in motions for name in group] + [f"fixed {j + 1}" for j in range(modes)]
    kind = f"Craig-Bampton, {boundary.shape[1]} constraint and {modes} fixed-interface modes, frame {frame}"
    basis = np.hstack([constraint, fixed])
    if frame == "first":
        return _modal_data(body, basis, labels, kind)

    K, M = _congruent(body.K, basis), _congruent(body.full_mass, basis)
    _, vectors = lowest_modes(K, M, len(K), shift=body.scale)
    names = [f"reduced {j + 1}" for j in range(len(K) - 6)]
    if not names:
        raise SigmafmuError(
            "the interfaces have the six rigid motions alone; ask for fixed-interface modes too (--modes)"
        )
    return _modal_data(body, basis @ vectors[:, 6:], names, kind).with_fixed_signs()


def _held(body: FeData, interfaces: Sequence[Sequence[int]]) -> np.ndarray:
    """Displacements of all interface nodes, ascending; the first interface must hold the body."""
    n = len(body.X)
    if not interfaces or not all(len(nodes) for nodes in interfaces):
        raise SigmafmuError("there are no interface nodes; give them with --interface")
    nodes = np.concatenate([np.asarray(nodes, dtype=int) for nodes in interfaces])
    wrong = nodes[(nodes < 0) | (nodes >= n)]
    if len(wrong):
        raise SigmafmuError(f"interface node {wrong[0]} is not there; nodes are 0 to {n - 1}")
    values, counts = np.unique(nodes, return_counts=True)
    if (counts > 1).any():
        raise SigmafmuError(f"interface node {values[counts > 1][0]} is given twice; a node belongs to one interface")
    if len(values) == n:
        raise SigmafmuError(f"all {n} nodes are interface nodes; some must be left between them")
    _holds(body, values, "the interfaces")
    return (3 * values[:, None] + np.arange(3)).ravel()


def _holds(body: FeData, nodes: np.ndarray, what: str) -> None:
    """Three nodes that are not in a line hold a body."""
    r = body.X[nodes] - body.X[nodes].mean(axis=0)
    sizes = np.linalg.svd(r, compute_uv=False)
    if len(nodes) < 3 or sizes[1] <= 1e-6 * sizes[0]:
        count = f"{len(nodes)} node{'s' if len(nodes) > 1 else ''}"
        raise SigmafmuError(
            f"{what} cannot hold the body with {count} in a line; at least three that are not are needed"
        )


def _interface_motions(X: np.ndarray, nodes: Sequence[int], number: int, rigid: bool) -> tuple[np.ndarray, list[str]]:
    """(3n, k) displacements of an interface's nodes alone, and their names."""
    nodes = np.asarray(nodes, dtype=int)
    rows = (3 * nodes[:, None] + np.arange(3)).ravel()
    if not rigid:
        result = np.zeros((3 * len(X), len(rows)))
        result[rows, np.arange(len(rows))] = 1.0
        return result, [f"node {i} {axis}" for i in nodes for axis in AXES]
    motions = rigid_motions(X[nodes], X[nodes].mean(axis=0)).reshape(-1, 6)
    independent = _independent(motions)
    result = np.zeros((3 * len(X), len(independent)))
    result[rows] = motions[:, independent]
    kinds = [*(f"translation {axis}" for axis in AXES), *(f"rotation {axis}" for axis in AXES)]
    return result, [f"interface {number} {kinds[k]}" for k in independent]


def _independent(motions: np.ndarray) -> list[int]:
    """The largest set of columns that are independent; the first of those with the best condition."""
    size = np.linalg.norm(motions, axis=0)
    scaled = motions / np.where(size > 1e-9 * size.max(), size, np.inf)
    rank = np.linalg.matrix_rank(scaled, tol=1e-6)
    choices = [list(c) for c in combinations(range(6), rank)]
    return max(choices, key=lambda c: round(np.linalg.svd(scaled[:, c], compute_uv=False)[-1], 6))


def _static(body: FeData, held: np.ndarray, boundary: np.ndarray) -> np.ndarray:
    """(3n, k) displacements of the body without loads for given ones of the interfaces."""
    inner = np.setdiff1d(np.arange(body.K.shape[0]), held)
    K = sp.csc_array(body.K)
    result = boundary.copy()
    result[inner] = -spl.splu(K[inner][:, inner].tocsc()).solve(K[inner][:, held] @ boundary[held])
    return result


def _fixed_vectors(body: FeData, held: np.ndarray, modes: int) -> np.ndarray:
    """(3n, modes) mass-normalised."""
    inner = np.setdiff1d(np.arange(body.K.shape[0]), held)
    vectors = np.zeros((body.K.shape[0], modes))
    if modes:
        K, M = (sp.csr_array(A[inner][:, inner]) for A in (body.K, body.full_mass))
        vectors[inner] = lowest_modes(K, M, modes)[1]
    return vectors


def _modal_data(body: FeData, vectors: np.ndarray, names: Sequence[str], kind: str) -> ModalData:
    note = f"{kind}; finite-element body of {len(body.X)} nodes"
    Phi = vectors.reshape(len(body.X), 3, -1)
    return ModalData(X=body.X, mass=body.M, Phi=Phi, K=_congruent(body.K, vectors), names=tuple(names), note=note)


def _congruent(A: sp.sparray, T: np.ndarray) -> np.ndarray:
    result = T.T @ (A @ T)
    return (result + result.T) / 2


def _limit(modes: int, largest: int, least: int) -> None:
    if not least <= modes <= largest:
        raise SigmafmuError(f"{modes} modes are asked for; allowed are {least} to {largest}")
