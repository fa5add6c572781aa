"""What a flexible body is to the floating frame of reference: a cloud of nodes with mode shapes."""

from dataclasses import dataclass, replace

import numpy as np
import scipy.linalg
import scipy.sparse as sp

SCALES = ("mass", "displacement", "none")


@dataclass(frozen=True)
class ModalData:
    """Node i is at r_i = x + R (X_i + Φ_i ζ); V = ½ ζᵀK ζ, damping forces −D ζ̇. SI units, all in the body's frame.

    T = ½ Σ m_i |ṙ_i|² with a mass for every node, or ½ Σ M_ij ṙ_i·ṙ_j with a consistent mass matrix.
    """

    X: np.ndarray
    """(n, 3) reference positions in m."""
    mass: np.ndarray | sp.sparray
    """(n) masses m, or the symmetric (n, n) matrix M, in kg."""
    Phi: np.ndarray
    """(n, 3, n_f) displacement of each node for ζ_j = 1."""
    K: np.ndarray
    """(n_f, n_f) modal stiffness."""
    D: np.ndarray | None = None
    """(n_f, n_f) modal damping; none: zero."""
    Theta: np.ndarray | None = None
    """(n, 3, n_f) small rotation of each node in rad for ζ_j = 1, where it is known."""
    names: tuple[str, ...] = ()
    note: str = ""

    @property
    def modes(self) -> int:
        """n_f."""
        return self.Phi.shape[2]

    @property
    def total_mass(self) -> float:
        """In kg."""
        return float(self.mass.sum())

    @property
    def center_of_mass(self) -> np.ndarray:
        """Of the undeformed body, in m."""
        return self.weigh(self.X).sum(axis=0) / self.total_mass

    @property
    def modal_mass(self) -> np.ndarray:
        """(n_f, n_f): Σ M_ij Φ_iᵀ Φ_j."""
        return self._moment(self.Phi, self.Phi)

    @property
    def frame_mass(self) -> np.ndarray:
        """(6 + n_f, 6 + n_f): mass matrix of frame (translation, rotation) and modes, undeformed."""
        basis = np.concatenate([rigid_motions(self.X), self.Phi], axis=2)
        return self._moment(basis, basis)

    @property
    def frequencies(self) -> np.ndarray:
        """√(K_jj / M_jj) / 2π of every mode in Hz with the frame at rest; eigenfrequencies if modes are orthogonal."""
        return np.sqrt(np.maximum(np.diag(self.K) / np.diag(self.modal_mass), 0.0)) / (2 * np.pi)

    def weigh(self, field: np.ndarray) -> np.ndarray:
        """Mass matrix times nodal values, (n, …)."""
        if self.mass.ndim == 1:
            return (field.T * self.mass).T
        return (self.mass @ field.reshape(len(field), -1)).reshape(field.shape)

    def scaled(self, scale: str) -> "ModalData":
        """The same space of deformations with modes that are orthonormal in mass, or reach 1 m, or as they are.

        'mass' solves the eigenproblem of K and the modal mass; modes that are no eigenmodes yet lose their names.
        """
        if scale == "mass":
            modal_mass = self.modal_mass
            size = np.sqrt(np.diag(modal_mass))
            coupling = [
                np.abs(A / np.outer(s, s) - np.eye(len(A))).max()
                for A, s in ((modal_mass, size), (self.K, np.sqrt(np.maximum(np.diag(self.K), np.finfo(float).tiny))))
            ]
            if max(coupling) < 1e-9:  # eigenmodes already: keep their order
                return self.transformed(np.diag(1 / size))
            _, vectors = scipy.linalg.eigh(self.K, modal_mass)
            names = tuple(f"mode {j + 1}" for j in range(self.modes))
            return replace(self.transformed(vectors).with_fixed_signs(), names=names)
        if scale == "displacement":
            return self.transformed(np.diag(1 / np.linalg.norm(self.Phi, axis=1).max(axis=0)))
        return self

    def transformed(self, vectors: np.ndarray) -> "ModalData":
        """The body in coordinates η with ζ = vectors η."""
        return replace(
            self,
            Phi=self.Phi @ vectors,
            K=_congruent(self.K, vectors),
            D=None if self.D is None else _congruent(self.D, vectors),
            Theta=None if self.Theta is None else self.Theta @ vectors,
        )

    def with_fixed_signs(self) -> "ModalData":
        """Modes whose largest displacement is positive: a solver's signs are arbitrary."""
        flat = self.Phi.reshape(-1, self.modes)
        largest = np.argmax(np.abs(flat) > 0.999 * np.abs(flat).max(axis=0), axis=0)  # the first of equals
        return self.transformed(np.diag(np.sign(flat[largest, np.arange(self.modes)])))

    def damped(self, a: float, b: float) -> "ModalData":
        """With Rayleigh damping D = a M + b K; a in 1/s, b in s."""
        return replace(self, D=a * self.modal_mass + b * self.K)

    def _moment(self, left: np.ndarray, right: np.ndarray) -> np.ndarray:
        result = np.einsum("nip,niq->pq", left, self.weigh(right), optimize=True)
        return (result + result.T) / 2


def rigid_motions(X: np.ndarray, center: np.ndarray | None = None) -> np.ndarray:
    """(n, 3, 6) displacements of nodes X for unit translations and small rotations about `center` (or the origin)."""
    r = X if center is None else X - center
    result = np.zeros((len(X), 3, 6))
    result[:, :, :3] = np.eye(3)
    for axis in range(3):
        result[:, :, 3 + axis] = np.cross(np.eye(3)[axis], r)
    return result


def _congruent(A: np.ndarray, T: np.ndarray) -> np.ndarray:
    result = T.T @ A @ T
    return (result + result.T) / 2
