"""Mechanisms from files: read by one table of keys, placed, assembled, and told what is wrong with all of them."""

ENDINGS = (".yaml", ".yml", ".json")
"""Of the names of mechanism files."""
