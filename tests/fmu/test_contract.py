"""The interface contract: every variable with its unit, causality, start value, and nothing beside them.

The table below says what a mechanism consists of; the variables of bodies, joints, spring-dampers and loads follow from
it. Numbers come from `research.reference`, which holds the literature's data without any code of the FMUs.
"""

import math
import re
import shutil
import subprocess
import uuid
import zipfile
from dataclasses import dataclass, field
from typing import NamedTuple
from xml.etree import ElementTree

import fmpy
import numpy as np
import pytest

from research.reference import CRANK, GRAVITY, ROD, SLIDER, TOP, Body, Rotor
from research.reference.clouds import PENDULUM_ANGULAR_VELOCITY, SpinUp

from .helpers import (
    ABSOLUTE_COORDINATES,
    CORRECTORS,
    EPS,
    FORMULATIONS,
    GROUPS,
    JACOBIANS,
    LOCAL_COORDINATES,
    METHODS,
    NEWTONS,
)

# --- what must be there ----------------------------------------------------------------------------------------------

ANGLE = {
    "angle": ("output", "rad"),
    "angularRate": ("output", "rad/s"),
    "angularAcceleration": ("output", "rad/s2"),
    "power": ("output", "W"),
    "motorTorque": ("input", "N.m"),
    "initialAngle": ("parameter", "rad"),
    "initialAngularRate": ("parameter", "rad/s"),
}
JOINT_COORDINATE = {
    "spherical": {},
    "universal": {f"{name}{number}": what for number in (1, 2) for name, what in ANGLE.items()},
    "fixed": {},
    "revolute": ANGLE,
    "prismatic": {
        "displacement": ("output", "m"),
        "rate": ("output", "m/s"),
        "acceleration": ("output", "m/s2"),
        "power": ("output", "W"),
        "actuatorForce": ("input", "N"),
        "initialDisplacement": ("parameter", "m"),
        "initialRate": ("parameter", "m/s"),
    },
}

JOINT_STARTS = {  # coordinate and rate; else 0
    "crankPivot.": (0.0, 6.0),
    "guide.": (0.2, 0.24),
    # about y of the rod, (0, 2, -1)/sqrt(5), then about W x; the rod turns with (1.92, -0.96, 0.48)
    "wristPin.1": (-math.atan2(math.sqrt(5), 2), 2.4 / math.sqrt(5)),
    "wristPin.2": (math.atan2(1, 2), -1.92),
}


@dataclass(frozen=True)
class Spring:
    stiffness: tuple[float, float, float]
    damping: tuple[float, float, float]


@dataclass(frozen=True)
class Flexible:
    """A flexible body; initial values are those of its frame."""

    name: str
    modes: int
    position: np.ndarray = field(default_factory=lambda: np.zeros(3))
    rotation: np.ndarray = field(default_factory=lambda: np.eye(3))
    velocity: np.ndarray = field(default_factory=lambda: np.zeros(3))
    angular_velocity: np.ndarray = field(default_factory=lambda: np.zeros(3))  # in W


@dataclass(frozen=True)
class Mechanism:
    bodies: tuple[Body | Flexible, ...]
    joints: dict[str, str] = field(default_factory=dict)  # name: type
    springs: dict[str, Spring] = field(default_factory=dict)
    loads: dict[str, np.ndarray] = field(default_factory=dict)  # name: torque in W
    stations: dict[str, int] = field(default_factory=dict)  # name: components of the deflection, -1: a scalar
    gravity: np.ndarray = field(default_factory=lambda: np.zeros(3))
    stop_time: float = 1.0  # s
    step_size: float = 1e-3  # s, internal


_rotor = Rotor()
_spin_up = SpinUp()


def stations(body: str) -> dict[str, int]:
    return {f"{body}.station{i}": 0 for i in (1, 2, 3, 4)}


