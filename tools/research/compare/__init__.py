"""Problems of the IFToMM library of benchmarks, and the slider-crank, beside other codes.

`python -m research compare` writes the measured part of docs/compare.md.
"""
