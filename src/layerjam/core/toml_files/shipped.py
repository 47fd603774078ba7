"""Files shipped with the program, found by name, or a user's files, found by path."""

import os
from collections.abc import Mapping
from functools import cache
from importlib.resources import files
from pathlib import Path

from layerjam.core.errors import UnknownNameError
from layerjam.core.toml_files.toml import read_text


def shipped_files(package: str, *folders: str) -> dict[str, str]:
    """Return {name: TOML text} of a folder in a package, sorted by name, as a new copy."""
    return dict(_read_shipped(package, *folders))


@cache
def _read_shipped(package: str, *folders: str) -> dict[str, str]:
    place = files(package).joinpath(*folders)
    return {
        f.name.removesuffix(".toml"): f.read_text(encoding="utf-8")
        for f in sorted(place.iterdir(), key=lambda f: f.name)
        if f.name.endswith(".toml")
    }


def load_text(kind: str, source: str | Path, texts: Mapping[str, str]) -> tuple[str, str]:
    """Return the TOML text and the name or path of a shipped or a user's file; errors name `kind`.

    Raises UnknownNameError (with the nearest names) or FileError.
    """
    name = str(source)
    if name in texts:
        return texts[name], name
    looks_like_path = name.endswith(".toml") or os.sep in name
    if not looks_like_path and not Path(name[:200]).is_file():
        suggestion = [f"{name}.toml"] if Path(f"{name[:200]}.toml").is_file() else []
        raise UnknownNameError(kind, name, suggestion or texts)
    return read_text(Path(name)), name
