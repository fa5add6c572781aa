"""An iterative master: repeats each communication step from a saved state until the coupling is satisfied.

Subsystems exchange interface signals u (forces, torques). Over a step from t_n to t_n + H each subsystem needs u(t),
but u_{n+1} follows only from outputs at the end of the step. A master that does not iterate guesses it from the past:

    hold            u(t) = u_n
    extrapolated    u(t) = u_n + (t − t_n) (u_n − u_{n−1}) / H.

A master that can go back (fmi2GetFMUstate, fmi2SetFMUstate) solves x = G(x) instead, where G(x) are the interface
signals found at the end of a step that was taken with u_{n+1} = x:

    linear          u(t) = u_n + (t − t_n) (x − u_n) / H
    mean            u(t) = (u_n + x) / 2.

The loop is cut open at u, and G steps through the subsystems in order (Gauss-Seidel). Any object with the four methods
of `Loop` can be such a loop; `Subsystem` is one FMU in it.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from ctypes import byref
from functools import partial
from typing import Protocol

import numpy as np
from fmpy.fmi2 import fmi2FMUstate

from sigmafmu import SigmafmuError
from sigmafmu.fmu import Fmu
from sigmafmu.instance import Instance, SimulationError
from sigmafmu.variables import SettingValue, select

HOLD, EXTRAPOLATED, LINEAR, MEAN = SCHEMES = ("hold", "extrapolated", "linear", "mean")
ITERATED = (LINEAR, MEAN)


class CouplingError(SigmafmuError):
    """A communication step cannot be taken: an FMU refuses it, or the iteration does not converge."""


class Loop(Protocol):
    """Subsystems coupled by interface signals u, all of one unit and size."""

    def signals(self) -> np.ndarray:
        """Return u as it follows from the present outputs."""

    def step(self, t: float, H: float, begin: np.ndarray, end: np.ndarray) -> None:
        """Take all subsystems from t to t + H [s], with u going linearly from `begin` to `end`."""

    def save(self) -> None:
        """Keep the present state of all subsystems."""

    def restore(self) -> None:
        """Go back to the state that was kept."""


class Subsystem:
    """An FMU in step mode, with the inputs and outputs that take part in the coupling."""

    def __init__(self, fmu: Fmu, instance: Instance, inputs: Sequence[str], outputs: Sequence[str]):
        self._instance, self._slave, self._saved = instance, instance.slave, fmi2FMUstate()
        self._inputs, self._outputs = ([v.valueReference for v in select(fmu, names)] for names in (inputs, outputs))

    def step(self, t: float, H: float, begin: np.ndarray, end: np.ndarray) -> None:
        """Communication step with inputs that go linearly from `begin` to `end`; SimulationError if it fails."""
        with self._instance.calls():
            self._slave.setReal(self._inputs, begin)
            self._slave.setRealInputDerivatives(self._inputs, [1] * len(self._inputs), (end - begin) / H)
            self._slave.doStep(t, H)

    def outputs(self) -> np.ndarray:
        """Present values of the outputs."""
        return np.array(self._slave.getReal(self._outputs))

    def save(self) -> None:
        """Keep the present state; overwrites the one kept before."""
        self._slave.fmi2GetFMUstate(self._slave.component, byref(self._saved))

    def restore(self) -> None:
        """Go back to the state that was kept, to the last bit."""
        self._slave.setFMUstate(self._saved)

    def free(self) -> None:
        """Free the state that was kept."""
        self._slave.freeFMUstate(self._saved)


@contextmanager
def subsystem(
    fmu: Fmu, settings: Mapping[str, SettingValue], inputs: Sequence[str], outputs: Sequence[str]
) -> Iterator[Subsystem]:
    """Start `fmu` at t = 0 as a part of a loop; `inputs` and `outputs` are names of scalars or vectors."""
    with Instance(fmu, settings) as instance:
        instance.start()
        part = Subsystem(fmu, instance, inputs, outputs)
        try:
            yield part
        finally:
            part.free()


class FixedPoint:
    """x ← G(x): converges only while the coupling is weak enough for its step size."""

    def prepare(self, residual: Callable[[np.ndarray], np.ndarray], x: np.ndarray) -> int:
        """Called once, before the first step; returns how many trial steps that took."""
        return 0

    def correction(self, r: np.ndarray) -> np.ndarray:
        """Change of x for the residual r = G(x) − x."""
        return r

    def learn(self, dx: np.ndarray, dr: np.ndarray) -> None:
        """Take note that a change dx of x changed the residual by dr."""


class Aitken(FixedPoint):
    """x ← x + ω r with Aitken's ω from the last two residuals (Irons, Tuck 1969); one number for all signals."""

    omega = 1.0

    def correction(self, r: np.ndarray) -> np.ndarray:
        """Relaxed fixed-point step."""
        return self.omega * r

    def learn(self, dx: np.ndarray, dr: np.ndarray) -> None:
        """ω such that the last change would have removed the residual."""
        self.omega = -(dx @ dr) / (dr @ dr)


