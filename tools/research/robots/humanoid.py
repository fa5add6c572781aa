"""What a humanoid costs: from its URDF file to an FMU, and a step of that FMU beside Exudyn in the same run."""

import json
import tempfile
import time
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from research.bench import runs
from research.robots import SEED, without_one_sided
from sigmafmu.fmu import Fmu
from sigmafmu.importers.convert import convert
from sigmafmu.markdown import markdown_table
from sigmafmu.mechanism_file.load import load, load_text
from sigmafmu.packing import build_fmu

ROBOT = "g1_description/urdf/g1_29dof_rev_1_0"
H, STEPS, ROUNDS = 1e-3, 500, 5
POINT = np.zeros(3)


def _timed(work: Callable[[], Any]) -> tuple[Any, float]:
    began = time.perf_counter()
    result = work()
    return result, time.perf_counter() - began


def section(path: Path) -> str:
    """The part of the page about it; `path` is its URDF file."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        text, converting = _timed(lambda: convert(path, folder)[0])
        robot, fmu_file = folder / "robot.yaml", folder / "robot.fmu"
        robot.write_text(text, encoding="utf-8")
        _, loading = _timed(lambda: load(robot))
        _, building = _timed(lambda: build_fmu(robot, fmu_file))
        with zipfile.ZipFile(fmu_file) as archive:
            xml = archive.getinfo("modelDescription.xml").file_size
        size, lines = fmu_file.stat().st_size, text.count("\n")
        robot.write_text(text + "expose: all\n", encoding="utf-8")
        build_fmu(robot, folder / "all.fmu")
        with zipfile.ZipFile(folder / "all.fmu") as archive:
            whole_xml = archive.getinfo("modelDescription.xml").file_size

        moving = load_text(_moving(text), robot)
        robot.write_text(_moving(text), encoding="utf-8")
        build_fmu(robot, folder / "moving.fmu")
        model = Fmu(folder / "moving.fmu")
        last = moving.definition["bodies"][-1]["name"]
        started, starting = _timed(lambda: _start(model))
        started.freeInstance()
        candidates = {
            "core": lambda: runs.core(load_text(_moving(text), robot).mechanism, H, STEPS, POINT),
            "fmu": lambda: runs.fmu(model, f"{last}.position", H, STEPS, {}, runs.DEFAULT),
            "exudyn": lambda: runs.exudyn(moving.mechanism.multibody, H, STEPS, POINT, modified=True, sparse=True),
        }
        found = runs.fastest(candidates, ROUNDS)
    costs = [
        ("`sigmafmu convert`, without the start of Python", f"{converting:.2f} s"),
        ("reading, placing, assembling the file", f"{loading:.2f} s"),
        ("`sigmafmu build`, without that", f"{building - loading:.2f} s"),
        ("lines of the mechanism file", str(lines)),
        ("modelDescription.xml, what `expose: auto` shows", f"{xml / 1e3:.0f} kB"),
        ("modelDescription.xml with `expose: all`", f"{whole_xml / 1e3:.0f} kB"),
        ("FMU, with sources and documentation", f"{size / 1e6:.1f} MB"),
        ("instantiating and initializing", f"{1e3 * starting:.1f} ms"),
        ("a step in the core", f"{1e6 * found['core'].seconds:.0f} µs"),
        (
            f"a step in the FMU, {runs.INTERNAL_STEPS_PER_CALL} in each `fmi2DoStep`",
            f"{1e6 * found['fmu'].seconds:.0f} µs",
        ),
        ("a step in Exudyn", f"{1e6 * found['exudyn'].seconds:.0f} µs"),
        ("Exudyn / FMU", f"{found['exudyn'].seconds / found['fmu'].seconds:.1f}"),
    ]
    bodies, hinges = (len(moving.definition[key]) for key in ("bodies", "joints"))
    gap = float(np.abs(found["fmu"].position - found["exudyn"].position).max())
    text = (
        f"`{ROBOT}`: {bodies} bodies, {hinges} hinges, a free pelvis. It falls\n"
        f"with random rates of its joints, without damping, friction and limits, for {STEPS} steps of {H:g} s;\n"
        "default settings here, Exudyn with modified Newton and its sparse solver. After that a body in our FMU is\n"
        f"{gap:.1e} m from where Exudyn has it."
    )
    return f"## A humanoid\n\n{text}\n\n{markdown_table(('what', 'takes'), costs)}"


def _start(model: Fmu) -> Any:
    slave = model.instantiate()
    slave.setupExperiment()
    slave.enterInitializationMode()
    slave.exitInitializationMode()
    return slave


def _moving(text: str) -> str:
    """The robot with rates of its joints, and nothing that acts on them."""
    content, rng = without_one_sided(text), np.random.default_rng(SEED)
    for joint in content["joints"].values():
        joint.pop("damping", None)
        joint["rate"] = float(rng.uniform(-1, 1))
    last = list(content["bodies"])[-1]
    outputs = {
        "outputs": [f"{last}.position*", "energy.*", "integrator.*"],
        "inputs": [],
        "parameters": ["integrator.*"],
    }
    return json.dumps(content | {"expose": outputs, "integrator": yaml.safe_load(text)["integrator"]})
