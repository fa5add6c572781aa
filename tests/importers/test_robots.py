"""Some of the robots of docs/robots.md, where the packages of `make bench` are installed, and the page's words."""

from importlib.metadata import PackageNotFoundError, version

import pytest

from research.robots import page
from research.robots.page import PACKAGES, descriptions, measure

ROBOTS = {
    "example-robot-data": (
        "double_pendulum_description/urdf/double_pendulum",
        "panda_description/urdf/panda",  # mimic joints
        "romeo_description/urdf/romeo",  # links without mass
        "solo_description/robots/solo12",  # a free base
    ),
    "gymnasium": ("hopper", "humanoid"),
}


@pytest.mark.parametrize("name", [name for names in ROBOTS.values() for name in names])
def test_accelerations_agree(name):
    pytest.importorskip("pinocchio")
    pytest.importorskip("mujoco")
    (package,) = (package for package in PACKAGES if name in ROBOTS[package.name])
    try:
        version(package.name)
    except PackageNotFoundError:
        pytest.skip(f"{package.name} is not installed; `make bench` adds it")
    (path,) = (path for found, path in descriptions(package) if found == name)
    assert package.compare(path, package.name, 3).error < 1e-10


def test_what_is_told_is_counted_by_kind():
    told = ["a: no body has the principal moments 1, 1, 3; they are", "b: starts at 1, since 0 is beyond its limits"]
    assert page._short([*told, *told, "contacts", "meshes that were not found: 2, x"]) == (
        "impossible inertias (2); starts beyond limits (2); contacts; meshes that were not found"
    )
    assert len(page._short(["x" * 300])) == page.SHOWN


def test_a_robot_is_measured(tmp_path):
    pytest.importorskip("mujoco")
    path = tmp_path / "bar.xml"
    path.write_text(
        '<mujoco><worldbody><body><joint name="j" axis="0 1 0"/><geom size="0.1" pos="1 0 0"/></body></worldbody>'
        "</mujoco>",
        encoding="utf-8",
    )
    name, bodies, degrees, error, size, told = measure("bar", path, PACKAGES[1])
    assert (name, bodies, degrees, told) == ("`bar`", "1", "1", "contacts")
    assert float(error) < 1e-13
    assert 1 < float(size) < 10
