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
from layerjam.core.errors import FileError, QuantityError
from layerjam.laboratory.dataset.people import Details

RECIPE = "recipe.json"
FORMAT = 3
"""Version of the recipe's format; a program reads its own version and all earlier ones. Formats 1
and 2 list rejected files only under `unused`, as a mapping. Format 1 has no title or authors, and
its dataset has no checksum of the description."""
USES = ("friction", "calibrate", "validate")
LIBRARIES = ("numpy", "scipy", "jax", "matplotlib", "jinja2", "typst")
Paths = tuple[str, ...]


@dataclass(frozen=True, kw_only=True)
class Unused:
    """A measurement that counts nowhere in one use; `use` is empty if no stage names the file."""

    file: str
    use: str
    why: str


@dataclass(frozen=True, kw_only=True)
class Recipe:
    """Files, as paths inside the dataset, in the order in which each stage receives them.

    The uses `friction`, `calibrate` and `validate` include the files that the stage leaves out,
    which `unused` lists with the reasons. `options` contains {name in Python: value} of those of
    `report` that differ from the defaults.
    """

    format: int = FORMAT
    versions: Mapping[str, str]
    brake: str
    results: str
    friction: Paths = ()
    calibrate: Paths = ()
    validate: Paths = ()
    options: Mapping[str, Any] = field(default_factory=dict)
    unused: tuple[Unused, ...] = ()
    stated: Details | None = None

    @property
    def files(self) -> Paths:
        """Return all files that the recipe names."""
        used_files = (*self.friction, *self.calibrate, *self.validate)
        return (self.brake, self.results, *used_files, *(row.file for row in self.unused))

    def used(self, use: str) -> Paths:
        """Return the files of one of USES that the stage did not leave out."""
        left_out = {row.file for row in self.unused if row.use == use}
        return tuple(name for name in getattr(self, use) if name not in left_out)

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
        document = json.loads(path.read_text(encoding="utf-8"))
        form = int(document["format"])
    except (OSError, ValueError, KeyError, TypeError, RecursionError):
        raise FileError(path, "is not a recipe from `layerjam publish`") from None
    if form > FORMAT:
        newer = f"has format {form}; this layerjam ({__version__}) reads formats up to {FORMAT}"
        raise FileError(path, f"{newer}: update layerjam")
    values = {f.name: document[f.name] for f in fields(Recipe) if f.name in document}
    if form < 3:
        values = _convert_unused(path, values)
    lacking = [name for name in ("versions", "brake", "results") if name not in values]
    if lacking:
        raise FileError(path, f"{lacking[0]} is missing")
    for name, value in values.items():
        values[name] = _check_value(path, name, value)
    recipe = Recipe(**values)
    for name in recipe.files:
        inner_path = PurePosixPath(name)
        if inner_path.is_absolute() or ".." in inner_path.parts or ":" in name or "\\" in name:
            raise FileError(path, f"names a file outside the dataset: {name[:80]!r}")
    return recipe


def _convert_unused(path: Path, values: dict[str, Any]) -> dict[str, Any]:
    """Return the values of formats 1 and 2 with every given file listed under its use."""
    unused = values.get("unused", {})
    if not isinstance(unused, dict):
        raise FileError(path, f"unused: {str(unused)[:60]!r} is not allowed")
    rows = [
        {"file": file, **(row if isinstance(row, dict) else {"use": "", "why": row})}
        for file, row in unused.items()
    ]
    for use in USES:
        left_out = [row["file"] for row in rows if row.get("use") == use]
        if left_out and isinstance(values.get(use, []), list):
            values[use] = [*values.get(use, []), *left_out]
    return {**values, "unused": rows}


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
        good = isinstance(value, list) and all(map(_is_unused, value))
        value = [Unused(**row) for row in value] if good else value
    elif name in ("versions", "options"):
        good = isinstance(value, dict)
    elif name == "format":
        good = isinstance(value, int)
    else:
        good = isinstance(value, list) and all(isinstance(v, str) for v in value)
    if not good:
        raise FileError(path, f"{name}: {str(value)[:60]!r} is not allowed")
    return tuple(value) if isinstance(value, list) else value


def _is_unused(row: Any) -> bool:
    names = {f.name for f in fields(Unused)}
    return (
        isinstance(row, dict) and {*row} == names and all(isinstance(v, str) for v in row.values())
    )
