"""From descriptions of robots to mechanism files: URDF, MJCF and SDF.

A reader (urdf.py, mjcf.py, sdf.py) makes a Robot of a file, reduce.py takes out what has no mass or does not move
against its neighbour, write.py writes the mechanism file. What has no counterpart is told in one list.
"""
