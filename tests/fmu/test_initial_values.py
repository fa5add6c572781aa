"""What a user sets is where a mechanism starts; what is not set gives way, and the log says what did."""

import math
import re

import numpy as np
import pytest

from sigmafmu import _core

from .helpers import EPS, ERROR, OK, assert_same_bits, owners, parameters

HALF = math.sqrt(0.5)
KINDS = ("Position", "Quaternion", "Velocity", "AngularVelocity", "Modal", "ModalRate")
JOINT_KINDS = {  # initial value: output
    "initialAngle": "angle",
    "initialAngularRate": "angularRate",
    "initialDisplacement": "displacement",
    "initialRate": "rate",
}


def initial_values(fmu) -> dict[str, str]:
    """Each parameter that is an initial value, and the output that shows it."""
    result = {}
    for v in parameters(fmu, "fixed"):
        owner, name = v.name.rsplit(".", 1)
        if name in JOINT_KINDS:
            result[v.name] = f"{owner}.{JOINT_KINDS[name]}"
        elif re.fullmatch(rf"initial({'|'.join(KINDS)})\[\d\]", name):
            result[v.name] = f"{owner}.{name[7].lower()}{name[8:]}"
    return result


def refusal(new, model, settings) -> str:
    """The message of a start that must fail."""
    instance = new(model)
    instance.set(settings)
    instance.slave.setupExperiment()
    instance.slave.enterInitializationMode()
    message = instance.refusal(instance.slave.exitInitializationMode)
    assert message.status == "error"
    return message.text


def assert_joints_closed(instance) -> None:
    assert instance.get("constraint.positionResidual") <= 1e-14
    assert instance.get("constraint.velocityResidual") <= 1e-13


# --- nothing set, or everything to its start value --------------------------------------------------------------------


def test_setting_everything_to_its_start_value_is_setting_nothing(new, model):
    """As masters do that set every parameter: the same bits, and no warning."""
    instance, untouched = new(model), new(model).start()
    everything = {v.name: float(v.start) for v in parameters(instance.fmu, "fixed") if v.type == "Real"}
    assert set(initial_values(instance.fmu)) <= set(everything)
    instance.start(everything)
    H = float(instance.fmu.description.defaultExperiment.stepSize)
    assert_same_bits(instance.trajectory(H, 20), untouched.trajectory(H, 20))
    assert instance.messages == untouched.messages == []


def test_start_values_are_those_of_the_start(new, model):
    """What the XML says of joints is where the mechanism starts when nothing is set; what it says of bodies, where that
    satisfies the joints, as in the benchmarks."""
    instance = new(model).start()
    for parameter, output in initial_values(instance.fmu).items():
        if not is_of_a_joint(parameter) and model not in _core.mechanisms():
            continue
        start = float(instance.fmu.variables[parameter].start)
        assert instance.get(output) == pytest.approx(start, rel=1e-11, abs=1e-11), parameter


def is_of_a_joint(parameter: str) -> bool:
    return parameter.endswith((".initialAngle", ".initialAngularRate", ".initialDisplacement", ".initialRate"))


def test_start_values_of_joints_are_free_of_rounding(fmu):
    starts = {v.name: v.start for v in fmu("SliderCrank").description.modelVariables}
    assert [starts[f"crankPivot.{n}"] for n in ("initialAngle", "initialAngularRate")] == ["0", "6"]
    assert [starts[f"guide.{n}"] for n in ("initialDisplacement", "initialRate")] == ["0.2", "0.24"]


def test_a_value_set_back_to_its_start_value_is_not_set(new):
    instance, untouched = new("SliderCrank"), new("SliderCrank").start()
    for name, value, back in (
        ("crank.initialAngularVelocity[1]", 20.0, 6.0),
        ("crankPivot.initialAngle", 1.0, 0.0),
        ("slider.initialPosition[2]", 1.0, -0.0),
    ):
        instance.set({name: value})
        instance.set({name: back})
    instance.start()
    assert_same_bits(instance.trajectory(1e-3, 10), untouched.trajectory(1e-3, 10))


