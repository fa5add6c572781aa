"""FMUs of the wheel for all platforms: one archive, since they have most of their content in common, unpacked once."""

import hashlib
import tarfile
import tempfile
import zipfile
from functools import cache
from pathlib import Path

from sigmafmu import SigmafmuError
from sigmafmu.user_cache import user_cache

ARCHIVE = Path(__file__).parent / "fmus.tar.xz"


@cache
def unpacked_fmus() -> Path:
    """Folder in the user's cache that has the FMUs of the archive; raises SigmafmuError."""
    try:
        content = hashlib.sha256(ARCHIVE.read_bytes()).hexdigest()[:16]
        folder = user_cache() / f"fmus-{content}"
        if not folder.is_dir():
            folder.parent.mkdir(parents=True, exist_ok=True)
            with tempfile.TemporaryDirectory(dir=folder.parent) as name:  # then moved: nobody sees half of them
                part = Path(name) / "fmus"
                part.mkdir()
                _unpack(part)
                if not folder.is_dir():  # nobody else was faster
                    part.rename(folder)
    except OSError as error:
        raise SigmafmuError(f"the FMUs cannot be unpacked: {error}; SIGMAFMU_CACHE names another folder") from error
    return folder


def _unpack(folder: Path) -> None:
    """In the archive FMUs are not compressed, so that it is small as a whole."""
    with tarfile.open(ARCHIVE) as archive:
        for member in archive:
            stored = archive.extractfile(member)
            assert stored is not None
            with (
                zipfile.ZipFile(stored) as source,
                zipfile.ZipFile(folder / member.name, "w", zipfile.ZIP_DEFLATED) as fmu,
            ):
                for info in source.infolist():
                    text = source.read(info)
                    info.compress_type = zipfile.ZIP_DEFLATED
                    fmu.writestr(info, text)
