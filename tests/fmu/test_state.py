"""Saving, restoring and serializing the state of an instance: all bit by bit."""

import ctypes
import math
import os
import random
import struct
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from .helpers import (
    ERROR,
    FORMULATIONS,
    METHODS,
    NEWTONS,
    Instance,
    assert_same_bits,
    inputs,
    integrator_combinations,
    parameters,
    rigid_bodies,
)

COMBINATIONS = integrator_combinations()


def names_of(combination: dict) -> str:
    return "-".join(str(value) for value in combination.values())


def communication_step(instance: Instance) -> float:
    """Not a multiple of the internal step: three steps, shorter than the longest allowed."""
    return 2.5 * instance.get("integrator.stepSize")


def shake(instance: Instance, seed: int = 1) -> None:
    """Sets every input to something, a torque on a body to no more than 100 rad/s² of it."""
    rng = np.random.default_rng(seed)
    names = inputs(instance.fmu)
    values = dict(zip(names, 0.1 * rng.uniform(-1, 1, len(names)), strict=True))
    for body in rigid_bodies(instance.fmu):
        for i, moment in enumerate(("xx", "yy", "zz")):
            values[f"{body}.torque[{i + 1}]"] *= min(1.0, 1e3 * instance.get(f"{body}.inertia.{moment}"))
    instance.set(values)


# --- rollback --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("settings", COMBINATIONS, ids=names_of)
def test_rollback_is_bitwise(new, model, settings):
    """Save, 100 steps, restore, 100 steps: identical outputs, counters included, for every kind of integrator."""
    instance = new(model).start(settings)
    H = communication_step(instance)
    shake(instance)
    instance.steps(H, 10)
    state, time = instance.save(), instance.time
    first = instance.trajectory(H, 100)
    assert not np.array_equal(first[0], first[-1])
    instance.restore(state)
    instance.time = time
    assert_same_bits(instance.trajectory(H, 100), first, instance.all_outputs[0] + instance.all_outputs[1])
    instance.slave.freeFMUstate(state)


def test_a_state_can_be_restored_many_times_and_overwritten(new, model):
    instance = new(model).start()
    H = communication_step(instance)
    state = instance.save()
    first = instance.trajectory(H, 5)
    for _ in range(3):
        instance.restore(state)
        instance.time = 0.0
        assert_same_bits(instance.trajectory(H, 5), first)
    later = instance.outputs()
    instance.slave.fmi2GetFMUstate(instance.slave.component, ctypes.byref(state))  # the same memory again
    instance.step(H)
    instance.restore(state)
    assert_same_bits(instance.outputs(), later)
    instance.slave.freeFMUstate(state)
    assert state.value is None
    instance.slave.freeFMUstate(state)  # freeing nothing is allowed


def test_several_states_live_side_by_side(new, model):
    instance = new(model).start()
    H, states, outputs = communication_step(instance), [], []
    for _ in range(5):
        states.append(instance.save())
        outputs.append(instance.outputs())
        instance.step(H)
    for i in (3, 0, 4, 1, 2):
        instance.restore(states[i])
        assert_same_bits(instance.outputs(), outputs[i])
    for state in states:
        instance.slave.freeFMUstate(state)


def test_saving_changes_nothing(new, model):
    instance, other = new(model).start(), new(model).start()
    H = communication_step(instance)
    for _ in range(20):
        instance.slave.freeFMUstate(instance.save())
        instance.serialized()
        for each in (instance, other):
            each.step(H)
    assert_same_bits(instance.outputs(), other.outputs())


# --- what belongs to the state ---------------------------------------------------------------------------------------


def test_pending_input_derivatives_belong_to_the_state(new, model):
    instance = new(model).start()
    H = communication_step(instance)
    instance.step(H)
    shake(instance)
    for order in (1, 2):
        instance.set_input_derivatives(order, dict.fromkeys(inputs(instance.fmu), 50.0))
    state, time = instance.save(), instance.time
    first = instance.trajectory(H, 3)
    instance.set_input_derivatives(1, dict.fromkeys(inputs(instance.fmu), -7.0))
    instance.restore(state)
    instance.time = time
    assert_same_bits(instance.trajectory(H, 3), first)
    instance.slave.freeFMUstate(state)


