"""Brakes by catalogue name or path."""

from pathlib import Path

from layerjam.brake.device.brake_file import BrakeFile, materials
from layerjam.core.toml_files.shipped import shipped_files

READING = "-eq9"
"""Suffix of a brake with the factor and the stiffness that the paper gives for its eq. 8 and 9."""


def _catalogue_texts() -> dict[str, str]:
    return shipped_files("layerjam.brake.device", "catalogue", "brakes")


def catalogue() -> list[str]:
    """Return the names of the brakes in the catalogue."""
    return list(_catalogue_texts())


def devices() -> list[str]:
    """Return the names of the brakes in the catalogue, with each device only once."""
    return [name for name in catalogue() if not name.endswith(READING)]


def load(brake: str | Path) -> BrakeFile:
    """Return a brake, given its catalogue name or the path of its TOML file.

    Raises UnknownNameError (with the nearest names) or FileError.
    """
    return BrakeFile.load(brake, _catalogue_texts())


__all__ = ["catalogue", "load", "materials"]
