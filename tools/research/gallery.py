"""Pictures in motion of every mechanism of the package, taken from pages of `sigmafmu view`, and docs/gallery.md."""

import tempfile
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import yaml
from PIL import Image

import sigmafmu
from research.browser import Browser
from research.view import slide
from sigmafmu.view import page as pages
from sigmafmu.view.subject import model_of, scene_of_fmu, to_record

LIBRARY = Path(__file__).resolve().parents[2] / "models" / "library"
WINDOW = (640, 480)
SIZE = (320, 240)
FRAMES = 20
STEPS = 600
"""Communication steps of a run."""
PERIOD = 90
"""Milliseconds that a frame is shown."""
QUALITY = 30
FIRST = "SliderCrank"
"""README.md shows it, larger and with its reactions."""


@dataclass(frozen=True)
class Take:
    """Until when a mechanism is shown [s], after which keys, with which slider of the panel, and driven by what."""

    end: float
    keys: str = ""
    deformation: float = 0.0
    names: bool = False
    settings: dict[str, float] = field(default_factory=dict)


TAKES = {
    "AndrewsSqueezer": Take(0.03),
    "BevelDifferential": Take(1.0),
    "Bicycle": Take(0.5),
    "Bricard": Take(3.0),
    "CardanShaft": Take(0.5),
    "Chain10": Take(2.0),
    "CrankRocker": Take(1.0),
    "DoubleFourBar": Take(3.0),
    "DoubleWishbone": Take(0.5, settings={"wheel.force[3]": 3000.0}),
    "FlexiblePendulum": Take(2.0, keys="t", deformation=0.6),
    "FlexibleSliderCrank": Take(2.0, deformation=0.6),
    "Flyball": Take(2.0),
    "FreeBody": Take(6.0),
    "GearTrain": Take(1.0),
    "HeavyTop": Take(2.0, keys="t"),
    "HighSpeedRotor": Take(6e-4),
    "JeffcottRotor": Take(0.1),
    "PlanarFourBar": Take(2.0),
    "PlanetaryGear": Take(1.0),
    "RobotArm": Take(1.0),
    "RollingCoin": Take(1.0),
    "SliderCrank": Take(1.1, keys="a", names=True),
    "SpinUpBeam": Take(6.0, deformation=0.5, settings={"hubPivot.motorTorque": 200.0}),
    "StewartPlatform": Take(1.0, settings={"leg1.actuatorForce": 2000.0, "leg2.actuatorForce": -2000.0}),
}


def targets() -> dict[str, str]:
    """Name → what `sigmafmu view` takes: models of the package, and files of the library that are none."""
    files = {path.stem: str(path) for path in LIBRARY.glob("*.yaml")}
    return dict(sorted((files | {name: name for name in sigmafmu.models()}).items(), key=lambda item: item[0]))


def write(document: Path, images: Path, names: Iterable[str], on_step: Callable[[str], None]) -> None:
    """Take pictures of `names` (none: all) into the folder `images`/gallery; write `document`."""
    folder = images / "gallery"
    folder.mkdir(parents=True, exist_ok=True)
    browser = Browser(*WINDOW)
    try:
        for name in names or targets():
            on_step(name)
            pictures = _pictures(browser, name, TAKES[name])
            _save(pictures, SIZE, folder / f"{name}.webp")
            if name == FIRST:
                _save(pictures, WINDOW, images / "slider_crank.webp")
    finally:
        browser.driver.quit()
    document.write_text(text(), encoding="utf-8")


def text() -> str:
    """The page."""
    lines = [HEAD]
    for name, target in targets().items():
        shown = target if target == name else f"models/library/{name}.yaml"
        shown += "".join(f" --set '{key}={value:g}'" for key, value in TAKES[name].settings.items())
        lines.append(f"## {name}\n\n{_description(name, target)}.\n\n![{name}](images/gallery/{name}.webp)\n")
        lines.append(f"```\nsigmafmu view {shown}\n```\n")
    return "\n".join(lines)


HEAD = """\
# Gallery

Every mechanism of the package. The commands show each in the browser, to be turned, slowed down and followed
([how](view.md)); bending is exaggerated here. Files are in the folder `models/library` of the sources, and in the
package. Pictures and page are written by `python -m research gallery`.
"""


def _description(name: str, target: str) -> str:
    if target == name:
        return sigmafmu.load(name).description
    return yaml.safe_load(Path(target).read_text(encoding="utf-8"))["description"]


def _pictures(browser: Browser, name: str, take: Take) -> list[Image.Image]:
    """FRAMES of them, evenly from the start."""
    model = model_of(targets()[name])
    scene = scene_of_fmu(model.fmu)
    result = model.run(take.end, step_size=take.end / STEPS, parameters=take.settings, outputs=to_record(model, scene))
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / f"{name}.html"
        file.write_text(pages.page(scene, result), encoding="utf-8")
        browser.open(file)
    browser.press("v", "p")  # without panel and plots
    browser.picture()  # the picture has its size
    browser.press("r", *take.keys)
    while (browser.state["names"] != "none") and not take.names:
        browser.press("l")
    if take.deformation:
        browser.run(slide("deformation", take.deformation))
    pictures = []
    for t in np.linspace(0.0, take.end, FRAMES, endpoint=False):
        browser.run(f"sigmafmu.seek({t})")
        pictures.append(Image.fromarray(browser.picture().astype(np.uint8)))
    return pictures


def _save(pictures: list[Image.Image], size: tuple[int, int], path: Path) -> None:
    first, *rest = [picture.resize(size, Image.Resampling.LANCZOS) for picture in pictures]
    options = {"save_all": True, "duration": PERIOD, "loop": 0, "quality": QUALITY, "method": 6, "minimize_size": True}
    first.save(path, append_images=rest, **options)
