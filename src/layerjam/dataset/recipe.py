"""How the numbers of a dataset were computed from its raw files, for a program to do it again."""

from __future__ import annotations

import json
import platform
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, fields
from importlib import metadata
from pathlib import Path
from typing import Any

from layerjam._version import __version__
from layerjam.errors import FileError

RECIPE = "recipe.json"
FORMAT = 1
"""Number of the recipe's form; a program reads its own and every lower one."""
LIBRARIES = ("numpy", "scipy", "jax")
Paths = tuple[str, ...]


@dataclass(frozen=True, kw_only=True)
class Recipe:
    """Files by their paths inside the dataset.

    `options` {name in Python: value} of `report`, where they differ from what is usual; `unused`
    {file: why} of measurements that were refused.
    """

    versions: Mapping[str, str]
    brake: str
    results: str
    friction: Paths = ()
    calibrate: Paths = ()
    validate: Paths = ()
    options: Mapping[str, Any] = field(default_factory=dict)
    unused: Mapping[str, str] = field(default_factory=dict)

    @property
    def files(self) -> Paths:
        """All that it names."""
        return (self.brake, self.results, *self.friction, *self.calibrate, *self.validate)

    def text(self) -> str:
        """The file's text."""
        return json.dumps({"format": FORMAT, **asdict(self)}, indent=2, ensure_ascii=False) + "\n"


def versions() -> dict[str, str]:
    """{program: version} of what computes here."""
    return {
        "layerjam": __version__,
        "python": platform.python_version(),
        **{name: metadata.version(name) for name in LIBRARIES},
    }


def read_recipe(folder: Path) -> Recipe:
    """The recipe of a dataset; FileError for one that is broken, newer, or points outside."""
    path = folder / RECIPE
    try:
        plain = json.loads(path.read_text(encoding="utf-8"))
        form = int(plain["format"])
    except (OSError, ValueError, KeyError, TypeError, RecursionError):
        raise FileError(path, "is no recipe of `layerjam publish`") from None
    if form > FORMAT:
        newer = f"is of form {form}; this layerjam ({__version__}) reads up to {FORMAT}"
        raise FileError(path, f"{newer}: take a newer one")
    known = {f.name: plain[f.name] for f in fields(Recipe) if f.name in plain}
    lacking = [name for name in ("versions", "brake", "results") if name not in known]
    if lacking:
        raise FileError(path, f"{lacking[0]} is missing")
    for name, value in known.items():
        known[name] = _checked(path, name, value)
    made = Recipe(**known)
    root = folder.resolve()
    for name in made.files:
        if not (root / name).resolve().is_relative_to(root):
            raise FileError(path, f"names a file outside the dataset: {name[:80]!r}")
    return made


def _checked(path: Path, name: str, value: Any) -> Any:
    """A value of the kind that its field holds; FileError for another."""
    if name in ("brake", "results"):
        good = isinstance(value, str)
    elif name in ("versions", "options", "unused"):
        good = isinstance(value, dict)
    else:
        good = isinstance(value, list) and all(isinstance(v, str) for v in value)
    if not good:
        raise FileError(path, f"{name}: {str(value)[:60]!r} is not allowed")
    return tuple(value) if isinstance(value, list) else value
