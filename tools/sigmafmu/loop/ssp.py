"""Writes a closed loop as an SSP 1.0 system: the plant's FMU, an FMU of every law, SystemStructure.ssd."""

import tempfile
import zipfile
from collections.abc import Mapping
from pathlib import Path

from fmpy.model_description import BaseUnit
from lxml import etree
from lxml.builder import ElementMaker

from sigmafmu import SigmafmuError, __version__
from sigmafmu.fmu import Fmu
from sigmafmu.loop.closed_loop import split_start_values
from sigmafmu.loop.controller_fmu import build
from sigmafmu.loop.loops import Loop
from sigmafmu.variables import SettingValue, parse_settings

PLANT = "plant"
"""Name of the component that holds the mechanism."""
NAMESPACES = {
    "ssd": "http://ssp-standard.org/SSP1/SystemStructureDescription",
    "ssc": "http://ssp-standard.org/SSP1/SystemStructureCommon",
    "ssv": "http://ssp-standard.org/SSP1/SystemStructureParameterValues",
    "osp": "http://opensimulationplatform.com/SSP/OSPAnnotations",
}
SSD, SSC, SSV, OSP = (ElementMaker(namespace=uri, nsmap=NAMESPACES) for uri in NAMESPACES.values())
EXPONENTS = ("kg", "m", "s", "A", "K", "mol", "cd", "rad")


def write_ssp(loop: Loop, path: Path | str, start_values: Mapping[str, SettingValue] | None = None) -> None:
    """Write `loop` to `path`; `start_values` as in `run_closed_loop`, with Reals only.

    Start values of the laws become those of their FMUs and are bound as well. Those of the plant are bound alone, which
    FMPy and Ecos ignore; without any, every master starts the same system.
    """
    plant = Fmu.of_model(loop.plant)
    plant_settings, part_values = split_start_values(loop, start_values or {})
    plant_values = {variable.name: value for variable, value in parse_settings(plant, plant_settings)}
    path = Path(path)
    with tempfile.TemporaryDirectory() as name:
        files = {PLANT: plant.path}
        for part, wires in loop.parts.items():
            files[part] = build(
                wires.law, Path(name), step_size=loop.H, stop_time=loop.stop_time, values=part_values[part]
            )
        try:
            with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
                archive.writestr("SystemStructure.ssd", _structure(loop, plant, plant_values, part_values))
                for component, file in files.items():
                    archive.write(file, f"resources/{component}.fmu")
        except OSError as error:
            raise SigmafmuError(f"cannot write {path}: {error.strerror}") from error


def _structure(
    loop: Loop, plant: Fmu, plant_values: Mapping[str, float], part_values: Mapping[str, Mapping[str, float]]
) -> bytes:
    def unit(name: str) -> str:
        return plant.variables[name].unit

    components, connections = [], []
    for part, wires in loop.parts.items():
        law = wires.law
        starts = {name: part_values[part].get(name, start) for name, (start, _, _) in law.parameters.items()}
        inputs = {name: unit(source) for name, source in wires.measured.items()}
        outputs = {name: unit(target) for name, target in wires.actuated.items()}
        components.append(_component(part, inputs, outputs, starts))
        connections += [_connection(PLANT, source, part, name) for name, source in wires.measured.items()]
        connections += [_connection(part, name, PLANT, target) for name, target in wires.actuated.items()]
    inputs, outputs = {name: unit(name) for name in loop.inputs}, {name: unit(name) for name in loop.outputs}
    components.insert(0, _component(PLANT, inputs, outputs, plant_values))

    used = {*inputs.values(), *outputs.values()}
    units = [_unit(u.name, u.baseUnit) for u in plant.description.unitDefinitions if u.name in used]
    root = SSD.SystemStructureDescription(
        SSD.System(SSD.Elements(*components), SSD.Connections(*connections), name=loop.plant),
        SSD.Units(*units),
        SSD.DefaultExperiment(_step_size_for_libcosim(loop.H), startTime="0", stopTime=repr(loop.stop_time)),
        version="1.0",
        name=loop.plant,
        generationTool=f"sigmafmu {__version__}",
    )
    return etree.tostring(root, xml_declaration=True, encoding="UTF-8", pretty_print=True)


def _component(
    name: str, inputs: Mapping[str, str], outputs: Mapping[str, str], starts: Mapping[str, float]
) -> etree._Element:
    """A component with its connectors (name → unit) and start values bound inline."""
    connectors = [
        SSD.Connector(SSC.Real(unit=unit), name=variable, kind=kind)
        for kind, variables in (("input", inputs), ("output", outputs))
        for variable, unit in variables.items()
    ]
    component = SSD.Component(
        SSD.Connectors(*connectors),
        name=name,
        type="application/x-fmu-sharedlibrary",
        source=f"resources/{name}.fmu",
        implementation="CoSimulation",
    )
    if starts:
        values = [
            SSV.Parameter(SSV.Real(value=repr(float(value))), name=variable) for variable, value in starts.items()
        ]
        parameters = SSV.ParameterSet(SSV.Parameters(*values), version="1.0", name=f"{name}Start")
        component.append(SSD.ParameterBindings(SSD.ParameterBinding(SSD.ParameterValues(parameters))))
    return component


def _connection(start: str, start_connector: str, end: str, end_connector: str) -> etree._Element:
    return SSD.Connection(
        startElement=start, startConnector=start_connector, endElement=end, endConnector=end_connector
    )


def _unit(name: str, base: BaseUnit) -> etree._Element:
    """A unit by its exponents, which SSP wants for every one."""
    exponents = {e: str(int(getattr(base, e))) for e in EXPONENTS if getattr(base, e)}
    return SSC.Unit(SSC.BaseUnit(**exponents), name=name)


def _step_size_for_libcosim(H: float) -> etree._Element:
    """SSP 1.0 has no place for the communication step; libcosim reads it from this annotation."""
    algorithm = OSP.Algorithm(OSP.FixedStepAlgorithm(baseStepSize=repr(H)))
    return SSD.Annotations(SSC.Annotation(algorithm, type="com.opensimulationplatform"))
