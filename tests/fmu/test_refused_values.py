"""Values and variables that are wrong: the message tells what is, and what is allowed; the instance is unharmed."""

import math
from dataclasses import dataclass

import pytest

from .complaints import complaint, shown
from .helpers import ERROR, assert_same_bits, bodies, inputs, parameters, rigid_bodies

# --- values that no mechanism can have -------------------------------------------------------------------------------

BAD_VALUES = [
    # variable, value, unit, what is allowed
    ("{body}.mass", -1.0, " kg", "finite, above 0"),
    ("{body}.mass", 0.0, " kg", "finite, above 0"),
    ("{body}.inertia.xx", -0.5, " kg.m2", "finite, above 0"),
    ("{body}.inertia.zz", 0.0, " kg.m2", "finite, above 0"),
    ("integrator.stepSize", 0.0, " s", "finite, above 0"),
    ("integrator.stepSize", -1e-3, " s", "finite, above 0"),
    ("integrator.spectralRadius", -0.1, "", "finite, at least 0, at most 1"),
    ("integrator.spectralRadius", 1.0 + 2.3e-16, "", "finite, at least 0, at most 1"),
    ("integrator.absoluteTolerance", 0.0, "", "finite, above 0"),
    ("integrator.relativeTolerance", -1e-9, "", "finite, at least 0, at most 0.01"),
    ("integrator.sigma", math.inf, "", "finite"),
    ("gravity[2]", math.nan, " m/s2", "finite"),
    ("{body}.force[1]", -math.inf, " N", "finite"),
]


@pytest.mark.parametrize(("name", "value", "unit", "allowed"), BAD_VALUES)
def test_a_bad_value_is_refused_with_name_value_and_limits(new, model, name, value, unit, allowed):
    instance = new(model)
    of_rigid_bodies = name.startswith(("{body}.mass", "{body}.inertia"))
    if of_rigid_bodies and not rigid_bodies(instance.fmu):
        pytest.skip("no rigid body")
    name = name.format(body=(rigid_bodies if of_rigid_bodies else bodies)(instance.fmu)[0])
    before = new(model)
    before.slave.enterInitializationMode()
    text = complaint(instance, instance.set, {name: value})
    allowed = allowed.replace("0.01", shown(0.01))
    assert text.replace("-nan", "nan") == f"{name} is {shown(value)}{unit}; it must be {allowed}."
    instance.slave.enterInitializationMode()
    assert instance.get(name) == before.get(name)


def test_stiffness_and_damping_must_not_be_negative(new):
    instance = new("HighSpeedRotor")
    for name, unit in (("leftSupport.stiffness[2]", "N/m"), ("rightSupport.damping[3]", "N.s/m")):
        text = complaint(instance, instance.set, {name: -1.0})
        assert text == f"{name} is -1 {unit}; it must be finite, at least 0."


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_no_variable_takes_a_value_that_is_not_finite(new, model, value):
    """Every Real that can be set, in every phase in which it can."""
    instance = new(model)
    settable = [*(v.name for k in ("fixed", "tunable") for v in parameters(instance.fmu, k)), *inputs(instance.fmu)]
    for name in settable:
        variable = instance.fmu.variables[name]
        if variable.type == "Real":
            text = complaint(instance, instance.slave.setReal, [variable.valueReference], [value])
            assert text.startswith(f"{name} is ")
            assert "it must be finite" in text
    instance.start()
    for name in [*(v.name for v in parameters(instance.fmu, "tunable")), *inputs(instance.fmu)]:
        complaint(instance, instance.slave.setReal, instance.fmu.references([name]), [value])
    undisturbed = new(model).start()
    for each in (instance, undisturbed):
        each.step(1e-3)
    assert_same_bits(instance.outputs(), undisturbed.outputs())


@pytest.mark.parametrize(
    ("name", "items"),
    [
        ("formulation", "1 (index3), 2 (index2) or 3 (stabilizedIndex2)"),
        ("corrector", "1 (residual) or 2 (incremental)"),
        ("jacobian", "1 (full) or 2 (tangentFree)"),
        ("newton", "1 (full) or 2 (modified)"),
        ("method", "1 (generalizedAlpha), 2 (rkmk4), 3 (rkmk54) or 4 (bliedf2)"),
        ("group", "1 (R3xSO3) or 2 (SE3)"),
        ("localCoordinates", "1 (exp), 2 (cayley) or 3 (cayley2)"),
        ("absoluteCoordinates", "1 (quaternion) or 2 (rotationVector)"),
    ],
)
def test_an_enumeration_takes_its_items_only(new, model, name, items):
    instance = new(model)
    reference = instance.fmu.references([f"integrator.{name}"])
    for value in (0, -1, items.count("(") + 1, 2**31 - 1, -(2**31)):
        text = complaint(instance, instance.slave.setInteger, reference, [value])
        assert text == f"integrator.{name} is {shown(value)}; it must be {items}."