def test_parameter_changes_and_pending_jumps_belong_to_the_state(new, model):
    """Saved between a change of inputs and parameters and the step that takes it up."""
    instance = new(model).start()
    H = communication_step(instance)
    instance.steps(H, 3)
    tunable = {v.name: 0.5 * float(v.start) + 0.1 for v in parameters(instance.fmu, "tunable")}
    instance.set(tunable)
    shake(instance)
    state, time = instance.save(), instance.time
    first = instance.trajectory(H, 3)
    instance.set(dict.fromkeys(tunable, 0.7))
    instance.restore(state)
    instance.time = time
    assert {name: instance.get(name) for name in tunable} == tunable
    assert_same_bits(instance.trajectory(H, 3), first)
    instance.slave.freeFMUstate(state)


def test_rollback_over_a_change_of_parameters(new, model):
    """Saved before the change: the old values come back."""
    instance, other = new(model).start(), new(model).start()
    H = communication_step(instance)
    for each in (instance, other):
        each.steps(H, 3)
    state, time = instance.save(), instance.time
    instance.set({v.name: 0.5 * float(v.start) + 0.1 for v in parameters(instance.fmu, "tunable")})
    instance.steps(H, 3)
    instance.restore(state)
    instance.time = time
    assert_same_bits(instance.trajectory(H, 5), other.trajectory(H, 5))
    instance.slave.freeFMUstate(state)


OTHER_SETTINGS = {
    "integrator.formulation": "index3",
    "integrator.newton": "modified",
    "integrator.spectralRadius": 0.6,
    "integrator.sigma": 1.3,
}


@pytest.mark.parametrize("disturbance", ["nothing", "same settings", "other settings", "start"])
def test_state_restored_after_a_reset(new, model, disturbance):
    """Whatever has been set meanwhile, fixed parameters too, gives way to what was saved."""
    instance = new(model).start(OTHER_SETTINGS)
    H = communication_step(instance)
    instance.steps(H, 5)
    state, time = instance.save(), instance.time
    first = instance.trajectory(H, 5)
    instance.reset()
    if disturbance == "same settings":
        instance.set(OTHER_SETTINGS)
    elif disturbance == "other settings":
        instance.set({"integrator.corrector": "incremental", "integrator.spectralRadius": 0.9})
    elif disturbance == "start":
        instance.start()
    instance.restore(state)
    instance.time = time
    assert_same_bits(instance.trajectory(H, 5), first)
    assert instance.get("integrator.sigma") == 1.3
    instance.slave.freeFMUstate(state)


def test_state_of_every_phase_restores_that_phase(new, model):
    """Taken before, during and after initialization and after the end."""
    reference = new(model).start(OTHER_SETTINGS)
    H = communication_step(reference)
    expected = reference.trajectory(H, 5)
    instance, states = new(model), {}
    instance.set(OTHER_SETTINGS)
    states["instantiated"] = instance.save()
    instance.slave.enterInitializationMode()
    states["initialization"] = instance.save()
    instance.outputs()
    states["initialized"] = instance.save()
    instance.slave.exitInitializationMode()
    states["step"] = instance.save()
    instance.step(H)
    instance.slave.terminate()
    states["terminated"] = instance.save()
    for phase, state in states.items():
        instance.restore(state)
        instance.time = 0.0
        if phase == "terminated":
            assert instance.status("fmi2DoStep", H, H, 1) == ERROR
            assert_same_bits(instance.outputs(), expected[1])
            continue
        if phase == "instantiated":
            instance.slave.enterInitializationMode()
        if phase != "step":
            instance.slave.exitInitializationMode()
        assert_same_bits(instance.trajectory(H, 5), expected)
    for state in states.values():
        instance.slave.freeFMUstate(state)


