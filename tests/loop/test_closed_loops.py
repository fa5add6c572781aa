"""The closed loops against independent models of plant and sampling, and against what their controllers promise.

A sampled loop has an exact reference: the plant in minimal coordinates (SciPy's DOP853, or the exponential of a matrix
where it is linear) between samples, and the same law at each of them. What is left is the error of the FMU's
integrator, which has to fall with the square of its step size.
"""

from collections.abc import Callable, Mapping

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from research.reference import TOP, TOP_PIVOT, Rotor
from research.reference.minimal_coordinates import SliderCrank
from sigmafmu import SigmafmuError
from sigmafmu.fmu import Fmu
from sigmafmu.instance import Instance, SimulationError
from sigmafmu.loop.closed_loop import off, run_closed_loop
from sigmafmu.loop.controller_fmu import build
from sigmafmu.loop.controllers.axis_attitude import AxisAttitude
from sigmafmu.loop.controllers.speed_pi import SpeedPI
from sigmafmu.loop.loops import CONTROLLER, LOOPS, Loop, find
from sigmafmu.loop.performance import PERFORMANCE, axis_error, whirl
from sigmafmu.result import Result

CRANK, ROTOR, TOP_LOOP = LOOPS["SliderCrank"], LOOPS["HighSpeedRotor"], LOOPS["HeavyTop"]
Inputs = Mapping[str, float]
"""Input of the plant → value held over a sampling period."""


class Plant:
    """A plant between samples: `flow` moves `state` on by H from time t, `outputs` are what the laws measure."""

    state: np.ndarray

    def flow(self, t: float, H: float, u: Inputs) -> None:
        raise NotImplementedError

    def outputs(self) -> dict[str, float]:
        raise NotImplementedError


def integrated(rhs: Callable, t: float, H: float, state: np.ndarray) -> np.ndarray:
    solution = solve_ivp(rhs, (t, t + H), state, method="DOP853", rtol=1e-11, atol=1e-12)
    assert solution.success
    return solution.y[:, -1]


class CrankPlant(Plant):
    """½ M(θ) θ̇² + V(θ) with a torque on θ: M θ̈ = τ − ½ M′ θ̇² − V′; M and V as Fourier series."""

    NODES = 256

    def __init__(self) -> None:
        theta = 2 * np.pi * np.arange(self.NODES) / self.NODES
        mechanism = SliderCrank(theta)
        potential = mechanism.energy(np.zeros_like(theta))
        inertia = 2 * (mechanism.energy(np.ones_like(theta)) - potential)
        self.series = np.fft.rfft([inertia, potential]) / self.NODES
        self.series[:, 1:] *= 2
        assert np.abs(self.series[:, -4:]).max() < 1e-15
        self.orders = 1j * np.arange(self.series.shape[1])
        self.state = np.array([0.0, 6.0])

    def acceleration(self, theta: float, rate: float, torque: float) -> float:
        waves = np.exp(self.orders * theta)
        inertia = (self.series[0] @ waves).real
        inertia_slope, potential_slope = (self.series @ (self.orders * waves)).real
        return (torque - 0.5 * inertia_slope * rate**2 - potential_slope) / inertia

    def flow(self, t: float, H: float, u: Inputs | Callable[[float], float]) -> None:
        torque = u if callable(u) else lambda _: u["crankPivot.motorTorque"]
        self.state = integrated(lambda t, y: [y[1], self.acceleration(*y, torque(t))], t, H, self.state)

    def outputs(self) -> dict[str, float]:
        return {"crankPivot.angle": self.state[0], "crankPivot.angularRate": self.state[1]}


