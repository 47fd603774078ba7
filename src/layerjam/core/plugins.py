"""Parts that a package adds to another: found by the entry points of installed packages."""

import functools
from importlib.metadata import EntryPoint, entry_points
from typing import Any

from layerjam.core.errors import InstallationError, UnknownNameError

OWN_GROUPS = ("layerjam.commands", "layerjam.layouts", "layerjam.readers")
"""Groups with entry points of our own, in pyproject.toml."""


def find_points(group: str) -> tuple[EntryPoint, ...]:
    """Return the entry points of a group; raises InstallationError if our own are missing."""
    points = tuple(entry_points(group=group))
    if group in OWN_GROUPS and not any(p.value.startswith("layerjam.") for p in points):
        raise InstallationError(f"the entry points {group}")
    return points


@functools.cache
def list_plugins(group: str) -> dict[str, Any]:
    """Return {name: entry point} of a group such as "layerjam.readers", sorted by name."""
    return {point.name: point for point in sorted(find_points(group), key=lambda p: p.name)}


def load_plugin(group: str, name: str) -> Any:
    """Return the object of an entry point; raises UnknownNameError if there is none."""
    points = list_plugins(group)
    if name not in points:
        raise UnknownNameError(f"entry point of {group}", name, [*points])
    return points[name].load()
