"""A linear time-invariant model and what can be done with it."""

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from sigmafmu import SigmafmuError, extras

if TYPE_CHECKING:
    import control
    from matplotlib.figure import Figure

STEADY = 1e-6
"""State derivatives [SI units] below this belong to an equilibrium."""


@dataclass(frozen=True, eq=False, repr=False)
class LinearModel:
    """x' = A x + B u, y = C x + D u for deviations x, u, y from the point x0, u0, y0 or from the motion through it.

    With a sample time it is x(t + T) = A x(t) + B u(t), where u holds over T. For n states, m inputs and p outputs A is
    (n, n), B (n, m), C (p, n) and D (p, m), in SI units; x is n/2 coordinates, then their rates.
    """

    A: np.ndarray
    B: np.ndarray
    C: np.ndarray
    D: np.ndarray
    x0: np.ndarray
    u0: np.ndarray
    y0: np.ndarray
    dx0: np.ndarray  # derivative of the state at the point
    states: tuple[str, ...]
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    state_units: tuple[str, ...]
    input_units: tuple[str, ...]
    output_units: tuple[str, ...]
    name: str
    time: float = 0.0  # of the point [s]
    frame: str = "world"
    sample_time: float = 0.0  # T [s]; 0: continuous time
    start_values: Mapping[str, float | int] = field(default_factory=dict)
    """Settings, initial values and inputs that start the FMU at the point."""

    def __repr__(self) -> str:
        sizes = f"{len(self.states)} states, {len(self.inputs)} inputs, {len(self.outputs)} outputs"
        return f"<LinearModel of {self.title}: {sizes}>"

    @property
    def title(self) -> str:
        """What was linearised, and where."""
        moving = "in steady motion" if self.is_steady else f"at t = {self.time:g} s"
        place = "at rest" if self.is_equilibrium else moving
        return f"{self.name} {place}" + (f", sampled with {self.sample_time:g} s" if self.sample_time else "")

    @property
    def derivatives(self) -> tuple[str, ...]:
        """Names of the state's derivatives."""
        return tuple(f"der({state})" for state in self.states)

    @property
    def residual(self) -> float:
        """Largest derivative of a rate at the point, in SI units; zero for steady motions."""
        return float(np.abs(self.dx0[len(self.dx0) // 2 :]).max())

    @property
    def is_steady(self) -> bool:
        """Whether all rates stay as they are: an equilibrium, or a motion such as a steady spin."""
        return self.residual < STEADY

    @property
    def is_equilibrium(self) -> bool:
        """Whether the state stays as it is."""
        return float(np.abs(self.dx0).max()) < STEADY

    def poles(self) -> np.ndarray:
        """Eigenvalues of A by size; of a complex pair the one with the positive imaginary part comes first."""
        poles = np.linalg.eigvals(self.A).astype(complex)
        return poles[np.lexsort((-poles.imag, poles.real.round(9), np.abs(poles).round(9)))]

    def frequency_response(self, omega: np.ndarray) -> np.ndarray:
        """C (iω − A)⁻¹ B + D at each ω [rad/s]: an array of frequencies × outputs × inputs."""
        s = 1j * omega if not self.sample_time else np.exp(1j * omega * self.sample_time)
        identity = np.eye(len(self.A))
        return np.array([self.C @ np.linalg.solve(x * identity - self.A, self.B) + self.D for x in s])

    def to_discrete(self, sample_time: float) -> "LinearModel":
        """The same with inputs that hold for `sample_time` [s]; exact at the samples."""
        if self.sample_time:
            raise SigmafmuError(f"the model of {self.name} is discrete already, with {self.sample_time:g} s")
        if not (math.isfinite(sample_time) and sample_time > 0):
            raise SigmafmuError(f"the sample time must be a positive number of seconds, not {sample_time:g}")
        n, m = self.B.shape
        both = np.zeros((n + m, n + m))
        both[:n, :n], both[:n, n:] = self.A, self.B
        transition = extras.need("scipy.linalg", "linear").expm(both * sample_time)
        return replace(self, A=transition[:n, :n], B=transition[:n, n:], sample_time=sample_time)

    def to_control(self) -> "control.StateSpace":
        """The model for python-control, with names that it accepts: `top.torque[1]` becomes `top_torque_1`."""
        return extras.need("control").StateSpace(
            self.A,
            self.B,
            self.C,
            self.D,
            self.sample_time,
            states=plain_names(self.states),
            inputs=plain_names(self.inputs),
            outputs=plain_names(self.outputs),
            name=self.name,
        )

    def bode(self, path: Path | str | None = None) -> "Figure":
        """A matplotlib figure of magnitude and phase of outputs over the frequency of inputs; saved at `path`.

        At most 4 inputs and 6 outputs have room in it; SigmafmuError for more.
        """
        from sigmafmu.linear.figures import bode

        return bode(self, path)

    def pole_map(self, path: Path | str | None = None) -> "Figure":
        """A matplotlib figure of the poles in the complex plane; saved at `path`."""
        from sigmafmu.linear.figures import pole_map

        return pole_map(self, path)

    def save(self, path: Path | str) -> None:
        """Write the model as `.npz`, `.mat` or `.json`."""
        from sigmafmu.linear.files import save

        save(self, Path(path))


def plain_names(names: tuple[str, ...]) -> list[str]:
    """Names of letters, digits and underscores alone."""
    return [re.sub(r"\W+", "_", name).strip("_") for name in names]
