"""What the tests of the integration methods share: their settings, and problems with independent solutions.

The problems: HeavyTop and SliderCrank, which are constrained, a rotor of moderate speed on its springs, and FreeBody.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, partial
from itertools import product
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp
from scipy.special import ellipj, ellipkm1

from research.reference import Rotor, add_vector
from research.reference.minimal_coordinates import high_speed_rotor
from sigmafmu import _core

from .helpers import History, Rotation, columns, errors, reference, rotation_of, simulation

GENERALIZED_ALPHA, RKMK4, RKMK54, BLIEDF2 = 1, 2, 3, 4
R3XSO3, SE3 = 1, 2
EXP, CAYLEY, CAYLEY2 = 1, 2, 3
QUATERNION, ROTATION_VECTOR = 1, 2

METHODS = {"generalizedAlpha": GENERALIZED_ALPHA, "rkmk4": RKMK4, "rkmk54": RKMK54, "bliedf2": BLIEDF2}
GROUPS = {"R3xSO3": R3XSO3, "SE3": SE3}
MAPS = {"exp": EXP, "cayley": CAYLEY, "cayley2": CAYLEY2}
ABSOLUTES = {"quaternion": QUATERNION, "rotationVector": ROTATION_VECTOR}

TIGHT = {"relative_tolerance": 1e-13, "absolute_tolerance": 1e-13}
"""Newton's method to rounding; rkmk54 as accurate as it can be."""
FIXED_STEPS = {"relative_tolerance": 1e-2, "absolute_tolerance": 1e12}
"""rkmk54 accepts every step, and does exactly those that it is asked for."""


def lgt(names: str = "group, map") -> dict[str, dict[str, int]]:
    """Settings of every group with every coordinate map, and every kind of absolute coordinates if `names` has it."""
    kinds = [("group", GROUPS), ("local_coordinates", MAPS)]
    if "absolute" in names:
        kinds.append(("absolute_coordinates", ABSOLUTES))
    return {
        " ".join(chosen): {key: items[name] for (key, items), name in zip(kinds, chosen, strict=True)}
        for chosen in product(*(items for _, items in kinds))
    }


# --- problems --------------------------------------------------------------------------------------------------------

FREE_INERTIA = np.array([1.0, 2.0, 3.0])
FREE_VELOCITY = np.array([0.1, -0.2, 0.3])
FREE_SPIN = np.array([0.0, 5.0, 0.01])


def free_body() -> _core.Mechanism:
    """A body without loads that spins about its middle axis and turns over (Dzhanibekov)."""
    mechanism = _core.Mechanism()
    body = _core.RigidBody()
    body.name, body.mass, body.inertia = "body", 1.0, FREE_INERTIA
    body.initial_velocity, body.initial_angular_velocity = FREE_VELOCITY, FREE_SPIN
    mechanism.multibody.add(body)
    return mechanism


def free_spin(t: Any) -> np.ndarray:
    """ω(t) in B: Jacobi's elliptic functions, for |L|² > 2 T J₂ and ω₁(0) = 0 (Landau, Lifshitz, Mechanics, § 37)."""
    j1, j2, j3 = FREE_INERTIA
    twice_energy, momentum = FREE_INERTIA @ FREE_SPIN**2, (FREE_INERTIA**2) @ FREE_SPIN**2  # 2 T, |L|²
    size = np.sqrt(
        [
            (twice_energy * j3 - momentum) / (j1 * (j3 - j1)),
            (twice_energy * j3 - momentum) / (j2 * (j3 - j2)),
            (momentum - twice_energy * j1) / (j3 * (j3 - j1)),
        ]
    )
    rate = np.sqrt((j3 - j2) * (momentum - twice_energy * j1) / (j1 * j2 * j3))
    # m = 1 - complement; with ω₁(0) = 0 the numerator is exactly (J₃ - J₂)(|L|² - 2 T J₁) less the product below
    complement = (j3 - j1) * FREE_SPIN[2] ** 2 * j3 * (j3 - j2) / ((j3 - j2) * (momentum - twice_energy * j1))
    sn, cn, dn, _ = ellipj(rate * np.asarray(t) + ellipkm1(complement), 1 - complement)
    return size[:, None] * np.array([cn, sn, dn]).reshape(3, -1)


@cache
def free_body_solution(stop: float, samples: int) -> History:
    """ω in closed form; the orientation from its kinematics by DOP853."""
    times = np.linspace(0.0, stop, samples + 1)

    def rhs(t: float, p: np.ndarray) -> np.ndarray:
        omega = free_spin(t)[:, 0]
        return 0.5 * np.array([-p[1:] @ omega, *(p[0] * omega + np.cross(p[1:], omega))])

    start = np.array([1.0, 0, 0, 0])
    solution = solve_ivp(rhs, (0.0, stop), start, method="DOP853", t_eval=times, rtol=3e-14, atol=1e-15, max_step=0.02)
    history: History = {"time": times}
    add_vector(history, "body.position", times[:, None] * FREE_VELOCITY)
    add_vector(history, "body.quaternion", solution.y.T)
    add_vector(history, "body.velocity", np.tile(FREE_VELOCITY, (samples + 1, 1)))
    add_vector(history, "body.angularVelocity", free_spin(times).T)
    return history


