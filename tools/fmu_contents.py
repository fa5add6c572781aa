"""Writes what the build puts into the FMU of a mechanism of models/ beside its binary, from its description.

    python tools/fmu_contents.py description FOLDER --tree TREE --source NAME ...
    python tools/fmu_contents.py contents FOLDER --tree TREE --resources models/resources/HeavyTop

FOLDER has description.json. The first writes TREE/modelDescription.xml, and beside the description mechanism.json and
model.cpp, which tells the binary its mechanism and GUID; the second all else that `sigmafmu.contents` makes, into TREE.
A model without a section in docs/mechanisms.md or a reference gets the rest.
"""

import argparse
import importlib
import importlib.util
import json
import sys
from pathlib import Path
from types import ModuleType

ROOT = Path(__file__).resolve().parents[1]
MODEL = """// Generated.
#include "fmi/model.h"

namespace sigmafmu {{
namespace models {{
Mechanism {model}();
}}

Model make_model(const char*) {{
  Model model;
  model.mechanism = models::{model}();
  model.guid = "{guid}";
  return model;
}}

}}  // namespace sigmafmu
"""


def module(name: str) -> ModuleType:
    """A module of `sigmafmu.contents`, as a package of its own: sigmafmu is not there before it is installed."""
    if "contents" not in sys.modules:
        folder = ROOT / "tools" / "sigmafmu" / "contents"
        place = {"submodule_search_locations": [str(folder)]}
        spec = importlib.util.spec_from_file_location("contents", folder / "__init__.py", **place)
        sys.modules["contents"] = importlib.util.module_from_spec(spec)
    return importlib.import_module(f"contents.{name}")


def main() -> None:
    """Reads the command line that CMake gives."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("what", choices=["description", "contents"])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--tree", type=Path, required=True, help="folder that becomes the FMU")
    parser.add_argument("--resources", type=Path, help="folder of the modal data of flexible bodies")
    parser.add_argument("--source", action="append", default=[], help="a file to compile, as it is named in `sources`")
    options = parser.parse_args()

    told = json.loads((options.folder / "description.json").read_text(encoding="utf-8"))
    description = module("description").Description(told)
    if options.what == "contents":
        references, errors = ROOT / "tests" / "references", ROOT / "models" / "errors"
        places = {"references": references, "errors": errors}
        module("write").write(description, options.resources, ROOT, options.tree, **places, ours=True)
        return
    xml, guid = module("model_description").model_description(description, options.source)
    files = {
        options.tree / "modelDescription.xml": xml,
        options.folder / "mechanism.json": description.mechanism,
        options.folder / "model.cpp": MODEL.format(model=description.model, guid=guid),
    }
    for path, text in files.items():
        path.write_text(text, encoding="utf-8", newline="\n")
    print(f"{description.model}: degrees of freedom: {told['degreesOfFreedom']}")


if __name__ == "__main__":
    main()
