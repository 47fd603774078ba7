"""Files that come with the program, by name; or a file of the user's, by path."""

from __future__ import annotations

import os
from collections.abc import Mapping
from functools import cache
from importlib.resources import files
from pathlib import Path

from layerjam.errors import UnknownNameError
from layerjam.records.toml import read_text


def shipped(package: str, *folders: str) -> dict[str, str]:
    """{name: TOML text} of a folder inside a package, in the order of names; a fresh copy."""
    return dict(_shipped(package, *folders))


@cache
def _shipped(package: str, *folders: str) -> dict[str, str]:
    place = files(package).joinpath(*folders)
    return {
        f.name.removesuffix(".toml"): f.read_text(encoding="utf-8")
        for f in sorted(place.iterdir(), key=lambda f: f.name)
        if f.name.endswith(".toml")
    }


def text_of(what: str, wanted: str | Path, texts: Mapping[str, str]) -> tuple[str, str]:
    """(TOML text, its name or path) of a shipped `what`, or of the user's file.

    Raises UnknownNameError (with the nearest names) or FileError.
    """
    name = str(wanted)
    if name in texts:
        return texts[name], name
    looks_like_path = name.endswith(".toml") or os.sep in name
    if not looks_like_path and not Path(name[:200]).is_file():
        own = [f"{name}.toml"] if Path(f"{name[:200]}.toml").is_file() else []
        raise UnknownNameError(what, name, own or texts)
    return read_text(Path(name)), name
