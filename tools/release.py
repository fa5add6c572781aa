"""Makes the FMUs that are given away: their `sources` folder, compiled for every platform of cmake/toolchains.

    python tools/release.py build/release/fmus dist

The compiler is Zig's (package ziglang), which needs some minutes on the first run: it compiles the C++ library of each
platform. Each FMU is rebuilt from what it contains, so this also shows that its sources are complete; what the FMUs
share is compiled once for each platform.
"""

import argparse
import os
import shutil
import subprocess
import sys
import time
import zipfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import ziglang

ROOT = Path(__file__).parents[1]
WORK = ROOT / "build" / "cross"
TOOLCHAINS = sorted(path for path in (ROOT / "cmake" / "toolchains").glob("*64.cmake"))


def run(command: list[str | Path], environment: dict[str, str]) -> None:
    """Runs a command silently; shows all that it printed if it fails."""
    done = subprocess.run(command, env=environment, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    if done.returncode:
        sys.exit(f"release: {' '.join(map(str, command))} failed:\n{done.stdout}")


def unpack(fmu: Path, tree: Path) -> None:
    """Makes the folder hold the files of an FMU. Equal files keep their time, so that nothing is compiled again."""
    with zipfile.ZipFile(fmu) as archive:
        contents = {tree / name: archive.read(name) for name in archive.namelist() if not name.endswith("/")}
    for path in sorted(tree.rglob("*"), reverse=True):  # what is in a folder comes before it
        if path.is_dir() and not any(path.iterdir()):
            path.rmdir()
        elif path.is_file() and path not in contents:
            path.unlink()
    for file, content in contents.items():
        file.parent.mkdir(parents=True, exist_ok=True)
        if not file.is_file() or file.read_bytes() != content:
            file.write_bytes(content)


def compile_for(toolchain: Path, tree: Path) -> None:
    """Adds the binary of a platform to an unpacked FMU."""
    environment = os.environ | {
        "ZIG": str(Path(ziglang.__file__).with_name("zig")),
        "ZIG_GLOBAL_CACHE_DIR": str(WORK / "zig-cache"),
    }
    build = WORK / toolchain.stem
    run(["cmake", "-G", "Ninja", "-S", tree / "sources", "-B", build, "--toolchain", toolchain], environment)
    run(["cmake", "--build", build, "--target", "install"], environment)


def main() -> None:
    """Reads the command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("fmus", type=Path, help="folder of FMUs")
    parser.add_argument("output", type=Path)
    options = parser.parse_args()
    fmus = sorted(options.fmus.glob("*.fmu"))
    if not fmus:
        sys.exit(f"release: no FMU in {options.fmus}; `make build` makes them.")

    options.output.mkdir(parents=True, exist_ok=True)
    platforms = " and ".join(toolchain.stem for toolchain in TOOLCHAINS)
    tree = WORK / "fmu"  # one folder for all, in turns: CMake finds what they share compiled
    for fmu in fmus:
        unpack(fmu, tree)
        shutil.rmtree(tree / "binaries")
        print(f"release: {fmu.stem} for {platforms} ", end="", flush=True)
        start = time.monotonic()
        with ThreadPoolExecutor() as pool:
            list(pool.map(lambda toolchain: compile_for(toolchain, tree), TOOLCHAINS))
        print(f"({time.monotonic() - start:.0f} s)", flush=True)
        packed = shutil.make_archive(str(WORK / fmu.stem), "zip", tree)
        shutil.move(packed, options.output / fmu.name)
    print(f"release: {len(fmus)} FMUs in {options.output}")


if __name__ == "__main__":
    main()
