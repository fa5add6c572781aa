"""Writes what informs a reader or a tool into the folder of an FMU, run by the build after modelDescription.xml.

    python tools/fmu_contents HeavyTop --model-description tree/modelDescription.xml --mechanism mechanism.json \\
        --resources models/resources/HeavyTop --references tests/references --output tree

makes there:

    model.png                             the icon, drawn from the mechanism
    documentation/index.html              with a figure of the mechanism and text from docs/
    documentation/licenses/               entry point license.txt
    terminalsAndIcons/                    FMI 3.0's terminals, which FMI 2.0.4 adopted
    extra/org.fmi-standard.fmi-ls-ref/    reference result with its error bounds, and documentation/fmi-ls-ref.html

A model without a section in docs/mechanisms.md or a reference gets the rest. Needs Matplotlib, lxml and Jinja2; FMPy
brings the last two.
"""

import argparse
import json
import shutil
from pathlib import Path

import documentation
import draw
import matplotlib
import reference
import terminals
from description import read_description

ROOT = Path(__file__).resolve().parents[2]
FOLDERS = ("documentation", "terminalsAndIcons", "extra")


def main() -> None:
    """Reads the command line that CMake gives."""
    parser = argparse.ArgumentParser(prog="fmu_contents", description=__doc__.split("\n")[0])
    parser.add_argument("model")
    parser.add_argument("--model-description", type=Path, required=True, help="modelDescription.xml of the model")
    parser.add_argument("--mechanism", type=Path, required=True, help="mechanism.json of the model")
    parser.add_argument("--elements", type=Path, required=True, help="elements.json of the model")
    parser.add_argument("--resources", type=Path, required=True, help="folder of the modal data of flexible bodies")
    parser.add_argument("--references", type=Path, required=True, help="folder of the reference solutions")
    parser.add_argument("--output", type=Path, required=True, help="folder that becomes the FMU")
    options = parser.parse_args()
    description = read_description(options.model_description, options.elements)
    out: Path = options.output

    for folder in FOLDERS:
        shutil.rmtree(out / folder, ignore_errors=True)
    matplotlib.rcdefaults()  # a user's own settings must not change an FMU
    mechanism = json.loads(options.mechanism.read_text(encoding="utf-8"))
    draw.draw_icon(mechanism, options.resources, out / "model.png")
    figure = draw.draw_figure(mechanism, options.resources)
    terminals.write(description, out)
    experiment = reference.write(description, options.references, ROOT / "models" / "errors", out)
    documentation.write(description, experiment, figure, ROOT, out)


if __name__ == "__main__":
    main()
