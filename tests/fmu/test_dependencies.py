"""ModelStructure against the FMU itself: what each output really depends on, and its derivatives.

Inputs act through accelerations and multipliers, which are affine in them: a difference over any length is exact. So the
inputs are set to large values, which lifts a true dependency far above the rounding of everything else.
"""

import numpy as np
import pytest

from sigmafmu.fmu import Fmu

from .helpers import EPS, Instance, bodies, inputs, integer_outputs, orders, real_outputs

POINTS = 4  # of one motion


def full_inertias(fmu: Fmu) -> dict[str, float]:
    """Inertia matrices without any zero, so that no dependency hides behind a symmetry."""
    rng = np.random.default_rng(5)
    settings = {}
    for body in bodies(fmu):
        moments = np.array([float(fmu.variables[f"{body}.inertia.{m}"].start) for m in ("xx", "yy", "zz")])
        trace = moments.sum()
        for name, value in zip(("xx", "yy", "zz"), moments + 0.2 * trace, strict=True):
            settings[f"{body}.inertia.{name}"] = value
        for name, value in zip(("xy", "xz", "yz"), rng.uniform(0.02, 0.1, 3) * trace, strict=True):
            settings[f"{body}.inertia.{name}"] = value
    return settings


def points_of_a_motion(instance: Instance, count: int = POINTS):
    """Moves on under arbitrary inputs and stops `count` times, with all inputs at zero."""
    fmu, rng = instance.fmu, np.random.default_rng(11)
    H = 0.05 * float(fmu.description.defaultExperiment.stopTime) / count
    names = inputs(fmu)
    for _ in range(count):
        instance.set(dict(zip(names, rng.uniform(-1, 1, len(names)), strict=True)))
        instance.step(H)
        instance.set(dict.fromkeys(names, 0.0))
        yield instance


def differences(instance: Instance, outputs: list[str]) -> np.ndarray:
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


LARGE = 1e9  # N or N m; responses exceed all other accelerations and reactions by orders of magnitude


def scale_by_unit(fmu: Fmu, names: list[str], values: np.ndarray) -> np.ndarray:
    """Largest |value| among the rows with the same unit, for each row (and column, if there are any)."""
    units = np.array([fmu.variables[name].unit for name in names])
    scale = np.zeros_like(values)
    for unit in set(units):
        rows = units == unit
        scale[rows] = np.abs(values[rows]).max(axis=0)
    return scale


def declared_dependencies(fmu: Fmu) -> dict[str, set[str]]:
    return {
        unknown.variable.name: {known.name for known in unknown.dependencies}
        for unknown in fmu.description.outputs
    }


def test_declared_dependencies_are_the_true_ones(new, model):
    instance = new(model)
    fmu = instance.fmu
    instance.start(full_inertias(fmu))
    outputs, declared = real_outputs(fmu), declared_dependencies(fmu)
    found: dict[str, set[str]] = {name: set() for name in outputs}
    undecided = []
    for point in points_of_a_motion(instance):
        slopes = differences(point, outputs)
        # Rounding of the response itself (n eps) and of the values at zero input, in the units of a slope.
        rounding = 1e3 * EPS * (scale_by_unit(fmu, outputs, slopes) + np.abs(point.reals(outputs))[:, None] / LARGE)
        for row, column in zip(*np.nonzero(np.abs(slopes) > rounding), strict=True):
            found[outputs[row]].add(inputs(fmu)[column])
            relative = np.abs(slopes[row, column]) / rounding[row, column]
            if relative < 1e3:
                undecided.append((outputs[row], inputs(fmu)[column], relative))
    missing = {name: sorted(found[name] - declared[name]) for name in outputs if found[name] - declared[name]}
    superfluous = {name: sorted(declared[name] - found[name]) for name in outputs if declared[name] - found[name]}
    assert missing == {}, f"not far above rounding: {undecided}"
    assert superfluous == {}


def test_counters_depend_on_no_input(new, model):
    instance = new(model)
    instance.start()
    declared = declared_dependencies(instance.fmu)
    for name in integer_outputs(instance.fmu):
        assert declared[name] == set()
    instance.step(1e-3)
    before = [instance.integer(name) for name in integer_outputs(instance.fmu)]
    instance.set(dict.fromkeys(inputs(instance.fmu), 1.0))
    instance.outputs()
    assert [instance.integer(name) for name in integer_outputs(instance.fmu)] == before


