"""Communication steps: how they are split, which are refused, and what is left when one cannot be finished."""

import itertools
import math

import numpy as np
import pytest

from sigmafmu import _core

from .helpers import DISCARD, ERROR, OK, Instance, assert_same_bits, inputs, orders, real_outputs


def internal_steps(instance: Instance, H: float) -> int:
    before = instance.integer("integrator.steps")
    instance.step(H)
    return instance.integer("integrator.steps") - before


# --- n = ceil(H / stepSize) ------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("ratio", "expected"),
    [(1e-3, 1), (0.5, 1), (1.0, 1), (1.001, 2), (1.5, 2), (2.0, 2), (2.000001, 3), (9.999999, 10), (17.2, 18)],
)
def test_communication_step_is_split_into_the_fewest_equal_steps(new, model, ratio, expected):
    instance = new(model)
    h = float(instance.fmu.variables["integrator.stepSize"].start)
    instance.start()
    assert [internal_steps(instance, ratio * h) for _ in range(3)] == [expected] * 3
    assert instance.integer("integrator.retries") == 0


@pytest.mark.parametrize("h", [1e-3, 2.5e-4, 1e-3 / 3, 0.1 / 7, 1e-3 * math.pi])
def test_multiples_of_the_step_size_are_recognized(new, h):
    """k h as product, as sum and as difference of times: rounding never costs an additional step."""
    instance = new("HeavyTop").start(
        {"integrator.stepSize": h, "gravity[3]": 0.0, "top.initialAngularVelocity": (0,) * 3}
    )
    summed = 0.0
    for k in range(1, 121):
        summed += h
        for H in (k * h, summed, (1000 + k) * h - 1000 * h):
            assert internal_steps(instance, H) == k


def test_large_multiples_of_the_step_size_are_recognized(new):
    instance = new("HighSpeedRotor").start({"integrator.stepSize": 1e-6, "rotor.initialAngularVelocity": (0,) * 3})
    for H, expected in ((0.1, 100_000), (0.1 + 1e-7, 100_001), (sum([1e-3] * 100), 100_000)):
        assert internal_steps(instance, H) == expected


def test_step_ends_exactly_where_the_master_says(new, model):
    """t + H to the last bit, not a sum of internal steps."""
    instance, t = new(model).start(), 0.0
    for H in (0.1, 0.2 / 3, 1e-3 * math.pi, 1e-7):
        instance.slave.doStep(t, H)
        t += H
        assert instance.last_successful_time() == t


# --- communication points --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("H", [1e-3, 1e-4, 0.1 / 7])
def test_accumulated_communication_points_are_accepted(new, H):
    """A master that adds up H is off by some 1e-12 s in the end."""
    accumulating = new("HeavyTop").start({"integrator.stepSize": 0.1})
    t = 0.0
    for _ in range(5000):
        accumulating.slave.doStep(t, H)
        t += H
    assert t != 5000 * H
    assert accumulating.integer("integrator.steps") == 5000
    multiplying = new("HeavyTop").start({"integrator.stepSize": 0.1})
    for i in range(100):
        multiplying.slave.doStep(i * H, H)
    multiplying.slave.doStep(100 * H * (1 + 4e-16), H)


@pytest.mark.parametrize("wrong", [2e-3, 0.0, -1e-3, 1.01e-3, 1e300])
def test_wrong_communication_point_is_refused(new, wrong):
    instance, other = (new("HeavyTop").start() for _ in range(2))
    for each in (instance, other):
        each.step(1e-3)
    message = instance.refusal(instance.slave.doStep, wrong, 1e-3)
    assert message.status == "error"
    assert message.text == f"The communication point is {wrong:.17g} s, but the FMU is at 0.001 s."
    for each in (instance, other):
        each.step(1e-3)
    assert_same_bits(instance.outputs(), other.outputs())


@pytest.mark.parametrize("H", [math.nan, math.inf, -math.inf, -1e-3])
def test_impossible_step_sizes_are_refused(new, H):
    instance = new("HeavyTop").start()
    message = instance.refusal(instance.slave.doStep, 0.0, H)
    assert message.status == "error"
    assert "is not possible; both must be finite, the step not negative" in message.text
    assert instance.refusal(instance.slave.doStep, math.nan, 1e-3).status == "error"
    instance.step(1e-3)


def test_absurdly_long_steps_are_refused(new):
    """More than 1e9 internal steps would look like a hanging master."""
    instance = new("HeavyTop").start({"integrator.stepSize": 1e-3})
    message = instance.refusal(instance.slave.doStep, 0.0, 1.1e6)
    assert message.text == (
        "The communication step is 1100000 s; with integrator.stepSize 0.001 s at most 1000000 s is allowed."
    )
    instance.step(1e-3)


