"""SHA-256 of every file of a dataset, in the form that `sha256sum --check` reads."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from pathlib import Path

from layerjam.identify.provenance import sha256

NAME = "checksums.sha256"
_LINE = re.compile(r"([0-9a-f]{64}) [ *](.+)")


def inside(folder: Path) -> list[str]:
    """Every file below a folder by its path with slashes, sorted; links are left out."""
    return sorted(n for n in everything(folder) if not (folder / n).is_symlink())


def everything(folder: Path) -> list[str]:
    """Every file and link below a folder by its path with slashes, sorted."""
    found = (p for p in folder.rglob("*") if p.is_symlink() or p.is_file())
    return sorted(p.relative_to(folder).as_posix() for p in found)


def written(folder: Path, names: Iterable[str]) -> str:
    """The text for files of a folder."""
    return "".join(f"{sha256(folder / name)}  {name}\n" for name in names)


def read(folder: Path) -> tuple[dict[str, str], list[tuple[int, str]]]:
    """{path: digest} of a dataset's list, and (number, text) of lines that do not belong there.

    These are lines that are not a checksum and a path, and second lines for one path. A list that
    is missing or not text has no line.
    """
    try:
        lines = (folder / NAME).read_text(encoding="utf-8").splitlines()
    except (OSError, UnicodeDecodeError):
        lines = []
    listed: dict[str, str] = {}
    strange = []
    for number, line in enumerate(lines, 1):
        match = _LINE.fullmatch(line)
        if match is None or match.group(2) in listed:
            strange.append((number, line))
        else:
            listed[match.group(2)] = match.group(1)
    return listed, strange


def changed(folder: Path, listed: Mapping[str, str]) -> list[str]:
    """Files that are missing, or that do not hold what the list says."""
    return sorted(
        name
        for name, digest in listed.items()
        if not _plain(folder, name) or sha256(folder / name) != digest
    )


def _plain(folder: Path, name: str) -> bool:
    """Whether it is a file below the folder, and no link out of it."""
    path = folder / name
    return path.is_file() and path.resolve().is_relative_to(folder.resolve())