class TopPlant(Plant):
    """Euler's equations about the pivot with a torque in B: J_P ω̇ + ω × J_P ω = m d × Rᵀ g + τ, ṗ = ½ p ∘ (0, ω)."""

    def __init__(self) -> None:
        d = -TOP_PIVOT
        self.inertia = np.array(TOP.inertia) + TOP.mass * (d @ d - d * d)  # diagonal, d being on a principal axis
        self.d = d
        self.state = np.array([1.0, 0.0, 0.0, 0.0, *TOP.angular_velocity])

    def flow(self, t: float, H: float, u: Inputs) -> None:
        torque = np.array([u[f"top.torque[{i}]"] for i in (1, 2, 3)])

        def rhs(_t: float, y: np.ndarray) -> np.ndarray:
            (w, *v), omega = y[:4], y[4:]
            v = np.array(v)
            weight = rotation(y[:4]).T @ [0, 0, -9.81 * TOP.mass]
            momentum = np.cross(self.d, weight) + torque - np.cross(omega, self.inertia * omega)
            return np.array([-v @ omega / 2, *((w * omega + np.cross(v, omega)) / 2), *(momentum / self.inertia)])

        self.state = integrated(rhs, t, H, self.state)

    def outputs(self) -> dict[str, float]:
        quaternion, omega = self.state[:4] / np.linalg.norm(self.state[:4]), self.state[4:]
        return {
            **{f"top.quaternion[{i + 1}]": q for i, q in enumerate(quaternion)},
            **{f"top.angularVelocity[{i + 1}]": w for i, w in enumerate(omega)},
        }


def rotation(q: np.ndarray) -> np.ndarray:
    """R = I + 2 (w ũ + ũ²) / |q|²."""
    tilde = np.cross(np.eye(3), q[1:])
    return np.eye(3) + 2 * (q[0] * tilde + tilde @ tilde) / (q @ q)


class RotorPlant(Plant):
    """Linear gyroscope in complex coordinates y + i z: r of the centre of mass, s of the axis' slope, F of forces.

    m r̈ = Σ F,   J_t s̈ − i J_x Ω ṡ = Σ a F − i T   with F = −k (r + a s) − c (ṙ + a ṡ) + actuator at x = a, and T the
    torque about y and z. Constant inputs over a period: the exponential of the matrix is exact.
    """

    def __init__(self, rotor: Rotor | None = None) -> None:
        rotor = rotor or Rotor()
        self.arms = np.array([-rotor.left, rotor.right])
        jx, jt, _ = rotor.inertia
        mass = np.diag([rotor.mass, jt])
        shape = sum(np.outer([1, a], [1, a]) for a in self.arms)
        gyroscopic = np.diag([0, -1j * jx * rotor.spin])
        lower = -np.linalg.solve(mass, np.hstack([rotor.stiffness * shape, rotor.damping * shape + gyroscopic]))
        self.matrix = np.vstack([np.hstack([np.zeros((2, 2)), np.eye(2)]), lower]).astype(complex)
        self.to_forces = np.linalg.inv(mass)
        self.load = np.array([0.0, -1j * (rotor.torque[1] + 1j * rotor.torque[2])])
        self.state = np.zeros(4, dtype=complex)
        self.flows: dict[float, np.ndarray] = {}

    def with_coupling(self, q: float) -> np.ndarray:
        """The matrix with the force i q r of a seal at the centre of mass."""
        return self.matrix + np.outer([0, 0, 1, 0], [1j * q * self.to_forces[0, 0], 0, 0, 0])

    def flow(self, t: float, H: float, u: Inputs) -> None:
        if H not in self.flows:
            extended = np.zeros((6, 6), dtype=complex)
            extended[:4, :4], extended[2:4, 4:] = self.matrix, self.to_forces
            self.flows[H] = expm(H * extended)
        force = [u[f"{side}Support.actuatorForce[2]"] + 1j * u[f"{side}Support.actuatorForce[3]"] for side in SIDES]
        seal = u["rotor.force[2]"] + 1j * u["rotor.force[3]"]
        generalized = self.load + np.array([sum(force) + seal, self.arms @ force])
        self.state = (self.flows[H] @ [*self.state, *generalized])[:4]

    def outputs(self) -> dict[str, float]:
        r, s = self.state[:2]
        points = {"rotor": r} | {f"{side}Support": r + a * s for side, a in zip(SIDES, self.arms, strict=True)}
        return {
            f"{name}.position[{i}]": value
            for name, point in points.items()
            for i, value in ((2, point.real), (3, point.imag))
        }