MECHANISMS = {
    "HeavyTop": Mechanism(
        bodies=(TOP,), joints={"pivot": "spherical"}, gravity=GRAVITY, stop_time=2.0, step_size=2.5e-4
    ),
    "HighSpeedRotor": Mechanism(
        bodies=(_rotor.body,),
        springs={
            "leftSupport": Spring((_rotor.stiffness,) * 3, (_rotor.damping,) * 3),
            "rightSupport": Spring((0.0, _rotor.stiffness, _rotor.stiffness), (0.0, _rotor.damping, _rotor.damping)),
        },
        loads={"load": _rotor.torque},
        stop_time=1.0,
        step_size=5e-6,
    ),
    "SliderCrank": Mechanism(
        bodies=(CRANK, ROD, SLIDER),
        joints={"crankPivot": "revolute", "crankPin": "spherical", "wristPin": "universal", "guide": "prismatic"},
        gravity=GRAVITY,
        stop_time=5.0,
        step_size=1e-4,
    ),
    "FlexiblePendulum": Mechanism(
        bodies=(Flexible("beam", 4, angular_velocity=PENDULUM_ANGULAR_VELOCITY),),
        joints={"pivot": "spherical"},
        stations={**stations("beam"), "tip": 3},
        gravity=GRAVITY,
        stop_time=2.0,
        step_size=1e-4,
    ),
    "FlexibleSliderCrank": Mechanism(
        bodies=(
            CRANK,
            Flexible(
                "rod",
                4,
                position=np.array([0, 0.1, 0.2]),  # B
                rotation=ROD.rotation,
                velocity=np.array([0, -0.48, 0]),
                angular_velocity=ROD.angular_velocity,
            ),
            SLIDER,
        ),
        joints={"crankPivot": "revolute", "crankPin": "spherical", "wristPin": "universal", "guide": "prismatic"},
        stations={**stations("rod"), "middle": 3},
        gravity=GRAVITY,
        stop_time=2.0,
        step_size=1e-4,
    ),
    "SpinUpBeam": Mechanism(
        bodies=(
            Body(
                "hub",
                100.0,
                (500.0, 500.0, _spin_up.hub_inertia),
                position=np.zeros(3),
                velocity=np.zeros(3),
                angular_velocity=np.zeros(3),
            ),
            Flexible("beam", _spin_up.modes),
        ),
        joints={"hubPivot": "revolute", "clamp": "fixed"},
        stations={**stations("beam"), "tip": -1},
        stop_time=30.0,
        step_size=5e-3,
    ),
}

# SI exponents (kg, m, s, rad) of every unit that the contract uses.
UNITS = {
    "1": (0, 0, 0, 0),
    "s": (0, 0, 1, 0),
    "1/s": (0, 0, -1, 0),
    "kg": (1, 0, 0, 0),
    "kg.m2": (1, 2, 0, 0),
    "m": (0, 1, 0, 0),
    "m/s": (0, 1, -1, 0),
    "m/s2": (0, 1, -2, 0),
    "rad": (0, 0, 0, 1),
    "rad/s": (0, 0, -1, 1),
    "rad/s2": (0, 0, -2, 1),
    "N": (1, 1, -2, 0),
    "N.m": (1, 2, -2, 0),
    "N/m": (1, 0, -2, 0),
    "N.s/m": (1, 0, -1, 0),
    "J": (1, 2, -2, 0),
    "W": (1, 2, -3, 0),
    "N.s": (1, 1, -1, 0),
    "N.m.s": (1, 2, -1, 0),
}

# shown = factor · value
DISPLAY_FACTORS = {
    "ms": 1e3,
    "us": 1e6,
    "mm": 1e3,
    "um": 1e6,
    "mm/s": 1e3,
    "deg": 180 / math.pi,
    "deg/s": 180 / math.pi,
    "deg/s2": 180 / math.pi,
    "rpm": 30 / math.pi,
    "kN": 1e-3,
    "N.mm": 1e3,
    "N/mm": 1e-3,
    "mJ": 1e3,
    "kW": 1e-3,
}