def test_step_of_length_zero_changes_nothing(new, model):
    instance = new(model).start()
    instance.step(1e-3)
    before = instance.outputs()
    instance.step(0.0)
    assert_same_bits(instance.outputs(), before)
    assert instance.last_successful_time() == 1e-3


def test_stop_time_is_respected(new):
    instance = new("HeavyTop").start(stop_time=0.3)
    instance.step(0.1)
    instance.step(0.1)
    message = instance.refusal(instance.slave.doStep, 0.2, 0.11)
    assert (message.status, "after the stopTime 0.2999" in message.text) == ("error", True)
    assert 0.1 + 0.1 + 0.1 > 0.3
    instance.step(0.1)
    assert instance.refusal(instance.slave.doStep, instance.time, 1e-3).status == "error"


@pytest.mark.parametrize(("start", "stop"), [(1.0, 0.5), (0.0, math.nan), (math.nan, None), (math.inf, None)])
def test_impossible_experiments_are_refused(new, start, stop):
    instance = new("HeavyTop")
    message = instance.refusal(instance.slave.setupExperiment, startTime=start, stopTime=stop)
    assert message.status == "error"
    assert message.text.startswith(("startTime is", "stopTime is"))
    instance.start()


@pytest.mark.parametrize("H", [2.0**-7, 1e-3])
@pytest.mark.parametrize("start_time", [32.0, 86_400.0, 3e7, 1.7e9, -1e5])
def test_start_time_shifts_everything(new, model, start_time, H):
    """Nothing in the mechanisms depends on time, and nothing is a difference of large times: the same bits, in seconds
    since 1970 as well."""
    early, late = new(model).start(), new(model).start(start_time=start_time, stop_time=start_time + 1)
    for instance in (early, late):
        if inputs(instance.fmu):
            instance.set_input_derivatives(1, {inputs(instance.fmu)[0]: 0.5})
    assert_same_bits(early.trajectory(H, 16), late.trajectory(H, 16))
    assert late.last_successful_time() == start_time + 15 * H + H


@pytest.mark.parametrize("start_time", [0.0, 1.7e9])
def test_tolerance_on_communication_points_belongs_to_the_step(new, start_time):
    """1.7e9 s is given to 2.4e-7 s; a point that is wrong by a millisecond or a second is wrong there too."""
    instance = new("HeavyTop").start(start_time=start_time)
    for wrong in (1.0, -1.0, 2e-3, 5e-6):
        message = instance.refusal(instance.slave.doStep, start_time + wrong, 1e-3)
        assert "The communication point is" in message.text
    t = start_time
    for _ in range(1000):  # adding up, as many masters do
        instance.slave.doStep(t, 1e-3)
        t += 1e-3
    instance.slave.doStep(np.nextafter(t, np.inf), 1e-3)


