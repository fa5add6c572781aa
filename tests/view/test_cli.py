"""`sigmafmu view` and `run --animate`: what they write, and what they say."""

import json
import re
import webbrowser
from pathlib import Path

import numpy as np
import pytest

import sigmafmu
from research.view import chain
from sigmafmu.contents.scene_of import BODIES, RED
from sigmafmu.view import page as pages

from ..command_line import run, succeed

LIBRARY = Path(__file__).resolve().parents[2] / "models" / "library"
MOST = 3e6
"""Bytes of a page."""


@pytest.fixture(autouse=True)
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


def fail(command: str) -> str:
    result = run(command)
    assert result.exit_code == 1, result.output
    return " ".join(result.stderr.split())


def content(page: Path) -> dict:
    text = page.read_text(encoding="utf-8")
    assert len(text.encode()) < MOST
    assert not re.search(r'<(script|link|img)[^>]*(src|href)="(?!data:,")', text)
    assert "MIT License" in text  # that of three.js
    return json.loads(re.search(r'<script type="application/json" id="scene">(.*?)</script>', text, re.DOTALL)[1])


def test_page_of_a_model_is_written_and_opened(viewer, monkeypatch):
    opened = []
    monkeypatch.setattr(webbrowser, "open", lambda address: opened.append(address) or True)
    assert succeed("view SliderCrank --stop-time 0.1") == "wrote SliderCrank.html\n"
    assert opened == [Path("SliderCrank.html").absolute().as_uri()]
    scene = content(Path("SliderCrank.html"))
    assert [body["name"] for body in scene["bodies"]] == ["crank", "rod", "slider"]
    assert "crankPivot.angle" in scene["plotted"]
    assert {column["unit"] for column in scene["columns"] if column["name"] == "crankPivot.angle"} == {"rad"}


def test_page_of_a_run_and_of_its_result(viewer):
    succeed("run SliderCrank --stop-time 0.1 --output crank.csv --animate run.html")
    succeed("view crank.csv --no-open --output result.html --of SliderCrank")
    assert content(Path("run.html"))["bodies"] == content(Path("result.html"))["bodies"]


def test_result_finds_its_mechanism(viewer):
    succeed(f"run {LIBRARY / 'PlanarFourBar.yaml'} --stop-time 0.1 --output bar.csv")
    assert "bar.csv does not tell its mechanism; name it: --of MODEL" in fail("view bar.csv --no-open")
    Path("Bar.yaml").write_text((LIBRARY / "PlanarFourBar.yaml").read_text())
    succeed("view bar.csv --no-open")
    assert content(Path("bar.html"))["name"] == "bar"


def test_shapes_of_a_file_are_in_its_fmu(viewer):
    succeed(f"build {LIBRARY / 'RobotArm.yaml'} -o arm.fmu")
    succeed(f"view {LIBRARY / 'RobotArm.yaml'} --stop-time 0.1 --no-open -o file.html")
    succeed("view arm.fmu --stop-time 0.1 --no-open -o fmu.html")
    scenes = [content(Path(name)) for name in ("file.html", "fmu.html")]
    assert scenes[0]["items"] == scenes[1]["items"]
    links = {item["color"] for item in scenes[0]["items"] if item["layer"] == "body"}
    assert links == {*BODIES, RED}  # the seventh link has the first colour again, the last one turns


def test_asked_variables_are_plotted(viewer):
    succeed("view HeavyTop --stop-time 0.1 --no-open --variables top.velocity --variables energy.total")
    expected = ["top.velocity[1]", "top.velocity[2]", "top.velocity[3]", "energy.total"]
    assert sorted(content(Path("HeavyTop.html"))["plotted"]) == sorted(expected)


def test_gltf_needs_no_viewer(monkeypatch):
    monkeypatch.setattr(pages, "VIEWER", "absent.js")
    succeed("view HeavyTop --stop-time 0.1 --gltf top.glb")
    assert Path("top.glb").read_bytes()[:4] == b"glTF"
    said = fail("view HeavyTop --stop-time 0.1 --no-open")
    assert "Error: this installation has no viewer, because npm could not be reached when it was built" in said
    assert not Path("HeavyTop.html").exists()


def test_mistakes_are_told():
    said = fail("view HeavyTop --no-open --gltf x.glb --variables energy.totl")
    assert "HeavyTop has no variable 'energy.totl'; did you mean energy.total" in said
    assert "unknown model 'Top'" in fail("view Top --no-open --gltf x.glb")
    Path("short.csv").write_text("time,a\n0,1,2\n")
    assert "short.csv is no result: its first column must be time" in fail("view short.csv --no-open --gltf x.glb")
    assert "absent.csv cannot be read: No such file" in fail("view absent.csv --no-open --gltf x.glb")


def test_notebooks_show_results(viewer):
    model = sigmafmu.load("HeavyTop")
    shown = model.run(0.1).show(height=400)._repr_html_()
    assert shown.startswith('<iframe style="width:100%;height:400px;border:0" sandbox="allow-scripts" srcdoc="&lt;!doc')
    assert shown.count('"') == 6
    with pytest.raises(sigmafmu.SigmafmuError, match=r"the result has no top\.position\[1\]"):
        model.run(0.1, outputs=["energy.total"]).show()


def test_size_of_ten_seconds_of_thirty_bodies(viewer):
    """A chain of thirty links, drawn from inertia, with all reactions: below 3 MB."""
    Path("Chain.yaml").write_text(chain())
    succeed("view Chain.yaml --no-open")
    scene = content(Path("Chain30.html"))
    assert scene["time"]["n"] >= 600
    assert len(scene["bodies"]) == 30
    assert len(scene["arrows"]) == 60


def test_results_can_be_pickled():
    import pickle

    result = sigmafmu.load("HeavyTop").run(0.01)
    again = pickle.loads(pickle.dumps(result))
    assert np.array_equal(again.values, result.values)


def test_meshes_are_drawn(viewer, tmp_path):
    """A tetrahedron in millimetres, on a body whose centre of mass is off its origin."""
    pytest.importorskip("trimesh")
    corners = np.array([(0, 0, 0), (90, 0, 0), (0, 60, 0), (0, 0, 30)])
    facets = "".join(
        "facet normal 0 0 0\nouter loop\n"
        + "".join("vertex {} {} {}\n".format(*corners[i]) for i in face)
        + "endloop\nendfacet\n"
        for face in ((0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3))
    )
    Path("part.stl").write_text(f"solid part\n{facets}endsolid part\n")
    Path("Part.yaml").write_text(
        "sigmafmu: 1\nname: Part\nbodies:\n  part: { mass: 1, inertia: [0.01, 0.01, 0.01], position: [0, 0, 0], "
        "center_of_mass: [0, 0, 0.01], shapes: [{ mesh: part.stl, scale: 0.001, color: '#123456' }] }\n"
    )
    succeed("build Part.yaml -o part.fmu")
    for target in ("Part.yaml", "part.fmu"):
        succeed(f"view {target} --stop-time 0.1 --no-open -o part.html")
        (item,) = (item for item in content(Path("part.html"))["items"] if item["color"] == "#123456")
        low = np.array(item["positions"]["bias"])
        np.testing.assert_allclose(low, [0, 0, -0.01], atol=1e-9)
        assert item["triangles"]["n"] == 4
    Path("Part.yaml").write_text(Path("Part.yaml").read_text().replace("part.stl", "absent.stl"))
    assert "absent.stl cannot be read" in fail("view Part.yaml --no-open")
    assert "1 s simulated" in succeed("run Part.yaml --stop-time 1")  # which needs no looks