# --- one value set ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("change", [0.05, -0.3])
def test_each_initial_value_is_kept_or_refused_by_name(new, model, change):
    """The start shows it to rounding, with closed joints; or the one message names it."""
    instance = new(model)
    kept = refused = 0
    for parameter, output in initial_values(instance.fmu).items():
        value = float(instance.fmu.variables[parameter].start) + change
        instance.reset().messages.clear()
        instance.set({parameter: value})
        instance.slave.setupExperiment()
        instance.slave.enterInitializationMode()
        if instance.status("fmi2ExitInitializationMode") == OK:
            kept += 1
            assert_joints_closed(instance)
            if "Quaternion" in parameter:  # normalized, and held as a whole
                vector = parameter.split("[")[0]
                expected = np.array([float(instance.fmu.variables[f"{vector}[{i}]"].start) for i in (1, 2, 3, 4)])
                expected[int(parameter[-2]) - 1] = value
                actual = instance.get(f"{output.split('[')[0]}")
                np.testing.assert_allclose(actual, expected / np.linalg.norm(expected), rtol=0, atol=4 * EPS)
            else:
                assert instance.get(output) == pytest.approx(value, rel=8 * EPS, abs=4 * EPS), parameter
            assert all(
                m.status == "warning" and m.text.startswith("Initial values gave way") for m in instance.messages
            )
            assert len(instance.messages) <= 1
        else:
            refused += 1
            (message,) = instance.messages
            assert message.status == "error"
            assert message.text.startswith(parameter.split("[")[0] if "Quaternion" in parameter else parameter), message
            assert re.search(r" contradicts joints? .* by \S+ (m|rad|m/s|rad/s)\.$", message.text), message
    assert kept > 0
    assert (refused > 0) == bool(owners(instance.fmu, ".reactionForce[1]"))


@pytest.mark.parametrize("rate", [0.0, 6.0, 10.0, 20.0])
def test_the_crank_starts_at_the_rate_that_was_set(new, rate):
    """One number starts the whole mechanism, whether it is the body's or the joint's."""
    for name in ("crank.initialAngularVelocity[1]", "crankPivot.initialAngularRate"):
        instance = new("SliderCrank").start({name: rate})
        assert instance.get("crank.angularVelocity[1]") == pytest.approx(rate, rel=4 * EPS, abs=EPS)
        assert instance.get("crankPivot.angularRate") == pytest.approx(rate, rel=4 * EPS, abs=EPS)
        assert instance.get("guide.rate") == pytest.approx(0.04 * rate, rel=16 * EPS, abs=EPS)
        assert_joints_closed(instance)


@pytest.mark.parametrize(("set_to", "expected"), [((HALF, HALF, 0, 0), (0, 0, 1)), ((HALF, 0, 0, -HALF), (1, 0, 0))])
def test_the_top_starts_as_it_was_turned(new, set_to, expected):
    """Its centre of mass follows; its angular velocity stays in body axes, and the velocity follows that."""
    instance = new("HeavyTop").start({"top.initialQuaternion": set_to})
    np.testing.assert_allclose(instance.get("top.quaternion"), set_to, rtol=0, atol=2 * EPS)
    np.testing.assert_allclose(instance.get("top.position"), expected, rtol=0, atol=4 * EPS)
    assert instance.get("top.angularVelocity").tolist() == [0, 150, -4.61538]
    assert np.linalg.norm(instance.get("top.velocity")) == pytest.approx(4.61538, rel=1e-14)
    assert_joints_closed(instance)


@pytest.mark.parametrize("height", [-0.9, 0.0, 0.6, 0.9])
def test_a_component_of_the_position_turns_the_top(new, height):
    """Also where its derivative by every turn vanishes, as at the start."""
    instance = new("HeavyTop").start({"top.initialPosition[2]": height})
    assert instance.get("top.position[2]") == height
    assert np.linalg.norm(instance.get("top.position")) == pytest.approx(1.0, rel=1e-14)


def test_elements_of_one_vector_are_held_one_by_one(new):
    """The velocity along the crank's circle is set; the angular velocity gives way to it and to nothing else."""
    instance = new("HeavyTop").start({"top.initialVelocity[1]": 1.0})
    np.testing.assert_allclose(instance.get("top.velocity"), [1, 0, 0], rtol=0, atol=1e-14)
    np.testing.assert_allclose(instance.get("top.angularVelocity"), [0, 150, -1], rtol=0, atol=1e-13)


