"""A mechanism that nobody has told the tests about: put into `models`, it builds, and the tests of the FMUs pass on it.

Three of them in a copy of the source tree, compiled there.
"""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
NEW = Path(__file__).parent / "models"
COPIED = (
    "CMakeLists.txt",
    "LICENSE",
    "README.md",
    "cmake",
    "docs",
    "fmu_src",
    "modelDescription",
    "pyproject.toml",
    "tests",
    "tools",
)

pytestmark = [pytest.mark.release, pytest.mark.slow]


@pytest.fixture(scope="module")
def run():
    """Function that runs a command with the tools of this environment and without sanitizers; returns its output."""
    paths = [str(Path(sys.executable).parent), os.environ["PATH"]]
    environment = os.environ | {"PATH": os.pathsep.join(paths), "VIRTUAL_ENV": sys.prefix}

    def call(*command: str | Path, may_fail: bool = False, **variables: str) -> str:
        done = subprocess.run(list(map(str, command)), text=True, capture_output=True, env=environment | variables)
        assert may_fail or done.returncode == 0, (done.stdout + done.stderr)[-8000:]
        return done.stdout + done.stderr

    return call


@pytest.fixture(scope="module")
def tree(tmp_path_factory, run) -> Path:
    """The sources with the new models alone, configured in `build`."""
    tree = tmp_path_factory.mktemp("sources")
    for name in COPIED:
        copy = shutil.copytree if (ROOT / name).is_dir() else shutil.copy
        copy(ROOT / name, tree / name)
    (tree / "models").mkdir()
    for file in NEW.glob("*.cpp"):
        shutil.copy(file, tree / "models")
    shutil.copytree(ROOT / "models" / "errors", tree / "models" / "errors")
    run("cmake", "-G", "Ninja", "-S", tree, "-B", tree / "build")
    return tree


def test_the_tests_of_the_fmus_pass_on_new_models(tree, run):
    said = run("cmake", "--build", tree / "build", "--target", "fmus")
    assert "HangingChain: degrees of freedom: 4 (12 velocities, 8 independent joint equations)" in said
    assert "SupportedBar: degrees of freedom: 6 (6 velocities, 0 independent joint equations)" in said
    assert "InclinedSlider: degrees of freedom: 3 (12 velocities, 9 independent joint equations)" in said
    fmus = tree / "build" / "fmus"
    assert sorted(path.stem for path in fmus.glob("*.fmu")) == sorted(path.stem for path in NEW.glob("*.cpp"))
    run(sys.executable, tree / "tools" / "update_model_descriptions.py", fmus)
    pytest_arguments = ("-q", "-n", str(os.cpu_count()), "-m", "not slow and not heavy and not release")
    passed = run(sys.executable, "-m", "pytest", *pytest_arguments, tree / "tests" / "fmu", SIGMAFMU_FMUS=str(fmus))
    assert " passed" in passed


# Three links in a square, closed by the ground.
SQUARE = """#include <string>

#include "model/mechanism.h"

namespace sigmafmu::models {

Mechanism NAME() {
  Mechanism m;
  m.name = "NAME";
  m.description = "Square of three links and the ground";
  const Vector3d corners[] = {{0, 0, 0}, {0, 1, 0}, {1, 1, 0}, {1, 0, 0}};
  for (int i = 0; i < 3; ++i) {
    RigidBodyDef link;
    link.name = "link" + std::to_string(i + 1);
    link.initial_position = (corners[i] + corners[i + 1]) / 2;
    m.multibody.add(link);
  }
  const JointType kinds[] = {KINDS};
  for (int i = 0; i < 4; ++i) {
    const auto frame = [&](int body) {
      return body == kGround ? Frame{corners[i]} : Frame{corners[i] - m.multibody.bodies[body].initial_position};
    };
    const int body1 = i - 1, body2 = i < 3 ? i : kGround;
    m.multibody.add(JointDef{"corner" + std::to_string(i + 1), kinds[i], body1, frame(body1), body2, frame(body2)});
  }
  return m;
}

}  // namespace sigmafmu::models
"""


def write_square(tree, name, kinds):
    file = tree / "models" / f"{name}.cpp"
    types = ", ".join(f"JointType::{kind}" for kind in kinds.split())
    file.write_text(SQUARE.replace("NAME", name).replace("KINDS", types))
    return file


def test_a_mechanism_that_cannot_move_does_not_build(tree, run):
    """The axis of the prismatic joint is the normal of the plane."""
    file = write_square(tree, "NoFreedom", "revolute revolute spherical prismatic")
    try:
        run("cmake", tree / "build")
        said = run("cmake", "--build", tree / "build", "--target", "NoFreedom", may_fail=True)
        assert "NoFreedom cannot move: degrees of freedom: 0 (18 velocities, 18 independent joint equations)" in said
    finally:
        file.unlink()


def test_a_mechanism_with_dependent_joints_builds_and_says_so(tree, run):
    file = write_square(tree, "FourBar", "revolute revolute revolute revolute")
    try:
        run("cmake", tree / "build")
        said = run("cmake", "--build", tree / "build", "--target", "FourBar")
        freedom = "1 (18 velocities, 17 independent joint equations, 3 dependent ones)"
        assert f"FourBar: degrees of freedom: {freedom}" in said
        description = tree / "build" / "fmu" / "FourBar" / "tree" / "modelDescription.xml"
        assert 'name="joints.redundant"' in description.read_text()
    finally:
        file.unlink()


# Free bodies with all their variables.
CLOUD = """#include <string>

#include "model/mechanism.h"

namespace sigmafmu::models {

Mechanism Cloud() {
  Mechanism m;
  m.name = "Cloud";
  m.description = "Free bodies";
  m.expose = ExposureDef{{"*"}, {"*"}, {"*"}};
  for (int i = 0; i < BODIES; ++i) {
    RigidBodyDef body;
    body.name = "body" + std::to_string(i + 1);
    m.multibody.add(body);
  }
  return m;
}

}  // namespace sigmafmu::models
"""


@pytest.mark.parametrize(("bodies", "listed"), [(2, True), (200, False)])
def test_a_million_pairs_of_variables_have_no_list_of_dependencies(tree, run, bodies, listed):
    """An output without a list may depend on all inputs, says FMI; thousands of each would take hours and gigabytes."""
    file = tree / "models" / "Cloud.cpp"
    file.write_text(CLOUD.replace("BODIES", str(bodies)))
    try:
        run("cmake", tree / "build")
        run("cmake", "--build", tree / "build", "--target", "Cloud")
        description = (tree / "build" / "fmu" / "Cloud" / "tree" / "modelDescription.xml").read_text()
        assert 'name="body1.force[1]"' in description
        assert ("dependencies=" in description) == listed
    finally:
        file.unlink()