ENUMERATIONS = {
    "integrator.formulation": (FORMULATIONS, "stabilizedIndex2"),
    "integrator.corrector": (CORRECTORS, "residual"),
    "integrator.jacobian": (JACOBIANS, "full"),
    "integrator.newton": (NEWTONS, "full"),
    "integrator.sigmaMode": (("fixed", "spinOptimal"), "fixed"),
    "integrator.stepControl": (("fixed", "error"), "fixed"),
    "integrator.method": (METHODS, "generalizedAlpha"),
    "integrator.group": (GROUPS, "R3xSO3"),
    "integrator.localCoordinates": (LOCAL_COORDINATES, "exp"),
    "integrator.absoluteCoordinates": (ABSOLUTE_COORDINATES, "quaternion"),
}


class Row(NamedTuple):
    type: str
    causality: str
    variability: str
    unit: str | None = None
    start: float | None = None
    start_rounding: float = 0.0  # the start may be a computed number: allowed difference


def expected_rows(mechanism: Mechanism) -> dict[str, Row]:
    rows: dict[str, Row] = {}

    def add(name: str, size: int, causality: str, unit: str, variability="continuous", start=None, rounding=0.0):
        """A Real scalar (size 0) or vector."""
        names = [name] if size == 0 else [f"{name}[{i + 1}]" for i in range(size)]
        starts = [None] * len(names) if start is None else np.broadcast_to(start, len(names)).tolist()
        for element, value in zip(names, starts, strict=True):
            rows[element] = Row("Real", causality, variability, unit, value, rounding)

    for body in mechanism.bodies:
        b = body.name
        for name, size, unit in (
            ("position", 3, "m"),
            ("quaternion", 4, "1"),
            ("rotationVector", 3, "rad"),
            ("velocity", 3, "m/s"),
            ("angularVelocity", 3, "rad/s"),
            ("acceleration", 3, "m/s2"),
            ("angularAcceleration", 3, "rad/s2"),
        ):
            add(f"{b}.{name}", size, "output", unit)
        add(f"{b}.force", 3, "input", "N", start=0.0)
        add(f"{b}.torque", 3, "input", "N.m", start=0.0)
        rotation = np.array(body.rotation)
        w = 0.5 * math.sqrt(1 + np.trace(rotation))
        axis = np.array([rotation[(i + 2) % 3, (i + 1) % 3] - rotation[(i + 1) % 3, (i + 2) % 3] for i in range(3)])
        turned = not np.array_equal(rotation, np.eye(3))
        rounding = 4 * EPS if turned else 0.0
        if isinstance(body, Flexible):
            add(f"{b}.modal", body.modes, "output", "m")
            add(f"{b}.modalRate", body.modes, "output", "m/s")
            add(f"{b}.initialModal", body.modes, "parameter", "m", "fixed", 0.0)
            add(f"{b}.initialModalRate", body.modes, "parameter", "m/s", "fixed", 0.0)
            add(f"{b}.massDamping", 0, "parameter", "1/s", "tunable", 0.0)
            add(f"{b}.stiffnessDamping", 0, "parameter", "s", "tunable", 0.0)
        else:
            add(f"{b}.mass", 0, "parameter", "kg", "fixed", body.mass)
            for i, moment in enumerate(("xx", "yy", "zz")):
                add(f"{b}.inertia.{moment}", 0, "parameter", "kg.m2", "fixed", body.inertia[i])
            for product in ("xy", "xz", "yz"):
                add(f"{b}.inertia.{product}", 0, "parameter", "kg.m2", "fixed", 0.0)
        add(f"{b}.initialPosition", 3, "parameter", "m", "fixed", body.position)
        add(f"{b}.initialQuaternion", 4, "parameter", "1", "fixed", np.array([w, *(axis / (4 * w))]), rounding)
        add(f"{b}.initialVelocity", 3, "parameter", "m/s", "fixed", body.velocity)
        speed = np.linalg.norm(body.angular_velocity)
        in_body = rotation.T @ body.angular_velocity
        add(f"{b}.initialAngularVelocity", 3, "parameter", "rad/s", "fixed", in_body, rounding * speed)
    for joint, kind in mechanism.joints.items():
        add(f"{joint}.reactionForce", 3, "output", "N")
        add(f"{joint}.reactionTorque", 3, "output", "N.m")
        for name, (causality, unit) in JOINT_COORDINATE[kind].items():
            if causality == "parameter":
                number = name[-1] if name[-1].isdigit() else ""
                start = JOINT_STARTS.get(f"{joint}.{number}", (0.0, 0.0))["Rate" in name]
                add(f"{joint}.{name}", 0, causality, unit, "fixed", start, 1e-12)  # given with 12 digits
            else:
                add(f"{joint}.{name}", 0, causality, unit, start=0.0 if causality == "input" else None)
    for spring, numbers in mechanism.springs.items():
        add(f"{spring}.stiffness", 3, "parameter", "N/m", "tunable", numbers.stiffness)
        add(f"{spring}.damping", 3, "parameter", "N.s/m", "tunable", numbers.damping)
        add(f"{spring}.position", 3, "output", "m")
        add(f"{spring}.force", 3, "output", "N")
        add(f"{spring}.energy", 0, "output", "J")
        add(f"{spring}.power", 0, "output", "W")
        add(f"{spring}.actuatorForce", 3, "input", "N", start=0.0)
    for station, axes in mechanism.stations.items():
        add(f"{station}.position", 3, "output", "m")
        if axes:
            add(f"{station}.deflection", max(axes, 0), "output", "m")
    for load, torque in mechanism.loads.items():
        add(f"{load}.force", 3, "parameter", "N", "tunable", 0.0)
        add(f"{load}.torque", 3, "parameter", "N.m", "tunable", torque, EPS * np.abs(torque).max())

    add("gravity", 3, "parameter", "m/s2", "tunable", mechanism.gravity)
    for energy in ("kinetic", "potential", "total"):
        add(f"energy.{energy}", 0, "output", "J")
    for name, unit in (("centerOfMass", "m"), ("momentum", "N.s"), ("angularMomentum", "N.m.s")):
        add(name, 3, "output", unit)
    for residual in ("positionResidual", "velocityResidual"):
        add(f"constraint.{residual}", 0, "output", "1")
    add("integrator.stepSize", 0, "parameter", "s", "fixed", mechanism.step_size)
    for name, start in (
        ("spectralRadius", 0.9),
        ("sigma", 1.0),
        ("absoluteTolerance", 1e-10),
        ("relativeTolerance", 1e-8),
        ("errorTolerance", 1e-8),
    ):
        add(f"integrator.{name}", 0, "parameter", "1", "fixed", start)
    for name, start in (("maxNewtonIterations", 20), ("maxHalvings", 10)):
        rows[f"integrator.{name}"] = Row("Integer", "parameter", "fixed", None, start)
    for name, (items, default) in ENUMERATIONS.items():
        rows[name] = Row("Enumeration", "parameter", "fixed", None, items.index(default) + 1)
    for estimate in ("errorEstimate", "largestErrorEstimate"):
        add(f"integrator.{estimate}", 0, "output", "1")
    for counter in ("steps", "newtonIterations", "jacobianEvaluations", "retries"):
        rows[f"integrator.{counter}"] = Row("Integer", "local", "discrete")
    return rows


