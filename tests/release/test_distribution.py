"""The wheel for all platforms and the source distribution, which `make release-check` puts into `dist`.

Binaries of Linux run, those of ARM Linux under qemu-user, of Windows under wine; those of macOS are looked at, and have
not been run here.
"""

import json
import re
import shutil
import sys
import tarfile
import zipfile
from email.parser import Parser
from pathlib import Path

import pytest

from .running import assert_same_motion, binary, poses, run

ROOT = Path(__file__).parents[2]
DIST = ROOT / "dist"
PLATFORMS = {"linux64": ".so", "aarch64-linux": ".so", "win64": ".dll", "darwin64": ".dylib"}
MOST_MEGABYTES = 25
FUNCTIONS = 34  # of FMI 2.0 for co-simulation
OF_THE_LINKER = re.compile(r"__Z[nd][wla]\w+|__mh_dylib_header|___dso_handle")
"""What macOS's libraries show beside their functions: C++'s allocation, which Zig's linker cannot hide, and its own."""
ARM_LIBRARIES = Path("/usr/aarch64-linux-gnu")  # Debian's libc6-arm64-cross

pytestmark = pytest.mark.distribution


@pytest.fixture(scope="session")
def wheel() -> Path:
    (file,) = DIST.glob("sigmafmu-*.whl")
    return file


@pytest.fixture(scope="session")
def python(wheel, tmp_path_factory) -> Path:
    """Python of a new environment in which nothing but the wheel has been installed."""
    folder = tmp_path_factory.mktemp("installed") / "venv"
    run(sys.executable, "-m", "venv", folder)
    run(folder / "bin" / "python", "-m", "pip", "install", "-q", "--disable-pip-version-check", wheel)
    return folder / "bin" / "python"


@pytest.fixture(scope="session")
def call(python, tmp_path_factory):
    """Function that runs a command of that environment; there is no other program, and so no compiler."""
    folder = tmp_path_factory.mktemp("use")

    def sigmafmu(*arguments: str | Path) -> str:
        return run(
            "env", "-i", "-C", folder, f"PATH={folder}", f"HOME={folder}", python.with_name("sigmafmu"), *arguments
        )

    sigmafmu.folder = folder
    return sigmafmu


@pytest.fixture(scope="session")
def fmus(call, tmp_path_factory) -> Path:
    """The unpacked FMUs that the installed package has, and one that it makes of a file, `Pendulum`."""
    folder = tmp_path_factory.mktemp("fmus")
    call("init", "Pendulum")
    call("build", "Pendulum.yaml")
    paths = [Path(call("path", name).strip()) for name in (line.split()[0] for line in call("list").splitlines())]
    for path in [*paths, call.folder / "Pendulum.fmu"]:
        with zipfile.ZipFile(path) as archive:
            archive.extractall(folder / path.stem)
    return folder


def test_the_wheel_is_for_every_python_and_platform(wheel):
    assert wheel.name.endswith("-py3-none-any.whl")
    assert wheel.stat().st_size < MOST_MEGABYTES * 1e6
    with zipfile.ZipFile(wheel) as archive:
        names = archive.namelist()
        (metadata,) = (name for name in names if name.endswith(".dist-info/METADATA"))
        told = Parser().parsestr(archive.read(metadata).decode())
    assert told["Requires-Python"] == ">=3.10"
    assert not [name for name in names if Path(name).name.startswith("_core.") and not name.endswith(".pyi")]
    for platform, suffix in PLATFORMS.items():
        assert {f"sigmafmu/slave/{platform}/{library}{suffix}" for library in ("slave", "describe")} <= set(names)


