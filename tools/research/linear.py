"""Linear models beside the FMUs: how far differences of what an FMU does are from A, B, C and D.

The FMU is started at the point and at neighbours on both sides, in random directions that satisfy the constraints.
States are read from its outputs: coordinates as they are, rotations from quaternions. So nothing of the linearisation
is used but its matrices. D is compared with fmi2GetDirectionalDerivative.

    python -m research linear

prints the largest differences for every model at ten times of a motion with constant inputs.
"""

from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass

import numpy as np
from fmpy.fmi2 import FMU2Slave

from sigmafmu import _core
from sigmafmu.fmu import Fmu
from sigmafmu.linear.coordinates import sizes
from sigmafmu.linear.differences import derivative
from sigmafmu.linear.linearization import linearize
from sigmafmu.linear.model import LinearModel
from sigmafmu.linear.point import OperatingPoint, operating_point
from sigmafmu.markdown import markdown_table

EXPERIMENTS: dict[
    str, tuple[dict[str, float], float]
] = {  # constant inputs and end of the motion [s]; default: its own
    "FlexiblePendulum": ({"beam.force[2]": 3.0}, 2.0),
    "FlexibleSliderCrank": ({"crankPivot.motorTorque": 0.1}, 1.0),
    "HeavyTop": ({"top.torque[1]": 5.0}, 1.0),
    "HighSpeedRotor": ({"leftSupport.actuatorForce[2]": 1.0, "rotor.torque[3]": 0.05}, 0.05),
    "SliderCrank": ({"crankPivot.motorTorque": 0.1}, 1.0),
    "SpinUpBeam": ({"hubPivot.motorTorque": 300.0}, 10.0),
}
TIMES = 10
PERTURBATION = 2e-3
"""Length of a perturbation, in parts of the mechanism's size (1 rad) and of its speed (at least 1 size per second)."""


@dataclass(frozen=True)
class Differences:
    """Largest differences, in parts of the largest terms in their row (at least 1 in SI units)."""

    point: float  # x0, dx0 and y0
    A: float
    B: float
    C: float
    D: float


def points(model: str) -> Iterator[OperatingPoint]:
    """The points of `model` at which it is checked."""
    u0, end = EXPERIMENTS.get(model) or ({}, _core.mechanism(model).stop_time)
    for i in range(1, TIMES + 1):
        yield operating_point(model, end * i / TIMES, u0=u0)


def check(point: OperatingPoint, frame: str = "world") -> Differences:
    """Compare the linear model of `point`, whose mechanism has default parameters, with the FMU."""
    linear = linearize(point, frame=frame)
    fmu = Fmu.of_model(point.model)
    plant = _Plant(fmu, linear)
    try:
        plant.start(point.start_values())
        reference = _Reading(plant.read(), None, linear)
        inputs, outputs = fmu.references(list(linear.inputs)), fmu.references(list(linear.outputs))
        D = np.column_stack([plant.slave.getDirectionalDerivative(outputs, [u], [1.0]) for u in inputs])
        B = np.column_stack([plant.by_input(u, value, reference) for u, value in zip(inputs, linear.u0, strict=True)])
        changes = [plant.by_state(point, direction, reference) for direction in _directions(point, len(linear.x0) + 2)]
    finally:
        plant.slave.freeInstance()
    x, dx, y = (np.column_stack(columns) for columns in zip(*changes, strict=True))
    unit = np.eye(len(inputs))
    freedom = len(linear.x0) // 2
    wrapped = _wrap(linear.outputs, reference.y - linear.y0, linear.y0)
    return Differences(
        point=max(
            _largest(wrapped, linear.y0),
            _largest(reference.rates - linear.x0[freedom:], linear.x0[freedom:]),
            _largest(reference.accelerations - linear.dx0[freedom:], linear.dx0[freedom:]),
        ),
        A=_rows(dx, linear.A, x),
        B=_rows(B, linear.B, unit),
        C=_rows(y, linear.C, x),
        D=_rows(D, linear.D, unit),
    )


def _largest(difference: np.ndarray, value: np.ndarray) -> float:
    return float((np.abs(difference) / np.maximum(1.0, np.abs(value))).max())


def _rows(change: np.ndarray, matrix: np.ndarray, x: np.ndarray) -> float:
    scale = np.maximum(1.0, (np.abs(matrix) @ np.abs(x)).max(axis=1, initial=0.0))
    return float((np.abs(change - matrix @ x).max(axis=1, initial=0.0) / scale).max())