# --- values that do not fit together: refused when the mechanism is built --------------------------------------------


@dataclass(frozen=True)
class Misfit:
    model: str
    settings: dict
    parts: tuple[str, ...]  # of the message


MISFITS = {
    "triangle inequality": Misfit(
        "HeavyTop",
        {"top.inertia.yy": 1.0},
        ("top.inertia has the principal moments", "0.234375", ", 1 kg.m2", "none may exceed the sum of the other two"),
    ),
    "not positive definite": Misfit(
        "HeavyTop",
        {"top.inertia.xz": 0.5},
        ("top.inertia has the principal moments -0.26", "kg.m2; they must be positive, or one of them zero"),
    ),
    "quaternion without direction": Misfit(
        "SliderCrank",
        {"rod.initialQuaternion": (0.0, 0.0, 0.0, 0.0)},
        ("rod.initialQuaternion has the length 0", "at least 1e-6"),
    ),
    "far from any assembly": Misfit(  # 1 km off with the arm of 1 m
        "HeavyTop",
        {"top.initialPosition": (1000.0, 0.0, 0.0)},
        ("top.initialPosition[1] = 1000 m", "contradict joint pivot by 999 m."),
    ),
    # A quarter turn off its guide the slider's equations are dependent: no direction leads back.
    "singular on the way": Misfit(
        "SliderCrank",
        {"slider.initialQuaternion": (1.0, 0.0, 0.0, 1.0)},
        ("slider.initialQuaternion contradicts joint guide by 1.5708 rad.",),
    ),
    "joint torn apart": Misfit(
        "SliderCrank",
        {"rod.initialPosition": (1e9, 0.0, 0.0)},
        ("rod.initialPosition[1] = 1e+09 m", "crankPin", "by 1e+09 m."),
    ),
}


@pytest.mark.parametrize("misfit", MISFITS.values(), ids=MISFITS)
def test_what_does_not_fit_together_is_refused_at_initialization(new, misfit):
    instance, undisturbed = new(misfit.model), new(misfit.model).start()
    instance.set(misfit.settings)
    instance.slave.setupExperiment()
    instance.slave.enterInitializationMode()
    # Reading needs the initial state, which cannot be computed: a failed computation. Leaving the mode is an error.
    message = instance.refusal(instance.outputs)
    assert message.status == "discard"
    assert all(part in message.text for part in misfit.parts), message.text
    leaving = instance.refusal(instance.slave.exitInitializationMode)
    assert (leaving.status, leaving.text) == ("error", message.text)
    # Other values, and it goes on from where it is ...
    instance.set({name: undisturbed.get(name) for name in misfit.settings if name in instance.fmu.variables})
    vectors = [name for name in misfit.settings if name not in instance.fmu.variables]
    instance.set({name: undisturbed.get(name).tolist() for name in vectors})
    instance.slave.exitInitializationMode()
    expected = undisturbed.trajectory(1e-3, 10)
    assert_same_bits(instance.trajectory(1e-3, 10), expected)
    # ... and another try ends in a reset.
    instance.reset().set(misfit.settings)
    instance.slave.enterInitializationMode()
    assert instance.status("fmi2ExitInitializationMode") == ERROR
    instance.reset().start()
    assert_same_bits(instance.trajectory(1e-3, 10), expected)


def test_a_thin_rod_is_on_the_boundary_of_the_triangle_inequality_and_allowed(new):
    new("HeavyTop").start({"top.inertia.xx": 0.3, "top.inertia.yy": 0.6, "top.inertia.zz": 0.3})
    text = complaint(
        instance := new("HeavyTop"),
        instance.start,
        {"top.inertia.xx": 0.3, "top.inertia.yy": 0.6001, "top.inertia.zz": 0.3},
    )
    assert "triangle inequality" in text


# --- variables that are not there, or not what they are taken for ----------------------------------------------------


def test_unknown_value_references_are_refused(new, model):
    instance = new(model).start()
    count = len(instance.fmu.variables)
    slave = instance.slave
    for reference in (count, 123456, 2**32 - 1):
        expected = f"Value reference {reference} is unknown; this FMU has 0 to {count - 1}."
        for call, arguments in (
            (slave.getReal, ([reference],)),
            (slave.getInteger, ([reference],)),
            (slave.setReal, ([reference], [0.0])),
            (slave.setInteger, ([reference], [1])),
            (slave.setRealInputDerivatives, ([reference], [1], [0.0])),
            (slave.getRealOutputDerivatives, ([reference], [1])),
            (slave.getDirectionalDerivative, ([reference], [], [])),
            (slave.getDirectionalDerivative, ([], [reference], [1.0])),
        ):
            assert complaint(instance, call, *arguments) == expected


