"""FMUs of files do what those that were compiled do, and their resources may be edited within what they check."""

import json
import os
import shutil
import subprocess
import sys
import time
import zipfile
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from fmpy.util import create_zip_archive
from fmpy.validation import validate_fmu
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from lxml import etree

import sigmafmu
from sigmafmu.fmu import Fmu

from .file_fmus import RESOURCES, Resources, chain, mechanism_of
from .helpers import Instance, assert_same_bits, inputs

COMPILED = ("HeavyTop", "SliderCrank", "FlexibleSliderCrank")
compiled = pytest.mark.parametrize("model", COMPILED)


@pytest.fixture(scope="module")
def built(tmp_path_factory) -> Callable[[str], Fmu]:
    """Function that builds the FMU of a mechanism of models/ from its file and opens it; each once."""
    folder = tmp_path_factory.mktemp("built")

    @cache
    def build(model: str) -> Fmu:
        path = folder / f"{model}.fmu"
        return Fmu(sigmafmu.build_fmu(mechanism_of(model), path, resources=RESOURCES / model))

    return build


@pytest.fixture
def start() -> Iterator[Callable[..., Instance]]:
    """Function that makes an instance of an opened FMU and starts it; all are freed after the test."""
    made: list[Instance] = []

    def make(fmu: Fmu, values=None) -> Instance:
        made.append(Instance(fmu))
        return made[-1].start(values)

    yield make
    for instance in made:
        instance.free()


