"""A dataset in a folder or in a zip file, which may come from an untrusted source."""

import contextlib
import stat
import tempfile
import zipfile
from collections import Counter
from collections.abc import Iterator
from pathlib import Path, PurePosixPath

from layerjam.dataset.recipe import RECIPE
from layerjam.errors import FileError

MOST_FILES = 20_000
LARGEST = 20 * 2**30
"""Largest size of all files together [bytes]."""
RATIO = 1_000
"""Largest ratio of unpacked to packed size; numbers as text compress to a tenth at best."""


@contextlib.contextmanager
def open_root(source: str | Path) -> Iterator[Path]:
    """Open a dataset; a zip file is unpacked into a temporary folder.

    Raises FileError for anything else, and for a zip file that would write outside its folder,
    would unpack to more than 20 GB or contains links.
    """
    path = Path(source)
    if path.is_dir():
        yield _find_dataset_root(path, path)
        return
    if not path.is_file():
        raise FileError(source, "does not exist")
    with tempfile.TemporaryDirectory(prefix="layerjam-dataset-") as name:
        folder = Path(name)
        try:
            with zipfile.ZipFile(path) as archive:
                _unpack_archive(archive, folder, path)
        except (zipfile.BadZipFile, OSError, NotImplementedError, RuntimeError, EOFError) as err:
            raise FileError(path, f"is not a readable zip file: {err}") from None
        yield _find_dataset_root(folder, path)


def _find_dataset_root(folder: Path, source: Path) -> Path:
    if (folder / RECIPE).is_file():
        return folder
    inner = [p for p in folder.iterdir() if p.is_dir() and (p / RECIPE).is_file()]
    if len(inner) != 1:
        raise FileError(source, f"is not a dataset from `layerjam publish`: {RECIPE} is missing")
    return inner[0]


def _unpack_archive(archive: zipfile.ZipFile, folder: Path, source: Path) -> None:
    entries = [e for e in archive.infolist() if not e.is_dir()]
    if len(entries) > MOST_FILES:
        raise FileError(source, f"contains {len(entries)} files; at most {MOST_FILES} can be read")
    if sum(e.file_size for e in entries) > LARGEST:
        raise FileError(source, f"unpacks to more than {LARGEST // 2**30} GB")
    [(name, times)] = Counter(entry.filename for entry in entries).most_common(1) or [("", 0)]
    if times > 1:
        raise FileError(source, f"contains {name[:80]!r} twice; which copy is read is ambiguous")
    for entry in entries:
        inside = PurePosixPath(entry.filename.replace("\\", "/"))
        if inside.is_absolute() or ".." in inside.parts or ":" in entry.filename:
            raise FileError(source, f"would write outside its folder: {entry.filename[:80]!r}")
        if stat.S_ISLNK(entry.external_attr >> 16):
            raise FileError(source, f"contains a link: {entry.filename[:80]!r}")
        if entry.file_size > RATIO * max(entry.compress_size, 1_000):
            raise FileError(
                source, (f"has an implausible compression ratio: {entry.filename[:80]!r}")
            )
        archive.extract(entry, folder)
