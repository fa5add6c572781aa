"""The command `sigmafmu convert`."""

import pytest

from ..command_line import run
from .test_urdf import ARM, joint, link, robot


@pytest.fixture(autouse=True)
def _folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "arm.urdf").write_text(ARM, encoding="utf-8")


def test_convert_writes_and_tells(tmp_path):
    result = run("convert arm.urdf")
    assert result.exit_code == 0
    assert result.stdout.splitlines() == [
        "wrote Some.yaml",
        "different, or not in the file:",
        "- largest efforts and velocities of joints",
        "- part of the ground, not drawn: world",
        "Some: 3 bodies, 3 joints",
        "degrees of freedom: 3 (18 velocities, 15 independent joint equations)",
    ]
    text = (tmp_path / "Some.yaml").read_text(encoding="utf-8")
    assert text.startswith("# Made by sigmafmu convert of arm.urdf.\n# What is different, or not here:\n# - largest")
    assert run("run Some.yaml --stop-time 0.01").exit_code == 0


def test_convert_overwrites_only_what_is_named():
    run("convert arm.urdf")
    result = run("convert arm.urdf")
    assert (result.exit_code, result.stderr) == (1, "Error: Some.yaml exists; -o Some.yaml overwrites it\n")
    assert run("convert arm.urdf -o Some.yaml").exit_code == 0


def test_mistakes_are_one_line(tmp_path):
    (tmp_path / "bad.urdf").write_text(robot(link("a"), joint("i", "fixed", "a", "b")), encoding="utf-8")
    result = run("convert bad.urdf")
    assert result.exit_code == 1
    assert result.stderr == "bad.urdf:3: joint i: there is no link b; allowed is a\n"
    result = run("convert absent.urdf")
    assert (result.exit_code, result.stderr) == (1, "absent.urdf: cannot be read: No such file or directory\n")


def test_meshes_are_named_from_the_file_that_is_written(tmp_path):
    (tmp_path / "robots" / "meshes").mkdir(parents=True)
    (tmp_path / "robots" / "meshes" / "a.stl").touch()
    visual = '<visual><geometry><mesh filename="meshes/a.stl"/></geometry></visual>'
    text = robot('<link name="world"/>', link("a", more=visual), joint("i", "continuous", "world", "a"))
    (tmp_path / "robots" / "arm.urdf").write_text(text, encoding="utf-8")
    (tmp_path / "out").mkdir()
    run("convert robots/arm.urdf -o out/arm.yaml")
    assert 'mesh: "../robots/meshes/a.stl"' in (tmp_path / "out" / "arm.yaml").read_text(encoding="utf-8")
