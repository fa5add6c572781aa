"""Instantiation, its callbacks and its resources."""

import ctypes

import fmpy
import pytest
from fmpy.fmi2 import fmi2CallbackFunctions, fmi2CallbackLoggerTYPE

from .complaints import complaint
from .helpers import ERROR, reads_resources, status_of


class Recorder:
    """A logger in C's eyes, which records all it is told."""

    def __init__(self, environment: int = 0x5EED):
        self.calls: list[tuple] = []
        self.functions = fmi2CallbackFunctions()
        self.functions.logger = fmi2CallbackLoggerTYPE(lambda *arguments: self.calls.append(arguments))
        self.functions.componentEnvironment = environment

    @property
    def text(self) -> str:
        return self.calls[-1][4].decode()


@pytest.fixture
def instantiate(new, model):
    """fmi2Instantiate with chosen arguments; what it returns is freed."""
    instance = new(model)
    components = []

    def call(recorder: Recorder | None, **arguments):
        chosen = {
            "name": b"it",
            "kind": 1,
            "guid": instance.fmu.description.guid.encode(),
            "resources": (instance.fmu.directory / "resources").as_uri().encode(),
        } | arguments
        functions = None if recorder is None else ctypes.byref(recorder.functions)
        names = ("name", "kind", "guid", "resources")
        component = instance.slave.fmi2Instantiate(*(chosen[n] for n in names), functions, 0, 0)
        components.append(component)
        return component

    yield call
    for component in components:
        if component:
            instance.slave.fmi2FreeInstance(component)


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        ({"name": b""}, "The instance name is missing; it must not be empty."),
        ({"name": None}, "The instance name is missing; it must not be empty."),
        ({"kind": 0}, "This FMU is for co-simulation alone."),
        ({"guid": b"{00000000-0000-0000-0000-000000000000}"}, "The GUID does not fit; it must be {guid}."),
        ({"guid": b""}, "The GUID does not fit; it must be {guid}."),
        ({"guid": None}, "The GUID does not fit; it must be {guid}."),
    ],
)
def test_instantiation_is_refused(fmu, model, instantiate, arguments, text):
    recorder = Recorder()
    assert instantiate(recorder, **arguments) is None
    (call,) = recorder.calls
    expected_name = arguments.get("name", b"it") or b""
    assert call[:4] == (0x5EED, expected_name, ERROR, b"logStatusError")
    assert recorder.text == text.replace("{guid}", fmu(model).description.guid)
    assert instantiate(recorder)


def test_instantiation_without_callbacks_or_logger(instantiate):
    assert instantiate(None) is None
    silent = Recorder()
    silent.functions.logger = fmi2CallbackLoggerTYPE()
    assert instantiate(silent, name=b"") is None
    assert instantiate(silent)


RESOURCES = {
    "null": None,
    "empty": b"",
    "three slashes": b"file:///no/such/folder%20here/resources",
    "one slash": b"file:/no/such/resources",
    "two slashes": b"file://host/share/resources",
    "umlauts, escaped": b"file:///tmp/M%C3%BCnchen/resources",
    "umlauts in UTF-8": "file:///tmp/München/resources".encode(),
    "umlauts in Latin-1": "file:///tmp/München/resources".encode("latin-1"),
    "a path of Windows": b"C:\\FMU\\resources",
    "half an escape": b"file:///tmp/%2",
    "capitals": b"FILE://LOCALHOST/tmp/resources",
    "this machine by its number": b"file://127.0.0.1/tmp/resources",
    "formats": b"%s%n",
    "long": b"file:///" + 100_000 * b"x",
}


@pytest.mark.parametrize("resources", RESOURCES.values(), ids=RESOURCES)
def test_resource_location_matters_only_where_there_are_resources(fmu, model, instantiate, resources):
    recorder = Recorder()
    component = instantiate(recorder, resources=resources)
    if not reads_resources(fmu(model)):
        assert component
        return
    assert component is None
    assert [call[2:4] for call in recorder.calls] == [(ERROR, b"logStatusError")]
    assert ".json" in recorder.text


@pytest.mark.parametrize("model", ["FlexiblePendulum"])
@pytest.mark.parametrize(
    "uri",
    [
        "file://{}",
        "FILE://{}",
        "File:{}",
        "file://localhost{}",
        "FILE://LocalHost{}",
        "file://127.0.0.1{}",
        "file://[::1]{}",
        "{}",
    ],
)
def test_scheme_and_host_of_the_resources_are_read_as_the_standard_says(fmu, model, uri, instantiate):
    """Both in any case (RFC 3986), and names of this machine are none of another."""
    resources = uri.format(fmu(model).directory / "resources")
    recorder = Recorder()
    assert instantiate(recorder, resources=resources.encode()), recorder.calls


@pytest.mark.parametrize("model", ["FlexiblePendulum"])
@pytest.mark.parametrize(
    ("uri", "text"),
    [
        ("HTTP://localhost/x", "; it must be a file URI, as file:///folder."),
        ("file:///x%00/resources", "; %%00 is not possible in a path."),
        ("%00", "%%00/beam.json: it cannot be opened"),
    ],
)
def test_other_locations_of_the_resources_are_refused(uri, text, instantiate):
    recorder = Recorder()
    assert instantiate(recorder, resources=uri.encode()) is None
    assert len(recorder.calls) == 1
    assert text in recorder.text


def test_folder_with_spaces_and_umlauts(fmu, model, tmp_path):
    folder = tmp_path / "Müller & Söhne 100%20"
    fmpy.extract(fmu(model).path, folder)
    H = float(fmu(model).description.defaultExperiment.stepSize)
    here, there = (fmpy.simulate_fmu(f, stop_time=H, output_interval=H) for f in (fmu(model).path, folder))
    assert here.tobytes() == there.tobytes()


def test_logger_gets_its_environment_and_the_name_of_the_instance(new, model, instantiate):
    slave = new(model).slave
    recorders = [Recorder(0x1111), Recorder(0x2222)]
    components = [instantiate(r, name=name) for r, name in zip(recorders, (b"first", b"second"), strict=True)]
    for component in components:
        assert status_of(slave.fmi2DoStep, component, 0.0, 1.0, 1) == ERROR
    assert [r.calls[0][:4] for r in recorders] == [
        (0x1111, b"first", ERROR, b"logStatusError"),
        (0x2222, b"second", ERROR, b"logStatusError"),
    ]
    assert [len(r.calls) for r in recorders] == [1, 1]


def test_messages_are_safe_for_a_logger_that_formats_them(new, model):
    """The logger is variadic like printf: a percent sign must come doubled, and nothing else may need arguments."""
    instance = new(model)
    categories = (ctypes.c_char_p * 1)(b"100%s of %n")
    call = (instance.slave.fmi2SetDebugLogging, instance.slave.component, 1, 1, categories)
    assert complaint(instance, *call) == 'The log category "100%%s of %%n" is unknown.'
