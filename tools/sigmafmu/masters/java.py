"""Java and the tools that come as Maven artifacts."""

import os
import re
import shutil
import subprocess
import tempfile
from dataclasses import dataclass
from pathlib import Path

from sigmafmu.masters.process import ProcessError, output_of
from sigmafmu.user_cache import user_cache

CACHE_VARIABLE = "SIGMAFMU_TOOLS"
"""Environment variable that names another folder for fetched artifacts than the user's cache."""


def cache() -> Path:
    """Folder of the fetched artifacts."""
    own = os.environ.get(CACHE_VARIABLE)
    return Path(own).absolute() if own else user_cache() / "tools"


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
    megabytes: int

    @property
    def path(self) -> Path:
        """Where it lies once it has been fetched."""
        return cache() / f"{self.name}-{self.version}-{self.classifier}.{self.kind}"

    @property
    def coordinates(self) -> str:
        """As Maven wants them."""
        return f"{self.group}:{self.name}:{self.version}:{self.kind}:{self.classifier}"

    def missing(self) -> str | None:
        """Why it cannot be used, or None."""
        if not shutil.which("java"):
            return "Java is not installed"
        if self.path.is_file():
            return None
        if not shutil.which("mvn"):
            return f"not downloaded, and Maven (mvn) is not installed to fetch {self.coordinates}"
        return failures.get(self, "not downloaded; `sigmafmu compat --yes` does it")

    def download(self) -> str | None:
        """What `fetch` would download, or None."""
        possible = shutil.which("java") and shutil.which("mvn") and not self.path.is_file()
        return f"{self.name} ({self.megabytes} MB, with Maven, into {cache()})" if possible else None

    def fetch(self) -> None:
        """Download it, if that is possible and necessary."""
        if self.download() and self not in failures and (reason := _fetch(self)):
            failures[self] = reason


failures: dict[Artifact, str] = {}
"""Why an artifact could not be fetched: a second try would take as long to fail."""


def _fetch(artifact: Artifact) -> str | None:
    """Let Maven copy it into the cache; returns why that failed, or None."""
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
