"""Any law as a PythonFMU slave. This file travels inside the FMU, beside the law's: it must not import sigmafmu."""

import sys
from functools import partial
from typing import ClassVar
from xml.etree.ElementTree import Element, SubElement

from pythonfmu import DefaultExperiment, Fmi2Causality, Fmi2Initial, Fmi2Slave, Fmi2Variability, Real


class LawSlave(Fmi2Slave):
    """fmi2DoStep(t, H) is the sample at t: the outputs after it are what the law wants for [t, t + H]."""

    law: type
    start_values: ClassVar = {}
    """Parameters that do not start as the law says."""
    base_units: ClassVar = {}
    """Unit → exponents of its base units, without which OMSimulator does not connect variables."""
    stop_time: float
    step_size: float

    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        # PythonFMU 0.7 crashes when a second instance finds the script of the first one loaded (its issue 228)
        sys.modules.pop(type(self).__module__, None)
        self.modelName = self.law.__name__
        self.description = (self.law.__doc__ or "").partition("\n")[0]
        self.default_experiment = DefaultExperiment(0.0, self.stop_time, self.step_size)
        self.instance = self.law(**self.start_values)
        self.measured = {name: start for name, (start, _, _) in self.law.inputs.items()}
        self.actuation = {name: start for name, (start, _, _) in self.law.outputs.items()}
        self.units = {}
        parameter, tunable = Fmi2Causality.parameter, Fmi2Variability.tunable
        self._register(self.law.inputs, self.measured, causality=Fmi2Causality.input)
        self._register(self.law.outputs, self.actuation, causality=Fmi2Causality.output, initial=Fmi2Initial.exact)
        self._register(self.law.parameters, self.instance.values, causality=parameter, variability=tunable)

    def _register(self, variables, values, **attributes):
        for name, (_, unit, description) in variables.items():
            getter, setter = partial(values.__getitem__, name), partial(values.__setitem__, name)
            self.register_variable(Real(name, description=description, getter=getter, setter=setter, **attributes))
            self.units[name] = unit

    def do_step(self, current_time, step_size):
        """One sample."""
        self.actuation.update(self.instance.step(current_time, step_size, self.measured))
        return True

    def to_xml(self, model_options=None):
        """PythonFMU's model description with what it has no place for: units and dependencies."""
        root = super().to_xml(model_options or {})
        definitions = Element("UnitDefinitions")
        for unit in sorted(set(self.units.values())):
            element = SubElement(definitions, "Unit", name=unit)
            if unit in self.base_units:
                exponents = {name: str(exponent) for name, exponent in self.base_units[unit].items()}
                SubElement(element, "BaseUnit", exponents)
        root.insert(1, definitions)  # after CoSimulation
        for variable in root.iter("ScalarVariable"):
            variable.find("Real").set("unit", self.units[variable.get("name")])
        for unknown in root.iter("Unknown"):
            unknown.set("dependencies", "")  # an output changes at a sample, not when an input is set
        return root