# --- what is there ---------------------------------------------------------------------------------------------------


@pytest.fixture
def expected(model) -> dict[str, Row]:
    if model not in MECHANISMS:
        pytest.skip(f"{model} is not in MECHANISMS, which say what the benchmarks consist of")
    return expected_rows(MECHANISMS[model])


@pytest.fixture
def xml(fmu, model) -> bytes:
    with zipfile.ZipFile(fmu(model).path) as archive:
        return archive.read("modelDescription.xml")


@pytest.fixture
def root(xml) -> ElementTree.Element:
    return ElementTree.fromstring(xml)


def scalars(root: ElementTree.Element) -> list[tuple[ElementTree.Element, ElementTree.Element]]:
    """(ScalarVariable, its type element) in the order of the file."""
    return [(variable, variable[0]) for variable in root.iter("ScalarVariable")]


def test_variables_are_those_of_the_contract(root, expected):
    found = {}
    for variable, kind in scalars(root):
        start = kind.get("start")
        found[variable.get("name")] = Row(
            kind.tag,
            variable.get("causality"),
            variable.get("variability"),
            kind.get("unit"),
            None if start is None else float(start),
        )
    assert sorted(expected.keys() - found.keys()) == [], "missing variables"
    assert sorted(found.keys() - expected.keys()) == [], "variables that the contract does not have"
    wrong = {}
    for name, row in expected.items():
        same_start = (
            row.start == found[name].start
            if row.start is None or found[name].start is None
            else abs(row.start - found[name].start) <= row.start_rounding
        )
        if row[:4] != found[name][:4] or not same_start:
            wrong[name] = (found[name], row)
    assert wrong == {}


