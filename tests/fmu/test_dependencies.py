"""ModelStructure against the FMU itself: what each output really depends on, and its derivatives.

Inputs act through accelerations and multipliers, which are affine in them: a difference over any length is exact. So
the inputs are set to large values, which lifts a true dependency far above the rounding of everything else.
"""

import json
import math
import re
from collections.abc import Callable, Iterator, Mapping
from functools import cache

import numpy as np
import pytest

from sigmafmu.fmu import Fmu

from .helpers import (
    EPS,
    Instance,
    bodies,
    counters,
    fastest_rotation,
    inputs,
    modal_files,
    orders,
    real_outputs,
    rigid_bodies,
)

LARGE = 1e9  # N or N m: responses exceed all other accelerations and reactions by orders of magnitude
ROUNDING = 1e4 * EPS  # of a response, against the largest of its kind: the equations' condition times a few digits
# Of a torque on the slender beam about its axis the joints take up 1 - 2e-7: the rounding of what they leave is larger.
CANCELLATION = {"SpinUpBeam": 1e3}
CERTAIN = 1e-6  # a dependency is beyond doubt above this fraction of the largest response of its kind


def full_inertias(fmu: Fmu) -> dict[str, float]:
    """Inertia matrices without any zero, so that no dependency hides behind a symmetry."""
    rng = np.random.default_rng(5)
    settings = {}
    for body in rigid_bodies(fmu):
        moments = np.array([float(fmu.variables[f"{body}.inertia.{m}"].start) for m in ("xx", "yy", "zz")])
        trace = moments.sum()
        for name, value in zip(("xx", "yy", "zz"), moments + 0.2 * trace, strict=True):
            settings[f"{body}.inertia.{name}"] = value
        for name, value in zip(("xy", "xz", "yz"), rng.uniform(0.02, 0.1, 3) * trace, strict=True):
            settings[f"{body}.inertia.{name}"] = value
    return settings


@cache
def without_symmetry(model: str) -> Fmu:
    """An FMU whose modal data, if it has some, are those of nodes and modes pushed aside by a tenth of their size."""
    fmu = Fmu.of_model(model)
    rng = np.random.default_rng(7)
    for path in modal_files(fmu):
        data = json.loads(path.read_text())
        for key in ("X", "Phi"):
            values = np.array(data[key])
            data[key] = (values + 0.1 * np.abs(values).max() * rng.uniform(-1, 1, values.shape)).tolist()
        data.pop("frequencies")
        path.write_text(json.dumps(data))
    return fmu


@pytest.fixture
def general() -> Iterator[Callable[[str], Instance]]:
    """As `new`, of FMUs with modal data without symmetry."""
    made: list[Instance] = []

    def make(model: str) -> Instance:
        made.append(Instance(without_symmetry(model)))
        return made[-1]

    yield make
    for instance in made:
        instance.free()


def points_of_a_motion(instance: Instance, count: int = 4) -> Iterator[Instance]:
    """Moves on under arbitrary inputs and stops `count` times, with all inputs at zero."""
    rng, names = np.random.default_rng(11), inputs(instance.fmu)
    H = 0.05 * float(instance.fmu.description.defaultExperiment.stopTime) / count
    for _ in range(count):
        instance.set(dict(zip(names, rng.uniform(-1, 1, len(names)), strict=True)))
        instance.step(H)
        instance.set(dict.fromkeys(names, 0.0))
        yield instance


def slopes_of_differences(instance: Instance, outputs: list[str]) -> np.ndarray:
    """d(outputs)/d(inputs) at the present point by central differences; rows are outputs."""
    columns = []
    for name in inputs(instance.fmu):
        values = []
        for sign in (1.0, -1.0):
            instance.set({name: sign * LARGE})
            values.append(instance.reals(outputs))
        instance.set({name: 0.0})
        columns.append((values[0] - values[1]) / (2 * LARGE))
    return np.array(columns).T


def largest_of_kind(fmu: Fmu, outputs: list[str], slopes: np.ndarray) -> np.ndarray:
    """For every slope the largest |slope| among outputs of its unit and inputs of its unit.

    Unless these are nothing but rounding of all slopes that compare with them, for example accelerations due to forces
    that the joints take up: then the largest of those counts, in their unit. A length makes forces of torques and
    linear accelerations of angular ones.
    """
    rows, columns = (np.array([fmu.variables[name].unit for name in names]) for names in (outputs, inputs(fmu)))
    scale = np.zeros_like(slopes)
    for row in set(rows):
        for column in set(columns):
            block = np.ix_(rows == row, columns == column)
            scale[block] = np.abs(slopes[block]).max()
    length = float(fmu.variables[f"{bodies(fmu)[0]}.position[1]"].declaredType.nominal or 1.0)
    factors = np.outer(
        [{"rad/s2": length, "N.m": 1 / length}.get(u, 1.0) for u in rows],
        [{"N.m": length}.get(u, 1.0) for u in columns],
    )
    comparable = np.array([{"rad/s2": "m/s2", "N.m": "N"}.get(u, u) for u in rows])
    largest = np.array([(factors * np.abs(slopes))[comparable == u].max() for u in comparable])[:, None] / factors
    return np.where(scale < CERTAIN**1.5 * largest, largest, scale)


