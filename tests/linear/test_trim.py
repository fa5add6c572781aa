"""Equilibria, and steady motions."""

import numpy as np
import pytest

import sigmafmu
from sigmafmu import SigmafmuError
from sigmafmu.model import Model

MOTOR = ["crankPivot.motorTorque"]


@pytest.mark.parametrize(
    ("model", "inputs", "hold"),
    [
        ("SliderCrank", MOTOR, {"crankPivot.angle": 0.5}),
        ("SliderCrank", MOTOR, {"guide.displacement": 0.25}),
        ("FlexibleSliderCrank", MOTOR, {"crankPivot.angle": 2.0}),
        ("HeavyTop", ["top.torque"], {}),
        ("FlexiblePendulum", [], {}),
        ("HighSpeedRotor", [], {}),
    ],
)
def test_the_fmu_stays_where_it_is_trimmed(fmu, model, inputs, hold):
    rest = sigmafmu.trim(model, inputs=inputs, hold=hold)
    linear = sigmafmu.linearize(rest)
    assert linear.is_equilibrium
    for name, value in hold.items():
        assert linear.y0[linear.outputs.index(name)] == pytest.approx(value, abs=1e-10)
    run = Model(fmu(model)).run(stop_time=0.05, parameters=rest.start_values())
    for name in run.names:
        if name.endswith((".position[3]", ".displacement", ".angle")) or ".modal[" in name:
            assert np.ptp(run[name]) < 1e-6, name


def test_torque_balances_gravity():
    """The heavy top lies horizontally: m g l about x, in body axes."""
    linear = sigmafmu.linearize(sigmafmu.trim("HeavyTop", inputs=["top.torque"]), inputs=["top.torque"])
    np.testing.assert_allclose(linear.u0, [15 * 9.81, 0, 0], atol=1e-8)


def test_without_inputs_a_stable_position_is_found_from_a_moving_one():
    linear = sigmafmu.linearize(sigmafmu.trim("FlexiblePendulum", 0.1))
    assert linear.poles().real.max() < 1e-6
    assert linear.y0[linear.outputs.index("tip.position[3]")] < -0.9


def test_a_held_rate_makes_a_steady_motion():
    """A spinning hub, started with gravity across its axis: the beam bends, and the hub keeps its speed."""
    point = sigmafmu.trim("SpinUpBeam", hold={"hubPivot.angularRate": 1.5})
    linear = sigmafmu.linearize(point)
    assert linear.is_steady
    assert not linear.is_equilibrium
    assert linear.x0[linear.states.index("hubPivot.angularRate")] == 1.5


@pytest.mark.parametrize("name", ["top.angularVelocity[2]", "top.angularVelocityW[3]"])
def test_a_held_spin_keeps_a_top_upright(fmu, name):
    """In axes of the body or of W."""
    upright = {"top.initialPosition": [0, 0, 1], "top.initialQuaternion": [np.sqrt(0.5), np.sqrt(0.5), 0, 0]}
    point = sigmafmu.trim("HeavyTop", parameters=upright, hold={name: 300.0})
    np.testing.assert_allclose(point.v, [0, 0, 0, 0, 300, 0], atol=1e-9)
    run = Model(fmu("HeavyTop")).run(stop_time=0.2, parameters=point.start_values())
    assert np.ptp(run["top.position"], axis=0).max() < 1e-9


def test_start_values_hold_the_settings(fmu):
    settings = {"gravity": "0,1,-5", "integrator.formulation": "index3", "crank.mass": 0.3}
    settings["crank.initialAngularVelocity[1]"] = 7.0
    rest = sigmafmu.trim("SliderCrank", parameters=settings, inputs=MOTOR, hold={"crankPivot.angle": 0.5})
    values = rest.start_values()
    assert values["gravity[3]"] == -5.0
    assert values["crank.initialAngularVelocity[1]"] == 0.0  # of the point, not of the settings
    run = Model(fmu("SliderCrank")).run(stop_time=0.05, parameters=values)
    assert np.ptp(run["crankPivot.angle"]) < 1e-9
    assert sigmafmu.linearize(rest).start_values == values


def test_held_values_keep_turns():
    point = sigmafmu.trim("SliderCrank", 1.0, inputs=MOTOR, hold={"crankPivot.angle": 7.0})
    assert sigmafmu.linearize(point).x0[0] == pytest.approx(7.0, abs=1e-10)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"inputs": MOTOR, "hold": {"guide.displacement": 0.9}}, r"found no equilibrium of SliderCrank: .*guide\.dis"),
        (
            {"inputs": ["slider.force[2]"]},
            r"found no equilibrium of SliderCrank: der\(crankPivot\.angularRate\) is still",
        ),
        ({"hold": {"crankPivot.angle": 0.5}}, r"found no equilibrium of SliderCrank"),
        ({"hold": {"crankPivot.angel": 0.5}}, r"no output 'crankPivot\.angel'; did you mean crankPivot\.angle"),
        ({"hold": {"crank.position": 0.5}}, r"'crank\.position' is a vector"),
        ({"hold": {"crankPivot.angle": np.nan}}, r"'crankPivot\.angle' must be finite, not nan"),
        ({"inputs": ["motor"]}, r"no input 'motor'"),
        ({"at": -1.0}, r"the time must be"),
    ],
)
def test_failures_are_explained(options, message):
    with pytest.raises(SigmafmuError, match=message):
        sigmafmu.trim("SliderCrank", **({"at": 0.1} | options))


def test_a_point_has_its_settings_already():
    point = sigmafmu.trim("SliderCrank")
    with pytest.raises(SigmafmuError, match=r"a point has its time, parameters and inputs already"):
        sigmafmu.linearize(point, parameters={"crank.mass": 1.0})
