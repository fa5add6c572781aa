"""The Python interface: models, runs with inputs over time, live instances."""

import ast
import pickle
import subprocess
import sys
from pathlib import Path

import fmpy
import numpy as np
import pytest

import sigmafmu
from sigmafmu import SigmafmuError, SimulationError

LIBRARY = Path(__file__).parents[2] / "models" / "library"
FREE_BODY = LIBRARY / "FreeBody.yaml"
MOTOR, RATE = "crankPivot.motorTorque", "crankPivot.angularRate"


@pytest.fixture(scope="module")
def crank():
    return sigmafmu.load("SliderCrank")


@pytest.fixture(scope="module")
def body():
    return sigmafmu.load(FREE_BODY)


def test_models_come_from_names_files_and_fmus(crank, body):
    fmu = sigmafmu.load(sigmafmu.fmu_path("SliderCrank"))
    assert fmu.outputs == crank.outputs
    assert repr(crank) == f"<Model SliderCrank: {len(crank.inputs)} inputs, {len(crank.outputs)} outputs>"
    assert body.name == "FreeBody"
    with pytest.raises(SigmafmuError, match="unknown model 'Slider'; known models: "):
        sigmafmu.load("Slider")


def test_a_file_runs_as_its_fmu_does(tmp_path):
    """The FMU that `load` makes has no documentation, and the same bits."""
    file = LIBRARY / "SliderCrank.yaml"
    sigmafmu.build_fmu(file, tmp_path / "x.fmu")
    one, other = (sigmafmu.load(target).run(0.02) for target in (file, tmp_path / "x.fmu"))
    assert one.names == other.names
    np.testing.assert_array_equal(one.values, other.values)


def test_a_flexible_file_finds_its_modal_data():
    model = sigmafmu.load(LIBRARY / "FlexibleSliderCrank.yaml")
    assert np.isfinite(model.run(0.01).values).all()
    assert model.linearize(inputs=[], outputs=["guide.displacement"]).C.shape[0] == 1


def test_variables_tell_what_they_are(crank):
    mass = crank.variables["crank.mass"]
    assert (mass.type, mass.causality, mass.variability, mass.unit) == ("Real", "parameter", "fixed", "kg")
    assert (mass.start, mass.minimum, mass.maximum) == (0.12, 0.0, None)
    assert crank.variables["integrator.formulation"].items == ("index3", "index2", "stabilizedIndex2")
    assert all(v.description for v in crank.variables.values())
    assert {*crank.inputs, *crank.outputs, *crank.parameters} < {*crank.variables}
    assert (crank.stop_time, crank.step_size) == (5.0, 1e-3)


def test_a_run_has_the_bits_that_fmpy_gets(crank):
    start = {"integrator.stepSize": 1e-3, "crank.mass": 0.2, MOTOR: 0.1}
    theirs = fmpy.simulate_fmu(
        str(crank.fmu.path), stop_time=0.25, output_interval=2.0**-7, start_values=start, output=[RATE]
    )
    ours = crank.run(0.25, step_size=2.0**-7, parameters=start, outputs=[RATE])
    np.testing.assert_array_equal(ours[RATE], theirs[RATE])
    assert ours.units == {RATE: "rad/s"}


@pytest.mark.parametrize(("jump", "H"), [(0.2, 0.05), (0.3, 0.1)])  # 0.2 + 0.1 is more than 0.3
def test_a_table_is_a_broken_line_with_jumps(body, jump, H):
    """Velocity of a free body: the integral of the force."""
    mass = body.variables["body.mass"].start
    times, force = [0.0, 0.1, jump, jump, jump + 0.2], [0.0, 3.0, 3.0, -1.0, 1.0]
    table = np.column_stack((force, np.zeros(5), force))
    result = body.run(0.6, step_size=H, parameters={"gravity": [0, 0, 0]}, inputs={"body.force": (times, table)})
    before = 0.15 + 3 * (jump - 0.1)  # N s
    after = before + 1.0 * (0.6 - jump - 0.2)
    for i in (1, 3):
        velocity = result[f"body.velocity[{i}]"] - result[f"body.velocity[{i}]"][0]
        assert velocity[round(jump / H)] == pytest.approx(before / mass, rel=1e-10)
        assert velocity[-1] == pytest.approx(after / mass, rel=1e-10)


def test_a_function_of_time_is_followed_to_second_order(body):
    """The force is the chord of a sine in each step: half the step, a quarter of the error."""
    mass, omega = body.variables["body.mass"].start, 20.0

    def error(H):
        result = body.run(
            0.4, step_size=H, parameters={"gravity": [0, 0, 0], "integrator.stepSize": 1e-3},
            inputs={"body.force[1]": lambda t: np.sin(omega * t)}, outputs=["body.velocity"],
        )  # fmt: skip
        exact = (1 - np.cos(omega * result.time)) / (omega * mass)
        return np.abs(result["body.velocity[1]"] - result["body.velocity[1]"][0] - exact).max()

    assert error(0.02) / error(0.01) == pytest.approx(4.0, rel=0.1)


@pytest.mark.parametrize(
    ("inputs", "message"),
    [
        ({"body.mass": 1.0}, "'body.mass' is no input of FreeBody; it is of causality parameter"),
        ({"body.forse": 1.0}, "no variable 'body.forse'; did you mean body.force"),
        ({"body.force": ([0.0, 1.0], [1.0, 2.0])}, r"'body.force' has 3 elements, but its signal has shape \(1,\)"),
        ({"body.force[1]": ([1.0, 0.0], [1.0, 2.0])}, "its times must not decrease"),
        ({"body.force[1]": ([0.0, 1.0], [1.0])}, r"times of shape \(2,\) and values of shape \(1,\)"),
    ],
)
def test_wrong_inputs_are_told(body, inputs, message):
    with pytest.raises(SigmafmuError, match=message):
        body.run(0.1, inputs=inputs)


