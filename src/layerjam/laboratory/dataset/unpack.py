"""A dataset in a folder or in a zip file, which may come from an untrusted source."""

import contextlib
import shutil
import stat
import tempfile
import zipfile
from collections.abc import Iterator
from pathlib import Path, PurePosixPath

from layerjam.core.errors import FileError
from layerjam.laboratory.dataset.checksums import compose_name, copy_files, map_files
from layerjam.laboratory.dataset.recipe import RECIPE

MOST_FILES = 20_000
LARGEST = 20 * 2**30
"""Largest size of all files together [bytes]."""
RATIO = 1_000
"""Largest ratio of unpacked to packed size; numbers as text compress to a tenth at best."""


@contextlib.contextmanager
def open_root(source: str | Path) -> Iterator[tuple[Path, list[str]]]:
    """Open a dataset; yield its folder, and the files of `source` outside this folder.

    A zip file is unpacked into a temporary folder, and a folder whose file names are decomposed
    (NFD) is copied into one. Raises FileError for anything else, and for a zip file that would
    write outside its folder, would unpack to more than 20 GB, or contains links or unusual names.
    """
    path = Path(source)
    if not path.exists():
        raise FileError(source, "does not exist")
    with tempfile.TemporaryDirectory(prefix="layerjam-dataset-") as name:
        folder = Path(name)
        if path.is_dir():
            root = _find_dataset_root(path, path)
            other_files = _list_files_beside(root, path)
            files = map_files(root)
            if not all((root / name).exists() for name in files):
                copy_files(files, folder)
                root = folder
            yield root, other_files
            return
        try:
            with zipfile.ZipFile(path) as archive:
                _unpack_archive(archive, folder, path)
        except (zipfile.BadZipFile, OSError, NotImplementedError, RuntimeError, EOFError) as err:
            raise FileError(path, f"is not a readable zip file: {err}") from None
        root = _find_dataset_root(folder, path)
        yield root, _list_files_beside(root, folder)


def _list_files_beside(root: Path, folder: Path) -> list[str]:
    if root == folder:
        return []
    names = (Path(name) for name in map_files(folder))
    return [f"../{n.as_posix()}" for n in names if n.parts[0] != compose_name(root.name)]


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
    for entry in entries:
        inner_path = PurePosixPath(entry.filename.replace("\\", "/"))
        if inner_path.is_absolute() or ".." in inner_path.parts or ":" in entry.filename:
            raise FileError(source, f"would write outside its folder: {entry.filename[:80]!r}")
        if inner_path.as_posix() != entry.orig_filename:
            raise FileError(source, f"contains an unusual file name: {entry.orig_filename[:80]!r}")
        if stat.S_ISLNK(entry.external_attr >> 16):
            raise FileError(source, f"contains a link: {entry.filename[:80]!r}")
        if entry.file_size > RATIO * max(entry.compress_size, 1_000):
            raise FileError(
                source, (f"has an implausible compression ratio: {entry.filename[:80]!r}")
            )
        target = folder / compose_name(entry.filename)
        if target.exists():
            name = entry.filename[:80]
            raise FileError(source, f"contains {name!r} twice; which copy is read is ambiguous")
        target.parent.mkdir(parents=True, exist_ok=True)
        with archive.open(entry) as source_file, target.open("xb") as target_file:
            shutil.copyfileobj(source_file, target_file)
