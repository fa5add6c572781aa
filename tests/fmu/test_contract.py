"""The interface contract: every variable as contract.py has it, and nothing beside them."""

import re
import shutil
import subprocess
import uuid
import zipfile
from xml.etree import ElementTree

import fmpy
import numpy as np
import pytest

from .contract import DISPLAY_FACTORS, ENUMERATIONS, MECHANISMS, UNITS, Row, expected_rows
from .helpers import EPS


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
