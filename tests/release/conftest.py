"""Fixtures of the tests of what is given away."""

import os
import sys
from collections.abc import Callable
from functools import cache
from pathlib import Path

import fmpy
import pytest

from .running import run

ZIG_CACHE = Path(__file__).parents[2] / "build" / "cross" / "zig-cache"  # of tools/release.py: has the C library by now
ZIG = [sys.executable, "-m", "ziglang", "cc", "-O3", "-s", "-target"]  # of FMUs: Zig compiles its libraries for each
COMPILERS = {
    "linux64": [os.environ.get("CXX", "g++"), "-x", "c"],
    "aarch64-linux": [*ZIG, "aarch64-linux-gnu.2.17"],
    "win64": [*ZIG, "x86_64-windows-gnu"],
}


@pytest.fixture(scope="session")
def runner(tmp_path_factory) -> Callable[..., Path]:
    """Function that compiles run_fmu.c, or another program of this folder, for a platform."""
    folder = tmp_path_factory.mktemp("runner")
    headers = Path(fmpy.__file__).parent / "c-code"

    @cache
    def compile_for(platform: str, name: str = "run_fmu") -> Path:
        source, program = Path(__file__).with_name(f"{name}.c"), folder / f"{name}_{platform}.exe"
        libraries = [] if platform == "win64" else ["-ldl"]
        command = [*COMPILERS[platform], "-std=c11", "-I", headers, source, *libraries, "-o", program]
        run(*command, ZIG_GLOBAL_CACHE_DIR=str(ZIG_CACHE))
        return program

    return compile_for