SIDES = ("left", "right")
PLANTS: dict[str, type[Plant]] = {"SliderCrank": CrankPlant, "HighSpeedRotor": RotorPlant, "HeavyTop": TopPlant}


def reference(loop: Loop, H: float, samples: int, parameters: Mapping[str, float], *, delay: int = 0) -> dict:
    """What the laws of `loop` measure at 0, H, … if the plant between samples is exact."""
    plant = PLANTS[loop.plant]()
    laws = {
        name: part.law(**{k.removeprefix(f"{name}."): v for k, v in parameters.items() if k.startswith(f"{name}.")})
        for name, part in loop.parts.items()
    }
    rows, waiting = [plant.outputs()], [dict.fromkeys(loop.inputs, 0.0)] * delay
    for i in range(samples):
        u = {}
        for name, part in loop.parts.items():
            answer = laws[name].step(i * H, H, {ours: rows[-1][theirs] for ours, theirs in part.measured.items()})
            u |= {part.actuated[ours]: value for ours, value in answer.items()}
        waiting.append(u)
        plant.flow(i * H, H, waiting.pop(0))
        rows.append(plant.outputs())
    return {name: np.array([row[name] for row in rows]) for name in rows[0]}


def largest_error(result: Result, expected: Mapping[str, np.ndarray]) -> float:
    """Over all measured variables, relative to the largest value with the same unit."""
    size: dict[str, float] = {}
    for name, values in expected.items():
        unit = result.units[name]
        size[unit] = max(size.get(unit, 0.0), np.abs(values).max())
    return max(np.abs(result[name] - values).max() / size[result.units[name]] for name, values in expected.items())


# --- the table ---


@pytest.mark.parametrize("loop", LOOPS.values(), ids=list(LOOPS))
def test_wires_fit(fmu, loop):
    """Every input and output of a law is wired to one of the plant with the same unit; none is driven twice."""
    variables = fmu(loop.plant).variables
    for part in loop.parts.values():
        assert part.measured.keys() == part.law.inputs.keys()
        assert part.actuated.keys() == part.law.outputs.keys()
        for wires, own, causality in (
            (part.measured, part.law.inputs, "output"),
            (part.actuated, part.law.outputs, "input"),
        ):
            for name, other in wires.items():
                assert variables[other].causality == causality
                assert variables[other].unit == own[name][1]
    assert len(set(loop.inputs)) == len(loop.inputs)


# --- sampling ---


def test_samples_see_the_outputs_at_their_time_and_inputs_hold_from_then_on(fmu):
    """Bit by bit what a loop written out gives."""
    H, n = 1e-3, 50
    seen = []

    def law(time, H, measured):
        seen.append((time, H, measured["speed"]))
        return {"torque": 0.3 - 0.02 * measured["speed"]}

    result = run_closed_loop(CRANK, H, n * H, law)
    rate, torque = fmu("SliderCrank").references(["crankPivot.angularRate", "crankPivot.motorTorque"])
    with Instance(fmu("SliderCrank")) as instance:
        instance.start()
        slave = instance.slave
        for i in range(n):
            (speed,) = slave.getReal([rate])
            assert seen[i] == (i * H, H, speed)
            assert result["crankPivot.angularRate"][i] == speed
            assert result["crankPivot.motorTorque"][i] == 0.3 - 0.02 * speed
            slave.setReal([torque], [0.3 - 0.02 * speed])
            slave.doStep(i * H, H)
        assert result["crankPivot.angularRate"][n] == slave.getReal([rate])[0]
    assert len(seen) == n
    assert result.time[-1] == pytest.approx(n * H)


def test_answers_arrive_after_the_delay():
    for delay in (0, 1, 3):
        result = run_closed_loop(CRANK, 1e-3, 0.01, lambda t, H, y: {"torque": 1.0 + t}, delay=delay)
        expected = np.concatenate([np.zeros(delay), 1.0 + 1e-3 * np.arange(10 - delay)])
        np.testing.assert_array_equal(result["crankPivot.motorTorque"][:-1], expected)