def declared_dependencies(fmu: Fmu) -> dict[str, set[str]]:
    return {unknown.variable.name: {v.name for v in unknown.dependencies} for unknown in fmu.description.outputs}


def test_declared_dependencies_are_the_true_ones(general, model):
    instance = general(model)
    fmu = instance.fmu
    instance.start(full_inertias(fmu))
    outputs, names = real_outputs(fmu), inputs(fmu)
    largest = np.zeros((len(outputs), len(names)))
    for point in points_of_a_motion(instance):
        slopes = slopes_of_differences(point, outputs)
        scale = largest_of_kind(fmu, outputs, slopes)
        largest = np.maximum(largest, np.divide(np.abs(slopes), scale, where=scale > 0, out=np.zeros_like(scale)))
    assert not ((largest > ROUNDING) & (largest < CERTAIN)).any(), "neither rounding nor a dependency"
    declared = declared_dependencies(fmu)
    missing, superfluous = {}, {}
    for output, row in zip(outputs, largest, strict=True):
        found = {name for name, value in zip(names, row, strict=True) if value >= CERTAIN}
        if found - declared[output]:
            missing[output] = sorted(found - declared[output])
        if declared[output] - found:
            superfluous[output] = sorted(declared[output] - found)
    assert (missing, superfluous) == ({}, {})


def test_counters_depend_on_no_input(new, model):
    instance = new(model).start()
    names = counters(instance.fmu)
    assert len(names) == 4
    instance.step(1e-3)
    before = [instance.integer(name) for name in names]
    instance.set(dict.fromkeys(inputs(instance.fmu), 1.0))
    instance.outputs()
    assert [instance.integer(name) for name in names] == before


# --- directional derivatives -----------------------------------------------------------------------------------------


def test_directional_derivatives_are_those_of_differences(new, model):
    instance = new(model)
    fmu = instance.fmu
    instance.start(full_inertias(fmu))
    outputs, names = real_outputs(fmu), inputs(fmu)
    rng = np.random.default_rng(3)
    for point in points_of_a_motion(instance):
        slopes = slopes_of_differences(point, outputs)
        scale = largest_of_kind(fmu, outputs, slopes)
        single = np.array([point.directional_derivatives(outputs, {name: 1.0}) for name in names]).T
        rounding = ROUNDING * CANCELLATION.get(model, 1.0)
        assert (np.abs(single - slopes) <= rounding * scale).all()
        direction = dict(zip(names, rng.uniform(-1, 1, len(names)), strict=True))
        combined = point.directional_derivatives(outputs, direction)
        assert (np.abs(combined - single @ list(direction.values())) <= rounding * scale.sum(axis=1)).all()
        assert (point.directional_derivatives(outputs, {}) == 0.0).all()


def test_directional_derivatives_exist_during_initialization_and_after_the_end(new, model):
    """And asking changes nothing."""
    instance, other = new(model), new(model).start()
    outputs, direction = real_outputs(instance.fmu), dict.fromkeys(inputs(instance.fmu), 1.0)
    instance.slave.enterInitializationMode()
    first = instance.directional_derivatives(outputs, direction)
    assert np.abs(first).max() > 0
    instance.slave.exitInitializationMode()
    np.testing.assert_array_equal(instance.directional_derivatives(outputs, direction), first)
    for each in (instance, other):
        each.step(1e-3)
    np.testing.assert_array_equal(instance.outputs(), other.outputs())
    last = instance.directional_derivatives(outputs, direction)
    instance.slave.terminate()
    np.testing.assert_array_equal(instance.directional_derivatives(outputs, direction), last)


# --- output derivatives ----------------------------------------------------------------------------------------------


