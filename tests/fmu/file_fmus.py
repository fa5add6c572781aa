"""FMUs of files for tests: mechanisms as the content of mechanism.json, and instances that may be refused."""

import ctypes
import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import fmpy
from fmpy.fmi2 import fmi2CallbackFunctions, fmi2CallbackLoggerTYPE

import sigmafmu
from sigmafmu import _core
from sigmafmu.fmu import Fmu

RESOURCES = Path(sigmafmu.__file__).parent / "resources"


def mechanism_of(model: str) -> dict[str, Any]:
    """A mechanism of models/."""
    return json.loads(_core.to_json(_core.mechanism(model)))


def chain(links: int) -> dict[str, Any]:
    """Links on hinges, each turned a little; but for the first one the same as the one before."""
    bodies, joints = [], []
    for k in range(1, links + 1):
        inertia = {"xx": 0.02, "yy": 0.09, "zz": 0.1}
        bodies.append({"name": f"link{k}", "mass": 1.0, "inertia": inertia, "position": [k - 0.5, 0, 0]})
        joints.append(
            {
                "name": f"hinge{k}",
                "type": "revolute",
                "bodies": ["ground" if k == 1 else f"link{k - 1}", f"link{k}"],
                "frame1": {"position": [0 if k == 1 else 0.5, 0, 0]},
                "frame2": {"position": [-0.5, 0, 0]},
            }
        )
    return {
        "sigmafmu": 1,
        "name": f"Chain{links}",
        "gravity": [0, -9.81, 0],
        "bodies": bodies,
        "joints": joints,
        "expose": {"outputs": [f"link{links}.position", "energy.*", "hinge*.angle"], "parameters": ["gravity"]},
    }


class Resources:
    """An FMU of a file with a copy of its resources that can be edited."""

    def __init__(self, fmu: Fmu, folder: Path):
        self.fmu = fmu
        self.folder = folder
        shutil.copytree(fmu.directory / "resources", folder)

    def edit(self, change: Callable[[Any], Any], name: str = "mechanism.json") -> None:
        """Applies a change to the content of a file."""
        path = self.folder / name
        content = json.loads(path.read_text(encoding="utf-8"))
        replaced = change(content)
        path.write_text(json.dumps(content if replaced is None else replaced), encoding="utf-8")

    def instantiate(self) -> list[str]:
        """The messages of an attempt to make an instance, which is freed; none when it succeeds."""
        messages: list[str] = []
        callbacks = fmi2CallbackFunctions()
        callbacks.logger = fmi2CallbackLoggerTYPE(lambda *call: messages.append(call[4].decode()))
        description = self.fmu.description
        suffix = fmpy.sharedLibraryExtension
        binary = self.fmu.directory / "binaries" / fmpy.platform / f"{description.modelName}{suffix}"
        library = ctypes.CDLL(str(binary))
        library.fmi2Instantiate.restype = ctypes.c_void_p
        library.fmi2FreeInstance.argtypes = (ctypes.c_void_p,)
        component = library.fmi2Instantiate(
            b"it", 1, description.guid.encode(), str(self.folder).encode(), ctypes.byref(callbacks), 0, 0
        )
        assert bool(component) != bool(messages)
        if component:
            library.fmi2FreeInstance(component)
        return messages

    def opened(self, path: Path) -> Fmu:
        """The FMU with these resources, as a file."""
        tree = path.with_suffix("")
        fmpy.extract(self.fmu.path, tree)
        shutil.rmtree(tree / "resources")
        shutil.copytree(self.folder, tree / "resources")
        shutil.make_archive(str(tree), "zip", tree)
        tree.with_suffix(".zip").rename(path)
        return Fmu(path)