@pytest.mark.parametrize(("hold", "order"), [("zero", 1), ("linear", 2)])
def test_order_of_the_holds(hold, order):
    """Against a torque that is continuous in time: a constant misses it by H, a line through two samples by H²."""

    def torque(t: float) -> float:
        return 0.2 * np.sin(15.0 * t)

    plant = CrankPlant()
    plant.flow(0.0, 0.4, torque)
    errors = []
    for H in (2e-2, 1e-2, 5e-3):
        result = run_closed_loop(CRANK, H, 0.4, lambda t, H, y: {"torque": torque(t)}, hold)
        errors.append(abs(result["crankPivot.angle"][-1] - plant.state[0]))
    # both holds have a next term: at H = 5e-3 it still is a tenth of the error
    assert np.log2(errors[1] / errors[2]) == pytest.approx(order, abs=0.15)


# --- exact references of the sampled loops ---

SHORT: dict[str, tuple[float, int, dict[str, float], tuple[float, float], float]] = {
    # H, samples, parameters, internal steps, largest error at the smaller one
    "SliderCrank": (2e-3, 200, {"controller.stepTime": 0.2}, (2e-4, 1e-4), 2.5e-7),
    "HighSpeedRotor": (5e-5, 2000, {}, (1e-5, 5e-6), 1e-3),
    "HeavyTop": (2e-3, 100, {}, (5e-4, 2.5e-4), 2e-4),
}


@pytest.mark.parametrize("model", LOOPS)
@pytest.mark.parametrize("delay", [0, 1])
def test_against_the_exact_sampled_loop(model, delay):
    """Second order in the internal step, so that the limit is the reference; accuracies as measured, about doubled."""
    H, samples, parameters, steps, accuracy = SHORT[model]
    expected = reference(LOOPS[model], H, samples, parameters, delay=delay)
    errors = []
    for h in steps:
        values = parameters | {"integrator.stepSize": h}
        result = run_closed_loop(LOOPS[model], H, samples * H, start_values=values, delay=delay)
        errors.append(largest_error(result, expected))
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2.0, abs=0.02)
    assert errors[1] < accuracy


# --- what the controllers promise ---


def test_speed_has_no_mean_error_over_a_turn():
    """In the periodic state the integral repeats, so that the error's mean over a turn vanishes; without it, it stays.

    What is left after the step decays as exp(−10 t), ki/kp = 10 / s: 4e-5 of 6 rad/s after 1 s.
    """
    mean = {}
    for gain in (10.0, 0.0):
        values = {"controller.integralGain": gain, "controller.stepTime": 0.2, "integrator.stepSize": 2.5e-4}
        result = run_closed_loop(CRANK, stop_time=1.4, start_values=values)
        law = SpeedPI(stepTime=0.2)
        mean[gain] = next(f.value for f in PERFORMANCE["SliderCrank"](result, law) if "mean error" in f.label)
    assert abs(mean[10.0]) < 1e-3
    assert abs(mean[0.0]) > 5e-3


def forward_whirl(result: Result, frequency: float, begin: float, periods: int) -> complex:
    """Mean of z exp(−iωt) over some periods from `begin` in a Hann window, which leaves out the slow precession."""
    window = (result.time >= begin) & (result.time < begin + periods * 2 * np.pi / frequency)
    z = result["rotor.position[2]"][window] + 1j * result["rotor.position[3]"][window]
    return np.mean(np.hanning(len(z)) * z * np.exp(-1j * frequency * result.time[window]))


