"""The table of the keys of a mechanism file, in which every key is once.

The loader reads by it; the JSON Schema and the tables of the documentation are made of it. A new element is an entry
in one of these modules: its keys, with dimension, meaning and default, and the ends by which it attaches to bodies.
Keys that are no geometry go into the definition under their own names.
"""
