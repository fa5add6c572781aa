"""The folder of an FMU that has this machine's binary."""

import fmpy

PLATFORM = "aarch64-linux" if fmpy.platform_tuple == "aarch64-linux" else fmpy.platform
"""FMI's name of this platform. FMPy takes ARM Linux for linux64, which is x86-64."""
