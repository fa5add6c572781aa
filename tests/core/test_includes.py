"""The layers of the C++ sources: includes point downward, fmi → integrator → solve → multibody → model → lie → text."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
SOURCES = ROOT / "fmu_src"
LAYERS = ("text", "lie", "model", "multibody", "solve", "integrator", "fmi")
INCLUDE = re.compile(r'^\s*#\s*include\s*(?:"([^"]+)"|<([^>]+)>)', re.MULTILINE)

FILES = sorted(path.relative_to(SOURCES).as_posix() for ext in ("*.h", "*.cpp") for path in SOURCES.rglob(ext))
every_file = pytest.mark.parametrize("file", FILES)


def includes(text):
    """(own, foreign): names in quotes and in angle brackets."""
    found = INCLUDE.findall(text)
    return [own for own, _ in found if own], [foreign for _, foreign in found if foreign]


def includes_of(file):
    return includes((SOURCES / file).read_text(encoding="utf-8"))


def layer(file):
    """Index of a file's layer."""
    return LAYERS.index(file.partition("/")[0])


def test_the_sources_are_found():
    assert {file.partition("/")[0] for file in FILES} == set(LAYERS)
    assert len(FILES) > 20


def test_includes_are_parsed():
    text = '// #include "no.h"\n#include <vector>\n  #  include "lie/so3.h"\n#include "fmi/slave.h"  // why\n'
    assert includes(text) == (["lie/so3.h", "fmi/slave.h"], ["vector"])


@every_file
def test_includes_point_downward(file):
    for name in includes_of(file)[0]:
        assert (SOURCES / name).is_file(), f'{file}: "{name}" is no path from fmu_src'
        assert layer(name) <= layer(file), f"{file} includes {name}, which lies above it"


@every_file
def test_headers_are_guarded_and_not_circular(file):
    if not file.endswith(".h"):
        return
    assert "#pragma once" in (SOURCES / file).read_text(encoding="utf-8")
    seen, todo = set(), [file]
    while todo:
        for name in includes_of(todo.pop())[0]:
            assert name != file, f"{file} includes itself"
            if name not in seen:
                seen.add(name)
                todo.append(name)


def test_a_mechanism_needs_only_its_definition_and_the_settings():
    assert set(includes_of("model/mechanism.h")[0]) == {"model/settings.h", "model/definition.h", "model/sensor.h"}
    assert includes_of("model/mechanisms.h")[0] == ["model/mechanism.h"]
    assert includes_of("model/settings.h") == ([], [])
    assert includes_of("model/definition.h")[0] == ["model/elements/coupling.h", "model/elements/elements.h"]
    shared = {path.name: path for path in (ROOT / "models").glob("*.h")}  # parts of several mechanisms
    models = sorted((ROOT / "models").glob("*.cpp"))
    assert models
    for file in [*models, *shared.values()]:
        (included,) = includes(file.read_text(encoding="utf-8"))[0]
        assert included == "model/mechanism.h" or (included in shared and file.suffix == ".cpp"), file.name


def test_the_solver_knows_blocks_only():
    """A sparse solver can take its place without a look at bodies or joints."""
    for file in FILES:
        blocks = ("solve/block_", "solve/order.")
        if file.startswith(blocks):
            assert all(name.startswith(blocks) for name in includes_of(file)[0]), file


def test_step_control_knows_no_method():
    found = {name for ext in (".h", ".cpp") for name in includes_of(f"integrator/step_control{ext}")[0]}
    assert found == {"integrator/step_control.h", "integrator/method.h"}
    assert set(includes_of("integrator/method.h")[0]) == {
        "integrator/state.h",
        "integrator/step_failure.h",
        "multibody/input_signal.h",
    }


def test_the_printed_algorithms_are_apart():
    users = {
        file
        for file in FILES
        if any(name.startswith("integrator/printed/") for name in includes_of(file)[0])
        and not file.startswith("integrator/printed/")
    }
    assert users == {"integrator/integrator.cpp"}


def test_the_integrator_knows_no_joints_and_no_blocks():
    """Of an Evaluation it knows that there is one."""
    inside = re.compile(r"\bincidences\b|\battachment\(|\bjoint\(|\.joints\b|\bphidot\b|_offset\(")
    for file in FILES:
        if file.startswith("integrator/"):
            assert not inside.search((SOURCES / file).read_text(encoding="utf-8")), file


@every_file
def test_only_the_fmi_layer_knows_fmi(file):
    assert file.startswith("fmi/") or not any("fmi" in name.lower() for name in includes_of(file)[1])
    # Functions with C linkage are in fmi2_functions.cpp, behind one guard; unload.cpp only declares those of C.
    if file not in ("fmi/fmi2_functions.cpp", "fmi/unload.cpp"):
        assert 'extern "C"' not in (SOURCES / file).read_text(encoding="utf-8")


def test_json_is_compiled_once():
    """Its header takes seconds: one file of an FMU includes it, for modal data, and one more reads whole mechanisms."""
    users = {file for file in FILES if any("nlohmann" in name for name in includes_of(file)[1])}
    assert users == {"model/json_values.h"}
    assert {file for file in FILES if users & set(includes_of(file)[0])} == {"model/json.cpp", "model/modal_file.cpp"}


@every_file
def test_the_core_does_no_input_or_output(file):
    if file == "text/file.h":
        return
    assert not {"iostream", "fstream", "cstdio", "stdio.h", "thread", "mutex"} & set(includes_of(file)[1])


def test_files_are_read_when_an_fmu_is_instantiated():
    readers = {file for file in FILES if "text/file.h" in includes_of(file)[0]}
    assert readers == {"fmi/model_of_file.cpp", "model/modal_file.cpp"}
