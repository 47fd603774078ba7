"""SHA-256 of every file in a dataset, in the format of `sha256sum --check`."""

import re
import shutil
import unicodedata
from collections.abc import Iterable, Mapping
from pathlib import Path

from layerjam.core.errors import FileError
from layerjam.laboratory.identify.provenance import sha256

NAME = "checksums.sha256"
_LINE = re.compile(r"([0-9a-f]{64}) [ *](.+)")


def compose_name(name: str) -> str:
    """Return a path in Unicode's form NFC; some systems decompose letters such as ü (NFD)."""
    return unicodedata.normalize("NFC", name)


def list_files(folder: Path) -> list[str]:
    """Return the sorted names of all files below a folder, without links."""
    return [name for name, path in map_files(folder).items() if not path.is_symlink()]


def map_files(folder: Path) -> dict[str, Path]:
    """Return {name: path} of all files and links below a folder, sorted by name.

    A name is the path inside the folder, with slashes, in NFC. Raises FileError if two files have
    the same name.
    """
    files: dict[str, Path] = {}
    for path in sorted(folder.rglob("*")):
        if not (path.is_symlink() or path.is_file()):
            continue
        name = compose_name(path.relative_to(folder).as_posix())
        if name in files:
            raise FileError(path, "has the same name as another file; rename one of them")
        files[name] = path
    return dict(sorted(files.items()))


def copy_files(files: Mapping[str, Path], folder: Path) -> None:
    """Copy {name: path} into a folder, each file under its name; raises FileError for a link."""
    for name, path in files.items():
        target = folder / name
        target.parent.mkdir(parents=True, exist_ok=True)
        if path.is_symlink():
            raise FileError(path, "is a link; a dataset contains files only")
        shutil.copyfile(path, target)


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