def test_passive_supports_whirl_above_the_critical_speed_as_theory_says():
    """The seal destabilizes the forward whirl once q > c ω; its growth rate is that of the linear gyroscope."""
    plant = RotorPlant()
    coupling = ROTOR.parts["seal"].law().values["crossCoupling"]
    stable, unstable = (np.linalg.eigvals(plant.with_coupling(q)) for q in (0.0, coupling))
    assert stable.real.max() < 0 < unstable.real.max()
    whirl_mode = unstable[np.argmax(unstable.real)]
    critical = whirl_mode.imag  # 81 rad/s: the rotor spins at 20944
    assert 250 * critical < Rotor().spin

    # the force of the seal is sampled as well: its mean delay H / 2 turns it by 2e-3 rad, 1e-2 / s of the growth rate
    result = run_closed_loop(ROTOR, 5e-5, 1.0, off)
    first, second = (abs(forward_whirl(result, critical, begin, 5)) for begin in (0.1, 0.6))
    assert np.log(second / first) / 0.5 == pytest.approx(whirl_mode.real, abs=0.05)


def test_magnetic_bearings_catch_a_growing_whirl_and_hold_the_rotor_still():
    """Switched on at 0.8 s: from there the rotor goes to the equilibrium of all springs, cross forces and the load."""
    law = ROTOR.parts[CONTROLLER].law()
    values = {"controller.startTime": 0.8, "integrator.stepSize": 1e-5}
    result = run_closed_loop(ROTOR, stop_time=1.6, start_values=values)

    plant, p, q = RotorPlant(), law.values, ROTOR.parts["seal"].law().values["crossCoupling"]
    shape = sum(np.outer([1, a], [1, a]) for a in plant.arms)
    stiffness = (Rotor().stiffness + p["stiffness"]) * shape.astype(complex)
    stiffness[0, 0] -= 1j * q
    stiffness[1, 1] -= 1j * p["crossStiffness"] * np.ptp(plant.arms)
    r, s = np.linalg.solve(stiffness, plant.load)
    end = result["leftSupport.position[2]"][-1] + 1j * result["leftSupport.position[3]"][-1]
    # exp(−15.7 · 0.8) = 3e-6 is left of 300 µm; the equilibrium is at 23 µm
    assert abs(end - (r + plant.arms[0] * s)) < 1e-4 * abs(end)

    before = (result.time > 0.7) & (result.time < 0.8)
    after = result.time > 1.5
    assert whirl(result, "rotor")[before].max() > 10 * whirl(result, "rotor")[after].max()
    assert whirl(result, "leftSupport", "actuatorForce").max() < p["forceLimit"]


@pytest.mark.parametrize("target", [(0.0, 0.0, 1.0), (1.0, -1.0, 0.5)])
def test_attitude_loses_its_potential_at_every_sample(target):
    """V = ½ J_P |ω⊥|² + k (1 − cos) of the law; the spin stays what it was."""
    values = {f"controller.target[{i}]": x for i, x in enumerate(target, start=1)}
    result = run_closed_loop(TOP_LOOP, start_values=values | {"integrator.stepSize": 1e-3})
    law = AxisAttitude(**{name.removeprefix("controller."): x for name, x in values.items()})
    angle, omega = axis_error(result, law), result["top.angularVelocity"]
    inertia = TOP.inertia[0] + TOP.mass * TOP_PIVOT @ TOP_PIVOT
    potential = law.values["stiffness"] * (1 - np.cos(np.radians(angle)))
    potential += 0.5 * inertia * (omega[:, 0] ** 2 + omega[:, 2] ** 2)
    assert np.diff(potential).max() < 0
    assert angle[0] > 80
    assert angle[-1] < 0.5
    np.testing.assert_allclose(omega[:, 1], TOP.angular_velocity[1], rtol=1e-10)  # nothing turns about the axis


# --- a controller as an FMU, and other controllers ---


