"""Steps of any lengths may follow each other: masters locate events, and error control changes the step size.

Errors of every sequence are compared with those of equal steps as long as the longest of the sequence.
"""

from collections.abc import Iterator
from functools import cache

import numpy as np
import pytest

from sigmafmu import _core

from .helpers import INCREMENTAL, INDEX2, INDEX3, MODIFIED, simulation
from .methods import BLIEDF2, CAYLEY, RKMK4, RKMK54, ROTATION_VECTOR, SE3, TIGHT

LONGEST = {
    "HeavyTop": (1e-3, 0.2),
    "HighSpeedRotor": (1e-5, 2e-3),
    "SliderCrank": (1e-3, 0.2),
    "FlexiblePendulum": (5e-4, 0.1),
    "FlexibleSliderCrank": (5e-4, 0.1),
    "SpinUpBeam": (5e-3, 0.5),
}
"""Longest step and length of a run [s]."""

METHODS = {
    "stabilizedIndex2": {},
    "index3": {"formulation": INDEX3},
    "index2": {"formulation": INDEX2},
    "sigma 0": {"sigma": 0.0},
    "incremental": {"corrector": INCREMENTAL},
    "modified": {"newton": MODIFIED},
    "rho 1": {"spectral_radius": 1.0},
    "rho 0.5": {"spectral_radius": 0.5},
    "rho 0": {"spectral_radius": 0.0},
    "index3, rho 0.3": {"formulation": INDEX3, "spectral_radius": 0.3},
    "SE3": {"group": SE3},
    "SE3, index3": {"group": SE3, "formulation": INDEX3},
    "cayley": {"local_coordinates": CAYLEY, "absolute_coordinates": ROTATION_VECTOR},
    "bliedf2": {"method": BLIEDF2},
    "bliedf2, index3": {"method": BLIEDF2, "formulation": INDEX3},
    "rkmk4": {"method": RKMK4},
    "rkmk54": {"method": RKMK54},
}
every_model = pytest.mark.parametrize("model", LONGEST)
every_method = pytest.mark.parametrize("method", METHODS)


def log_uniform(smallest: float, seed: int, count: int) -> np.ndarray:
    return smallest ** np.random.default_rng(seed).uniform(0, 1, count)


