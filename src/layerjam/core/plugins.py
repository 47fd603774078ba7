"""Parts that a package adds to another: found by the entry points of installed packages."""

import functools
from importlib.metadata import entry_points
from typing import Any

from layerjam.core.errors import UnknownNameError


@functools.cache
def list_plugins(group: str) -> dict[str, Any]:
    """Return {name: entry point} of a group such as "layerjam.readers", sorted by name."""
    return {point.name: point for point in sorted(entry_points(group=group), key=lambda p: p.name)}


def load_plugin(group: str, name: str) -> Any:
    """Return the object of an entry point; raises UnknownNameError if there is none."""
    points = list_plugins(group)
    if name not in points:
        raise UnknownNameError(f"entry point of {group}", name, [*points])
    return points[name].load()
