"""Finds the files of meshes that a description names."""

import os
from pathlib import Path

SCHEMES = ("package://", "model://", "file://")


class Meshes:
    """Paths of meshes as a mechanism file in `folder` names them."""

    def __init__(self, description: Path, folder: Path):
        self.description, self.folder = description.absolute().parent, folder.absolute()
        self.missing: list[str] = []

    def path(self, uri: str) -> str:
        """The path from the mechanism file; empty: the mesh is not found."""
        for place in self._places(uri):
            if place.is_file():
                return os.path.relpath(place, self.folder).replace(os.sep, "/")
        self.missing.append(uri)
        return ""

    def _places(self, uri: str) -> list[Path]:
        scheme = next((scheme for scheme in SCHEMES if uri.startswith(scheme)), "")
        name = uri[len(scheme) :]
        if scheme == "file://" or Path(name).is_absolute():
            return [Path(name)]
        if not scheme:
            return [self.description / name]
        package, _, rest = name.partition("/")  # a folder of that name around the description, or beside one around it
        above = [self.description, *self.description.parents]
        roots = [folder for folder in above if folder.name == package] + [folder / package for folder in above]
        listed = os.environ.get("ROS_PACKAGE_PATH", "").split(os.pathsep)
        return [root / rest for root in (*roots, *(Path(folder) / package for folder in listed if folder))]

    def tell(self) -> list[str]:
        """Meshes that were not found."""
        if not self.missing:
            return []
        shown = ", ".join(self.missing[:3]) + (", ..." if len(self.missing) > 3 else "")
        return [f"meshes that were not found, not drawn: {len(self.missing)}, {shown}"]