def sequences(steps: int, longest: float) -> Iterator[tuple[str, np.ndarray]]:
    """Lengths of steps over the longest, each sequence as long as `steps` of these."""
    shortest = 1e-13 / longest
    one = np.ones(steps + 1)
    one[steps // 2] = shortest
    one[steps // 2 + 1] -= shortest
    yield "one step of 1e-13 s", one
    for part in (shortest, 1e-9, 1e-6, 1e-4, 1e-3, 0.02, 0.1, 0.3, 0.45):
        yield f"every step split at {part:.1e}", np.tile([1 - part, part], steps)
    for smallest in (0.5, 0.1, 1e-3, 1e-6, shortest):
        for seed in (1, 2):
            lengths = log_uniform(smallest, seed, 40 * steps)
            yield f"log-uniform from {smallest:.1e}, {seed}", until(lengths, steps)
    uniform = np.random.default_rng(3).uniform(0.01, 1, 4 * steps)
    yield "uniform", until(uniform, steps)
    yield (
        "growing and shrinking",
        until(np.tile(np.concatenate([0.5 ** np.arange(20), 0.5 ** np.arange(20)[::-1]]), steps), steps),
    )


def until(lengths: np.ndarray, total: float) -> np.ndarray:
    """As many of them as fit, and what is missing."""
    kept = lengths[np.cumsum(lengths) < total]
    return np.append(kept, total - kept.sum())


def states(model: str, lengths: np.ndarray, parts: int = 1, **settings: float) -> dict[str, np.ndarray]:
    """Motion after each part of the steps of such lengths [s], their accelerations and multipliers."""
    run = simulation(model, step_size=lengths.max(), **settings)
    system = _core.System(_core.mechanism(model).multibody)
    u = np.zeros(system.input_size)
    if model == "SpinUpBeam":
        u[system.motor_index(0)] = 1.0
        run.set_input(u, 0 * u, 0.0)
        run.start()
    rows = []
    for part in np.split(lengths, parts):
        for h in part:
            run.advance(h, 1)
        q, v = run.state.q, run.state.v
        rows.append((q, v, *system.accelerations(q, v, u)))
    return {kind: np.array(x) for kind, x in zip(("q", "v", "vdot", "lambda"), zip(*rows, strict=True), strict=True)}


@cache
def truth(model: str, parts: int = 1) -> dict[str, np.ndarray]:
    longest, length = LONGEST[model]
    steps = 8 * round(length / longest)
    tight = {"relative_tolerance": 1e-12, "absolute_tolerance": 1e-13}
    return states(model, np.full(steps, length / steps), parts, method=RKMK54, **tight)


def errors(model: str, lengths: np.ndarray, parts: int = 1, **settings: float) -> dict[str, float]:
    found, exact = states(model, lengths, parts, **settings), truth(model, parts)
    return {kind: np.abs(found[kind] - exact[kind]).max(initial=0.0) for kind in found}


@every_model
@every_method
def test_errors_are_at_most_twice_those_of_equal_steps(model, method):
    longest, length = LONGEST[model]
    steps = round(length / longest)
    equal = errors(model, np.full(steps, longest), **METHODS[method])
    rounding = {kind: 1e-9 * np.abs(x).max(initial=0.0) for kind, x in truth(model).items()}
    for name, lengths in sequences(steps, longest):
        for kind, error in errors(model, longest * lengths, **METHODS[method]).items():
            assert error <= 2 * equal[kind] + rounding[kind], (name, kind)


PATTERNS = {
    "every step split at 1e-3": np.array([0.999, 0.001]),
    "every step split at 1e-7": np.array([1 - 1e-7, 1e-7]),
    "log-uniform from 1e-3": log_uniform(1e-3, 5, 16),
    "log-uniform from 1e-8": log_uniform(1e-8, 6, 16),
}


@pytest.mark.parametrize("model", ["HeavyTop", "HighSpeedRotor", "SliderCrank"])
@pytest.mark.parametrize(
    "method", ["stabilizedIndex2", "index3", "index2", "rho 0.5", "SE3", "bliedf2", "bliedf2, index3"]
)
@pytest.mark.parametrize("pattern", PATTERNS)
def test_order_2_is_kept(model, method, pattern):
    """The pattern again and again, with all steps half as long each time."""
    longest, length = LONGEST[model]
    lengths = PATTERNS[pattern] / PATTERNS[pattern].sum()
    times = round(length / longest / PATTERNS[pattern].sum() * PATTERNS[pattern].max())
    found = [
        errors(model, length / repeats * np.tile(lengths, repeats), 4, **METHODS[method], **TIGHT)
        for repeats in (2 * times, 4 * times, 8 * times)
    ]
    for kind in ("q", "v", "vdot"):
        order = np.log2(found[1][kind] / found[2][kind])
        assert order == pytest.approx(2.0, abs=0.2), (kind, [f[kind] for f in found])


@every_model
@pytest.mark.parametrize("method", ["stabilizedIndex2", "index3", "rho 0.5", "SE3", "bliedf2", "bliedf2, index3"])
@pytest.mark.parametrize("pattern", PATTERNS)
def test_energy_stays_bounded(model, method, pattern):
    """Over many steps, and in comparison with equal ones: what grows from step to step would be huge."""
    longest, _ = LONGEST[model]
    system = _core.System(_core.mechanism(model).multibody)

    def energies(lengths: np.ndarray) -> np.ndarray:
        run = simulation(model, step_size=longest, **METHODS[method])
        if model == "SpinUpBeam":
            push = run.state
            push.v = push.v + 1e-3 * np.sin(np.arange(system.velocity_size))
            push.v = system.project_velocities(push.q, push.v)
            run.state = push
            run.start()
        found = [system.energy(run.state.q, run.state.v)]
        for h in lengths:
            run.advance(h, 1)
            found.append(system.energy(run.state.q, run.state.v))
        return np.array(found)

    equal = energies(np.full(400, longest))
    scale = max(np.abs(equal - equal[0]).max(), 1e-6 * np.abs(equal).max())
    found = energies(longest * until(np.tile(PATTERNS[pattern], 400), 400))
    assert np.abs(found - equal[0]).max() <= 3 * scale


def test_accelerations_after_one_tiny_step():
    """The rotor's were 43 % off after one step of 1e-13 s."""
    longest, _ = LONGEST["HighSpeedRotor"]
    tiny = 1e-13
    regular = states("HighSpeedRotor", np.full(20, longest))
    disturbed = states("HighSpeedRotor", np.insert(np.full(19, longest), 9, [tiny, longest - tiny]))
    after = states("HighSpeedRotor", np.append(np.full(19, longest), [longest - tiny, tiny]))
    for kind in ("q", "v", "vdot"):
        scale = np.abs(regular[kind]).max()
        np.testing.assert_allclose(disturbed[kind], regular[kind], rtol=0, atol=1e-4 * scale)
        np.testing.assert_allclose(after[kind], regular[kind], rtol=0, atol=1e-4 * scale)


def test_a_step_of_any_length_is_done():
    """Down to the smallest numbers: nothing is divided by it."""
    for h in (1e-9, 1e-12, 1e-13, 1e-30, 1e-300):
        run = simulation("SliderCrank")
        before = run.state.q
        run.advance(h, 3)
        assert run.state.counters.steps == 3
        assert np.abs(run.state.q - before).max() <= 3 * h + 1e-15
        assert np.isfinite(run.state.vdot).all()
