"""The page of `sigmafmu view` in a real browser."""

import json
from pathlib import Path

import numpy as np
import pytest
from PIL import Image, ImageFilter
from scipy.interpolate import CubicSpline

import sigmafmu
from research.browser import Browser, MissingError
from sigmafmu.contents import draw
from sigmafmu.contents.raster import paint
from sigmafmu.view import page as pages
from sigmafmu.view.subject import model_of, scene_of_fmu, to_record

G = 9.81
V = np.array([0.3, 1.2, 2.5])
THROWN = """
sigmafmu: 1
name: Thrown
gravity: [0, 0, -9.81]
bodies:
  stone:
    mass: 1
    inertia: [0.01, 0.01, 0.01]
    position: [0, 0, 0]
    velocity: [0.3, 1.2, 2.5]
    angular_velocity: [0, 0, 20]
    shapes: [{ sphere: 0.03, color: "#ff0000" }, { sphere: 0.02, position: [0.3, 0, 0], color: "#00ff00" }]
  weight:
    mass: 1
    inertia: [0.01, 0.01, 0.01]
    position: [1, 0, 0]
    velocity: [0, 0, 1]
    shapes: [{ sphere: 0.02, color: "#0000ff" }]
experiment: { stop_time: 0.6, step_size: 0.01 }
"""


@pytest.fixture(scope="module")
def browser():
    try:
        browser = Browser()
    except MissingError as error:
        pytest.skip(str(error))
    yield browser
    browser.driver.quit()


@pytest.fixture(scope="module")
def page(viewer, tmp_path_factory):
    """Function that writes the page of a model or a file, and tells its path."""
    written = {}

    def get(target: str, stop_time: float | None = None) -> Path:
        if target not in written:
            model = model_of(target)
            scene = scene_of_fmu(model.fmu)
            result = model.run(stop_time, outputs=to_record(model, scene))
            written[target] = tmp_path_factory.mktemp("view") / f"{model.name}.html"
            written[target].write_text(pages.page(scene, result), encoding="utf-8")
        return written[target]

    return get


@pytest.fixture(scope="module")
def thrown(tmp_path_factory, page):
    file = tmp_path_factory.mktemp("thrown") / "Thrown.yaml"
    file.write_text(THROWN, encoding="utf-8")
    return page(str(file))


SHAKEN = """
sigmafmu: 1
name: Shaken
gravity: [0, 0, -9.81]
bodies:
  bob: { mass: 1, inertia: [0.01, 0.01, 0.01] }
joints:
  pin: { type: spherical, bodies: [ground, bob], frame1: { motion: shaker }, frame2: { position: [0, 0, 0.5] } }
motions:
  shaker: { position: [0.2, 0, 0], x: [[0, 0], [0.2, 0.1], [0.5, -0.1], [1, 0.2]] }
experiment: { stop_time: 1, step_size: 0.01 }
"""


@pytest.fixture(scope="module")
def shaken(tmp_path_factory, page):
    file = tmp_path_factory.mktemp("shaken") / "Shaken.yaml"
    file.write_text(SHAKEN, encoding="utf-8")
    return page(str(file))


def requests(browser: Browser) -> list[str]:
    """Addresses that the page asked for."""
    events = [json.loads(message)["message"] for message in browser.log("performance")]
    return [e["params"]["request"]["url"] for e in events if e["method"] == "Network.requestWillBeSent"]


