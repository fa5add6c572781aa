"""Random legal and illegal calls with random arguments on several instances: never a crash, always a sensible status.

A call out of order must give fmi2Error, any other a status that it may give. At the end every instance, however it was
treated, is reset and must reproduce the run of a new one bit by bit.
"""

import ctypes
import math

import pytest
from hypothesis import HealthCheck, settings
from hypothesis import strategies as st
from hypothesis.stateful import (
    Bundle,
    RuleBasedStateMachine,
    consumes,
    initialize,
    multiple,
    rule,
    run_state_machine_as_test,
)

from .helpers import DISCARD, ERROR, OK, Instance, assert_same_bits, inputs, parameters, real_outputs

INSTANTIATED, INITIALIZATION, STEP, TERMINATED = "instantiated", "initialization", "step", "terminated"
ANY = {INSTANTIATED, INITIALIZATION, STEP, TERMINATED}
READABLE = {INITIALIZATION, STEP, TERMINATED}
WRITABLE = {INSTANTIATED, INITIALIZATION, STEP}

REALS = st.one_of(
    st.sampled_from([0.0, 1.0, -1.0, math.nan, math.inf, -math.inf, 1e300, 1e-300, 1e6]), st.floats(-10, 10)
)
# a step that does what it should must end in reasonable time: none between 1e-2 s and what is refused as too long
STEPS = st.sampled_from([0.0, 1e-4, 1e-3, 3.3e-4, -1e-3, math.nan, math.inf, 1e300])
FIRST_STEP = 1e-3