def test_reset_gives_the_first_run_again(new, model):
    """All of it is forgotten: parameters, inputs and their derivatives, states, a stop time."""
    fresh, used = new(model).start(), new(model)
    H = communication_step(fresh)
    used.start(
        OTHER_SETTINGS | {v.name: 0.3 for v in parameters(used.fmu, "tunable")}, start_time=1.0, stop_time=1.0 + 25 * H
    )
    shake(used)
    used.steps(H, 20)
    used.set_input_derivatives(1, dict.fromkeys(inputs(used.fmu), 3.0))
    used.reset().start()
    expected = fresh.trajectory(H, 100)
    assert_same_bits(used.trajectory(H, 100), expected)
    used.slave.terminate()
    used.reset().start()
    assert_same_bits(used.trajectory(H, 100), expected)


# --- bytes -----------------------------------------------------------------------------------------------------------


def test_serialized_states_continue_in_another_process(new, model, fmus_dir, tmp_path):
    """Bit by bit, for every kind of integrator, with inputs, derivatives and changed parameters pending."""
    expected = {}
    for settings in COMBINATIONS:
        instance = new(model).start(settings)
        H = communication_step(instance)
        instance.steps(H, 7)
        shake(instance)
        instance.set_input_derivatives(1, dict.fromkeys(inputs(instance.fmu), 5.0))
        instance.set({v.name: 0.9 * float(v.start) for v in parameters(instance.fmu, "tunable")})
        file = tmp_path / names_of(settings)
        file.write_bytes(instance.serialized())
        time = instance.time
        expected[file] = instance.trajectory(H, 50)
        instance.free()
    script = Path(__file__).with_name("continue_from_state.py")
    arguments = [model, repr(time), repr(H), "50", *map(str, expected)]
    subprocess.run(
        [sys.executable, str(script), *arguments],
        check=True,
        timeout=120,
        env=os.environ | {"SIGMAFMU_FMUS": str(fmus_dir)},
    )
    for file, trajectory in expected.items():
        assert_same_bits(np.load(f"{file}.npy"), trajectory)


@pytest.mark.parametrize("newton", NEWTONS)
@pytest.mark.parametrize("formulation", FORMULATIONS)
@pytest.mark.parametrize("method", METHODS)
def test_bytes_taken_in_mid_run_are_all_that_a_method_remembers(new, model, method, formulation, newton):
    """Another instance goes on from them as the first one does, over steps of unequal length and a jump of inputs."""
    settings = {"method": method, "formulation": formulation, "newton": newton}
    instance, other = new(model).start({f"integrator.{name}": value for name, value in settings.items()}), new(model)
    H = communication_step(instance)
    for part in (1.0, 0.3, 1.0):
        instance.step(part * H)
    other.deserialize(instance.serialized())
    other.time = instance.time
    runs = []
    for each in (instance, other):
        rows = [each.outputs()]
        for part in (1.0, 0.1, 1.0, 1.0):
            each.step(part * H)
            rows.append(each.outputs())
            shake(each, len(rows))
        runs.append(np.array(rows))
    assert_same_bits(*runs)


def test_bytes_survive_a_round_trip(new, model):
    instance = new(model).start({"integrator.newton": "modified"})
    H = communication_step(instance)
    instance.steps(H, 3)
    data, time = instance.serialized(), instance.time
    assert instance.serialized() == data
    first = instance.trajectory(H, 5)
    other = new(model)
    other.deserialize(data)
    assert other.serialized() == data
    other.time = time
    assert_same_bits(other.trajectory(H, 5), first)


def refused(instance: Instance, data: bytes) -> str:
    """The message with which `data` is refused."""
    message = instance.refusal(instance.slave.deSerializeFMUstate, data)
    assert message.status == "error"
    return message.text


