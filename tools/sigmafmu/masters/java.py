"""Java and the tools that come as Maven artifacts."""

import functools
import os
import re
import shutil
import subprocess
import tempfile
from dataclasses import dataclass
from pathlib import Path

from sigmafmu.console import err
from sigmafmu.masters.process import ProcessError, output_of

CACHE_VARIABLE = "SIGMAFMU_TOOLS"
"""Environment variable that names another folder for fetched artifacts than build/tools."""


def cache() -> Path:
    """Folder of the fetched artifacts."""
    return Path(os.environ.get(CACHE_VARIABLE) or Path("build") / "tools").absolute()


def java_version() -> str:
    """Version of the Java that is installed."""
    shown = subprocess.run(["java", "-version"], capture_output=True, text=True, check=False)
    found = re.search(r'version "([^"]+)"', shown.stderr + shown.stdout)
    return found[1] if found else "unknown"


@dataclass(frozen=True)
class Artifact:
    """A file from a Maven repository."""

    group: str
    name: str
    version: str
    kind: str
    classifier: str

    @property
    def path(self) -> Path:
        """Where it lies once it has been fetched."""
        return cache() / f"{self.name}-{self.version}-{self.classifier}.{self.kind}"

    @property
    def coordinates(self) -> str:
        """As Maven wants them."""
        return f"{self.group}:{self.name}:{self.version}:{self.kind}:{self.classifier}"

    def missing(self) -> str | None:
        """Why it cannot be used, or None; fetches it if need be."""
        if not shutil.which("java"):
            return "Java is not installed"
        if self.path.is_file():
            return None
        if not shutil.which("mvn"):
            return f"not fetched, and Maven (mvn) is not installed to fetch {self.coordinates}"
        return _fetch(self)


@functools.cache  # a second try would take as long to fail
def _fetch(artifact: Artifact) -> str | None:
    """Let Maven copy it into the cache; returns why that failed, or None."""
    err.print(f"fetching {artifact.coordinates} with Maven into {cache()}", soft_wrap=True)
    cache().mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=cache()) as name:  # then moved, so that nobody sees half a file
        folder = Path(name)
        options = [f"-Dartifact={artifact.coordinates}", f"-DoutputDirectory={folder}"]
        try:
            output_of(["mvn", "--batch-mode", "--quiet", "dependency:copy", *options], folder)
        except ProcessError as error:
            return f"Maven cannot fetch {artifact.coordinates} ({error})"
        (folder / artifact.path.name).replace(artifact.path)
    return None
