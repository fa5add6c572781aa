"""Linear time-invariant model of a mechanism about a point of its motion, in minimal coordinates.

At a point (q, v, u) let B be the constraint gradient, Z = d(Bv)/dq, N an orthonormal basis of the null space of B and
Y = −B⁺ Z N. Motions and velocities near the point that satisfy the constraints are, to first order,

    δq = N ξ,   δv = N η + Y ξ                                             (NᵀN = I, NᵀY = 0)

and with the basis carried along so that NᵀṄ = 0 (Ṅ = −B⁺ Ḃ N), δ(q)' = δv − v̂ δq and δv̇ from the index-1 equations,

    ξ' = −Nᵀ v̂ N ξ + η
    η' = (Nᵀ ∂v̇/∂ξ + Ṅᵀ Y) ξ + Nᵀ ∂v̇/∂η η + Nᵀ ∂v̇/∂u δu.

The derivatives of v̇ and of the outputs are central differences, extrapolated once (error about 1e-9). About a point
that is not an equilibrium the matrices change along the motion; they are those of the moment.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from rich import box
from rich.table import Table

from sigmafmu import SigmafmuError, _core


@dataclass(frozen=True)
class LinearModel:
    """x' = A x + B u, y = C x + D u with x = (ξ, η), deviations from the point; control.ss(A, B, C, D) takes them."""

    A: np.ndarray
    B: np.ndarray
    C: np.ndarray
    D: np.ndarray
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    time: float  # s
    basis: np.ndarray
    """N: columns are the motions (per body: translation in W, rotation in B) that ξ measures."""


def linearize(
    model: str,
    at: float = 0.0,
    *,
    settings: Mapping[str, float] | None = None,
    outputs: Sequence[str] | None = None,
    inputs: Sequence[str] | None = None,
) -> LinearModel:
    """Linearize `model` at time `at` [s] of its motion with zero inputs; names default to all outputs and inputs."""
    try:
        mechanism = _core.mechanism(model)
        for name, value in (settings or {}).items():
            mechanism.set(name, value)
        simulation = _core.Simulation(mechanism)
        if at > 0:
            simulation.run(at, max(1, int(np.ceil(at / mechanism.integrator.step_size * (1 - 1e-9)))))
    except (ValueError, RuntimeError) as error:
        raise SigmafmuError(str(error)) from error
    return linearize_at(mechanism, simulation.state.q, simulation.state.v, at, outputs=outputs, inputs=inputs)


def linearize_at(
    mechanism: "_core.Mechanism",
    q: np.ndarray,
    v: np.ndarray,
    time: float = 0.0,
    *,
    outputs: Sequence[str] | None = None,
    inputs: Sequence[str] | None = None,
) -> LinearModel:
    """Linearize about a consistent point (q, v) with zero inputs."""
    system, output = _core.System(mechanism.multibody), _core.Outputs(mechanism)
    rows = _indices(output.names, outputs, "output")
    columns = _indices(output.inputs, inputs, "input")
    u = np.zeros(system.input_size)

    _, _, constraint, rate = system.constraints(q, v)
    pseudo_inverse = np.linalg.pinv(constraint)
    basis = _null_space(constraint)
    freedom = basis.shape[1]
    drift = -pseudo_inverse @ rate @ basis  # Y

    spin = max(1.0, *(np.linalg.norm(w) for w in v.reshape(-1, 6)[:, 3:]))
    along = _derivative(lambda s: system.constraints(system.compose(q, s * v), v)[2], 1e-3 / spin)
    basis_rate = -pseudo_inverse @ along @ basis  # dN/dt

    def response(dq: np.ndarray, dv: np.ndarray, du: np.ndarray, step: float) -> np.ndarray:
        """d(v̇, y) in a direction."""

        def at(s: float) -> np.ndarray:
            point = system.compose(q, s * dq), v + s * dv, u + s * du
            return np.concatenate([system.accelerations(*point)[0], output.values(*point)])

        return _derivative(at, step)

    none_v, none_u = np.zeros_like(v), np.zeros_like(u)
    by_position = np.column_stack([response(basis[:, k], drift[:, k], none_u, 1e-3) for k in range(freedom)])
    by_velocity = np.column_stack([response(none_v, basis[:, k], none_u, 1e-2 * spin) for k in range(freedom)])
    by_input = np.column_stack([response(none_v, none_v, unit, 1.0) for unit in np.eye(len(u))[columns]])

    n = len(v)
    convection = basis.T @ _hat(v) @ basis
    A = np.block(
        [
            [-convection, np.eye(freedom)],
            [basis.T @ by_position[:n] + basis_rate.T @ drift, basis.T @ by_velocity[:n]],
        ]
    )
    B = np.vstack([np.zeros((freedom, len(columns))), basis.T @ by_input[:n]])
    C = np.hstack([by_position[n:], by_velocity[n:]])[rows]
    D = by_input[n:][rows]
    names = tuple(output.inputs[i] for i in columns), tuple(output.names[i] for i in rows)
    return LinearModel(A, B, C, D, *names, time, basis)


def pole_table(A: np.ndarray) -> Table:
    """Eigenvalues of A with frequency and damping ratio; of a complex pair only the upper one."""
    table = Table(box=box.SIMPLE_HEAD)
    for title in ("pole [1/s]", "frequency [Hz]", "damping ratio"):
        table.add_column(title, justify="right")
    poles = np.linalg.eigvals(A)
    for pole in sorted(poles[poles.imag >= 0], key=abs):
        size = abs(pole)
        text = f"{pole.real:.4g}" + (f" ± {pole.imag:.4g}i" if pole.imag > 0 else "")
        table.add_row(text, f"{size / (2 * np.pi):.4g}", f"{-pole.real / size:.3g}" if size > 0 else "")
    return table


def _indices(names: Sequence[str], wanted: Sequence[str] | None, kind: str) -> list[int]:
    if wanted is None:
        return list(range(len(names)))
    unknown = [name for name in wanted if name not in names]
    if unknown:
        raise SigmafmuError(f"there is no {kind} '{unknown[0]}'")
    return [names.index(name) for name in wanted]


def _null_space(matrix: np.ndarray) -> np.ndarray:
    """Orthonormal basis, rank decided at 1e-10 of the largest singular value."""
    _, singular, right = np.linalg.svd(matrix)
    rank = int(np.sum(singular > 1e-10 * singular[0])) if singular.size else 0
    return right[rank:].T


def _derivative(function: Callable[[float], np.ndarray], step: float) -> np.ndarray:
    """f'(0) by central differences with steps h and h/2, extrapolated to fourth order."""
    coarse = (function(step) - function(-step)) / (2 * step)
    fine = (function(step / 2) - function(-step / 2)) / step
    return (4 * fine - coarse) / 3


def _hat(v: np.ndarray) -> np.ndarray:
    """v̂ on R³×SO(3): zero for translations, ω̃ for rotations (Holzinger, Arnold, Gerstmayr 2025, Eq. B.2)."""
    result = np.zeros((len(v), len(v)))
    for i in range(3, len(v), 6):
        result[i : i + 3, i : i + 3] = _core.lie.hat(v[i : i + 3])
    return result