def machine(fmu) -> type[RuleBasedStateMachine]:
    """The state machine for one FMU."""
    slow = {fmu.variables["integrator.stepSize"].valueReference}  # tiny steps are legal and take for ever
    count = len(fmu.variables)
    known = st.integers(0, count - 1).filter(lambda r: r not in slow)
    anything = st.lists(st.one_of(known, st.sampled_from([count, 2**31, 2**32 - 1])), max_size=4)

    def some(names: list[str]) -> st.SearchStrategy[list[int]]:
        """Mostly variables that fit the call."""
        fitting = st.lists(st.sampled_from([r for r in fmu.references(names) if r not in slow]), max_size=4)
        return st.one_of(fitting, fitting, anything)

    settable = some([*inputs(fmu), *(v.name for v in parameters(fmu, "fixed") + parameters(fmu, "tunable"))])
    derivable = st.one_of(some(inputs(fmu)), some(real_outputs(fmu)))
    reference_run = Instance(fmu).start()
    reference = reference_run.trajectory(FIRST_STEP, 5)
    reference_run.free()

    class Master(RuleBasedStateMachine):
        instances = Bundle("instances")
        states = Bundle("states")
        serialized = Bundle("serialized")

        def __init__(self):
            super().__init__()
            self.phase: dict[Instance, str] = {}
            self.made: list[Instance] = []
            self.kept: list[tuple[Instance, ctypes.c_void_p, str]] = []

        def check(self, instance: Instance, allowed: set[str], status: int, *others: int) -> bool:
            """Whether the call did something; fails if its status is not one of the allowed."""
            if self.phase[instance] not in allowed:
                assert status == ERROR
            else:
                assert status in {OK, ERROR, *others}
            return status == OK

        @initialize(target=instances, start=st.booleans())
        def first(self, start):
            return self.instantiate(start)

        @rule(target=instances, start=st.booleans())
        def another(self, start):
            return self.instantiate(start) if len(self.made) < 3 else multiple()

        def instantiate(self, start: bool) -> Instance:
            instance = Instance(fmu)
            self.made.append(instance)
            self.phase[instance] = STEP if start else INSTANTIATED
            return instance.start() if start else instance

        @rule(i=instances, start=REALS, stop=st.one_of(st.none(), REALS))
        def setup(self, i, start, stop):
            status = i.status("fmi2SetupExperiment", 0, 0.0, start, stop is not None, stop or 0.0)
            if self.check(i, {INSTANTIATED}, status):
                i.time = start

        @rule(i=instances)
        def enter(self, i):
            if self.check(i, {INSTANTIATED}, i.status("fmi2EnterInitializationMode")):
                self.phase[i] = INITIALIZATION

        @rule(i=instances)
        def leave(self, i):
            if self.check(i, {INITIALIZATION}, i.status("fmi2ExitInitializationMode")):
                self.phase[i] = STEP

        @rule(i=instances)
        def start(self, i):
            if i.status("fmi2EnterInitializationMode") == OK:
                self.phase[i] = INITIALIZATION
            if i.status("fmi2ExitInitializationMode") == OK:
                self.phase[i] = STEP

        @rule(i=instances, really=st.integers(0, 3))
        def terminate(self, i, really):
            if really == 0 and self.check(i, {STEP}, i.status("fmi2Terminate")):
                self.phase[i] = TERMINATED

        @rule(i=instances, really=st.integers(0, 2))
        def reset(self, i, really):
            if really != 0:
                return
            assert i.status("fmi2Reset") == OK
            self.phase[i], i.time = INSTANTIATED, 0.0

        @rule(i=instances, r=settable, data=st.data())
        def set_real(self, i, r, data):
            values = data.draw(st.lists(REALS, min_size=len(r), max_size=len(r)))
            arguments = (ctypes.c_uint * len(r))(*r), len(r), (ctypes.c_double * len(r))(*values)
            self.check(i, WRITABLE, i.status("fmi2SetReal", *arguments), DISCARD)

        @rule(i=instances, r=settable, value=st.integers(-1, 5))
        def set_integer(self, i, r, value):
            arguments = (ctypes.c_uint * len(r))(*r), len(r), (ctypes.c_int * len(r))(*[value] * len(r))
            self.check(i, WRITABLE, i.status("fmi2SetInteger", *arguments))

        @rule(i=instances, r=some(real_outputs(fmu)))
        def get(self, i, r):
            arguments = (ctypes.c_uint * len(r))(*r), len(r)
            self.check(i, READABLE, i.status("fmi2GetReal", *arguments, (ctypes.c_double * len(r))()), DISCARD)
            self.check(i, READABLE, i.status("fmi2GetInteger", *arguments, (ctypes.c_int * len(r))()), DISCARD)
            self.check(i, READABLE, i.status("fmi2GetBoolean", *arguments, (ctypes.c_int * len(r))()))
            self.check(i, READABLE, i.status("fmi2GetString", *arguments, (ctypes.c_char_p * len(r))()))

        @rule(i=instances, r=derivable, order=st.integers(-1, 3), value=REALS)
        def derivatives(self, i, r, order, value):
            n = len(r)
            arguments = (ctypes.c_uint * n)(*r), n, (ctypes.c_int * n)(*[order] * n)
            rates = (ctypes.c_double * n)(*[value] * n)
            self.check(i, WRITABLE, i.status("fmi2SetRealInputDerivatives", *arguments, rates))
            status = i.status("fmi2GetRealOutputDerivatives", *arguments, (ctypes.c_double * n)())
            self.check(i, {STEP, TERMINATED}, status, DISCARD)

        @rule(i=instances, unknowns=some(real_outputs(fmu)), knowns=some(inputs(fmu)), value=REALS)
        def directional(self, i, unknowns, knowns, value):
            m, n = len(unknowns), len(knowns)
            direction, result = (ctypes.c_double * n)(*[value] * n), (ctypes.c_double * m)()
            arguments = (ctypes.c_uint * m)(*unknowns), m, (ctypes.c_uint * n)(*knowns), n, direction, result
            self.check(i, READABLE, i.status("fmi2GetDirectionalDerivative", *arguments), DISCARD)

        @rule(i=instances, count=st.integers(1, 5))
        def good_steps(self, i, count):
            for _ in range(count):
                self.do_step(i, 1e-3, 0.0)

        @rule(i=instances, H=STEPS, offset=st.sampled_from([0.0, 0.0, 0.0, 1e-12, 0.1, math.nan]))
        def random_step(self, i, H, offset):
            self.do_step(i, H, offset)

        def do_step(self, i, H, offset):
            if self.check(i, {STEP}, i.status("fmi2DoStep", i.time + offset, H, 1), DISCARD):
                i.time += H
            elif self.phase[i] == STEP:
                i.time = i.last_successful_time()

        @rule(i=instances)
        def null_pointers(self, i):
            for function in ("fmi2GetReal", "fmi2SetReal", "fmi2GetInteger", "fmi2SetInteger"):
                assert i.status(function, None, 1, None) == ERROR
            assert i.status("fmi2SetFMUstate", None) == ERROR

        @rule(i=instances, target=states)
        def save(self, i):
            state = i.save()
            self.kept.append((i, state, self.phase[i]))
            return state, self.phase[i], i.time

        @rule(i=instances, state=states)
        def restore(self, i, state):
            pointer, phase, time = state
            assert i.status("fmi2SetFMUstate", pointer) == OK
            self.phase[i], i.time = phase, time

        @rule(i=instances, target=serialized)
        def serialize(self, i):
            return i.serialized(), self.phase[i], i.time

        @rule(i=instances, data=consumes(serialized), cut=st.integers(0, 40), flip=st.integers(0, 10**6))
        def deserialize(self, i, data, cut, flip):
            content, phase, time = data
            damaged = bytearray(content[: len(content) - cut])
            if cut == 0 and flip % 3 == 0:  # intact
                i.deserialize(content)
                self.phase[i], i.time = phase, time
                return
            damaged[flip % len(damaged)] ^= 0x10
            pointer = ctypes.c_void_p()
            buffer = (ctypes.c_char * len(damaged)).from_buffer(damaged)
            status = i.status("fmi2DeSerializeFMUstate", buffer, len(damaged), ctypes.byref(pointer))
            assert status == ERROR
            assert not pointer.value

        def teardown(self):
            for owner, state, _ in self.kept:
                owner.slave.freeFMUstate(state)
            for instance in self.made:
                assert instance.status("fmi2Reset") == OK
                instance.time = 0.0
                assert_same_bits(instance.start().trajectory(FIRST_STEP, 5), reference)
                instance.free()

    return Master


@pytest.mark.parametrize("name", ["HeavyTop", "HighSpeedRotor", "SliderCrank"])
def test_random_calls(fmu, name):
    run_state_machine_as_test(
        machine(fmu(name)),
        settings=settings(
            max_examples=100,
            stateful_step_count=40,
            deadline=None,
            derandomize=True,
            suppress_health_check=list(HealthCheck),
        ),
    )
