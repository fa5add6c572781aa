"""Makes the FMUs that are given away: those of the build, with binaries for other platforms (cmake/toolchains).

    python tools/release.py build/release dist                       # FMUs for linux64 and win64
    python tools/release.py build/release build/universal --wheel    # every platform, with all that the wheel needs

The compiler is Zig's (package ziglang), which needs some minutes on the first run: it compiles the C++ library of each
platform. The core is compiled once for each platform and linked into every FMU.
"""

import argparse
import os
import shutil
import subprocess
import sys
import tarfile
import time
import zipfile
from concurrent.futures import ThreadPoolExecutor
from io import BytesIO
from pathlib import Path

import ziglang

from universal_binary import universal_binary

ROOT = Path(__file__).parents[1]
CROSS = ROOT / "build" / "cross"
PLATFORMS = {
    "linux64": ("linux64",),
    "win64": ("win64",),
    "aarch64-linux": ("aarch64-linux",),
    "darwin64": ("darwin64-x86_64", "darwin64-arm64"),  # one file for both
}
"""FMI's name of a platform → toolchains, whose binaries become one file."""
RELEASED = ("linux64", "win64")
SUFFIXES = {"win64": ".dll", "darwin64": ".dylib"}
NO_DATE = (1980, 1, 1, 0, 0, 0)
"""The first that a zip file can have, so that the same files are the same FMU."""


def run(command: list[str | Path]) -> None:
    """Runs a command with Zig silently; shows all that it printed if it fails."""
    environment = os.environ | {
        "ZIG": str(Path(ziglang.__file__).with_name("zig")),
        "ZIG_GLOBAL_CACHE_DIR": str(CROSS / "zig-cache"),
    }
    done = subprocess.run(command, env=environment, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    if done.returncode:
        sys.exit(f"release: {' '.join(map(str, command))} failed:\n{done.stdout}")


def compile_for(toolchain: str, built: Path, targets: list[str]) -> None:
    """Compiles for one processor and system, into its folder of build/cross."""
    start, build = time.monotonic(), CROSS / toolchain
    file = ROOT / "cmake" / "toolchains" / f"{toolchain}.cmake"
    described = f"-DSIGMAFMU_DESCRIBED={built.resolve() / 'fmu'}"
    run(["cmake", "-G", "Ninja", "-S", ROOT, "-B", build, "--toolchain", file, described])
    run(["cmake", "--build", build, "--target", *targets])
    print(f"release: {toolchain} compiled ({time.monotonic() - start:.0f} s)", flush=True)


def binary(platform: str, folder: str, name: str) -> tuple[str, bytes]:
    """File name and content of a library that was compiled for a platform."""
    file = name + SUFFIXES.get(platform, ".so")
    parts = [(CROSS / toolchain / folder / file).read_bytes() for toolchain in PLATFORMS[platform]]
    return file, parts[0] if len(parts) == 1 else universal_binary(parts)


def pack(fmu: Path, target: Path | BytesIO, platforms: list[str], compression: int = zipfile.ZIP_DEFLATED) -> None:
    """Writes an FMU with these platforms' binaries in place of those that it has."""
    with zipfile.ZipFile(fmu) as archive:
        names = sorted(n for n in archive.namelist() if not n.endswith("/") and not n.startswith("binaries/"))
        contents = {name: archive.read(name) for name in names}
    for platform in platforms:
        file, content = binary(platform, "fmus", fmu.stem)
        contents[f"binaries/{platform}/{file}"] = content
    with zipfile.ZipFile(target, "w") as archive:
        for name, content in contents.items():
            info = zipfile.ZipInfo(name, NO_DATE)
            info.compress_type = compression
            info.external_attr = 0o100644 << 16
            archive.writestr(info, content)


def pack_all(fmus: list[Path], target: Path, platforms: list[str]) -> None:
    """Writes all FMUs into one archive, which is a sixth of their sizes: most of what they have is the same."""
    target.parent.mkdir(parents=True, exist_ok=True)
    with tarfile.open(target, "w:xz", preset=9) as archive:
        for fmu in fmus:
            content = BytesIO()
            pack(fmu, content, platforms, zipfile.ZIP_STORED)
            member = tarfile.TarInfo(fmu.name)
            member.size = content.tell()
            content.seek(0)
            archive.addfile(member, content)


def copy_slave(slave: Path, target: Path, platforms: list[str]) -> None:
    """Writes what makes FMUs of files, with libraries for these platforms."""
    shutil.rmtree(target, ignore_errors=True)
    shutil.copytree(slave / "sources", target / "sources")
    for platform in platforms:
        (target / platform).mkdir()
        for name in ("slave", "describe"):
            file, content = binary(platform, f"slave/{platform}", name)
            (target / platform / file).write_bytes(content)


def copy_viewer(script: Path, target: Path) -> None:
    """Writes the script of the page of `sigmafmu view`."""
    if not script.is_file():
        sys.exit(f"release: there is no {script}; `make build` makes it where npm can be reached.")
    shutil.copy(script, target)


def main() -> None:
    """Reads the command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build", type=Path, help="folder in which `make build` has built")
    parser.add_argument("output", type=Path)
    parser.add_argument("--wheel", action="store_true", help="every platform, and libraries for FMUs of files")
    parser.add_argument("--platform", choices=PLATFORMS, action="append", help="this one alone; more than once: these")
    options = parser.parse_args()
    fmus = sorted((options.build / "fmus").glob("*.fmu"))
    if not fmus:
        sys.exit(f"release: no FMU in {options.build / 'fmus'}; `make build` makes them.")

    platforms = options.platform or list(PLATFORMS if options.wheel else RELEASED)
    targets = ["fmus", "slave", "describe"] if options.wheel else ["fmus"]
    toolchains = [toolchain for platform in platforms for toolchain in PLATFORMS[platform]]
    with ThreadPoolExecutor(max_workers=2) as pool:
        list(pool.map(lambda toolchain: compile_for(toolchain, options.build, targets), toolchains))
    options.output.mkdir(parents=True, exist_ok=True)
    if options.wheel:
        copy_viewer(options.build / "viewer" / "viewer.js", options.output)
        pack_all(fmus, options.output / "fmus.tar.xz", platforms)
        copy_slave(options.build / "slave", options.output / "slave", platforms)
    else:
        for fmu in fmus:
            pack(fmu, options.output / fmu.name, platforms)
    print(f"release: {len(fmus)} FMUs for {', '.join(platforms)} in {options.output}")


if __name__ == "__main__":
    main()