@pytest.mark.parametrize(
    ("sizes", "model", "name", "accuracy"),
    [
        ("one", "SliderCrank", "energy.kinetic", 1e-6),
        ("0.999", "SliderCrank", "energy.total", 1e-5),
        ("0.999", "HeavyTop", "energy.total", 1e-5),
        ("0.9999", "HeavyTop", "energy.total", 1e-5),
        ("0.999", "FlexibleSliderCrank", "energy.total", 1e-4),
        ("log", "HeavyTop", "energy.total", 1e-5),
    ],
)
def test_communication_steps_of_very_different_length(new, sizes, model, name, accuracy):
    """As masters make them that locate events: 200 ms in steps of 1 ms at most, beside equal ones."""
    H, count = 1e-3, 200
    if sizes == "one":
        lengths = np.insert(np.full(count, H), count // 2, 1e-13)
    elif sizes == "log":
        lengths = np.random.default_rng(7).permutation(np.geomspace(1e-6, H, 700))
        lengths *= count * H / lengths.sum()
    else:
        part = float(sizes)
        lengths = np.tile([part * H, (1 - part) * H], count)
    equal, other = new(model).start(), new(model).start()
    equal.steps(H, count)
    for length in lengths:
        other.step(length)
    scale = 1.0 + abs(equal.get("energy.total"))
    assert other.get(name) == pytest.approx(equal.get(name), abs=accuracy * scale)
    for output in real_outputs(equal.fmu):  # accelerations and reactions too, as far as the time is the same
        vector = np.abs(equal.get(output.partition("[")[0])).max() if "[" in output else 0.0
        if output.startswith(("constraint", "integrator")):
            continue
        assert other.get(output) == pytest.approx(equal.get(output), abs=2e-3 * (1 + vector)), output


# --- varying steps ---------------------------------------------------------------------------------------------------

RESTLESS = (1.0, 3.0, 0.7, 0.7, 2.2, 1.4, 0.5, 2.5)  # relative sizes
CALM = (1.0, 1.25) * 4


@pytest.mark.parametrize("model", ["HeavyTop", "HighSpeedRotor", "SliderCrank"])
@pytest.mark.parametrize(
    ("formulation", "pattern"),
    # Index 3 bears no jumps: its multipliers answer to a change of step size with an oscillation that is damped only by
    # a factor ρ∞ a step.
    [("stabilizedIndex2", RESTLESS), ("index2", RESTLESS), ("index3", CALM)],
)
def test_second_order_with_varying_step_sizes(new, model, formulation, pattern):
    """One internal step in each communication step."""
    span = {"HeavyTop": 0.05, "HighSpeedRotor": 3e-4, "SliderCrank": 0.5}[model]
    body = {"HeavyTop": "top", "HighSpeedRotor": "rotor", "SliderCrank": "rod"}[model]

    def run(halvings: int, sizes: tuple[float, ...], formulation: str) -> np.ndarray:
        settings = {"integrator.stepSize": 1.0, "integrator.formulation": formulation}
        settings |= {"integrator.relativeTolerance": 1e-12, "integrator.absoluteTolerance": 1e-12}
        instance = new(model).start(settings)
        parts = np.repeat(np.tile(sizes, 8), 2**halvings)
        times = span * np.concatenate([[0.0], np.cumsum(parts)]) / parts.sum()
        for t0, t1 in itertools.pairwise(times):
            instance.slave.doStep(t0, t1 - t0)
        assert instance.integer("integrator.steps") == len(parts)
        return np.concatenate([instance.get(f"{body}.velocity"), instance.get(f"{body}.angularVelocity")])

    exact = run(7, (1.0,) * 8, "stabilizedIndex2")
    errors = [np.abs(run(k, pattern, formulation) - exact).max() for k in (2, 3, 4)]
    assert orders(errors) == pytest.approx([2.0, 2.0], abs=0.1), errors


# --- steps that fail -------------------------------------------------------------------------------------------------


def cannot_converge(new) -> Instance:
    """Tolerances that one iteration cannot meet: no internal step succeeds."""
    settings = {"integrator.relativeTolerance": 0.0, "integrator.absoluteTolerance": 1e-300}
    settings |= {"integrator.maxNewtonIterations": 1, "integrator.maxHalvings": 1}
    return new("HeavyTop").start(settings)


def test_step_that_cannot_begin_is_discarded(new):
    instance = cannot_converge(new)
    before = instance.outputs()
    message = instance.refusal(instance.slave.doStep, 0.0, 1e-3)
    assert (message.status, message.category) == ("discard", "logStatusDiscard")
    for part in (
        "failed even with a step size of",
        "Newton's method did not converge in 1 iteration,",
        "body top",
        "the last successful time is 0 s.",
    ):
        assert part in message.text
    assert instance.last_successful_time() == 0.0
    names = real_outputs(instance.fmu)
    assert_same_bits(instance.reals(names), before[: len(names)])
    assert instance.integer("integrator.retries") == 1  # maxHalvings
    assert instance.integer("integrator.steps") == 0


def test_step_that_fails_on_its_way_stays_at_the_last_good_time(new):
    """A torque spins the top up until it turns by more than half a turn in the smallest step."""
    instance = new("HeavyTop").start()
    instance.step(0.01)
    instance.set({"top.torque[2]": 1e12})
    message = instance.refusal(instance.slave.doStep, 0.01, 0.01)
    assert message.status == "discard"
    assert "body top would turn by" in message.text
    assert "less than pi is allowed" in message.text
    reached = instance.last_successful_time()
    assert 0.01 < reached < 0.02
    assert f"the last successful time is {reached:.10g} s." in message.text
    # The outputs belong to that time: constant torque about the axis of symmetry, ω = ω₀ + t τ / J.
    assert instance.get("top.angularVelocity[2]") == pytest.approx(150 + (reached - 0.01) * 1e12 / 0.46875, rel=1e-9)
    assert np.isfinite(instance.outputs()).all()
    # The master may go on from there, not from elsewhere.
    instance.set({"top.torque[2]": 0.0})
    assert instance.status("fmi2DoStep", 0.02, 1e-9, 1) == ERROR
    assert instance.status("fmi2DoStep", reached, 1e-9, 1) == OK


def test_forces_beyond_all_numbers_are_discarded(new):
    instance = new("SliderCrank").start()
    instance.set({"crankPivot.motorTorque": 1e300})
    message = instance.refusal(instance.slave.doStep, 0.0, 1e-3)
    assert message.status == "discard"
    assert "the motion of body" in message.text
    assert "is not finite" in message.text
    assert "nan rad" not in message.text
    instance.set({"crank.force": (1e308,) * 3, "rod.force": (1e308,) * 3, "rod.torque": (1e308,) * 3})
    message = instance.refusal(instance.slave.doStep, 0.0, 1e-3)
    assert message.status == "discard"
    assert instance.last_successful_time() == 0.0


def test_the_time_of_a_step_can_be_bounded(new):
    """Without halvings a communication step of n internal steps ends after n · maxNewtonIterations iterations."""
    H, n = 5e-3, 5
    bounds = {"integrator.stepSize": H / n, "integrator.maxNewtonIterations": 1, "integrator.maxHalvings": 0}
    instance = new("SliderCrank").start(bounds)
    message = instance.refusal(instance.slave.doStep, 0.0, H)
    assert message.status == "discard"
    assert "did not converge in 1 iteration" in message.text
    assert instance.integer("integrator.newtonIterations") <= n
    assert instance.integer("integrator.retries") == 0
    instance = new("SliderCrank").start(bounds | {"integrator.maxNewtonIterations": 3})
    free = new("SliderCrank").start({"integrator.stepSize": H / n})
    assert_same_bits(instance.trajectory(H, 20), free.trajectory(H, 20))
    assert instance.integer("integrator.newtonIterations") <= 3 * n * 20


def test_halvings_are_limited_by_their_parameter(new):
    for halvings in range(4):
        instance = new("HeavyTop").start({"integrator.stepSize": 1.0, "integrator.maxHalvings": halvings})
        message = instance.refusal(instance.slave.doStep, 0.0, 1.0)  # 150 rad in a step; 1/8 of it is still too much
        assert f"with a step size of {0.5**halvings:g} s" in message.text
        assert instance.integer("integrator.retries") == halvings


@pytest.mark.parametrize("model", ["HeavyTop", "SliderCrank"])
def test_rollback_after_a_failed_step(new, model):
    """As a master does that tries again with less: bit by bit as if nothing had happened."""
    instance, other = (new(model).start() for _ in range(2))
    for each in (instance, other):
        each.steps(1e-3, 5)
    state = instance.save()
    torque = {"HeavyTop": "top.torque[2]", "SliderCrank": "crankPivot.motorTorque"}[model]
    instance.set({torque: {"HeavyTop": 1e12, "SliderCrank": 1e300}[model]})
    assert instance.status("fmi2DoStep", instance.time, 1e-3, 0) == DISCARD
    instance.restore(state)
    instance.slave.freeFMUstate(state)
    for each in (instance, other):
        each.steps(1e-3, 20)
    assert_same_bits(instance.outputs(), other.outputs())


def test_reset_after_a_failed_step(new):
    instance, fresh = cannot_converge(new), new("HeavyTop").start()
    assert instance.status("fmi2DoStep", 0.0, 1e-3, 1) == DISCARD
    instance.reset().start()
    assert_same_bits(instance.trajectory(1e-3, 20), fresh.trajectory(1e-3, 20))


def test_halved_steps_bring_a_hard_start_to_its_end(new):
    """A torque that spins the top up beyond what one internal step can take: halving copes, and counts it."""
    instance = new("HeavyTop").start({"integrator.stepSize": 2e-3, "gravity[3]": 0.0})
    torque = 1e6  # N m: 20 rad/s in the smallest step needed
    instance.set({"top.torque[2]": torque})
    instance.step(0.004)
    assert instance.integer("integrator.retries") > 0
    assert instance.integer("integrator.steps") > 2
    assert instance.get("top.angularVelocity[2]") == pytest.approx(150 + 0.004 * torque / 0.46875, rel=1e-9)


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        ({"do_step": 0}, "must be addresses"),
        ({"component": 0}, "must be addresses"),
        ({"n": -1}, "n is -1; it must not be negative"),
        ({"period": math.nan}, "period is nan s"),
        ({"period": -1.0}, "period is -1"),
        ({"period": 1e300}, "at most 1e8 s"),
        ({"n": 2**31 - 1, "period": 1.0}, "at most 1e8 s"),
    ],
)
def test_paced_steps_are_refused_before_they_are_counted(arguments, text):
    """A clock counts whole nanoseconds: what it cannot count must not become one of its numbers."""
    with pytest.raises(ValueError, match=text):
        _core.do_steps(**{"do_step": 1, "component": 1, "t0": 0.0, "H": 1e-3, "n": 1, **arguments})
