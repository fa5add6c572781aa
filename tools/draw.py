"""Draws the mechanisms of models/ into build/images, as the build draws them into their FMUs.

.venv/bin/python tools/draw.py [MODEL ...]
"""

import json
import sys
from pathlib import Path

from sigmafmu.contents.draw import draw_figure, draw_icon

ROOT = Path(__file__).resolve().parents[1]

if __name__ == "__main__":
    built, images = ROOT / "build" / "release" / "fmu", ROOT / "build" / "images"
    images.mkdir(exist_ok=True)
    for model in sys.argv[1:] or sorted(path.parent.name for path in built.glob("*/mechanism.json")):
        mechanism = json.loads((built / model / "mechanism.json").read_text(encoding="utf-8"))
        resources = ROOT / "models" / "resources" / model
        draw_figure(mechanism, resources).save(images / f"{model}.png")
        draw_icon(mechanism, resources, images / f"{model}.icon.png")
        sys.stdout.write(f"drew {model}\n")
