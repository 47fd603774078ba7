"""A report as a folder: checked before the work begins, and written completely or not at all."""

import json
import math
import os
from collections.abc import Mapping, Sequence
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any

from layerjam.core.errors import FileError
from layerjam.core.store import Appearing
from layerjam.core.system import check_file_name, report_failure
from layerjam.core.toml_files.folders import make_hidden_folder, write_files

NAMES = ("report.html", "results.json")


def check_folder(out: Path, overwrite: bool, names: Sequence[str] = NAMES) -> None:
    """Raise FileError if a report cannot be written into `out`, before any work is done."""
    check_file_name(out)
    with report_failure(out, "cannot be created"):
        if os.path.lexists(out) and not out.is_dir():
            raise FileError(out, "is a file, not a folder")
        for name in names:
            if os.path.lexists(out / name) and not overwrite:
                raise FileError(out / name, "already exists; --overwrite replaces it")
        parent = _find_nearest_folder(out)
        if not os.access(parent, os.W_OK):
            raise FileError(out, f"cannot be created: the folder {parent} is read-only")
        with make_hidden_folder(parent):
            pass  # an administrator can write anywhere, except on read-only file systems


def _find_nearest_folder(out: Path) -> Path:
    for folder in (out.absolute(), *out.absolute().parents):
        if folder.is_dir():
            return folder
        if os.path.lexists(folder):
            raise FileError(out, f"cannot be created: {folder} is not a folder")
    raise FileError(out, "cannot be created")


def write_folder(out: Path, content: Mapping[str, str | bytes], old: Sequence[str] = ()) -> None:
    """Write {path inside `out`: content} completely or not at all; delete `old` files not in it.

    Everything is first written to a folder next to `out`. Other files in `out` remain. Raises
    FileError.
    """
    with report_failure(out, "cannot be written"):
        with make_hidden_folder(_find_nearest_folder(out.parent)) as hidden:
            report = hidden / "report"
            write_files(report, content)
            Appearing.begin()
            if not out.exists():
                out.parent.mkdir(parents=True, exist_ok=True)
                os.replace(report, out)
                return
            for name in content:
                (out / name).parent.mkdir(exist_ok=True)
                os.replace(report / name, out / name)
        for name in set(old) - set(content):
            (out / name).unlink(missing_ok=True)


def figure_files(drawings: Mapping[str, str]) -> dict[str, str | bytes]:
    """Return {path in a report's folder: content} for drawings {name: SVG}."""
    return {f"figures/{name}.svg": svg for name, svg in drawings.items()}


def format_json(value: Any) -> str:
    """Return the text of a JSON file."""
    return json.dumps(value, indent=2, ensure_ascii=False, allow_nan=False) + "\n"


def to_json(value: Any) -> Any:
    """Return a value as JSON types; NaN and infinite numbers become None."""
    if isinstance(value, Mapping):
        return {str(k): to_json(v) for k, v in value.items()}
    if is_dataclass(value) and not isinstance(value, type):
        return {f.name: to_json(getattr(value, f.name)) for f in fields(value)}
    if isinstance(value, list | tuple):
        return [to_json(v) for v in value]
    if hasattr(value, "to_numpy"):
        value = value.to_numpy()
    if hasattr(value, "tolist"):
        return to_json(value.tolist())
    if isinstance(value, bool | int | str) or value is None:
        return value
    number = float(value)
    return number if math.isfinite(number) else None