def test_every_variable_is_described_and_can_be_told_apart(root):
    variables = [variable for variable, _ in scalars(root)]
    assert all(variable.get("description") for variable in variables)
    references = [int(variable.get("valueReference")) for variable in variables]
    assert len(set(references)) == len(references)
    names = [variable.get("name") for variable in variables]
    assert len(set(names)) == len(names)
    assert root.get("variableNamingConvention") == "structured"


def test_initial_and_start_attributes_fit_the_causality(root):
    for variable, kind in scalars(root):
        initial, start = variable.get("initial"), kind.get("start")
        expected = {"parameter": ("exact", True), "input": (None, True), "output": ("calculated", False)}
        expected["local"] = expected["output"]
        assert (initial, start is not None) == expected[variable.get("causality")], variable.get("name")


def test_every_output_is_a_real(root):
    """Some importers read every output as Real, whatever its type."""
    assert {kind.tag for variable, kind in scalars(root) if variable.get("causality") == "output"} == {"Real"}


def test_starts_lie_within_min_and_max(root):
    for variable, kind in scalars(root):
        if kind.get("start") is None:
            continue
        low, high = float(kind.get("min", "-inf")), float(kind.get("max", "inf"))
        assert low <= float(kind.get("start")) <= high, variable.get("name")
        assert low < high, variable.get("name")


def test_limits_tell_what_is_allowed(root):
    """What a master can know before it tries: the least and the largest value."""
    limits = {
        variable.get("name"): (kind.get("min"), kind.get("max"))
        for variable, kind in scalars(root)
        if kind.get("min") or kind.get("max")
    }
    assert limits["integrator.spectralRadius"] == ("0", "1")
    assert limits["integrator.stepSize"] == ("0", None)
    not_negative = re.compile(
        r".*\.(mass|inertia\.(xx|yy|zz)|(stiffness|damping)\[[123]\]|massDamping|stiffnessDamping)"
    )
    names = [v.get("name") for v, _ in scalars(root) if not_negative.fullmatch(v.get("name"))]
    assert names
    assert {limits.get(name) for name in names} == {("0", None)}


def test_units_have_the_right_exponents_and_display_units(root):
    defined = {}
    for unit in root.iter("Unit"):
        base = unit.find("BaseUnit")
        exponents = {key: int(value) for key, value in base.attrib.items()}
        assert set(exponents) <= {"kg", "m", "s", "rad"}
        assert tuple(exponents.get(key, 0) for key in ("kg", "m", "s", "rad")) == UNITS[unit.get("name")]
        displays = {}
        for display in unit.iter("DisplayUnit"):
            factor = float(display.get("factor", "1"))
            assert factor == pytest.approx(DISPLAY_FACTORS[display.get("name")], rel=2 * EPS)
            displays[display.get("name")] = factor
        defined[unit.get("name")] = displays
    for variable, kind in scalars(root):
        if kind.tag == "Real":
            assert kind.get("displayUnit") in {None, *defined[kind.get("unit")]}, variable.get("name")