def test_directional_derivatives_are_those_of_central_differences(new, model):
    instance = new(model)
    fmu = instance.fmu
    instance.start(full_inertias(fmu))
    outputs, names = real_outputs(fmu), inputs(fmu)
    rng = np.random.default_rng(3)
    for point in points_of_a_motion(instance):
        slopes = differences(point, outputs)
        scale = scale_by_unit(fmu, outputs, slopes) + np.abs(point.reals(outputs))[:, None] / LARGE
        single = np.array([point.directional_derivatives(outputs, {name: 1.0}) for name in names]).T
        # The equations' matrix amplifies rounding by its condition number, which the largest response shows.
        assert (np.abs(single - slopes) <= 1e4 * EPS * scale.max(axis=1, keepdims=True)).all()
        direction = dict(zip(names, rng.uniform(-1, 1, len(names)), strict=True))
        combined = point.directional_derivatives(outputs, direction)
        tolerance = 1e4 * EPS * scale.max(axis=1) * len(names)
        assert (np.abs(combined - single @ list(direction.values())) <= tolerance).all()
        assert (point.directional_derivatives(outputs, {}) == 0.0).all()


def test_directional_derivatives_exist_during_initialization_and_after_the_end(new, model):
    """And are the same as in step mode: asking changes nothing."""
    instance = new(model)
    outputs, direction = real_outputs(instance.fmu), dict.fromkeys(inputs(instance.fmu), 1.0)
    instance.slave.enterInitializationMode()
    first = instance.directional_derivatives(outputs, direction)
    instance.slave.exitInitializationMode()
    np.testing.assert_array_equal(instance.directional_derivatives(outputs, direction), first)
    instance.slave.terminate()
    np.testing.assert_array_equal(instance.directional_derivatives(outputs, direction), first)
    assert np.abs(first).max() > 0


# --- output derivatives ----------------------------------------------------------------------------------------------


def fastest(instance: Instance) -> float:
    """Largest angular velocity, rad/s, at least 1: the time scale of the motion."""
    speeds = [np.linalg.norm(instance.get(f"{body}.angularVelocity")) for body in bodies(instance.fmu)]
    return max(1.0, *speeds)


def central_difference(new, model: str, delta: float, rates: dict[str, float]) -> tuple[np.ndarray, np.ndarray]:
    """Output derivatives at a point in motion, and the difference of outputs over ± delta around it.

    The internal step is a hundredth of delta: the difference shows the error of the difference formula alone.
    """
    instance = new(model)
    instance.start(full_inertias(instance.fmu) | {"integrator.stepSize": delta / 100})
    outputs = real_outputs(instance.fmu)
    values = []
    for _ in range(2):
        values.append(instance.reals(outputs))
        instance.set_input_derivatives(1, rates)
        if len(values) == 2:
            derivative = instance.output_derivatives(outputs)
        instance.step(delta)
    values.append(instance.reals(outputs))
    return derivative, (values[2] - values[0]) / (2 * delta)


@pytest.mark.parametrize("moving", [False, True], ids=["inputs at rest", "inputs in motion"])
def test_output_derivatives_are_those_of_the_motion(new, model, moving):
    """The difference over ± delta differs from the derivative by O(delta²): a factor 4 per halving."""
    probe = new(model)
    scale = fastest(probe.start())
    rates = {name: 10.0 + i if moving else 0.0 for i, name in enumerate(inputs(probe.fmu))}
    outputs = real_outputs(probe.fmu)
    errors = []
    for delta in (0.02 / scale, 0.01 / scale):
        derivative, difference = central_difference(new, model, delta, rates)
        errors.append(np.abs(derivative - difference))
        size = np.abs(difference)
    coarse, fine = (scale_by_unit(probe.fmu, outputs, e) for e in errors)
    largest = scale_by_unit(probe.fmu, outputs, size)
    # fmi2GetRealOutputDerivatives promises about 1e-8 of the largest value of its kind.
    significant = fine > 1e-8 * largest
    assert (fine <= 2e-4 * largest)[largest > 0].all()
    assert significant.any()
    observed = orders([coarse[significant], fine[significant]])
    assert (np.abs(observed - 2.0) <= 0.1).all(), dict(zip(np.array(outputs)[significant], observed[0], strict=True))
