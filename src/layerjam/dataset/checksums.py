"""SHA-256 of every file in a dataset, in the format of `sha256sum --check`."""

import re
from collections.abc import Iterable, Mapping
from pathlib import Path

from layerjam.identify.provenance import sha256

NAME = "checksums.sha256"
_LINE = re.compile(r"([0-9a-f]{64}) [ *](.+)")


def list_files(folder: Path) -> list[str]:
    """Return the sorted paths, with slashes, of all files below a folder, without links."""
    return sorted(n for n in list_all_files(folder) if not (folder / n).is_symlink())


def list_all_files(folder: Path) -> list[str]:
    """Return the sorted paths, with slashes, of all files and links below a folder."""
    paths = (p for p in folder.rglob("*") if p.is_symlink() or p.is_file())
    return sorted(p.relative_to(folder).as_posix() for p in paths)


def format_checksums(folder: Path, names: Iterable[str]) -> str:
    """Return the checksum list for selected files in a folder."""
    return "".join(f"{sha256(folder / name)}  {name}\n" for name in names)


def read_checksums(folder: Path) -> tuple[dict[str, str], list[tuple[int, str]]]:
    """Return {path: digest} from a dataset's list, and (line number, text) of invalid lines.

    A line is invalid if it is not a checksum and a path, or if it repeats a path. A list that is
    missing or not text has no lines.
    """
    try:
        lines = (folder / NAME).read_text(encoding="utf-8").splitlines()
    except (OSError, UnicodeDecodeError):
        lines = []
    digests: dict[str, str] = {}
    strange = []
    for number, line in enumerate(lines, 1):
        match = _LINE.fullmatch(line)
        if match is None or match.group(2) in digests:
            strange.append((number, line))
        else:
            digests[match.group(2)] = match.group(1)
    return digests, strange


def find_changed_files(folder: Path, digests: Mapping[str, str]) -> list[str]:
    """Return the files that are missing or whose digest differs from the list."""
    return sorted(
        name
        for name, digest in digests.items()
        if not _is_plain_file(folder, name) or sha256(folder / name) != digest
    )


def _is_plain_file(folder: Path, name: str) -> bool:
    """Return whether a path is a file below the folder and not a link to the outside."""
    path = folder / name
    return path.is_file() and path.resolve().is_relative_to(folder.resolve())
