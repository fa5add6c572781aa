"""All that an FMU tells beside modelDescription.xml."""

import json
import shutil
from pathlib import Path

import matplotlib

from . import documentation, draw, reference, terminals
from .description import Description
from .layout import NO_SHAPES, Shapes

FOLDERS = ("documentation", "terminalsAndIcons", "extra")


def write(
    description: Description,
    resources: Path,
    texts: Path,
    out: Path,
    *,
    references: Path | None = None,
    errors: Path | None = None,
    source: Path | None = None,
    ours: bool,
    shapes: Shapes = NO_SHAPES,
) -> None:
    """Writes all but modelDescription.xml into the FMU's folder `out`.

    `resources` has the modal data of flexible bodies, `texts` what is quoted (see `documentation.write`);
    `references` and `errors` are the folders of reference results and of their errors, for mechanisms that have them.
    `shapes` tell what bodies look like.
    """
    for folder in FOLDERS:
        shutil.rmtree(out / folder, ignore_errors=True)
    mechanism = json.loads(description.mechanism)
    with matplotlib.rc_context():  # a user's own settings must not change an FMU
        matplotlib.rcdefaults()
        draw.draw_icon(mechanism, resources, out / "model.png", shapes)
        figure = draw.draw_figure(mechanism, resources, shapes)
        terminals.write(description, out)
        experiment = reference.write(description, references, errors, out) if references and errors else None
        documentation.write(description, figure, texts, out, experiment=experiment, source=source, ours=ours)
