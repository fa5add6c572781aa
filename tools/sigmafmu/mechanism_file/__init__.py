"""Mechanisms from files: read by one table of keys, placed, assembled, and told what is wrong with all of them."""

MECHANISM_FILES = (".yaml", ".yml", ".json")
"""Endings of their names."""