def test_steps_are_those_of_a_run(crank):
    result = crank.run(0.01, parameters={"crank.mass": 0.2}, outputs=[RATE, "slider.position"])
    with crank.instance({"crank.mass": 0.2}) as m:
        rows = [m.get([RATE, "slider.position"])]
        for _ in range(10):
            m.step(1e-3)
            rows.append(m.get([RATE, "slider.position"]))
        np.testing.assert_array_equal(m.get("slider.position"), rows[-1][1:])
        assert m.get(RATE) == rows[-1][0]
    np.testing.assert_allclose(rows, result.values, rtol=0, atol=1e-13)  # times are added up otherwise


def test_a_state_goes_on_with_the_same_bits_elsewhere(crank):
    with crank.instance() as m:
        m.set(MOTOR, 0.1)
        m.step(0.01)
        state = m.save()
        first = m.run(0.02).values
        m.restore(state)
        assert m.time == 0.01
        np.testing.assert_array_equal(m.run(0.02).values, first)
    with pickle.loads(pickle.dumps(crank)).instance() as other:
        other.restore(pickle.loads(pickle.dumps(state)))
        np.testing.assert_array_equal(other.run(0.02).values, first)
    with sigmafmu.load("HeavyTop").instance() as top, pytest.raises(SigmafmuError, match="not to HeavyTop"):
        top.restore(state)


def test_a_run_continues_and_counts_its_own_steps(crank):
    with crank.instance({"integrator.stepSize": 1e-3}) as m:
        first, second = m.run(0.1, step_size=0.01), m.run(0.3, step_size=0.01)
        with pytest.raises(SigmafmuError, match=r"must be above the present time 0\.3 s, not 0\.2 s"):
            m.run(0.2)
    assert (first.statistics.steps, second.statistics.steps) == (100, 200)
    assert second.statistics.simulated_time == pytest.approx(0.2)
    np.testing.assert_array_equal(first.values[-1][:-4], second.values[0][:-4])


def test_reset_forgets_what_was_set(crank):
    with crank.instance({"crank.mass": 0.3}) as m:
        heavy = m.run(0.01).values
        m.reset()
        np.testing.assert_array_equal(m.run(0.01).values, crank.run(0.01).values)
        m.reset({"crank.mass": 0.3})
        np.testing.assert_array_equal(m.run(0.01).values, heavy)


def test_what_a_model_refuses_is_told_in_its_words(crank):
    with pytest.raises(SimulationError, match=r"crank\.mass is -1 kg; it must be"):
        crank.run(0.01, parameters={"crank.mass": -1.0})
    impossible = {"integrator.stepSize": 0.01, "integrator.maxHalvings": 0, "integrator.maxNewtonIterations": 1}
    with sigmafmu.load("HeavyTop").instance(impossible) as m:
        with pytest.raises(SimulationError, match=r"^HeavyTop stopped at t = 0 s: .*Newton"):
            m.step(0.01)
        m.reset()
        m.step(0.01)
        with pytest.raises(SimulationError, match=r"top\.mass"):
            m.set("top.mass", 1.0)
    with pytest.raises(SigmafmuError, match="this instance of HeavyTop is closed"):
        m.step(0.01)


def test_a_run_that_stops_gives_what_it_has():
    impossible = {"integrator.stepSize": 0.01, "integrator.maxHalvings": 0, "integrator.maxNewtonIterations": 1}
    with pytest.raises(SimulationError) as caught:
        sigmafmu.load("HeavyTop").run(1.0, parameters=impossible)
    assert len(caught.value.result.time) >= 1


def test_start_values_of_a_point_start_the_run_there(crank):
    rest = crank.trim(inputs=[MOTOR], hold={"crankPivot.angle": 0.5})
    result = crank.run(0.05, parameters=rest.start_values(), outputs=["crankPivot.angle"])
    np.testing.assert_allclose(result["crankPivot.angle"], 0.5, atol=1e-9)


def test_public_names_are_there_and_documented():
    assert len(set(sigmafmu.__all__)) == len(sigmafmu.__all__)
    for name in sigmafmu.__all__:
        thing = getattr(sigmafmu, name)
        assert name == "__version__" or thing.__doc__, name
        for member, value in vars(thing).items() if isinstance(thing, type) else ():
            if callable(value) and not member.startswith("_"):
                assert value.__doc__, f"{name}.{member}"
    assert {*sigmafmu.__all__} <= {*dir(sigmafmu)}
    with pytest.raises(AttributeError, match="no attribute 'simulate'"):
        _ = sigmafmu.simulate


def test_the_command_line_starts_without_what_runs_need():
    heavy = ("numpy", "fmpy", "matplotlib", "lxml", "sigmafmu._core")
    code = f"import sys, sigmafmu.cli; print([m for m in {heavy} if m in sys.modules])"
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout == "[]\n"


def test_commands_use_the_interface_and_nothing_below_it():
    """No command opens FMUs or mechanisms by itself."""
    package = Path(sigmafmu.__file__).parent
    below = ("fmpy", "sigmafmu._core", "sigmafmu.fmu", "sigmafmu.instance")
    for file in (package / "cli.py", *package.glob("*_cli.py"), *package.glob("*/cli.py")):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom):
                assert node.module not in below, file
