"""Fixtures of the FMU tests."""

from collections.abc import Callable, Iterator

import pytest

from .helpers import Instance


@pytest.fixture
def new(fmu) -> Iterator[Callable[..., Instance]]:
    """Function that makes an instance of a model, in the state `instantiated`; all are freed after the test."""
    made: list[Instance] = []

    def make(model: str, **keywords) -> Instance:
        made.append(Instance(fmu(model), **keywords))
        return made[-1]

    yield make
    for instance in made:
        instance.free()
