"""Numbers with limits."""

from sigmafmu.mechanism_file.kinds import Number
from sigmafmu.mechanism_file.structures import List


def least(dimension: str) -> Number:
    """A number that must not be negative."""
    return Number(dimension, 0.0)


def positive(dimension: str) -> Number:
    """A number above zero."""
    return Number(dimension, 0.0, above=True)


def limits(dimension: str) -> List:
    """The least and the largest of what is allowed."""
    return List(Number(dimension), 2)
