"""Frequencies of a rotor over its speed, seen from W: Campbell diagrams and critical speeds.

At each speed Ω the steady motion with this rate is searched, and the mechanism is linearised about it in axes of W.
That model is constant if the rotor is symmetric about its axis, which is tested. Poles are followed from speed to
speed by their modes. A critical speed is one where a mode whirls once in a turn, Im λ = Ω: what an unbalance excites.
"""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from sigmafmu import SigmafmuError
from sigmafmu.linear.linearization import Linearization
from sigmafmu.linear.point import OperatingPoint, operating_point
from sigmafmu.result import CsvWriter
from sigmafmu.variables import SettingValue

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from sigmafmu.model import Model

PART_OF_A_TURN = 1 / 7
"""After which the model of a symmetric rotor is the same."""
SAME = 1e-5
"""Difference of the rows of A, relative to their largest entries, that comes from the integration."""
PLANE = 0.1
"""Modes whose path is flatter than this (1: a circle) whirl in no direction."""
SPINS = 1e-6
"""Of the rotor's speed: bodies that turn less stand still."""
ACCURACY = 1e-9
"""Relative, of critical speeds."""
MAX_REFINEMENTS = 60
ZERO = 1e-6
"""Frequencies below this part of the largest one are none."""


@dataclass(frozen=True)
class CriticalSpeed:
    """A speed at which a mode whirls once in a turn."""

    speed: float  # rad/s
    damping: float
    """Damping ratio of the mode, negative if it grows."""
    whirl: str
    """`forward` (excited by unbalance), `backward` or `plane`."""

    def __str__(self) -> str:
        rpm = self.speed * 30 / np.pi
        return f"{self.speed:.6g} rad/s ({rpm:.6g} rpm), {self.whirl}, damping ratio {self.damping:.2g}"


@dataclass(frozen=True, eq=False, repr=False)
class Campbell:
    """Poles of a rotor over its speed."""

    model: str
    rate: str
    """Name of the rate that is the speed."""
    speeds: np.ndarray
    """(n,) in rad/s."""
    poles: np.ndarray
    """(n, m), complex, in 1/s and rad/s: a column is one pole from speed to speed."""
    whirl: np.ndarray
    """(n, m): 1 for a mode that whirls in a circle with the rotor, −1 against it, 0 in a plane."""
    critical: tuple[CriticalSpeed, ...]
    """By speed."""

    def __repr__(self) -> str:
        return f"<Campbell of {self.model}: {len(self.speeds)} speeds, {len(self.critical)} critical ones between them>"

    def frequencies(self) -> np.ndarray:
        """(n, m) in rad/s, NaN for poles that do not oscillate and the lower ones of complex pairs."""
        imaginary = self.poles.imag
        return np.where(imaginary > ZERO * np.abs(imaginary).max(), imaginary, np.nan)

    def to_csv(self, path: Path | str) -> None:
        """Write a row for each speed: the speed, real and imaginary part and whirl of each pole."""
        names = [f"{part}[{k + 1}]" for k in range(self.poles.shape[1]) for part in ("real", "imaginary", "whirl")]
        columns = np.stack((self.poles.real, self.poles.imag, self.whirl), axis=2).reshape(len(self.speeds), -1)
        with CsvWriter(path) as writer:
            writer.write(("speed", *names), np.column_stack((self.speeds, columns)))

    def plot(self, path: Path | str | None = None) -> "Figure":
        """A matplotlib figure of frequencies and decay rates over the speed, with critical speeds; saved at `path`."""
        from sigmafmu.linear.campbell_figure import figure
        from sigmafmu.plots import save

        drawn = figure(self)
        if path is not None:
            save(drawn, path)
        return drawn