def test_all_files_tell_the_same_version(wheel):
    version = wheel.name.split("-")[1]
    assert f"pip install {wheel.name}\n" in (ROOT / "docs" / "start.md").read_text(encoding="utf-8")
    assert f"\nversion: {version}\n" in (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    assert re.search(
        rf"^## \[?{re.escape(version)}\b", (ROOT / "CHANGELOG.md").read_text(encoding="utf-8"), re.MULTILINE
    )


def test_the_demonstration_runs(call):
    assert "HeavyTop" in call("demo", "--output", "demo")
    assert (call.folder / "demo" / "SliderCrank.png").stat().st_size > 10_000


def test_every_fmu_has_every_platform(fmus, models):
    assert sorted(path.name for path in fmus.iterdir()) == sorted([*models, "Pendulum"])
    for tree in fmus.iterdir():
        for platform, suffix in PLATFORMS.items():
            assert binary(tree, platform).name == tree.name + suffix


def test_a_mechanism_file_runs(call, fmus):
    call("run", "Pendulum.yaml", "--stop-time", "0.1", "--output", "pendulum.csv")
    assert (call.folder / "pendulum.csv").read_text(encoding="utf-8").count("\n") > 10


def test_a_mechanism_is_shown_in_one_page(call, fmus):
    call("view", "Pendulum.yaml", "--stop-time", "0.1", "--no-open", "--output", "pendulum.html")
    page = (call.folder / "pendulum.html").read_text(encoding="utf-8")
    assert "WebGLRenderer" in page
    assert len(page) > 500_000


@pytest.mark.parametrize(
    ("platform", "loader"), [("linux64", "ld-linux-x86-64.so.2"), ("aarch64-linux", "ld-linux-aarch64.so.1")]
)
def test_linux_binaries_need_an_old_c_library_alone(fmus, platform, loader):
    import lief

    for tree in fmus.iterdir():
        elf = lief.ELF.parse(str(binary(tree, platform)))
        versions = [v.name for needed in elf.symbols_version_requirement for v in needed.get_auxiliary_symbols()]
        glibc = [tuple(map(int, version.removeprefix("GLIBC_").split("."))) for version in versions]
        assert max(glibc) <= (2, 17)
        assert set(elf.libraries) <= {"libc.so.6", "libm.so.6", "libpthread.so.0", "libdl.so.2", loader}
        exported = [symbol.name for symbol in elf.exported_symbols]
        assert len(exported) == FUNCTIONS
        assert all(name.startswith("fmi2") for name in exported)


def test_macos_binaries_are_complete(fmus):
    """Not run here: processors, oldest system, libraries, symbols and the signature that Apple's processors want."""
    import lief

    for tree in fmus.iterdir():
        file = lief.MachO.parse(str(binary(tree, "darwin64")))  # owns its parts
        parts = list(file)
        assert [part.header.cpu_type.name for part in parts] == ["X86_64", "ARM64"]
        for part in parts:
            assert part.header.file_type.name == "DYLIB"
            assert (part.build_version.platform.name, part.build_version.minos) == ("MACOS", [11, 0, 0])
            itself, *needed = (library.name for library in part.libraries)
            assert itself.startswith("@rpath/")
            assert needed == ["/usr/lib/libSystem.B.dylib"]
            exported = [symbol.name for symbol in part.exported_symbols]
            assert sum(name.startswith("_fmi2") for name in exported) == FUNCTIONS
            assert [
                name for name in exported if not name.startswith("_fmi2") and not OF_THE_LINKER.fullmatch(name)
            ] == []
        assert parts[1].has_code_signature


@pytest.fixture(scope="session")
def emulate(runner):
    """Function: the command that runs a program of this folder on another platform; skips where that cannot be."""

    def command(platform: str, name: str = "run_fmu") -> list[str | Path]:
        if platform == "aarch64-linux":
            qemu = shutil.which("qemu-aarch64") or shutil.which("qemu-aarch64-static")
            if not qemu or not ARM_LIBRARIES.is_dir():
                pytest.skip("qemu-user or libc6-arm64-cross is not installed")
            return [qemu, "-L", ARM_LIBRARIES, runner(platform, name)]
        wine = shutil.which("wine") or shutil.which("wine64")
        if not wine:
            pytest.skip("wine is not installed")
        return [wine, runner(platform, name)]

    return command


@pytest.mark.parametrize("platform", ["aarch64-linux", "win64"])
def test_binaries_of_other_platforms_compute_what_those_of_linux_do(fmus, runner, emulate, platform):
    program = emulate(platform)
    for tree in fmus.iterdir():
        there = poses(program, binary(tree, platform))
        assert_same_motion(there, poses([runner("linux64")], binary(tree, "linux64")))


@pytest.mark.parametrize("platform", ["aarch64-linux", "win64"])
def test_other_platforms_describe_mechanisms_as_linux_does(fmus, python, runner, emulate, platform):
    """Names and checksums: an FMU that is built on one system runs on all others."""
    mechanism = fmus / "Pendulum" / "resources" / "mechanism.json"
    parts = Path(run(python, "-c", "from sigmafmu.native import PARTS; print(PARTS)").strip())

    def told(command: list[str | Path], system: str) -> dict:
        library = parts / system / f"describe{PLATFORMS[system]}"
        return json.loads(run(*command, library, mechanism, WINEDEBUG="-all"))

    here, there = (
        told([runner("linux64", "run_describe")], "linux64"),
        told(emulate(platform, "run_describe"), platform),
    )
    for key in ("degreesOfFreedom", "units", "types", "enumerations", "outputs", "elements", "checksums"):
        assert there[key] == here[key], key
    assert [v["name"] for v in there["variables"]] == [v["name"] for v in here["variables"]]


def test_the_source_distribution_has_what_the_wheel_is_built_of(tmp_path):
    """Python's build tools make a wheel of it, with this machine's compiler."""
    (file,) = DIST.glob("sigmafmu-*.tar.gz")
    with tarfile.open(file) as archive:
        archive.extractall(tmp_path, filter="data")
    (tree,) = tmp_path.iterdir()
    run(sys.executable, "-m", "build", "--wheel", "--no-isolation", "--outdir", tmp_path / "wheel", tree)
    (built,) = (tmp_path / "wheel").glob("*.whl")
    with zipfile.ZipFile(built) as archive:
        assert any(Path(name).name.startswith("_core.") and name.endswith(".so") for name in archive.namelist())
    for needed in ("Makefile", "tools/release.py", "cmake/toolchains/darwin64-arm64.cmake", "tests/release/run_fmu.c"):
        assert (tree / needed).is_file(), needed
