"""The script tools/viewer/build.py as a module of another name: PyPI has a package `build`."""

import importlib.util
from pathlib import Path
from types import ModuleType

FILE = Path(__file__).resolve().parents[2] / "tools" / "viewer" / "build.py"


def viewer_build() -> ModuleType:
    """A new one."""
    spec = importlib.util.spec_from_file_location("viewer_build", FILE)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module