@pytest.mark.parametrize("loop", LOOPS.values(), ids=list(LOOPS))
def test_controller_fmu_answers_like_its_law(loop, tmp_path):
    """To the last bit, with start values of its own and others set by the master; twice in the same process.

    Others of the same law, with other start values, are loaded beside it.
    """
    pytest.importorskip("pythonfmu")
    law = loop.parts[CONTROLLER].law
    first, second, *_ = law.parameters
    changed = {name: 1.25 * law.parameters[name][0] + 0.1 for name in (first, second)}
    path = build(law, tmp_path, step_size=loop.H, stop_time=loop.stop_time, values={first: changed[first]})
    stop_time = 50 * loop.H
    expected = run_closed_loop(loop, stop_time=stop_time, controller=law(**changed))
    build(law, tmp_path / "other", step_size=loop.H, stop_time=loop.stop_time)
    fmu, other = Fmu(path), Fmu(tmp_path / "other" / path.name)
    for _ in range(2):
        plain = run_closed_loop(loop, stop_time=stop_time, controller=other)
        by_master = {f"controller.{second}": changed[second]}
        result = run_closed_loop(loop, stop_time=stop_time, controller=fmu, start_values=by_master)
        np.testing.assert_array_equal(result.values, expected.values)
        np.testing.assert_array_equal(plain.values, run_closed_loop(loop, stop_time=stop_time).values)
    assert not np.array_equal(plain.values, expected.values)


def test_controller_fmu_says_what_it_is(tmp_path):
    pytest.importorskip("pythonfmu")
    fmu = Fmu(build(SpeedPI, tmp_path, step_size=1e-3, stop_time=2.0, values={"setPoint": 7.0}))
    variables = fmu.variables
    assert {v.name: (v.causality, v.unit) for v in variables.values()} == {
        **{name: ("input", unit) for name, (_, unit, _) in SpeedPI.inputs.items()},
        **{name: ("output", unit) for name, (_, unit, _) in SpeedPI.outputs.items()},
        **{name: ("parameter", unit) for name, (_, unit, _) in SpeedPI.parameters.items()},
    }
    assert float(variables["setPoint"].start) == 7.0
    assert float(variables["torqueLimit"].start) == SpeedPI.parameters["torqueLimit"][0]
    with pytest.raises(SigmafmuError, match="SpeedPI has no parameter 'setpoint'"):
        build(SpeedPI, tmp_path, step_size=1e-3, stop_time=2.0, values={"setpoint": 7.0})


def test_a_law_that_is_given_starts_afresh():
    law = SpeedPI(setPoint=8.0)
    runs = [run_closed_loop(CRANK, stop_time=0.02, controller=law) for _ in range(2)]
    np.testing.assert_array_equal(runs[0].values, runs[1].values)


@pytest.mark.parametrize(
    ("keywords", "message"),
    [
        ({"hold": "cubic"}, "hold is 'cubic', but must be one of zero, linear"),
        ({"delay": -1}, "delay is -1"),
        ({"H": 0.0}, "step size must be a positive number"),
        ({"start_values": {"controller.gain": 1.0}}, "SpeedPI has no parameter 'gain'; it has setPoint"),
        ({"start_values": {"controller.setPoint": "fast"}}, "'controller.setPoint' needs a number, not 'fast'"),
        ({"start_values": {"crank.weight": 1.0}}, "no variable 'crank.weight'"),
        ({"controller": off, "start_values": {"controller.setPoint": 1.0}}, "given ready made"),
        ({"controller": lambda t, H, y: {"torqe": 1.0}}, "answers with 'torqe', but has the outputs torque"),
        ({"controller": lambda t, H, y: {"torque": np.nan}}, "wants torque = nan at t = 0 s"),
    ],
)
def test_refusals(keywords, message):
    with pytest.raises(SigmafmuError, match=message):
        run_closed_loop(CRANK, **{"stop_time": 0.01, **keywords})


def test_unknown_loop():
    with pytest.raises(SigmafmuError, match="no loop 'Crank'; known loops: SliderCrank, HighSpeedRotor, HeavyTop"):
        find("Crank")


def test_a_step_that_fails_says_when():
    """A torque beyond all measure at 5 ms."""
    with pytest.raises(SimulationError, match=r"SliderCrank in its loop stopped at t = 0\.005 s"):
        run_closed_loop(CRANK, 1e-3, 0.01, lambda t, H, y: {"torque": 1e200 if t > 4.5e-3 else 0.0})