def campbell(
    model: "Model",
    rate: str,
    speeds: Iterable[float],
    *,
    parameters: Mapping[str, SettingValue] | None = None,
    on_speed: Callable[[float], None] | None = None,
) -> Campbell:
    """Follow the poles of `model` over `speeds` [rad/s] of the coordinate's `rate`; as `Model.campbell`."""
    grid = np.asarray(list(speeds), dtype=float)
    if len(grid) < 2 or not np.isfinite(grid).all() or not (np.diff(grid) > 0).all() or grid[0] < 0:
        raise SigmafmuError("a Campbell diagram needs two or more speeds that increase, from 0 on, in rad/s")
    rotor = _Rotor(model, rate, dict(parameters or {}))
    branches = [rotor.modes(grid[0])]
    for speed in grid[1:]:
        branches.append(_followed(rotor.modes(speed), branches))
        if on_speed:
            on_speed(float(speed))
    rotor.check_symmetry(grid[-1])
    poles = np.array([modes.poles for modes in branches])
    whirl = np.array([modes.whirl for modes in branches])
    return Campbell(model.name, rate, grid, poles, whirl, _critical(rotor, grid, branches))


@dataclass(frozen=True, eq=False)
class _Modes:
    poles: np.ndarray
    vectors: np.ndarray  # columns, of unit length
    whirl: np.ndarray

    def reordered(self, order: list[int]) -> "_Modes":
        return _Modes(self.poles[order], self.vectors[:, order], self.whirl[order])


class _Rotor:
    """A mechanism whose coordinate turns with a given rate."""

    def __init__(self, model: "Model", rate: str, parameters: dict[str, SettingValue]):
        self._model, self._rate, self._parameters = model, rate, parameters
        self._coordinates: tuple[str, ...] = ()

    def modes(self, speed: float) -> _Modes:
        """Poles and modes at a speed, in any order."""
        point = self._model.trim(parameters=self._parameters, hold={self._rate: speed})
        return self._modes_at(point, speed)

    def _modes_at(self, point: OperatingPoint, speed: float) -> _Modes:
        linear = Linearization(point, "world", self._coordinates)
        self._coordinates = tuple(c.name for c in linear.chosen)
        spinning = self._spinning(point, speed)
        self._check(linear, spinning)
        poles, vectors = np.linalg.eig(linear.model([], []).A)
        vectors = vectors / np.linalg.norm(vectors, axis=0)
        motions = linear.selection.motions @ vectors[: len(linear.chosen)]
        whirl = np.array([_whirl(point, spinning, motion, pole) for motion, pole in zip(motions.T, poles, strict=True)])
        return _Modes(poles, vectors, whirl)

    @staticmethod
    def _spinning(point: OperatingPoint, speed: float) -> dict[int, np.ndarray]:
        """Axes in W of the bodies that turn, by their indices."""
        axes = {}
        for i in range(len(point.mechanism.multibody.bodies)):
            spin = _rotation(point, i) @ point.v[6 * i + 3 : 6 * i + 6]
            if (size := np.linalg.norm(spin)) > SPINS * abs(speed):
                axes[i] = spin / size
        return axes

    def _check(self, linear: Linearization, spinning: Mapping[int, np.ndarray]) -> None:
        """Refuse coordinates that turn with the rotor: in these, frequencies are others."""
        multibody = linear.point.mechanism.multibody
        for i in spinning:
            if multibody.bodies[i].modal is not None:
                raise SigmafmuError(
                    f"the modes of {multibody.bodies[i].name} turn with it, and so do their frequencies; a Campbell "
                    "diagram needs rotors of rigid bodies"
                )
        joints = {joint.name: joint for joint in multibody.joints}
        for coordinate in linear.chosen:
            joint = joints.get(coordinate.name.rpartition(".")[0])
            if joint is not None and coordinate.rate != self._rate and joint.body1 in spinning:
                raise SigmafmuError(
                    f"'{coordinate.name}' is measured from a body that turns, and so are its frequencies; a Campbell "
                    "diagram needs bodies that move freely or in joints to parts that do not turn"
                )

    def check_symmetry(self, speed: float) -> None:
        """SigmafmuError if the model is another one after a part of a turn."""
        point = self._model.trim(parameters=self._parameters, hold={self._rate: speed})
        later = operating_point(
            self._model, PART_OF_A_TURN * 2 * np.pi / speed, parameters=self._parameters | point.start_values()
        )
        now, then = (Linearization(p, "world", self._coordinates).model([], []) for p in (point, later))
        apart = np.abs(then.A - now.A) / np.maximum(np.abs(now.A).max(axis=1, keepdims=True), 1.0)
        if apart.max() > SAME:
            row = now.derivatives[int(apart.max(axis=1).argmax())]
            raise SigmafmuError(
                f"{self._model.name} is not symmetric about the axis of {self._rate}: {row} follows another law after "
                "a part of a turn, and a Campbell diagram does not tell such motions"
            )


