"""Many instances: they share nothing, and leave nothing behind."""

import ctypes
import gc
import os
import threading
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from sigmafmu.fmu import Fmu

from .helpers import ERROR, Instance, assert_same_bits, inputs, same_bits

VARIANTS = (
    {},
    {"integrator.formulation": "index3", "integrator.newton": "modified"},
    {"integrator.corrector": "incremental", "integrator.sigma": 1.3},
    {"integrator.spectralRadius": 0.5, "gravity": (1.0, 2.0, -3.0)},
    {"integrator.method": "rkmk4", "integrator.group": "SE3"},
    {"integrator.method": "rkmk54", "integrator.absoluteCoordinates": "rotationVector"},
    {"integrator.method": "bliedf2", "integrator.group": "SE3", "integrator.localCoordinates": "cayley"},
)
COUNT = 200  # communication steps


def push(instance: Instance, i: int) -> None:
    """Inputs at the i-th communication point."""
    names = inputs(instance.fmu)
    instance.set({name: 0.05 * np.sin(0.1 * i + k) for k, name in enumerate(names)})


def run(instance: Instance, settings: dict) -> np.ndarray:
    instance.start(settings)
    H, rows = 2.5 * instance.get("integrator.stepSize"), []
    for i in range(COUNT):
        push(instance, i)
        instance.slave.doStep(i * H, H)
        rows.append(instance.outputs())
    return np.array(rows)


@pytest.fixture
def alone(new, model) -> list[np.ndarray]:
    """Each variant by itself, one after the other."""
    results = []
    for settings in VARIANTS:
        instance = new(model)
        results.append(run(instance, settings))
        instance.free()
    return results


def test_interleaved_instances_do_as_if_they_were_alone(new, model, alone):
    instances = [new(model) for _ in VARIANTS]
    for instance, settings in zip(instances, VARIANTS, strict=True):
        instance.start(settings)
    H = 2.5 * instances[0].get("integrator.stepSize")
    rows: list[list[np.ndarray]] = [[] for _ in VARIANTS]
    for i in range(COUNT):
        for instance in instances:
            push(instance, i)
        for instance in reversed(instances):
            instance.slave.doStep(i * H, H)
        for instance, outputs in zip(instances, rows, strict=True):
            outputs.append(instance.outputs())
    for outputs, expected in zip(rows, alone, strict=True):
        assert_same_bits(np.array(outputs), expected)


def test_instances_in_threads_do_as_if_they_were_alone(new, model, alone):
    """Each in its own thread, all at the same time; ctypes releases the interpreter's lock during calls."""
    instances = [new(model) for _ in VARIANTS]
    results: list[np.ndarray | None] = [None] * len(VARIANTS)
    barrier = threading.Barrier(len(VARIANTS))

    def work(i: int) -> None:
        barrier.wait()
        results[i] = run(instances[i], VARIANTS[i])

    threads = [threading.Thread(target=work, args=(i,)) for i in range(len(VARIANTS))]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for result, expected in zip(results, alone, strict=True):
        assert_same_bits(result, expected)


def test_instances_in_threads_during_long_steps(new, model):
    """One communication step of many internal ones: the threads are inside the binary together."""
    reference = new(model).start()
    H = 5000 * reference.get("integrator.stepSize")
    reference.step(H)
    instances = [new(model).start() for _ in range(4)]
    threads = [threading.Thread(target=instance.step, args=(H,)) for instance in instances]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert all(same_bits(instance.outputs(), reference.outputs()) for instance in instances)


def test_instance_may_move_to_another_thread(new, model):
    """Masters with thread pools call one instance from many threads, one after the other."""
    instance, reference = new(model), new(model).start()
    H = 2.5 * float(instance.fmu.variables["integrator.stepSize"].start)

    def in_thread(call, *arguments) -> None:
        thread = threading.Thread(target=call, args=arguments)
        thread.start()
        thread.join()

    in_thread(instance.start)
    for _ in range(20):
        in_thread(instance.step, H)
        reference.step(H)
    assert_same_bits(instance.outputs(), reference.outputs())