@pytest.mark.parametrize("target", ["FlexibleSliderCrank", "HighSpeedRotor"])
def test_page_runs_without_errors_and_network(browser, page, target):
    file = page(target, 0.2)
    browser.open(file)
    browser.wait("return sigmafmu.state.frames > 5")
    assert browser.log("browser") == []
    assert [url for url in requests(browser) if not url.startswith("data:")] == [file.as_uri()]
    assert browser.state["playing"]
    picture = browser.picture()
    background = picture[2, picture.shape[1] // 2]
    different = (np.abs(picture - background).max(axis=2) > 40).mean()
    assert 0.02 < different < 0.6


@pytest.mark.parametrize("t", [0.0, 0.2034, 0.55])
def test_body_is_drawn_where_it_is(browser, thrown, t):
    """The parabola and the spin, known without any simulation; t lies between frames, too."""
    browser.open(thrown)
    browser.run(f"sigmafmu.seek({t})")
    browser.press("l", "l")  # no names in front of it
    centre = V * t - [0, 0, G * t**2 / 2]
    expected = browser.pixel(centre)
    drawn = browser.run("return sigmafmu.project('stone')")
    left, top = browser.run(
        "const r = document.querySelector('canvas').getBoundingClientRect(); return [r.left, r.top]"
    )
    assert np.linalg.norm(expected - (drawn["x"] - left, drawn["y"] - top)) < 0.2
    picture = browser.picture()
    tip = centre + 0.3 * np.array([np.cos(20 * t), np.sin(20 * t), 0])
    for point, channel in ((centre, 0), (tip, 1)):
        others = [i for i in range(3) if i != channel]
        colored = (picture[..., channel] > 90) & (picture[..., others].max(axis=2) < 0.55 * picture[..., channel])
        rows, columns = np.nonzero(colored)
        assert len(rows) > 20
        seen = np.array([columns.min() + columns.max() + 1, rows.min() + rows.max() + 1]) / 2
        assert np.linalg.norm(seen - browser.pixel(point)) < 2


@pytest.mark.parametrize("t", [0.0, 0.2, 0.734])
def test_a_moving_frame_is_drawn_where_it_is(browser, shaken, t):
    """The feet of the pin go with the shaker, whose table SciPy's natural spline interpolates as well."""
    browser.open(shaken)
    browser.run(f"sigmafmu.seek({t})")
    moved = CubicSpline([0, 0.2, 0.5, 1], [0, 0.1, -0.1, 0.2], bc_type="natural")(t)
    drawn = browser.run("return sigmafmu.project('shaker', 'ground')")
    left, top = browser.run(
        "const r = document.querySelector('canvas').getBoundingClientRect(); return [r.left, r.top]"
    )
    expected = browser.pixel(np.array([0.2 + moved, 0, 0]))
    assert np.linalg.norm(expected - (drawn["x"] - left, drawn["y"] - top)) < 0.2
    assert t == 0 or np.linalg.norm(expected - browser.pixel(np.array([0.2, 0, 0]))) > 10


def test_keys_control_the_player(browser, thrown):
    from selenium.webdriver.common.keys import Keys

    browser.open(thrown)
    browser.press(Keys.SPACE)
    assert not browser.state["playing"]
    browser.press(Keys.HOME)
    assert browser.state["time"] == 0
    browser.press(Keys.ARROW_RIGHT, Keys.ARROW_RIGHT, Keys.ARROW_RIGHT, Keys.ARROW_LEFT)
    assert browser.state["time"] == pytest.approx(2 * 0.01, abs=1e-8)
    browser.press(Keys.END)
    assert browser.state["time"] == pytest.approx(0.6, abs=1e-8)
    speed = browser.state["speed"]
    browser.press("+", "+", "+")
    assert browser.state["speed"] == pytest.approx(10 * speed)
    browser.press("-")
    assert browser.state["speed"] == pytest.approx(4 * speed)  # from 5 to 2
    browser.press(Keys.HOME, Keys.SPACE)
    browser.wait("return sigmafmu.state.time > 0.1")


def test_keys_control_the_picture(browser, page):
    browser.open(page("SliderCrank", 0.2))
    browser.press(" ")
    before = browser.state
    browser.press("f")
    assert browser.state["followed"] == 0
    browser.press("a", "t", "x", "d", "l")
    after = browser.state
    for switch in ("arrows", "paths", "axes"):
        assert not before[switch]
        assert after[switch]
    assert {before["theme"], after["theme"]} == {"light", "dark"}
    assert before["names"] != after["names"]
    browser.press("f", "f", "f")
    assert browser.state["followed"] == -1
    browser.press("1")
    camera = browser.state["camera"]
    assert np.argmax(np.abs(np.subtract(camera["position"], camera["target"]))) == 0
    browser.press("v", "p")
    width, height = browser.size
    assert width == browser.run("return innerWidth")
    assert height > 0.8 * browser.run("return innerHeight")
    browser.press("h")
    assert browser.run("return document.querySelector('dialog').open")
    assert browser.log("browser") == []


def test_followed_body_stays_in_the_middle(browser, thrown):
    browser.open(thrown)
    browser.press("f")
    for t in (0.1, 0.5):
        browser.run(f"sigmafmu.seek({t})")
        target = np.array(browser.state["camera"]["target"])
        np.testing.assert_allclose(target, V * t - [0, 0, G * t**2 / 2], atol=1e-4)


def test_deformation_is_exaggerated(browser, page):
    browser.open(page("FlexibleSliderCrank", 0.2))
    browser.run("sigmafmu.seek(0.15)")
    browser.press("l", "l")
    before = browser.picture()
    browser.run(
        "const input = document.querySelector('[aria-label=deformation]');"
        "input.value = 2; input.dispatchEvent(new Event('input'))"
    )
    assert (np.abs(browser.picture() - before).max(axis=2) > 60).sum() > 300


def test_notebook_shows_it_in_a_frame(viewer, browser, tmp_path):
    model = sigmafmu.load("HeavyTop")
    notebook = tmp_path / "notebook.html"
    notebook.write_text(f"<!doctype html><meta charset=utf-8>{model.run(0.1).show()._repr_html_()}", encoding="utf-8")
    browser.log("browser")
    browser.driver.get(notebook.as_uri())
    browser.driver.switch_to.frame(0)
    browser.wait("return !!window.sigmafmu && sigmafmu.state.frames > 2")
    assert browser.size[1] > 200
    assert browser.log("browser") == []
    browser.driver.switch_to.default_content()


@pytest.mark.parametrize("model", ["SliderCrank", "HighSpeedRotor"])
def test_picture_is_that_of_the_documentation(browser, page, model):
    """Loosely: the outlines agree with those that the FMU's picture is painted with, by other code."""
    browser.open(page(model, 0.2))
    browser.run("sigmafmu.seek(0)")
    browser.press(*"gll")
    picture = browser.picture()
    mine = np.abs(picture - picture[-3, 3]).max(axis=2) > 12
    mine[:40, :250] = False  # the title
    scene = draw.still(scene_of_fmu(sigmafmu.load(model).fmu))
    scene.solids = [solid for solid in scene.solids if solid.layer not in ("station", "sensor")]
    camera = draw.camera_for(scene, 900, 700, np.array([20, 20]))
    _, seen = paint(draw.painted(scene), camera)
    outlines = [_framed(outline) for outline in (mine, seen >= 0)]
    for one, other in (outlines, outlines[::-1]):
        assert (one & _wider(other)).sum() > 0.95 * one.sum()


def _wider(outline: np.ndarray) -> np.ndarray:
    """What lies within six pixels: the page's camera is near, that of the documentation far away."""
    return np.asarray(Image.fromarray(outline).convert("L").filter(ImageFilter.MaxFilter(13))) > 0


def _framed(outline: np.ndarray) -> np.ndarray:
    """What is true, in the middle of 160 × 160 pixels and just as wide or high."""
    rows, columns = (np.flatnonzero(outline.any(axis=axis)) for axis in (1, 0))
    half = max(np.ptp(rows), np.ptp(columns)) / 2
    y, x = (np.round((a[0] + a[-1]) / 2 + np.linspace(-half, half, 160)).astype(int) for a in (rows, columns))
    room = int(half) + 1
    return np.pad(outline, room)[np.ix_(y + room, x + room)]