def _rotation(point: OperatingPoint, body: int) -> np.ndarray:
    from sigmafmu import _core

    return np.asarray(_core.lie.rotation_matrix(point.q[7 * body + 3 : 7 * body + 7]))


def _whirl(point: OperatingPoint, spinning: Mapping[int, np.ndarray], motion: np.ndarray, pole: complex) -> float:
    """Direction of the path of what spins, weighted by inertia: 1 a circle with the spin, −1 against it."""
    area, size = 0.0, 0.0
    for i, axis in spinning.items():
        body = point.mechanism.multibody.bodies[i]
        rotation = _rotation(point, i)
        inertia = float(np.mean(body.inertia))
        parts = ((body.mass, motion[6 * i : 6 * i + 3]), (inertia, rotation @ motion[6 * i + 3 : 6 * i + 6]))
        for weight, displacement in parts:
            across = displacement - axis * (axis @ displacement)
            area -= weight * float(np.imag(np.cross(across.conj(), across) @ axis))
            size += weight * float(np.linalg.norm(across) ** 2)
    return 0.0 if size == 0.0 or pole.imag == 0.0 else float(np.sign(pole.imag)) * area / size


def _followed(modes: _Modes, before: list[_Modes]) -> _Modes:
    """In the order of those at the speed before: near to where poles were going, and with similar modes."""
    last = before[-1]
    expected = last.poles if len(before) < 2 else 2 * last.poles - before[-2].poles
    distance = np.abs(modes.poles[None, :] - expected[:, None]) / max(np.abs(modes.poles).max(), 1e-300)
    alike = np.abs(last.vectors.conj().T @ modes.vectors)
    cost = distance + 0.1 * (1 - alike)
    order = [-1] * len(cost)
    for flat in np.argsort(cost, axis=None):
        i, j = divmod(int(flat), len(cost))
        if order[i] < 0 and j not in order:
            order[i] = j
    return modes.reordered(order)


def _critical(rotor: _Rotor, speeds: np.ndarray, branches: list[_Modes]) -> tuple[CriticalSpeed, ...]:
    found = []
    for k in range(len(branches[0].poles)):
        excess = np.array([modes.poles[k].imag - speed for modes, speed in zip(branches, speeds, strict=True)])
        for i in np.flatnonzero((excess[:-1] > 0) != (excess[1:] > 0)):
            ends = speeds[i : i + 2]
            if min(branches[i].poles[k].imag, branches[i + 1].poles[k].imag) > 0:
                found.append(_refined(rotor, ends, (branches[i].poles[k], branches[i + 1].poles[k]), excess[i : i + 2]))
    return tuple(sorted(found, key=lambda c: c.speed))


def _refined(rotor: _Rotor, ends: np.ndarray, poles: tuple[complex, complex], excess: np.ndarray) -> CriticalSpeed:
    """Regula falsi with the Illinois rule, for the pole nearest to the line between those at the ends."""
    (a, b), (fa, fb) = ends, excess
    for _ in range(MAX_REFINEMENTS):
        speed = b - fb * (b - a) / (fb - fa)
        modes = rotor.modes(speed)
        share = (speed - ends[0]) / (ends[1] - ends[0])
        nearest = int(np.abs(modes.poles - (poles[0] + share * (poles[1] - poles[0]))).argmin())
        f = modes.poles[nearest].imag - speed
        if abs(f) <= ACCURACY * speed or abs(b - a) <= ACCURACY * speed:
            break
        if (f > 0) != (fb > 0):
            a, fa = b, fb
        else:
            fa /= 2
        b, fb = speed, f
    pole, whirl = modes.poles[nearest], modes.whirl[nearest]
    kind = "plane" if abs(whirl) < PLANE else "forward" if whirl > 0 else "backward"
    return CriticalSpeed(float(speed), float(-pole.real / abs(pole)), kind)
