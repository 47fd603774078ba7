"""Recipe of a dataset, with which a program recomputes its numbers from the raw files."""

import json
import platform
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import asdict, dataclass, field, fields
from importlib import metadata
from pathlib import Path, PurePosixPath
from typing import Any

from layerjam._version import __version__
from layerjam.dataset.people import Details
from layerjam.errors import FileError, QuantityError

RECIPE = "recipe.json"
FORMAT = 2
"""Version of the recipe's format; a program reads its own version and all earlier ones. Format 1
has no title or authors, and its dataset has no checksum of the description."""
LIBRARIES = ("numpy", "scipy", "jax", "matplotlib", "jinja2", "typst")
Paths = tuple[str, ...]


@dataclass(frozen=True, kw_only=True)
class Recipe:
    """Files, as paths inside the dataset.

    `options` contains {name in Python: value} of those of `report` that differ from the defaults.
    `unused` is {file: {"use": ..., "why": ...}} of rejected measurements.
    """

    format: int = FORMAT
    versions: Mapping[str, str]
    brake: str
    results: str
    friction: Paths = ()
    calibrate: Paths = ()
    validate: Paths = ()
    options: Mapping[str, Any] = field(default_factory=dict)
    unused: Mapping[str, Any] = field(default_factory=dict)
    stated: Details | None = None

    @property
    def files(self) -> Paths:
        """Return all files that the recipe names."""
        used = (*self.friction, *self.calibrate, *self.validate)
        return (self.brake, self.results, *used, *self.unused)

    def text(self) -> str:
        """Return the text of the recipe's file."""
        return json.dumps(asdict(self), indent=2, ensure_ascii=False) + "\n"


def list_program_versions() -> dict[str, str]:
    """Return {program: version} of the programs that compute and draw here."""
    programs = {"layerjam": __version__, "python": platform.python_version()}
    for name in LIBRARIES:
        with suppress(metadata.PackageNotFoundError):
            programs[name] = metadata.version(name)
    return programs


def read_recipe(folder: Path) -> Recipe:
    """Return a dataset's recipe; raises FileError if it is invalid, newer or points outside."""
    path = folder / RECIPE
    try:
        plain = json.loads(path.read_text(encoding="utf-8"))
        form = int(plain["format"])
    except (OSError, ValueError, KeyError, TypeError, RecursionError):
        raise FileError(path, "is not a recipe from `layerjam publish`") from None
    if form > FORMAT:
        newer = f"has format {form}; this layerjam ({__version__}) reads formats up to {FORMAT}"
        raise FileError(path, f"{newer}: update layerjam")
    values = {f.name: plain[f.name] for f in fields(Recipe) if f.name in plain}
    lacking = [name for name in ("versions", "brake", "results") if name not in values]
    if lacking:
        raise FileError(path, f"{lacking[0]} is missing")
    for name, value in values.items():
        values[name] = _check_value(path, name, value)
    recipe = Recipe(**values)
    for name in recipe.files:
        inside = PurePosixPath(name)
        if inside.is_absolute() or ".." in inside.parts or ":" in name or "\\" in name:
            raise FileError(path, f"names a file outside the dataset: {name[:80]!r}")
    return recipe


def _check_value(path: Path, name: str, value: Any) -> Any:
    """Return a value if it has the type of the field; otherwise raises FileError."""
    if name == "stated":
        try:
            return value and Details.read(value)
        except (TypeError, KeyError, AttributeError, ValueError, QuantityError):
            raise FileError(path, f"stated: {str(value)[:60]!r} is not allowed") from None
    if name in ("brake", "results"):
        good = isinstance(value, str)
    elif name == "unused":
        good = isinstance(value, dict)
        value = {k: v if isinstance(v, dict) else {"use": "", "why": v} for k, v in value.items()}
    elif name in ("versions", "options"):
        good = isinstance(value, dict)
    elif name == "format":
        good = isinstance(value, int)
    else:
        good = isinstance(value, list) and all(isinstance(v, str) for v in value)
    if not good:
        raise FileError(path, f"{name}: {str(value)[:60]!r} is not allowed")
    return tuple(value) if isinstance(value, list) else value