def test_damaged_bytes_are_refused(new, model):
    instance, other = new(model).start(), new(model).start()
    H = communication_step(instance)
    for each in (instance, other):
        each.steps(H, 3)
    data = instance.serialized()
    for length in (0, 1, 8, 15, 16, 17, 60, len(data) // 2, len(data) - 8, len(data) - 1):
        text = refused(instance, data[:length])
        assert text in {
            "The bytes are no serialized FMU state of sigmafmu.",
            "The serialized FMU state is truncated or damaged: its checksum is wrong.",
        }
    generator = random.Random(1)
    for position in [8, 12, len(data) - 1, *(generator.randrange(8, len(data)) for _ in range(50))]:
        damaged = bytearray(data)
        damaged[position] ^= 1 << generator.randrange(8)
        assert "truncated or damaged" in refused(instance, bytes(damaged))
    assert "truncated or damaged" in refused(instance, data + b"\0")
    assert "no serialized FMU state" in refused(instance, b"\0" * len(data))
    assert "no serialized FMU state" in refused(instance, generator.randbytes(1000))
    for each in (instance, other):
        each.step(H)
    assert_same_bits(instance.outputs(), other.outputs())


def test_bytes_of_another_fmu_are_refused(new, model, models):
    instance = new(model).start()
    for stranger in set(models) - {model}:
        text = refused(instance, new(stranger).start().serialized())
        assert text == "The serialized FMU state belongs to another FMU or another version of it."


def test_a_buffer_that_is_too_small_is_refused(new, model):
    instance = new(model).start()
    state, size = instance.save(), ctypes.c_size_t()
    slave = instance.slave
    slave.fmi2SerializedFMUstateSize(slave.component, state, ctypes.byref(size))
    buffer = ctypes.create_string_buffer(size.value)
    arguments = (slave.component, state, buffer, size.value - 1)
    message = instance.refusal(slave.fmi2SerializeFMUstate, *arguments)
    assert message.text == (
        f"The buffer for the serialized FMU state has {size.value - 1} bytes; {size.value} are needed."
    )
    assert bytes(buffer) == b"\0" * size.value
    slave.fmi2SerializeFMUstate(slave.component, state, buffer, size.value)
    assert bytes(buffer) == instance.serialized()
    slave.freeFMUstate(state)


def checksum(data: bytes) -> bytes:
    """FNV-1a."""
    value = 0xCBF29CE484222325
    for byte in data:
        value = (value ^ byte) * 0x100000001B3 % 2**64
    return value.to_bytes(8, "little")


@pytest.mark.parametrize(
    ("name", "value"),
    [(f"integrator.{n}", x) for n in ("method", "maxHalvings") for x in (math.nan, math.inf, -1e300, 1e10, 99.0)]
    + [("integrator.stepSize", x) for x in (math.nan, 0.0, -1.0)],
)
def test_bytes_with_a_value_that_no_parameter_can_have_are_refused(new, model, name, value):
    """Whoever has computed a checksum for them: as an index or a step size such a number must never be used."""
    instance = new(model).start()
    settable = [v for v in instance.fmu.description.modelVariables if v.causality == "parameter"]
    data = bytearray(instance.serialized())
    first = data.index(struct.pack("<Q", len(settable))) + 8
    start = first + 8 * [v.name for v in settable].index(name)
    data[start : start + 8] = struct.pack("<d", value)
    data[-8:] = checksum(data[:-8])
    message = instance.refusal(instance.slave.deSerializeFMUstate, bytes(data))
    assert message.status == "error"
    assert message.text.startswith(f"The serialized FMU state is damaged. {name} is ")


def test_bytes_with_a_phase_that_does_not_exist_are_refused(new, model):
    instance = new(model).start()
    data = bytearray(instance.serialized())
    guid = instance.fmu.description.guid.encode()
    data[data.index(guid) + len(guid)] = 200
    data[-8:] = checksum(data[:-8])
    message = instance.refusal(instance.slave.deSerializeFMUstate, bytes(data))
    assert (message.status, message.text) == ("error", "The serialized FMU state is damaged.")