SPIN = 300.0
"""rad/s: slow enough for every map, fast enough to matter to all of them."""


def rotor() -> _core.Mechanism:
    mechanism = _core.mechanism("HighSpeedRotor")
    mechanism.multibody.body(0).initial_angular_velocity = np.array([SPIN, 0.0, 0.0])
    return mechanism


@cache
def rotor_solution(stop: float, samples: int) -> History:
    return high_speed_rotor(np.linspace(0.0, stop, samples + 1), Rotor(spin=SPIN))


def body_errors(truth: History, q: np.ndarray, v: np.ndarray, name: str) -> dict[str, float]:
    """Largest differences of one body without joints."""
    turn = Rotation.from_quat(columns(truth, f"{name}.quaternion", 4), scalar_first=True)
    differences = {
        "position": q[:, :3] - columns(truth, f"{name}.position"),
        "orientation": (turn.inv() * rotation_of(q)).as_rotvec(),
        "velocity": v[:, :3] - columns(truth, f"{name}.velocity"),
        "angularVelocity": v[:, 3:] - columns(truth, f"{name}.angularVelocity"),
    }
    return {kind: float(np.abs(difference).max()) for kind, difference in differences.items()}


@dataclass(frozen=True)
class Problem:
    make: Callable[[], _core.Mechanism]
    solution: Callable[[float, int], History]  # of (stop, samples)
    errors: Callable[..., dict[str, float]]  # of (solution, q, v, multipliers)
    ranges: dict[int, tuple[float, int]]  # per method: stop time and steps to it, in its asymptotic range


def _benchmark(name: str, ranges: dict[int, tuple[float, int]]) -> Problem:
    solution = partial(reference, name)
    return Problem(lambda: _core.mechanism(name), solution, partial(errors, name), ranges)


def _single(make: Callable, solution: Callable, name: str, ranges: dict[int, tuple[float, int]]) -> Problem:
    return Problem(make, solution, lambda truth, q, v, _: body_errors(truth, q, v, name), ranges)


PROBLEMS = {
    "FreeBody": _single(
        free_body,
        free_body_solution,
        "body",
        {GENERALIZED_ALPHA: (2.0, 800), BLIEDF2: (2.0, 1600), RKMK4: (2.0, 400), RKMK54: (1.0, 40)},
    ),
    "rotor": _single(
        rotor,
        rotor_solution,
        "rotor",
        {GENERALIZED_ALPHA: (0.04, 400), BLIEDF2: (0.04, 800), RKMK4: (0.04, 160), RKMK54: (0.3, 1024)},
    ),
    "HeavyTop": _benchmark(
        "HeavyTop", {GENERALIZED_ALPHA: (0.1, 800), BLIEDF2: (0.1, 800), RKMK4: (0.1, 400), RKMK54: (0.1, 200)}
    ),
    "SliderCrank": _benchmark(
        "SliderCrank", {GENERALIZED_ALPHA: (0.4, 400), BLIEDF2: (0.4, 1600), RKMK4: (0.4, 400), RKMK54: (0.8, 1280)}
    ),
}
SAMPLES = 8


def run_errors(problem: Problem, stop: float, steps: int, **settings: Any) -> dict[str, float]:
    """Largest errors at SAMPLES times of a run of so many equal steps, per kind of quantity."""
    run = simulation(problem.make(), step_size=stop / steps, **settings)
    _, q, v, multipliers = run.trajectory(stop, steps)
    assert run.state.counters.steps == steps
    at = slice(None, None, steps // SAMPLES)
    return problem.errors(problem.solution(stop, SAMPLES), q[at], v[at], multipliers[at])


def orders(coarse: dict[str, float], fine: dict[str, float]) -> dict[str, float]:
    """log2 of the ratios of errors with steps h and h/2; no error is zero (it would not tell an order)."""
    return {kind: float(np.log2(coarse[kind] / (fine[kind] or np.nan))) for kind in fine}


def observed_orders(name: str, method: int, **settings: Any) -> dict[str, float]:
    """Of two runs in the asymptotic range of the method, per kind of quantity.

    A translation of FreeBody on R³×SO(3) is exact and has no order: it is left out, once it has been found so.
    """
    problem = PROBLEMS[name]
    stop, steps = problem.ranges[method]
    tolerances = FIXED_STEPS if method == RKMK54 else TIGHT
    coarse, fine = (
        run_errors(problem, stop, n, **{"method": method, **tolerances, **settings}) for n in (steps, 2 * steps)
    )
    if name == "FreeBody" and settings.get("group", R3XSO3) == R3XSO3:
        assert max(fine.pop("position"), fine.pop("velocity")) <= 1e-13
    return orders({kind: coarse[kind] for kind in fine}, fine)


def assert_order(orders: dict[str, float], expected: float) -> None:
    for kind, order in orders.items():
        assert abs(order - expected) <= 0.1, f"{kind}: {order:.3f}"
