"""Measures the pages of `sigmafmu view` in headless Chromium, and writes docs/view.md's table and pictures."""

import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from PIL import Image

from research.browser import Browser
from sigmafmu.view import page as pages
from sigmafmu.view.subject import model_of, scene_of_fmu, to_record

LIBRARY = Path(__file__).resolve().parents[2] / "models" / "library"
SIZE = (1000, 760)
FRAMES = 300
"""So many frames of the playing page are prepared to tell what one costs."""
START, END = "<!-- measured -->", "<!-- /measured -->"
HEAD = (
    "| mechanism | bodies | frames | page | of it scene and motion | written in | first picture | script per frame "
    "| draw calls |\n"
    "|---|---|---|---|---|---|---|---|---|\n"
)
COST = """
const { view, player } = sigmafmu, { renderer } = view, render = renderer.render;
const calls = renderer.info.render.calls;
player.play(false);
renderer.render = () => {};  // that is the graphics card's work, which is done by the processor here
player.play(true);
const began = performance.now();
for (let k = 0; k < FRAMES; k++) {
  player.tick(1 / 60);
  view.draw();
}
const cost = (performance.now() - began) / FRAMES;
renderer.render = render;
return [cost, calls];
"""


@dataclass(frozen=True)
class Shot:
    """A mechanism to measure; with a picture if it has a `time` for that, after a script."""

    target: str
    stop_time: float | None = None
    time: float | None = None
    keys: str = ""
    script: str = ""


def slide(name: str, power: float) -> str:
    """A script that moves the slider `name` of the panel."""
    return (
        f"const slider = document.querySelector('[aria-label={name}]');"
        f"slider.value = {power}; slider.dispatchEvent(new Event('input'));"
    )


SHOTS = {
    "slider_crank": Shot("SliderCrank", time=0.38, keys="a"),
    "closed_loop": Shot(str(LIBRARY / "AndrewsSqueezer.yaml"), time=0.02, keys="d"),
    "flexible": Shot("FlexiblePendulum", time=1.7, keys="t", script=slide("deformation", 0.8)),
    "robot": Shot(str(LIBRARY / "RobotArm.yaml"), stop_time=1.0, time=0.1, keys="dt"),
    "rotor": Shot("HighSpeedRotor", stop_time=0.1, time=0.05),
    "chain": Shot("Chain30"),
}


def chain(links: int = 30) -> str:
    """A mechanism file: a chain of hinged links that falls for 10 s, with 60 rows a second."""
    hinge = "orientation: { rpy: ['90 deg', 0, 0] }"
    bodies = [
        f"link{i}: {{ mass: 1, inertia: [0.01, 0.01, 0.001], center_of_mass: [0, 0, -0.1] }}" for i in range(links)
    ]
    joints = [
        f"joint{i}: {{ type: revolute, bodies: [{f'link{i - 1}' if i else 'ground'}, link{i}], coordinate: 0.1, "
        f"frame1: {{ position: [0, 0, {-0.2 if i else 0}], {hinge} }}, frame2: {{ {hinge} }} }}"
        for i in range(links)
    ]
    lines = [f"sigmafmu: 1\nname: Chain{links}\nbodies:", *(f"  {body}" for body in bodies)]
    lines += ["joints:", *(f"  {joint}" for joint in joints)]
    lines += [f"experiment: {{ stop_time: 10, step_size: {1 / 60} }}", f"integrator: {{ stepSize: {1 / 120} }}"]
    return "\n".join(lines) + "\n"


def write(document: Path, images: Path, on_step: Callable[[str], None]) -> None:
    """Put the measured table into `document` between its marks, and pictures into the folder `images`."""
    rows = []
    browser = Browser(*SIZE)
    try:
        with tempfile.TemporaryDirectory() as folder:
            for name, shot in SHOTS.items():
                on_step(name)
                rows.append(_measured(browser, name, shot, Path(folder), images))
    finally:
        browser.driver.quit()
    text = document.read_text(encoding="utf-8")
    before, after = text.partition(START)[0], text.partition(END)[2]
    document.write_text(f"{before}{START}\n{HEAD}{''.join(rows)}{END}{after}", encoding="utf-8")


def _measured(browser: Browser, name: str, shot: Shot, folder: Path, images: Path) -> str:
    target = shot.target
    if target == "Chain30":
        target = str(folder / "Chain30.yaml")
        Path(target).write_text(chain(), encoding="utf-8")
    model = model_of(target)
    scene = scene_of_fmu(model.fmu)
    result = model.run(shot.stop_time, outputs=to_record(model, scene))
    began = time.perf_counter()
    text = pages.page(scene, result)
    spent = time.perf_counter() - began
    file = folder / f"{name}.html"
    file.write_text(text, encoding="utf-8")
    browser.open(file)
    loaded = browser.run("return sigmafmu.loaded")
    frames = browser.run("return sigmafmu.player.motion.time.length")
    cost, calls = browser.run(COST.replace("FRAMES", str(FRAMES)))
    if shot.time is not None:
        browser.press(*shot.keys)
        browser.run(shot.script)
        browser.run(f"sigmafmu.seek({shot.time})")
        browser.picture()  # waits for it
        picture = images / f"view_{name}.png"
        browser.driver.save_screenshot(str(picture))
        Image.open(picture).convert("P", palette=Image.Palette.ADAPTIVE, colors=256).save(picture, optimize=True)
    size = len(text.encode()) / 1e6
    own = size - len(pages.viewer_source().encode()) / 1e6
    values = (
        f"{size:.2f} MB",
        f"{own:.2f} MB",
        f"{spent:.1f} s",
        f"{loaded / 1e3:.1f} s",
        f"{cost:.1f} ms",
        str(calls),
    )
    return f"| {model.name} | {len(scene.layout.bodies)} | {frames} | {' | '.join(values)} |\n"