class QuasiNewton(FixedPoint):
    """x ← x − J⁻¹ r with J = ∂r/∂x from differences at first, by a trial step for each signal.

    From then on Broyden's method follows J, from one communication step to the next as well.
    """

    inverse: np.ndarray

    def __init__(self, difference: float = 1e-3):
        self.difference = difference

    def prepare(self, residual: Callable[[np.ndarray], np.ndarray], x: np.ndarray) -> int:
        """J by differences of the size `difference`, in the unit of the signals."""
        r = residual(x)
        columns = [residual(x + self.difference * e) - r for e in np.eye(len(x))]
        self.inverse = np.linalg.inv(np.column_stack(columns) / self.difference)
        return len(x) + 1

    def correction(self, r: np.ndarray) -> np.ndarray:
        """Newton's step with the present J⁻¹."""
        return -self.inverse @ r

    def learn(self, dx: np.ndarray, dr: np.ndarray) -> None:
        """The least change of J that explains dr (Broyden 1965), applied to J⁻¹."""
        row = dx @ self.inverse
        if scale := row @ dr:
            self.inverse += np.outer(dx - self.inverse @ dr, row) / scale


def run(
    loop: Loop,
    H: float,
    steps: int,
    scheme: str = LINEAR,
    solver: FixedPoint | None = None,
    *,
    tolerance: float = 1e-8,
    max_iterations: int = 50,
    observe: Callable[[float], None] = lambda t: None,
) -> np.ndarray:
    """Take `steps` communication steps of H [s] from t = 0; `observe` is called with the time after each of them.

    Iterates until |G(x) − x| ≤ tolerance · max(1, |x|), in the unit of the signals. Returns how many times each step
    was taken.
    """
    if scheme not in SCHEMES:
        raise SigmafmuError(f"there is no scheme '{scheme}'; choose one of {', '.join(SCHEMES)}")
    solver = solver or QuasiNewton()
    counts = np.ones(steps, dtype=int)
    u = before = loop.signals()
    for i in range(steps):
        guess = u if scheme == HOLD else 2 * u - before
        take = partial(_take, loop, scheme, i * H, H, u)
        try:
            if scheme in ITERATED:
                loop.save()
                residual = partial(_residual, loop, take)
                counts[i] = solver.prepare(residual, guess) if i == 0 else 0
                counts[i] += _solve(residual, guess, solver, tolerance, max_iterations)
            else:
                take(guess)
        except (SimulationError, _NotConvergedError) as error:
            raise CouplingError(f"coupling '{scheme}' failed in the step from t = {i * H:.6g} s: {error}") from error
        before, u = u, loop.signals()
        observe((i + 1) * H)
    return counts


def _take(loop: Loop, scheme: str, t: float, H: float, u: np.ndarray, x: np.ndarray) -> None:
    """One step from u to x, which the iterated mean takes as a constant."""
    begin, end = ((u + x) / 2, (u + x) / 2) if scheme == MEAN else (u, x)
    loop.step(t, H, begin, end)


def _residual(loop: Loop, take: Callable[[np.ndarray], None], x: np.ndarray) -> np.ndarray:
    """r = G(x) − x, from the state at the beginning of the step."""
    loop.restore()
    take(x)
    return loop.signals() - x


class _NotConvergedError(Exception):
    """The iteration of a step has not reached its tolerance."""


def _solve(residual: Callable, x: np.ndarray, solver: FixedPoint, tolerance: float, max_iterations: int) -> int:
    """Leave the loop in the state of the solution; returns the number of residuals."""
    r = residual(x)
    for count in range(1, max_iterations + 1):
        if np.linalg.norm(r) <= tolerance * max(1.0, np.linalg.norm(x)):
            return count
        dx = solver.correction(r)
        changed = residual(x + dx)
        solver.learn(dx, changed - r)
        x, r = x + dx, changed
    raise _NotConvergedError(f"no convergence in {max_iterations} iterations, residual {np.linalg.norm(r):.3g}")
