"""Calls in the wrong order: the states in which the standard allows each function."""

import pytest
from fmpy.fmi2 import fmi2DoStepStatus, fmi2LastSuccessfulTime, fmi2PendingStatus, fmi2Terminated

from .complaints import ALLOWED, STATES, bring_to, calls, complaint
from .helpers import ERROR, OK, assert_same_bits


@pytest.mark.parametrize("state", STATES)
@pytest.mark.parametrize("function", ALLOWED)
@pytest.mark.parametrize("model", ["SliderCrank"])
def test_each_function_is_allowed_in_the_states_of_the_standard(new, model, function, state):
    instance, undisturbed = bring_to(new(model), state), bring_to(new(model), state)
    arguments = calls(instance)[function]
    if state in ALLOWED[function]:
        assert instance.status(function, *arguments) == OK
        assert instance.messages == []
        return
    text = complaint(instance, getattr(instance.slave, function), instance.slave.component, *arguments)
    assert text == f'{function} is not allowed in the state "{state}".'
    # The call has left no trace.
    assert instance.serialized() == undisturbed.serialized()


def test_table_of_calls_is_complete(new):
    assert set(calls(bring_to(new("HeavyTop"), "step mode"))) == set(ALLOWED)


def test_a_second_life_after_the_end(new, model):
    instance, fresh = bring_to(new(model), "terminated"), new(model).start()
    assert instance.status("fmi2DoStep", 1e-3, 1e-3, 1) == ERROR
    instance.reset().start()
    assert_same_bits(instance.trajectory(1e-3, 5), fresh.trajectory(1e-3, 5))


def test_nothing_is_pending(new, model):
    """Steps end before fmi2DoStep returns: there is nothing to cancel and nothing to wait for."""
    instance = new(model).start()
    slave = instance.slave
    assert "no step is pending" in complaint(instance, slave.cancelStep)
    for call, kind in (
        (slave.getStatus, fmi2DoStepStatus),
        (slave.getStringStatus, fmi2PendingStatus),
        (slave.getIntegerStatus, fmi2LastSuccessfulTime),
        (slave.getBooleanStatus, fmi2DoStepStatus),
        (slave.getRealStatus, fmi2DoStepStatus),
    ):
        message = instance.refusal(call, kind)
        assert (message.status, message.category) == ("discard", "logStatusDiscard")
        assert "asynchronous" in message.text
    assert slave.getBooleanStatus(fmi2Terminated) is False
    assert slave.getRealStatus(fmi2LastSuccessfulTime) == 0.0