# --- joints -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("angle", [0.5, -1.0, 3.0, 7.0, -20.0, 100.0])
@pytest.mark.parametrize("model", ["SliderCrank", "FlexibleSliderCrank"])
def test_the_angle_of_the_crank_sets_the_mechanism(new, model, angle):
    """It counts turns; the rest follows on the same branch, and the unset rate stays 6 rad/s."""
    instance = new(model).start({"crankPivot.initialAngle": angle})
    assert instance.get("crankPivot.angle") == pytest.approx(angle, rel=4 * EPS)
    assert instance.get("crankPivot.angularRate") == pytest.approx(6.0, rel=16 * EPS)
    y, z = 0.1 - 0.08 * math.sin(angle), 0.12 + 0.08 * math.cos(angle)  # crank pin
    assert instance.get("guide.displacement") == pytest.approx(math.sqrt(0.09 - y**2 - z**2), rel=1e-13)
    assert_joints_closed(instance)
    instance.step(1e-3)
    assert instance.get("crankPivot.angle") == pytest.approx(angle + 6e-3, abs=1e-4), "turns are kept"


def test_the_displacement_of_the_slider_sets_the_mechanism(new):
    instance = new("SliderCrank").start({"guide.initialDisplacement": 0.25, "guide.initialRate": -0.5})
    assert instance.get("guide.displacement") == pytest.approx(0.25, rel=4 * EPS)
    assert instance.get("guide.rate") == pytest.approx(-0.5, rel=16 * EPS)
    angle = instance.get("crankPivot.angle")
    y, z = 0.1 - 0.08 * math.sin(angle), 0.12 + 0.08 * math.cos(angle)
    assert math.sqrt(0.09 - y**2 - z**2) == pytest.approx(0.25, rel=1e-13)
    assert_joints_closed(instance)


def test_modes_give_way_to_nothing_that_a_rigid_motion_can_do(new):
    instance = new("SpinUpBeam").start({"hubPivot.initialAngle": 2.0, "hubPivot.initialAngularRate": 0.5})
    assert instance.get("beam.modal").tolist() == instance.get("beam.modalRate").tolist() == [0, 0, 0]
    np.testing.assert_allclose(instance.get("beam.angularVelocity"), [0, 0, 0.5], rtol=0, atol=4 * EPS)


def test_a_value_may_be_set_twice_in_different_words(new):
    turned = (math.cos(0.5), math.sin(0.5), 0, 0)
    instance = new("SliderCrank").start({"crankPivot.initialAngle": 1.0, "crank.initialQuaternion": turned})
    assert instance.get("crankPivot.angle") == pytest.approx(1.0, rel=4 * EPS)
    instance = new("SliderCrank").start({"crankPivot.initialAngularRate": 9, "crank.initialAngularVelocity[1]": 9})
    assert instance.get("crankPivot.angularRate") == pytest.approx(9.0, rel=4 * EPS)


def test_a_run_can_start_where_another_one_is(new, model):
    """Every initial value set to what the outputs show at some time."""
    first = new(model).start()
    first.steps(float(first.fmu.description.defaultExperiment.stepSize), 20)
    shown = {parameter: first.get(output) for parameter, output in initial_values(first.fmu).items()}
    second = new(model).start(shown)
    for parameter, output in initial_values(first.fmu).items():
        assert second.get(output) == pytest.approx(shown[parameter], rel=1e-14, abs=1e-12), parameter


# --- contradictions ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("model", "settings", "expected"),
    [
        (
            "HeavyTop",
            {"top.initialPosition[2]": 1.1},
            "top.initialPosition[2] = 1.1 m contradicts joint pivot by 0.1 m.",
        ),
        (
            "HeavyTop",
            {"top.initialVelocity[2]": 1.0},
            "top.initialVelocity[2] = 1 m/s contradicts joint pivot by 1 m/s.",
        ),
        (
            "HeavyTop",
            {"top.initialQuaternion": (HALF, HALF, 0, 0), "top.initialPosition[1]": 0.25},
            "top.initialPosition[1] = 0.25 m and top.initialQuaternion contradict joint pivot by 0.25 m.",
        ),
        (
            "SliderCrank",
            {"crank.initialAngularVelocity[2]": 1.0},
            "crank.initialAngularVelocity[2] = 1 rad/s contradicts joint crankPivot by 1 rad/s.",
        ),
        (
            "SliderCrank",
            {"crank.initialAngularVelocity[1]": 10.0, "crankPivot.initialAngularRate": 11.0},
            "crank.initialAngularVelocity[1] = 10 rad/s and crankPivot.initialAngularRate = 11 rad/s contradict each "
            "other by 1 rad/s.",
        ),
        (
            "SliderCrank",
            {"crankPivot.initialAngle": 0.5, "crank.initialQuaternion": (math.cos(0.5), math.sin(0.5), 0, 0)},
            "crank.initialQuaternion and crankPivot.initialAngle = 0.5 rad contradict each other by 0.5 rad.",
        ),
    ],
)
def test_contradictions_are_named_with_their_size(new, model, settings, expected):
    assert refusal(new, model, settings) == expected