def test_instances_of_different_fmus_do_not_clash(new, models, alone, model):
    """All binaries loaded at once, in the order that the files have."""
    others = [new(other).start() for other in models]
    for settings, expected in zip(VARIANTS, alone, strict=True):
        for other in others:
            other.step(1e-3)
        assert_same_bits(run(new(model), settings), expected)


# --- memory ----------------------------------------------------------------------------------------------------------


class _MallInfo(ctypes.Structure):
    """What glibc's mallinfo2 returns."""

    _fields_ = tuple(
        (name, ctypes.c_size_t)
        for name in ("arena", "ordblks", "smblks", "hblks", "hblkhd", "usmblks", "fsmblks", "used", "free", "keepcost")
    )


def resident_memory() -> int:
    """Bytes of the process in memory, shared libraries included."""
    return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")


def allocated_memory() -> int | None:
    """Bytes that malloc has given out and not got back, exactly; None where the C library cannot tell."""
    try:
        mallinfo2 = ctypes.CDLL(None).mallinfo2
    except AttributeError:
        return None
    mallinfo2.restype = _MallInfo
    info = mallinfo2()
    return info.used + info.hblkhd


def assert_no_leak(work: Callable[[], None], count: int) -> None:
    """Nothing is left of `count` calls, once caches and arenas have been filled by some."""
    for _ in range(count // 4):
        work()
    gc.collect()
    resident, allocated = resident_memory(), allocated_memory()
    for _ in range(count):
        work()
    gc.collect()
    # Pages come and go; an instance of 20 kB or a state of 1 kB a call would be far more.
    assert resident_memory() - resident <= 600 * count
    if allocated is not None:
        # The interpreter's own few objects of more than 512 bytes.
        assert allocated_memory() - allocated <= count


memory = pytest.mark.skipif(
    not Path("/proc/self/statm").exists() or "asan" in os.environ.get("LD_PRELOAD", ""),
    reason="needs /proc, and an allocator that gives memory back",
)


@memory
def test_two_thousand_instances_leave_no_memory_behind(new, fmu, model):
    opened: Fmu = fmu(model)
    slave = new(model).slave
    location = (opened.directory / "resources").as_uri().encode()
    arguments = (opened.description.guid.encode(), location, ctypes.byref(slave.callbacks), 0, 0)

    def live_and_die() -> None:
        component = slave.fmi2Instantiate(b"one of many", 1, *arguments)
        assert component
        slave.fmi2EnterInitializationMode(component)
        slave.fmi2ExitInitializationMode(component)
        slave.fmi2DoStep(component, 0.0, 1e-4, 1)
        slave.fmi2FreeInstance(component)

    assert_no_leak(live_and_die, 2000)  # a block of one byte that stays each time is noticed


@memory
def test_ten_thousand_resets_leave_no_memory_behind(new, model):
    instance = new(model)

    def again() -> None:
        instance.start()
        instance.step(1e-4)
        instance.reset()

    assert_no_leak(again, 10_000)


@memory
def test_a_thousand_states_leave_no_memory_behind(new, model):
    instance = new(model).start()
    data = instance.serialized()

    def save_and_restore() -> None:
        state = instance.save()
        instance.restore(state)
        instance.slave.freeFMUstate(state)
        instance.deserialize(data)
        assert instance.status("fmi2SetFMUstate", None) == ERROR
        instance.messages.clear()

    assert_no_leak(save_and_restore, 1000)


@memory
def test_refused_calls_leave_no_memory_behind(new, model):
    """Those in the constructor too: nothing half made remains."""
    instance = new(model)
    slave, callbacks = instance.slave, ctypes.byref(instance.slave.callbacks)

    def refuse() -> None:
        assert slave.fmi2Instantiate(b"name", 1, b"{no such guid}", None, callbacks, 0, 0) is None
        assert instance.status("fmi2DoStep", 0.0, 1e-3, 1) != 0
        instance.messages.clear()

    assert_no_leak(refuse, 1000)