def test_types_are_not_mixed(new, model):
    instance = new(model).start()
    slave = instance.slave
    real = instance.fmu.references(["energy.total"])
    parameter = instance.fmu.references(["gravity[1]"])
    integer = instance.fmu.references(["integrator.steps"])
    option = instance.fmu.references(["integrator.formulation"])
    assert complaint(instance, slave.getInteger, real) == "energy.total is a Real; it was read as an Integer."
    assert complaint(instance, slave.getReal, integer) == "integrator.steps is an Integer; it was read as a Real."
    assert complaint(instance, slave.getReal, option) == "integrator.formulation is an Integer; it was read as a Real."
    assert complaint(instance, slave.setInteger, parameter, [1]) == "gravity[1] is a Real; it was set as an Integer."
    assert "was set as a Real" in complaint(instance, slave.setReal, option, [1.0])
    for call, arguments in (
        (slave.getBoolean, (real,)),
        (slave.getString, (real,)),
        (slave.setBoolean, (parameter, [1])),
        (slave.setString, (parameter, ["1"])),
    ):
        assert "this FMU has no variables of that type" in complaint(instance, call, *arguments)
    # No variable at all is nothing wrong.
    assert (slave.getBoolean([]), slave.getString([]), slave.getReal([]), slave.getInteger([])) == ([], [], [], [])


def test_outputs_cannot_be_set(new, model):
    instance = new(model)
    for phase in ("before", "after"):
        for variable in instance.fmu.description.modelVariables:
            if variable.causality == "output":
                setter = instance.slave.setReal if variable.type == "Real" else instance.slave.setInteger
                text = complaint(instance, setter, [variable.valueReference], [1])
                assert text == f"{variable.name} is an output; it cannot be set."
            elif variable.causality == "local":
                text = complaint(instance, instance.slave.setInteger, [variable.valueReference], [1])
                assert text == f"{variable.name} is computed; it cannot be set."
        if phase == "before":
            instance.start()


def test_a_refused_call_sets_none_of_its_values(new, model):
    """The bad one last: those before it must not stay."""
    instance, undisturbed = new(model), new(model).start()
    body = bodies(instance.fmu)[0]
    good = ["gravity[1]", "integrator.sigma", f"{body}.initialPosition[1]", f"{body}.force[2]"]
    values = [7.0, 0.3, 1.7, 11.0]
    for bad, value in (("integrator.stepSize", -1.0), ("energy.total", 0.0), ("integrator.steps", 1.0)):
        complaint(instance, instance.slave.setReal, instance.fmu.references([*good, bad]), [*values, value])
    complaint(instance, instance.slave.setReal, [*instance.fmu.references(good), 99999], [*values, 0.0])
    instance.start()
    assert_same_bits(instance.reals(good), undisturbed.reals(good))
    assert_same_bits(instance.trajectory(1e-3, 5), undisturbed.trajectory(1e-3, 5))


def test_derivatives_of_other_things_are_refused(new, model):
    instance, undisturbed = new(model).start(), new(model).start()
    slave, body = instance.slave, bodies(instance.fmu)[0]
    force = instance.fmu.references([f"{body}.force[1]", f"{body}.force[2]"])
    output = instance.fmu.references(["energy.total", f"{body}.velocity[1]"])
    parameter, counter = instance.fmu.references(["gravity[1]"]), instance.fmu.references(["integrator.steps"])
    for order in (0, 3, -1):
        text = complaint(instance, slave.setRealInputDerivatives, force, [1, order], [5.0, 1.0])
        assert text == f"The derivative order of {body}.force[2] is {order}; it must be 1 to 2."
    for order in (0, 2):
        text = complaint(instance, slave.getRealOutputDerivatives, output, [1, order])
        assert text == f"The derivative order of {body}.velocity[1] is {order}; it must be 1."
    for value in (math.nan, math.inf):
        text = complaint(instance, slave.setRealInputDerivatives, force, [1, 1], [5.0, value])
        assert text.startswith(f"Derivative 1 of {body}.force[2] is {value}; it must be finite")
        text = complaint(instance, slave.getDirectionalDerivative, output, force, [1.0, value])
        assert text == f"The direction of {body}.force[2] must be finite."
    text = complaint(instance, slave.setRealInputDerivatives, parameter, [1], [1.0])
    assert text == "gravity[1] is no input; derivatives can be set for inputs alone."
    text = complaint(instance, slave.getRealOutputDerivatives, counter, [1])
    assert text == "integrator.steps is no Real output; derivatives can be had of Real outputs alone."
    text = complaint(instance, slave.getDirectionalDerivative, output, parameter, [1.0])
    assert text == "gravity[1] is no input; directional derivatives exist with respect to inputs alone."
    text = complaint(instance, slave.getDirectionalDerivative, parameter, force, [1.0, 1.0])
    assert text == "gravity[1] is no Real output; directional derivatives exist of Real outputs alone."
    for each in (instance, undisturbed):
        each.step(1e-3)
    assert_same_bits(instance.outputs(), undisturbed.outputs())
