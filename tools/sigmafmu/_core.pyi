"""The compiled module is not part of the public interface, and has no types."""

from typing import Any

def __getattr__(name: str) -> Any: ...