def test_people_see_degrees_and_revolutions_per_minute(root):
    shown = {v.get("name").partition("[")[0].rpartition(".")[2]: kind.get("displayUnit") for v, kind in scalars(root)}
    assert shown["rotationVector"] == "deg"
    assert shown["angularVelocity"] == shown["initialAngularVelocity"] == "rpm"
    assert {shown[name] for name in ("angle", "angularRate", "displacement") if name in shown} <= {"deg", "rpm", "mm"}
    assert all(shown[name] for name in ("angle", "angularRate", "displacement") if name in shown)


def test_enumerations_have_the_items_in_order(root):
    types = {t.get("name"): [(i.get("name"), i.get("value")) for i in t.iter("Item")] for t in root.iter("SimpleType")}
    declared = {v.get("name"): kind.get("declaredType") for v, kind in scalars(root) if kind.tag == "Enumeration"}
    assert set(declared) == set(ENUMERATIONS)
    for name, (items, _) in ENUMERATIONS.items():
        assert types[declared[name]] == [(item, str(i + 1)) for i, item in enumerate(items)]


def test_default_experiment(root, model):
    experiment = root.find("DefaultExperiment").attrib
    assert float(experiment["startTime"]) == 0.0
    assert float(experiment["stopTime"]) == (MECHANISMS[model].stop_time if model in MECHANISMS else 1.0)
    starts = {variable.get("name"): kind.get("start") for variable, kind in scalars(root)}
    steps = float(experiment["stepSize"]) / float(starts["integrator.stepSize"])
    assert steps >= 1
    assert steps == pytest.approx(round(steps), abs=1e-9), "a communication step of whole internal steps"
    for tolerance in ("integrator.relativeTolerance", "integrator.errorTolerance"):
        assert float(experiment["tolerance"]) == float(starts[tolerance]), "passed on, it changes nothing"


def test_capabilities(root, model):
    (capabilities,) = root.findall("CoSimulation")
    assert root.find("ModelExchange") is None
    assert capabilities.attrib == {
        "modelIdentifier": model,
        "canHandleVariableCommunicationStepSize": "true",
        "canInterpolateInputs": "true",
        "maxOutputDerivativeOrder": "1",
        "canGetAndSetFMUstate": "true",
        "canSerializeFMUstate": "true",
        "providesDirectionalDerivative": "true",
        "canNotUseMemoryManagementFunctions": "true",
    }, "needsExecutionTool and canBeInstantiatedOnlyOncePerProcess must stay at their default, false"


def test_log_categories(root):
    categories = {c.get("name"): c.get("description") for c in root.iter("Category")}
    assert set(categories) == {"logStatusError", "logStatusDiscard", "logStatusWarning", "logEvents"}
    assert all(categories.values())


# --- ModelStructure and the text of the file -------------------------------------------------------------------------


def test_model_structure_is_complete_and_sorted(root):
    variables = [variable for variable, _ in scalars(root)]
    outputs = [i + 1 for i, v in enumerate(variables) if v.get("causality") == "output"]
    structure = root.find("ModelStructure")
    for section in ("Outputs", "InitialUnknowns"):
        assert [int(u.get("index")) for u in structure.find(section)] == outputs, section
    assert structure.find("Derivatives") is None
    inputs = {i + 1 for i, v in enumerate(variables) if v.get("causality") == "input"}
    for unknown in structure.find("Outputs"):
        dependencies = [int(i) for i in unknown.get("dependencies").split()]
        assert set(dependencies) <= inputs
        assert dependencies == sorted(set(dependencies))


def test_text_of_the_file_suits_picky_readers(xml):
    """Legal XML that some masters crash on."""
    assert xml.startswith(b"<?xml"), "no byte order mark"
    text = xml.decode("utf-8")
    assert "xsi" not in text
    assert "<Annotations" not in text
    assert "\r" not in text
    for dependencies in re.findall(r'dependencies="([^"]*)"', text):
        assert re.fullmatch(r"(\d+( \d+)*)?", dependencies), f"spaces in dependencies {dependencies!r}"