def derivative_and_difference(
    instance: Instance, time: float, delta: float, step: float, rates: Mapping[str, float]
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Output derivatives at `time`, the difference of outputs over ± delta around it, and the rounding in that."""
    outputs, values = real_outputs(instance.fmu), []
    instance.start(full_inertias(instance.fmu) | {"integrator.stepSize": step})
    for H in (time - delta, delta, delta):
        instance.set_input_derivatives(1, rates)
        if len(values) == 2:
            derivative = instance.output_derivatives(outputs)
        instance.step(H)
        values.append(instance.reals(outputs))
    return derivative, (values[2] - values[0]) / (2 * delta), 16 * EPS * np.abs(values[1]) / delta


PREVENTED = {"SpinUpBeam": re.compile(r".*\.angularAcceleration\[[12]\]")}
"""Outputs that the joints keep at zero; what cancels is so large that rounding exceeds the test's figures."""


def largest_by_unit(fmu: Fmu, values: np.ndarray) -> dict[str, float]:
    names = real_outputs(fmu)
    prevented = PREVENTED.get(fmu.name, re.compile("(?!)"))
    units = np.array(["" if prevented.fullmatch(name) else fmu.variables[name].unit for name in names])
    return {unit: np.abs(values[units == unit]).max() for unit in sorted(set(units) - {""})}


@pytest.mark.parametrize("moving", [False, True], ids=["inputs at rest", "inputs in motion"])
def test_output_derivatives_are_those_of_the_motion(new, model, moving):
    """A difference over ± delta is wrong by O(delta²), its extrapolation to delta = 0 by O(delta⁴).

    The internal step is so small that the differences show nothing of the integrator's error.
    """
    probe = new(model)
    fmu, scale = probe.fmu, fastest_rotation(probe.start())
    rates = {name: 1.0 + 0.1 * i if moving else 0.0 for i, name in enumerate(inputs(fmu))}  # N/s, N m/s
    delta = 0.02 / scale
    (derivative, coarse, _), (_, fine, rounding) = (
        derivative_and_difference(new(model), 0.5 / scale, d, delta / 200, rates) for d in (delta, delta / 2)
    )
    sizes = largest_by_unit(fmu, derivative)
    errors = [largest_by_unit(fmu, difference - derivative) for difference in (coarse, fine)]
    extrapolated = largest_by_unit(fmu, (4 * fine - coarse) / 3 - derivative)
    noise = largest_by_unit(fmu, CANCELLATION.get(model, 1.0) * rounding)
    largest = max(sizes.values())
    if largest == 0.0:
        assert not moving
        pytest.skip("at rest")
    for unit, size in sizes.items():
        if size <= 1e-9 * largest:  # rounding of accelerations that joints prevent
            assert errors[0][unit] <= 1e-8 * largest, unit
            continue
        if errors[1][unit] > 100 * noise[unit]:
            assert orders([e[unit] for e in errors])[0] == pytest.approx(2.0, abs=0.1), unit
        # (delta · rotation)⁴ = 1.6e-7, times a small factor
        assert extrapolated[unit] <= 1e-6 * size + noise[unit], unit


def test_rotation_vector_has_a_derivative_where_it_jumps(new):
    """At half a turn it jumps to its negative; its rate, here the spin of the top, does not."""
    for short_of_half_a_turn in (1e-3, 5e-5, 0.0):
        half = (math.pi - short_of_half_a_turn) / 2
        instance = new("HeavyTop").start({"top.initialQuaternion": (math.cos(half), 0, math.sin(half), 0)})
        psi, omega = instance.get("top.rotationVector"), instance.get("top.angularVelocity")
        rate = instance.output_derivatives([f"top.rotationVector[{i}]" for i in (1, 2, 3)])
        assert np.linalg.norm(psi) == pytest.approx(math.pi, abs=2e-3)
        # d|psi|/dt = psi·omega/|psi|: the component along the axis of rotation is that of the angular velocity.
        assert rate @ psi == pytest.approx(omega @ psi, rel=1e-13)
        assert np.linalg.norm(rate) <= 1.6 * np.linalg.norm(omega)  # |T⁻¹| <= pi/2 up to half a turn


def test_output_derivatives_follow_a_change_of_inputs_at_once(new, model):
    """Velocities have the accelerations as derivatives, whatever the inputs have just been set to."""
    instance = new(model).start()
    fmu = instance.fmu
    instance.step(1e-3)
    for value in (0.0, 3.0):
        instance.set(dict.fromkeys(inputs(fmu), value))
        for body in bodies(fmu):
            for motion, rate in (("velocity", "acceleration"), ("angularVelocity", "angularAcceleration")):
                expected = instance.get(f"{body}.{rate}")
                found = instance.output_derivatives(instance.names(f"{body}.{motion}"))
                # A difference of velocities over 1e-4 / rotation: rounding of the velocities times 1e4.
                size = np.linalg.norm(instance.get(f"{body}.{motion}")) * fastest_rotation(instance)
                np.testing.assert_allclose(found, expected, rtol=1e-7, atol=4e4 * EPS * max(1.0, size))