def run(instance: Instance, steps: int = 40) -> np.ndarray:
    """All outputs at the communication points, with a load on every input from the tenth on."""
    H = float(instance.fmu.description.defaultExperiment.stepSize)
    before = instance.trajectory(H, steps // 4)
    instance.set({name: 0.01 * (i + 1) for i, name in enumerate(inputs(instance.fmu))})
    return np.concatenate([before, instance.trajectory(H, steps - steps // 4)])


# --- the same FMU ----------------------------------------------------------------------------------------------------


@compiled
@pytest.mark.skipif("SIGMAFMU_FMUS" in os.environ, reason="another compiler's FMUs have other bits")
def test_outputs_are_those_of_the_compiled_fmu(built, fmu, start, model):
    here, there = built(model), fmu(model)
    assert list(here.variables) == list(there.variables)
    assert_same_bits(run(start(here)), run(start(there)), list(here.variables))


@compiled
def test_the_xml_tells_the_same(built, fmu, model):
    """But for the GUID, whose FMU it is and its sources."""
    here, there = (etree.parse(f.directory / "modelDescription.xml").getroot() for f in (built(model), fmu(model)))
    assert {k: v for k, v in there.attrib.items() if here.get(k) != v}.keys() == {"guid", "author", "version"}
    assert set(here.attrib) < set(there.attrib)
    annotations = here.find("VendorAnnotations")
    annotations.remove(annotations.find("Tool[MechanismFile]"))
    annotations[-1].tail = "\n    "
    for root in (here, there):
        root.find("CoSimulation").remove(root.find("CoSimulation/SourceFiles"))
    assert [etree.tostring(part) for part in here] == [etree.tostring(part) for part in there]


@compiled
def test_validators_find_nothing(built, model):
    assert validate_fmu(str(built(model).path)) == []


def test_the_same_mechanism_is_the_same_file(tmp_path):
    paths = [sigmafmu.build_fmu(mechanism_of("SliderCrank"), tmp_path / f"{i}.fmu") for i in range(2)]
    assert paths[0].read_bytes() == paths[1].read_bytes()
    with zipfile.ZipFile(paths[0]) as archive:
        names = archive.namelist()
        assert names == sorted(names)
        assert {info.date_time for info in archive.infolist()} == {(1980, 1, 1, 0, 0, 0)}
    assert sorted(path.name for path in tmp_path.iterdir()) == ["0.fmu", "1.fmu"]


def test_geometry_that_the_xml_does_not_tell_makes_another_guid(built, tmp_path):
    mechanism = mechanism_of("SliderCrank")
    mechanism["joints"][1]["frame1"]["position"][0] += 1e-9
    mechanism["joints"][1]["frame2"]["position"][0] += 1e-9
    other = Fmu(sigmafmu.build_fmu(mechanism, tmp_path / "other.fmu"))
    assert other.description.guid != built("SliderCrank").description.guid


def test_sources_are_complete(built):
    """The binary's C++ files are listed, and nothing is left to fill in."""
    tree = built("HeavyTop").directory
    with zipfile.ZipFile(built("HeavyTop").path) as archive:
        names = archive.namelist()
        texts = {name: archive.read(name).decode() for name in names if name.startswith("sources/") and "/" in name}
    listed = {file.get("name") for file in etree.parse(tree / "modelDescription.xml").iter("File")}
    assert {f"sources/{name}" for name in listed} == {name for name in names if name.endswith(".cpp")}
    assert "fmi/model_of_file.cpp" in listed
    assert "model.cpp" not in listed
    assert [name for name, text in texts.items() if "@MODEL@" in text] == []
    assert 'modelIdentifier="HeavyTop"' in texts["sources/buildDescription.xml"]
    assert "project(HeavyTop " in texts["sources/CMakeLists.txt"]


def test_descriptions_end_where_the_file_says_no_more(tmp_path):
    """What has no description of its own adds nothing behind what a variable is."""
    mechanism = mechanism_of("FlexiblePendulum")
    mechanism["loads"] = [{"name": "pull", "body": "beam", "force": [1.0, 0.0, 0.0]}]
    mechanism["sensors"] = [{"name": "probe", "type": "motion", "body": "beam"}]
    del mechanism["stations"][0]["description"]
    fmu = Fmu(sigmafmu.build_fmu(mechanism, tmp_path / "x.fmu", resources=RESOURCES / "FlexiblePendulum"))
    told = {name: variable.description for name, variable in fmu.variables.items()}
    station, other = (entry["name"] for entry in mechanism["stations"][:2])
    assert told["pull.force[1]"] == "Constant force at the centre of mass, in W"
    assert told[f"{station}.position[1]"] == "Position in W"
    assert told["probe.position[1]"] == "Position seen from the reference, in the reference frame's axes"
    assert told[f"{other}.position[1]"].startswith("Position in W: ")
    assert [name for name, text in told.items() if not text[-1].isalnum() and text[-1] != ")"] == []


def test_documentation_is_about_this_mechanism(tmp_path):
    """A file called like a mechanism of ours does not get its words, reference and accuracy."""
    source = tmp_path / "my top & more.yaml"
    source.write_text("name: HeavyTop\n", encoding="utf-8")
    fmu = Fmu(sigmafmu.build_fmu(mechanism_of("HeavyTop"), tmp_path / "x.fmu", source=source))
    page = (fmu.directory / "documentation" / "index.html").read_text(encoding="utf-8")
    assert '<a href="source/my%20top%20%26%20more.yaml">my top &amp; more.yaml</a>' in page
    assert (fmu.directory / "documentation" / "source" / source.name).read_bytes() == source.read_bytes()
    assert "Brüls, Cardona" not in page.partition('id="master"')[0]
    assert "Every number below" not in page
    assert "frame B in the centre of mass" in page
    assert 'id="accuracy"' not in page
    assert not (fmu.directory / "extra").exists()
    assert (fmu.directory / "model.png").is_file()
    assert (fmu.directory / "terminalsAndIcons" / "terminalsAndIcons.xml").is_file()


@pytest.mark.release
def test_the_sources_make_the_binary(built, start, tmp_path):
    tree = tmp_path / "tree"
    with zipfile.ZipFile(built("HeavyTop").path) as archive:
        archive.extractall(tree)
    shutil.rmtree(tree / "binaries")
    configure = ["cmake", "-S", tree / "sources", "-B", tmp_path / "build", "-DCMAKE_BUILD_TYPE=Debug"]
    for command in (configure, ["cmake", "--build", tmp_path / "build", "--target", "install", "--parallel", "2"]):
        done = subprocess.run(command, text=True, capture_output=True)
        assert done.returncode == 0, done.stdout + done.stderr
    create_zip_archive(tmp_path / "rebuilt.fmu", tree)
    there, here = run(start(Fmu(tmp_path / "rebuilt.fmu"))), run(start(built("HeavyTop")))
    assert np.abs(here - there).max() < 1e-9 * np.abs(here).max()


@pytest.mark.release
@pytest.mark.slow
def test_the_tests_of_the_fmus_pass(tmp_path):
    """All of them, on FMUs of files that have no section in docs/."""
    for model in ("SliderCrank", "FlexibleSliderCrank"):
        mechanism = mechanism_of(model) | {"name": f"My{model}"}
        mechanism["experiment"]["stop_time"] = 1.0  # as mechanisms have that the tests know nothing of
        sigmafmu.build_fmu(mechanism, tmp_path / f"My{model}.fmu", resources=RESOURCES / model)
    command = [sys.executable, "-m", "pytest", "-q", "-m", "not slow and not heavy and not release"]
    apart = ["--deselect", "tests/fmu/test_model_description.py", "--ignore", "tests/fmu/test_file_fmus.py"]
    done = subprocess.run(
        [*command, *apart, "tests/fmu"],
        cwd=Path(__file__).parents[2],
        env=os.environ | {"SIGMAFMU_FMUS": str(tmp_path)},
        text=True,
        capture_output=True,
    )
    assert done.returncode == 0, done.stdout[-8000:]
    assert " passed" in done.stdout


# --- several ---------------------------------------------------------------------------------------------------------


def test_two_mechanisms_in_one_process(built, start):
    """The same binary, loaded twice, in turns."""
    models = ("HeavyTop", "SliderCrank")
    alone = [run(start(built(model))) for model in models]
    both = [start(built(model)) for model in models]
    H = [float(f.fmu.description.defaultExperiment.stepSize) for f in both]
    rows = [[instance.outputs()] for instance in both]
    for _ in range(10):
        for instance, h, outputs in zip(both, H, rows, strict=True):
            instance.step(h)
            outputs.append(instance.outputs())
    for outputs, expected in zip(rows, alone, strict=True):
        assert_same_bits(np.array(outputs[:10]), expected[:10])


@pytest.mark.parametrize(("links", "limit"), [(100, 0.05), (1000, 1.0)])
def test_time_of_an_instantiation(tmp_path, links, limit):
    """Of this process, so that others do not count."""
    fmu = Fmu(sigmafmu.build_fmu(chain(links), tmp_path / "chain.fmu"))
    resources = Resources(fmu, tmp_path / "resources")
    times = []
    for _ in range(3):
        begin = time.process_time()
        assert resources.instantiate() == []
        times.append(time.process_time() - begin)
    assert min(times) < limit


BUILD_ALONE = """
import importlib.abc, sys
class Blocked(importlib.abc.MetaPathFinder):
    def find_spec(self, name, path=None, target=None):
        if name == "sigmafmu._core":
            raise ModuleNotFoundError(name)
sys.meta_path.insert(0, Blocked())
import sigmafmu
sigmafmu.build_fmu(open(sys.argv[1], encoding="utf-8").read(), sys.argv[2])
"""


def test_no_compiler_and_no_core_is_needed(built, tmp_path):
    text = tmp_path / "mechanism.json"
    text.write_text(json.dumps(mechanism_of("HeavyTop")), encoding="utf-8")
    nothing = {"PATH": str(tmp_path), "HOME": str(tmp_path), "MPLCONFIGDIR": str(tmp_path)}
    command = [sys.executable, "-c", BUILD_ALONE, text, tmp_path / "alone.fmu"]
    done = subprocess.run(command, env=nothing, text=True, capture_output=True)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "alone.fmu").read_bytes() == built("HeavyTop").path.read_bytes()


# --- edited resources ------------------------------------------------------------------------------------------------


@pytest.fixture
def resources(built, tmp_path) -> Callable[[str], Resources]:
    """Function that makes resources that can be edited, of the FMU of a mechanism."""
    return lambda model="SliderCrank": Resources(built(model), tmp_path / "resources")


def test_edited_values_are_those_of_the_instance(built, resources, start, tmp_path):
    """As if the parameters had been set, bit by bit."""
    files = resources()

    def edit(m):
        m["bodies"][1]["mass"] = 0.75
        m["bodies"][2]["inertia"]["zz"] = 1.5e-4
        m["gravity"] = [0.5, 0, -1.62]
        m["integrator"]["stepSize"] = 5e-4
        m["description"] = "Edited"

    files.edit(edit)
    edited = start(files.opened(tmp_path / "edited.fmu"))
    values = {"rod.mass": 0.75, "slider.inertia.zz": 1.5e-4, "gravity": (0.5, 0, -1.62), "integrator.stepSize": 5e-4}
    assert edited.get("rod.mass") == 0.75
    assert_same_bits(run(edited), run(start(built("SliderCrank"), values)))


def test_another_modal_file_is_another_body(built, resources, start, tmp_path):
    """And a state belongs to the data that it was computed with."""
    files = resources("FlexibleSliderCrank")
    files.edit(lambda data: data.update(K=(2 * np.array(data["K"])).tolist()), "rod.json")
    edited, before = start(files.opened(tmp_path / "edited.fmu")), start(built("FlexibleSliderCrank"))
    assert np.abs(run(edited) - run(before)).max() > 1e-6
    edited.messages.clear()
    state = before.serialized()
    before.deserialize(state)
    message = edited.refusal(edited.deserialize, state)
    assert message.text == "The serialized FMU state belongs to another FMU or another version of it."


def test_what_is_read_otherwise_the_same_is_the_same(built, resources, start, tmp_path):
    """Other white space and order of keys."""
    files = resources()
    files.edit(lambda m: dict(reversed(m.items())))
    assert_same_bits(run(start(files.opened(tmp_path / "edited.fmu"))), run(start(built("SliderCrank"))))


def renamed(m):
    return json.loads(json.dumps(m).replace('"rod"', '"bar"'))


REFUSED = {
    "a body's name": renamed,
    "a body more": lambda m: m["bodies"].append(m["bodies"][0] | {"name": "more"}),
    "a joint's type": lambda m: m["joints"][1].update(type="universal"),
    "a joint's bodies": lambda m: m["joints"][1].update(bodies=["crank", "slider"]),
    "a joint's place": lambda m: m["joints"][1]["frame1"]["position"].__setitem__(2, 0.05),
    "a joint less": lambda m: m["joints"].__delitem__(2),
    "a force": lambda m: m.update(loads=[{"name": "wind", "body": "rod"}]),
    "variables": lambda m: m.update(expose={"outputs": ["*"]}),
    "the name": lambda m: m.update(name="Other"),
}


@pytest.mark.parametrize("edit", REFUSED.values(), ids=REFUSED)
def test_edits_beyond_values_are_refused(resources, edit):
    files = resources()
    files.edit(edit)
    (said,) = files.instantiate()
    assert said == (
        f"{files.folder / 'mechanism.json'}: it has been edited since the build in more than values; "
        "names, connections, geometry and the choice of variables need a new build."
    )


def test_other_variables_are_refused(resources):
    """As a binary of another version would have."""
    files = resources()
    files.edit(lambda identity: identity.update(variables="0" * 16), "identity.json")
    assert files.instantiate() == [
        "The mechanism has other variables than modelDescription.xml; the FMU must be built again."
    ]


# --- damaged resources -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("mechanism.json", None, "it cannot be opened; the FMU is made of this file."),
        ("identity.json", None, "it cannot be opened; the FMU is made of this file."),
        ("mechanism.json", "", "The mechanism is no JSON: "),
        ("mechanism.json", "[" * 100_000, "The mechanism is no JSON: its lists are nested deeper than 16."),
        ("mechanism.json", "{}", "sigmafmu is missing."),
        ("identity.json", "{", "It is no JSON: "),
        ("mechanism.json", b'{"\xc3": "\x9e\xff"}', "The mechanism is no JSON: "),
        ("identity.json", "[]", "It is []; it must be an object."),
        ("identity.json", '{"guid": 1}', "guid is 1; it must be a text."),
        ("identity.json", '{"guid": "{}"}', "variables is missing."),
    ],
)
def test_damaged_file_is_one_message_that_names_it(resources, name, text, message):
    files = resources()
    path = files.folder / name
    path.unlink()
    if text is not None:
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
    (said,) = files.instantiate()
    assert said.startswith(f"{path}: {message}")


def test_edited_value_that_is_wrong_is_one_message(resources):
    files = resources()
    files.edit(lambda m: m["bodies"][0].update(mass="1 kg"))
    (said,) = files.instantiate()
    assert said == f'{files.folder / "mechanism.json"}: bodies[0].mass is "1 kg"; it must be a number.'
    files.edit(lambda m: m["bodies"][0].update(mass=-1))
    (said,) = files.instantiate()
    assert said.startswith("crank.mass is -1 kg; it must be ")


@settings(deadline=None, max_examples=200, suppress_health_check=list(HealthCheck))
@given(at=st.integers(0, 10_000), put=st.binary(max_size=4), cut=st.integers(0, 40))
def test_no_damage_does_more_than_refuse(built, tmp_path_factory, at, put, cut):
    """One message or an instance, whatever bytes the file has."""
    folder = tmp_path_factory.mktemp("damaged")
    files = Resources(built("HeavyTop"), folder / "resources")
    path = files.folder / "mechanism.json"
    text = path.read_bytes()
    at %= len(text)
    path.write_bytes(text[:at] + put + text[at + cut :])
    assert len(files.instantiate()) <= 1


# --- what cannot be built --------------------------------------------------------------------------------------------


def test_wrong_mechanism_is_one_sentence(tmp_path):
    path = tmp_path / "x.fmu"
    for mechanism, message in (
        ("{", r"^The mechanism is no JSON: "),
        (mechanism_of("HeavyTop") | {"name": "1"}, r'^The name of the mechanism is "1"; '),
        (mechanism_of("HeavyTop") | {"description": "a\0b"}, r"^the descriptions of the mechanism cannot be written "),
        (mechanism_of("FlexiblePendulum"), r"beam\.json: it cannot be opened"),
        (chain(1) | {"joints": [{"name": "hold", "type": "fixed", "bodies": ["ground", "link1"]}]}, "cannot move"),
    ):
        with pytest.raises(sigmafmu.SigmafmuError, match=message):
            sigmafmu.build_fmu(mechanism, path, resources=tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_files_that_cannot_be_used_are_named(tmp_path):
    mechanism = mechanism_of("HeavyTop")
    with pytest.raises(sigmafmu.SigmafmuError, match=r"x\.fmu\.part: No such file or directory$"):
        sigmafmu.build_fmu(mechanism, tmp_path / "no" / "x.fmu")
    with pytest.raises(sigmafmu.SigmafmuError, match=r"my\.yaml: No such file or directory$"):
        sigmafmu.build_fmu(mechanism, tmp_path / "x.fmu", source=tmp_path / "my.yaml")
    taken = mechanism_of("FlexiblePendulum")
    taken["bodies"][0]["flexible"]["file"] = "identity.json"
    (tmp_path / "identity.json").write_bytes((RESOURCES / "FlexiblePendulum" / "beam.json").read_bytes())
    with pytest.raises(sigmafmu.SigmafmuError, match=r"^a file of modal data is called identity\.json, "):
        sigmafmu.build_fmu(taken, tmp_path / "x.fmu", resources=tmp_path)