def test_guid_is_the_hash_of_the_file_without_it(xml, fmu, model, new):
    text = xml.decode("utf-8")
    guid = fmu(model).description.guid
    blank = text.replace(guid, "")
    assert len(text) - len(blank) == len(guid)
    assert guid == "{" + str(uuid.uuid5(uuid.NAMESPACE_OID, blank)) + "}"
    new(model)  # the binary knows the same one


# --- the binary ------------------------------------------------------------------------------------------------------

CO_SIMULATION_FUNCTIONS = {
    "fmi2" + name
    for name in re.findall(
        r"\w+",
        """GetTypesPlatform GetVersion SetDebugLogging Instantiate FreeInstance SetupExperiment
        EnterInitializationMode ExitInitializationMode Terminate Reset GetReal GetInteger GetBoolean GetString SetReal
        SetInteger SetBoolean SetString GetFMUstate SetFMUstate FreeFMUstate SerializedFMUstateSize SerializeFMUstate
        DeSerializeFMUstate GetDirectionalDerivative SetRealInputDerivatives GetRealOutputDerivatives DoStep CancelStep
        GetStatus GetRealStatus GetIntegerStatus GetBooleanStatus GetStringStatus""",
    )
}


@pytest.mark.skipif(shutil.which("nm") is None, reason="nm of binutils is missing")
def test_binary_exports_the_functions_of_co_simulation_and_nothing_else(fmu, model):
    binary = fmu(model).directory / "binaries" / fmpy.platform / f"{model}{fmpy.sharedLibraryExtension}"
    listing = subprocess.run(["nm", "-D", "--defined-only", binary], check=True, capture_output=True, text=True).stdout
    assert {line.split()[-1] for line in listing.splitlines()} == CO_SIMULATION_FUNCTIONS


def test_binary_says_which_standard_it_follows(new, model):
    slave = new(model).slave
    assert (slave.getVersion(), slave.getTypesPlatform()) == ("2.0", "default")


def test_archive_holds_nothing_unexpected(fmu, model):
    with zipfile.ZipFile(fmu(model).path) as archive:
        assert archive.testzip() is None
        names = archive.namelist()
    assert len(set(names)) == len(names)
    allowed = (
        "modelDescription.xml",
        "binaries/",
        "resources/",
        "sources/",
        "documentation/",
        "terminalsAndIcons/",
        "extra/",
        "model.png",
    )
    assert [name for name in names if not name.startswith(allowed)] == []
    assert [name for name in names if "\\" in name or name.startswith("/")] == []


# --- start values, as the binary has them ----------------------------------------------------------------------------


def test_binary_has_the_start_values_of_the_file(new, model, root):
    instance = new(model)
    instance.slave.enterInitializationMode()
    for variable, kind in scalars(root):
        if kind.get("start") is None:
            continue
        reference = [int(variable.get("valueReference"))]
        getter = instance.slave.getReal if kind.tag == "Real" else instance.slave.getInteger
        assert getter(reference)[0] == float(kind.get("start")), variable.get("name")


def test_initial_motion_is_the_one_of_the_literature(new, model):
    """The given initial values are consistent already: the projection must not move them."""
    if model not in MECHANISMS:
        pytest.skip("no numbers for this model")
    instance = new(model).start()
    for body in MECHANISMS[model].bodies:
        rotation = np.array(body.rotation)
        speed = max(1.0, np.linalg.norm(body.angular_velocity))
        for name, value, size in (
            ("position", body.position, 1.0),
            ("velocity", body.velocity, max(1.0, np.linalg.norm(body.velocity))),
            ("angularVelocity", rotation.T @ body.angular_velocity, speed),
        ):
            np.testing.assert_allclose(instance.get(f"{body.name}.{name}"), value, rtol=0, atol=16 * EPS * size)
    assert instance.get("constraint.positionResidual") <= 4 * EPS
    assert instance.get("constraint.velocityResidual") <= 64 * EPS
