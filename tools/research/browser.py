"""Headless Chromium, driven by Selenium: opens pages of `sigmafmu view` and tells what they show."""

import io
import shutil
import time
from pathlib import Path

import numpy as np
from PIL import Image

PROGRAMS = {"chromium": ("chromium", "chromium-browser", "google-chrome"), "driver": ("chromedriver",)}
OPTIONS = (
    *("--headless=new", "--no-sandbox", "--disable-dev-shm-usage", "--hide-scrollbars"),
    *("--use-angle=swiftshader", "--enable-unsafe-swiftshader"),  # WebGL without a graphics card
    "--force-device-scale-factor=1",
)
PATIENCE = 30.0
"""Seconds until a page must be there."""


class MissingError(Exception):
    """There is no browser."""


def programs() -> tuple[str, str]:
    """Paths of Chromium and its driver; raises MissingError where they are not installed."""
    found = [next((path for name in names if (path := shutil.which(name))), None) for names in PROGRAMS.values()]
    if None in found:
        raise MissingError("Chromium and its driver are not installed: apt-get install chromium chromium-driver")
    return found[0], found[1]


class Browser:
    """A browser with one page."""

    def __init__(self, width: int = 900, height: int = 640):
        from selenium import webdriver
        from selenium.webdriver.chrome.options import Options
        from selenium.webdriver.chrome.service import Service

        chromium, driver = programs()
        options = Options()
        options.binary_location = chromium
        for option in OPTIONS:
            options.add_argument(option)
        options.add_argument(f"--window-size={width},{height}")
        options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
        self.driver = webdriver.Chrome(options=options, service=Service(driver))

    def open(self, page: Path) -> None:
        """Open a file and wait until it runs."""
        self.log("browser"), self.log("performance")  # what was before
        self.driver.get(page.absolute().as_uri())
        self.wait("return !!window.sigmafmu")

    def wait(self, condition: str) -> None:
        """Wait until a script returns true."""
        end = time.monotonic() + PATIENCE
        while not self.run(condition):
            assert time.monotonic() < end, (condition, self.log("browser"))
            time.sleep(0.02)

    def run(self, script: str):
        """What a script returns."""
        return self.driver.execute_script(script)

    def log(self, kind: str) -> list[str]:
        """Messages since the last time."""
        return [entry["message"] for entry in self.driver.get_log(kind)]

    @property
    def state(self) -> dict:
        """What the page says of itself."""
        return self.run("return sigmafmu.state")

    def press(self, *keys: str) -> None:
        """Press keys, one after the other, as a user does."""
        from selenium.webdriver.common.action_chains import ActionChains

        for key in keys:
            ActionChains(self.driver).send_keys(key).perform()

    def picture(self) -> np.ndarray:
        """The picture of the mechanism with what lies over it, height × width × 3."""
        self.run("return new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")
        png = self.driver.find_element("css selector", ".stage").screenshot_as_png
        return np.asarray(Image.open(io.BytesIO(png)).convert("RGB"), dtype=int)

    def pixel(self, point) -> np.ndarray:
        """Where a point of W is in the picture, by the camera's place and a projection of our own."""
        camera = self.state["camera"]
        eye, target, up = (np.array(camera[key]) for key in ("position", "target", "up"))
        back = (eye - target) / np.linalg.norm(eye - target)
        right = np.cross(up, back) / np.linalg.norm(np.cross(up, back))
        x, y, z = np.array([right, np.cross(back, right), back]) @ (np.asarray(point) - eye)
        width, height = self.size
        focal = height / 2 / np.tan(np.radians(camera["angle"]) / 2)
        return np.array([width / 2 + focal * x / -z, height / 2 - focal * y / -z])

    @property
    def size(self) -> tuple[int, int]:
        """Width and height of the picture."""
        return tuple(self.run("const s = document.querySelector('.stage'); return [s.clientWidth, s.clientHeight]"))