def _directions(point: OperatingPoint, count: int) -> list[tuple[np.ndarray, np.ndarray]]:
    """Random changes of positions and velocities: as many as there are states and some more tell all of a matrix."""
    random = np.random.default_rng(0)
    size = sizes(point.mechanism, _core.System(point.mechanism.multibody))
    speed = max(1.0, float(np.abs(point.v / size).max()))
    both = random.standard_normal((2, count, len(size))) * size
    return list(zip(both[0], speed * both[1], strict=True))


class _Plant:
    """The FMU, started anew at every point."""

    def __init__(self, fmu: Fmu, linear: LinearModel):
        self.slave: FMU2Slave = fmu.instantiate()
        self.linear = linear
        self._fmu = fmu
        joints = (".angularRate", ".rate")
        differentiated = [s for s in linear.states if s.endswith(joints) or ".modalRate[" in s]
        self._differentiated = differentiated
        self._names = [v.name for v in fmu.description.modelVariables if v.causality == "output" and v.type == "Real"]

    def start(self, values: Mapping[str, float]) -> None:
        self.slave.reset()
        self.slave.setupExperiment(startTime=0.0)
        self.slave.setReal(self._fmu.references(list(values)), list(values.values()))
        self.slave.enterInitializationMode()
        self.slave.exitInitializationMode()

    def read(self) -> dict[str, float]:
        """All outputs, and the derivatives of joint and modal rates as `der(name)`."""
        values = dict(zip(self._names, self.slave.getReal(self._fmu.references(self._names)), strict=True))
        names = self._differentiated
        if names:
            rates = self.slave.getRealOutputDerivatives(self._fmu.references(names), [1] * len(names))
            values |= {f"der({name})": rate for name, rate in zip(names, rates, strict=True)}
        return values

    def by_input(self, reference: int, value: float, centre: "_Reading") -> np.ndarray:
        """d(dx)/du; everything is affine in u."""
        both = []
        for sign in (1.0, -1.0):
            self.slave.setReal([reference], [value + sign])
            both.append(_Reading(self.read(), centre, self.linear).dx)
        self.slave.setReal([reference], [value])
        return (both[0] - both[1]) / 2

    def by_state(
        self, point: OperatingPoint, direction: tuple[np.ndarray, np.ndarray], centre: "_Reading"
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """d(x, dx, y) in a direction."""
        system = _core.System(point.mechanism.multibody)

        def at(s: float) -> np.ndarray:
            q = system.project_positions(system.compose(point.q, s * direction[0]))
            v = system.project_velocities(q, point.v + s * direction[1])
            near = OperatingPoint(point.mechanism, q, v, point.u, point.turned)
            self.start(near.start_values())
            reading = _Reading(self.read(), centre, self.linear)
            return np.concatenate([reading.x, reading.dx, _wrap(self.linear.outputs, reading.y - centre.y, centre.y)])

        result = derivative(at, PERTURBATION)
        n = len(self.linear.x0)
        return result[:n], result[n : 2 * n], result[2 * n :]


class _Reading:
    """States, their derivatives and outputs, as deviations from those of `centre` (from zero without one)."""

    def __init__(self, values: Mapping[str, float], centre: "_Reading | None", linear: LinearModel):
        self._values = values
        self._centre = centre or self
        freedom = len(linear.states) // 2
        self.y = np.array([values[name] for name in linear.outputs])
        self.rates = np.array([self._rate(name) for name in linear.states[freedom:]])
        self.accelerations = np.array([self._acceleration(name) for name in linear.states[freedom:]])
        coordinates = [self._coordinate(name) for name in linear.states[:freedom]]
        position, speed = np.array(coordinates).T
        self.x = np.concatenate([position, self.rates - self._centre.rates])
        self.dx = np.concatenate([speed, self.accelerations - self._centre.accelerations])

    def _vector(self, body: str, name: str, length: int = 3) -> np.ndarray:
        return np.array([self._values[f"{body}.{name}[{i + 1}]"] for i in range(length)])

    def _rotation(self, body: str) -> np.ndarray:
        return _core.lie.rotation_matrix(self._vector(body, "quaternion", 4))

    def _rate(self, name: str) -> float:
        body, kind, i = _split(name)
        if kind == "angularVelocityW":
            return (self._rotation(body) @ self._vector(body, "angularVelocity"))[i]
        if kind == "velocityB":
            return (self._rotation(body).T @ self._vector(body, "velocity"))[i]
        return self._values[name]

    def _acceleration(self, name: str) -> float:
        body, kind, i = _split(name)
        if kind == "velocity":
            return self._vector(body, "acceleration")[i]
        if kind == "angularVelocity":
            return self._vector(body, "angularAcceleration")[i]
        if kind == "angularVelocityW":
            return (self._rotation(body) @ self._vector(body, "angularAcceleration"))[i]
        if kind == "velocityB":
            spin = self._vector(body, "angularVelocity")
            turning = self._rotation(body).T
            change = turning @ self._vector(body, "acceleration")
            return (change - np.cross(spin, turning @ self._vector(body, "velocity")))[i]
        return self._values[f"der({name})"]

    def _coordinate(self, name: str) -> tuple[float, float]:
        """Deviation of a coordinate and its time derivative, where the centre moves as well."""
        body, kind, i = _split(name)
        if kind in ("rotationW", "rotationB"):
            here, there = self._quaternion(body), self._centre._quaternion(body)
            pairs = [(here[0], there[0]), (here[1], there[0]), (here[0], there[1])]
            # R(t) R0(t)ᵀ or R0(t)ᵀ R(t), of which the quaternion's vector is half the small rotation
            order = (
                [_product(a, _conjugate(b)) for a, b in pairs]
                if kind == "rotationW"
                else [_product(_conjugate(b), a) for a, b in pairs]
            )
            value, left, right = order
            return 2 * value[1 + i], 2 * (left + right)[1 + i]
        if kind == "displacementB":
            turning = self._centre._rotation(body).T
            offset = turning @ (self._vector(body, "position") - self._centre._vector(body, "position"))
            speed = turning @ (self._vector(body, "velocity") - self._centre._vector(body, "velocity"))
            spin = self._centre._vector(body, "angularVelocity")
            return offset[i], (speed - np.cross(spin, offset))[i]
        rate = {"angle": "angularRate", "displacement": "rate", "modal": "modalRate", "position": "velocity"}[kind]
        rate_name = name.replace(f".{kind}", f".{rate}")
        difference = self._values[name] - self._centre._values[name]
        if kind == "angle":
            difference = float(_turned(difference))
        return difference, self._values[rate_name] - self._centre._values[rate_name]

    def _quaternion(self, body: str) -> tuple[np.ndarray, np.ndarray]:
        """q and q' = q ω / 2."""
        q = self._vector(body, "quaternion", 4)
        return q, _product(q, np.concatenate([[0.0], self._vector(body, "angularVelocity")])) / 2


def _split(name: str) -> tuple[str, str, int]:
    """`top.rotationW[2]` → (`top`, `rotationW`, 1)."""
    owner, _, last = name.rpartition(".")
    kind, _, index = last.partition("[")
    return owner, kind, int(index[:-1]) - 1 if index else 0


def _product(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return np.concatenate([[a[0] * b[0] - a[1:] @ b[1:]], a[0] * b[1:] + b[0] * a[1:] + np.cross(a[1:], b[1:])])


def _conjugate(q: np.ndarray) -> np.ndarray:
    return np.concatenate([q[:1], -q[1:]])


def _turned(angle: np.ndarray | float) -> np.ndarray:
    """An angle within half a turn of zero."""
    return angle - 2 * np.pi * np.round(np.asarray(angle) / (2 * np.pi))


def _wrap(names: tuple[str, ...], difference: np.ndarray, centre: np.ndarray) -> np.ndarray:
    """Differences of outputs without the jumps of joint angles and rotation vectors, which an FMU starts within π."""
    result = difference.copy()
    for i, name in enumerate(names):
        if name.endswith(".angle"):
            result[i] = _turned(difference[i])
        elif name.endswith(".rotationVector[1]"):
            vector = centre[i : i + 3] + difference[i : i + 3]
            turns = np.arange(-1, 2) * 2 * np.pi
            length = np.linalg.norm(vector) or 1.0
            candidates = [vector * (1 + turn / length) - centre[i : i + 3] for turn in turns]
            result[i : i + 3] = min(candidates, key=np.linalg.norm)
    return result


def page() -> str:
    """The largest differences of every model, as a table in Markdown."""
    kinds, rows = ("point", "A", "B", "C", "D"), []
    for model in sorted(_core.mechanisms()):
        found = [asdict(check(point)) for point in points(model)]
        rows.append([f"`{model}`", *(f"{max(f[kind] for f in found):.1e}" for kind in kinds)])
    return markdown_table(["model", *kinds], rows)
