"""States are physical, named, and continuous in time; angle outputs have no wrap in C."""

import numpy as np
import pytest

import sigmafmu
from sigmafmu import SigmafmuError
from sigmafmu.model import Model

TOP = tuple(f"top.{kind}[{i}]" for kind in ("rotationW", "angularVelocityW") for i in (1, 2, 3))
CRANK = ("crankPivot.angle", "crankPivot.angularRate")


@pytest.mark.parametrize(
    ("model", "names"),
    [
        ("SliderCrank", CRANK),
        ("HeavyTop", TOP),
        (
            "HighSpeedRotor",
            tuple(
                f"rotor.{kind}[{i}]"
                for kind in ("position", "rotationW", "velocity", "angularVelocityW")
                for i in (1, 2, 3)
            ),
        ),
        (
            "SpinUpBeam",
            (
                "hubPivot.angle",
                *(f"beam.modal[{i}]" for i in (1, 2, 3)),
                "hubPivot.angularRate",
                *(f"beam.modalRate[{i}]" for i in (1, 2, 3)),
            ),
        ),
        (
            "FlexibleSliderCrank",
            (
                "crankPivot.angle",
                *(f"rod.modal[{i}]" for i in (1, 2, 3, 4)),
                "crankPivot.angularRate",
                *(f"rod.modalRate[{i}]" for i in (1, 2, 3, 4)),
            ),
        ),
        (
            "FlexiblePendulum",
            (
                *(f"beam.modal[{i}]" for i in (1, 2, 3, 4)),
                *(f"beam.rotationW[{i}]" for i in (1, 2, 3)),
                *(f"beam.modalRate[{i}]" for i in (1, 2, 3, 4)),
                *(f"beam.angularVelocityW[{i}]" for i in (1, 2, 3)),
            ),
        ),
    ],
)
@pytest.mark.parametrize("at", [0.0, 0.01, 0.02])
def test_states_are_the_same_physical_quantities_at_all_times(model, names, at):
    linear = sigmafmu.linearize(model, at)
    assert linear.states == names
    assert linear.derivatives[0] == f"der({names[0]})"
    # the derivative of an integral's state is the state that follows
    assert linear.dx0[: len(names) // 2].tolist() == linear.x0[len(names) // 2 :].tolist()


def test_matrices_are_continuous_along_the_motion():
    """The crank's angle and rotation vector wrap, but no entry jumps: changes shrink with the distance of times."""
    outputs = ["*.angle", "guide.*", "crank.rotationVector", "rod.quaternion"]

    def largest_changes(count):
        models = [sigmafmu.linearize("SliderCrank", t, outputs=outputs) for t in np.linspace(0.27, 0.34, count)]
        return np.array([np.abs(np.diff([getattr(m, key) for m in models], axis=0)).max() for key in "ABC"])

    assert (largest_changes(29) < 0.7 * largest_changes(15)).all()


@pytest.mark.parametrize("at", [0.3035, 0.3036, 0.3037, 1.0, 2.0])
def test_angle_outputs_have_no_wrap(at):
    outputs = ["crankPivot.angle", "crankPivot.angularRate"]
    linear = sigmafmu.linearize("SliderCrank", at, outputs=outputs)
    np.testing.assert_allclose(linear.C, np.eye(2), atol=1e-10)


def test_hanging_position_has_no_wrap():
    hanging = sigmafmu.trim("SliderCrank", 0.3)
    linear = sigmafmu.linearize(hanging, outputs=["crankPivot.angle"])
    assert abs(linear.x0[0]) == pytest.approx(np.pi, abs=1e-9)
    np.testing.assert_allclose(linear.C, [[1.0, 0.0]], atol=1e-10)


@pytest.mark.parametrize("short", [0.0, 1e-9, 1e-3])
def test_rotation_vectors_have_no_jump_at_half_a_turn(short):
    """About the rotor's axis the vector changes as the rotation does; at π its sign may jump, its derivative not."""
    half = (np.pi - short) / 2
    settings = {"rotor.initialQuaternion": [np.cos(half), np.sin(half), 0, 0]}
    linear = sigmafmu.linearize(
        "HighSpeedRotor", parameters=settings, outputs=["rotor.rotationVector", "rotor.quaternion"]
    )
    column = dict(zip(linear.outputs, linear.C[:, linear.states.index("rotor.rotationW[1]")], strict=True))
    assert column["rotor.rotationVector[1]"] == pytest.approx(1.0, abs=1e-9)
    assert column["rotor.quaternion[1]"] == pytest.approx(-np.sin(half) / 2, abs=1e-9)
    assert np.abs(linear.C).max() < 2.0  # T⁻¹ at π


def test_operating_point_is_where_the_fmu_gets_to(fmu):
    """With turns of the crank, and with a constant torque."""
    settings, u0 = {"gravity": "0,0,-3", "integrator.formulation": "index3"}, {"crankPivot.motorTorque": 0.2}
    linear = sigmafmu.linearize("SliderCrank", 1.5, parameters=settings, u0=u0)
    run = Model(fmu("SliderCrank")).run(stop_time=1.5, step_size=1e-4, parameters=settings | u0)
    assert linear.x0[0] > 4 * np.pi
    for name, value in zip(linear.outputs, linear.y0, strict=True):
        assert value == pytest.approx(run[name][-1], rel=1e-9, abs=1e-9), name
    assert linear.u0[linear.inputs.index("crankPivot.motorTorque")] == 0.2
    np.testing.assert_allclose(linear.x0, [run[name][-1] for name in linear.states], rtol=1e-9)


def test_inputs_among_the_settings_are_the_same():
    one = sigmafmu.linearize("SliderCrank", 0.1, u0={"crankPivot.motorTorque": 0.2})
    other = sigmafmu.linearize("SliderCrank", 0.1, parameters={"crankPivot.motorTorque": "0.2"})
    assert (one.A == other.A).all()
    assert (one.u0 == other.u0).all()
    with pytest.raises(SigmafmuError, match=r"'crank\.mass' is no input of SliderCrank"):
        sigmafmu.linearize("SliderCrank", u0={"crank.mass": 1.0})


def test_coordinates_can_be_wanted():
    linear = sigmafmu.linearize("SliderCrank", 0.1, coordinates=["guide.displacement"])
    assert linear.states == ("guide.displacement", "guide.rate")
    usual = sigmafmu.linearize("SliderCrank", 0.1)
    # poles depend on the coordinate where the mechanism accelerates; at rest they do not
    rest = sigmafmu.trim("SliderCrank", inputs=["crankPivot.motorTorque"], hold={"crankPivot.angle": 0.5})
    poles = [sigmafmu.linearize(rest, coordinates=c).poles() for c in (["guide.displacement"], ())]
    np.testing.assert_allclose(*poles, rtol=1e-9)
    transform = usual.C[usual.outputs.index("guide.displacement"), 0]
    assert linear.B[1, -1] == pytest.approx(transform * usual.B[1, -1], rel=1e-9)
    with pytest.raises(SigmafmuError, match=r"'crankPivot\.angle' cannot be a state here"):
        sigmafmu.linearize("SliderCrank", coordinates=["guide.displacement", "crankPivot.angle"], at=0.1)


def test_one_name_needs_no_list():
    linear = sigmafmu.linearize("SliderCrank", inputs="crankPivot.motorTorque", outputs="crank.position")
    assert (linear.inputs, len(linear.outputs)) == (("crankPivot.motorTorque",), 3)
    assert sigmafmu.linearize("SliderCrank", inputs=(), outputs=()).A.shape == (2, 2)


def test_vectors_and_patterns_name_inputs_and_outputs():
    linear = sigmafmu.linearize("SliderCrank", 0.1, inputs=["crank.torque"], outputs=["*.angularRate", "guide.rate"])
    assert linear.inputs == ("crank.torque[1]", "crank.torque[2]", "crank.torque[3]")
    assert linear.outputs == ("crankPivot.angularRate", "guide.rate")
    assert (linear.A.shape, linear.B.shape, linear.C.shape, linear.D.shape) == ((2, 2), (2, 3), (2, 2), (2, 3))


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"at": np.inf}, r"the time must be a finite number of seconds, at least 0, not inf"),
        ({"at": np.nan}, r"not nan"),
        ({"at": -1.0}, r"not -1"),
        ({"inputs": ["crankPivot.motor"]}, r"no input 'crankPivot\.motor'; did you mean crankPivot\.motorTorque"),
        ({"outputs": ["crank.posit"]}, r"no output 'crank\.posit'; did you mean crank\.position"),
        ({"outputs": ["constraint.positionResidual"]}, r"tells about the solver"),
        ({"coordinates": ["guide"]}, r"no coordinate 'guide'"),
        ({"parameters": {"crank.masss": 1.0}}, r"no variable 'crank\.masss'; did you mean crank\.mass"),
        ({"parameters": {"crank.mass": -1.0}}, r"crank\.mass is -1 kg; it must be"),
        ({"parameters": {"crank.mass": "heavy"}}, r"'crank\.mass' needs a number, not 'heavy'"),
        ({"parameters": {"crank.inertia.xx": 1.0}}, r"cannot start: .*crank\.inertia"),
        ({"parameters": {"gravity": "0,1"}}, r"'gravity' has 3 elements"),
        ({"parameters": {"integrator.formulation": "index7"}}, r"choose one of index3, index2, stabilizedIndex2"),
        ({"u0": {"crankPivot.motorTorque": np.inf}}, r"'crankPivot\.motorTorque' must be finite, not inf"),
        ({"frame": "moon"}, r"the frame must be world or body, not 'moon'"),
    ],
)
def test_mistakes_are_explained(options, message):
    with pytest.raises(SigmafmuError, match=message):
        sigmafmu.linearize("SliderCrank", **options)


def test_unknown_models_are_explained():
    with pytest.raises(SigmafmuError, match=r"unknown model 'SlideCrank'; known models"):
        sigmafmu.linearize("SlideCrank")
