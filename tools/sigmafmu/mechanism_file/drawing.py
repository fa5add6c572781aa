"""Draws a mechanism at its start, as the FMUs' documentation shows it."""

import json
from pathlib import Path

from sigmafmu import SigmafmuError, native
from sigmafmu.mechanism_file.load import MechanismFile, folder_of


def draw(file: MechanismFile, path: Path) -> None:
    """Write a PNG; raises SigmafmuError."""
    from sigmafmu.contents.draw import draw_figure  # Matplotlib takes a second to load

    with folder_of(file.resources) as folder:
        picture = draw_figure(json.loads(native.describe(file.text, folder)["mechanism"]), folder)
    try:
        picture.save(path)
    except OSError as error:
        raise SigmafmuError(f"cannot write {path}: {error.strerror}") from error