def test_the_gap_of_a_slider_out_of_reach_is_the_true_one(new):
    text = refusal(new, "SliderCrank", {"guide.initialDisplacement": 0.3})
    loop = "joints crankPivot, crankPin, wristPin and guide"
    assert text.startswith(f"guide.initialDisplacement = 0.3 m contradicts {loop} by 0.0098")
    farthest = math.sqrt(0.09 - (math.hypot(0.1, 0.12) - 0.08) ** 2)
    assert float(re.search(r"by (\S+) m\.", text)[1]) == pytest.approx(0.3 - farthest, rel=2e-2)


# --- what the log says ------------------------------------------------------------------------------------------------


def test_what_gave_way_is_told_once_with_before_and_after(new):
    instance = new("HeavyTop").start({"top.initialQuaternion": (HALF, HALF, 0, 0)})
    (message,) = instance.messages
    assert (message.status, message.category) == ("warning", "logStatusWarning")
    assert (
        message.text == "Initial values gave way to those that were set: top.initialPosition (0, 1, 0) -> (0, 0, 1) m."
    )


def test_a_long_list_is_cut(new):
    instance = new("SliderCrank").start({"crankPivot.initialAngularRate": 10.0})
    (message,) = instance.messages
    assert message.text.startswith(
        "Initial values gave way to those that were set: wristPin.initialAngularRate1 1.07331 -> 1.78885 rad/s, "
        "wristPin.initialAngularRate2 -1.92 -> -3.2 rad/s, guide.initialRate 0.24 -> 0.4 m/s, "
        "crank.initialVelocity (0, -0.24, 0) -> (0, -0.4, 0) m/s"
    )
    assert message.text.endswith(" and 4 more.")


def test_nothing_is_told_where_nothing_gave_way(new):
    assert new("HighSpeedRotor").start({"rotor.initialAngularVelocity[1]": 2.0}).messages == []
    assert new("FlexiblePendulum").start({"beam.initialModal[1]": 0.01}).messages == []


# --- life -------------------------------------------------------------------------------------------------------------


def test_initial_values_can_be_tried_in_initialization_mode(new):
    """Read, change, read again: each reading is the start that the values make; the warning comes at the end."""
    instance = new("SliderCrank")
    instance.slave.setupExperiment()
    instance.slave.enterInitializationMode()
    for rate in (10.0, 6.0, 20.0):
        instance.set({"crankPivot.initialAngularRate": rate})
        assert instance.get("crank.angularVelocity[1]") == pytest.approx(rate, rel=4 * EPS)
        assert instance.messages == []
    instance.slave.exitInitializationMode()
    assert len(instance.messages) == 1


def test_states_carry_what_was_set(new):
    """A state saved before the start brings its initial values back; a reset forgets them."""
    settings = {"crankPivot.initialAngle": 7.0, "crank.initialAngularVelocity[1]": 9.0}
    instance, expected = new("SliderCrank"), new("SliderCrank").start(settings).trajectory(1e-3, 10)
    instance.set(settings)
    state = instance.save()
    data = instance.slave.serializeFMUstate(state)
    untouched = instance.reset().start().trajectory(1e-3, 10)
    assert_same_bits(untouched, new("SliderCrank").start().trajectory(1e-3, 10))
    for saved in (state, instance.slave.deSerializeFMUstate(data)):
        instance.reset().restore(saved)
        assert_same_bits(instance.start().trajectory(1e-3, 10), expected)
        instance.slave.freeFMUstate(saved)
    assert instance.integer("integrator.steps") > 0
    assert instance.status("fmi2EnterInitializationMode") == ERROR


def test_the_order_of_setting_does_not_matter(new):
    settings = {"crankPivot.initialAngle": 0.4, "rod.initialAngularVelocity[1]": 2.0, "crank.initialPosition[1]": 0.0}
    one = new("SliderCrank").start(settings).trajectory(1e-3, 5)
    other = new("SliderCrank")
    for name in reversed(settings):
        other.set({name: settings[name]})
    assert_same_bits(other.start().trajectory(1e-3, 5), one)
