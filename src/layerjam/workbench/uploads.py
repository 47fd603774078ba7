"""Files dropped on the page, stored in the tab's temporary folder under generated names.

The user's name of a file is only displayed. Nothing outside the folder is written or read. The
folder is deleted when the tab is closed, when the program ends, or when it next starts.
"""

import hashlib
import io
import itertools
import re
import threading
import unicodedata
import weakref
import zipfile
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from nicegui import run
from nicegui.elements.upload_files import FileUpload

from layerjam.core.errors import FileError, QuantityError
from layerjam.core.toml_files.toml import decode_toml
from layerjam.laboratory.identify.provenance import rename_files
from layerjam.laboratory.measure.runs import ENDING
from layerjam.laboratory.measure.sidecar import sidecar_path as sidecar_of
from layerjam.workbench.call import DataFile
from layerjam.workbench.folders import Folder

LARGEST = 60 * 2**20
"""Maximum size of a file in bytes: about two million rows of time, force and elongation as text,
less than the limit of 64 MB for a request body.
"""
MAX_FILES = 200
"""Maximum number of measurements in a tab: four vacuums, five speeds and ten repeats."""
ALL_TOGETHER = 500 * 2**20
"""Maximum total size of all files in a tab [bytes]."""
SIDECAR = 64 * 2**10
"""Maximum size of a sidecar [bytes]."""
LONGEST_NAME = 120
TEXTS = (".csv", ".tsv", ".txt", ".tra", ".dat", ".asc", ".log", ".xml")
ENDINGS = (*TEXTS, ".xlsx", ".xlsm", ".xlsb", ".xls", ".ods", ENDING)
"""Extensions kept in generated names; others become .dat. Readers go by the content."""
OURS = "layerjam-file-"


class UploadError(QuantityError):
    """A rejected file, with the reason as a sentence."""


@dataclass(frozen=True)
class Upload(DataFile):
    """A measurement in the folder, with its digest and its size in bytes."""

    digest: str = ""
    size: int = 0

    @property
    def key(self) -> str:
        """Short digest of the content, so that settings apply again if the same file is dropped."""
        return self.digest[:12]


class Uploads:
    """The files of one tab.

    `sidecars` is {user's name of the measurement: its sidecar's text}; a sidecar may arrive first.
    Files whose key is in `waiting` were dropped, but their use has not been chosen yet: no page
    uses them.
    """

    def __init__(self) -> None:
        self.files: list[Upload] = []
        self.sidecars: dict[str, str] = {}
        self.listed: dict[str, str] = {}
        """{user's name of a file: its metadata from the list of conditions, as sidecar text}."""
        self.from_list: dict[str, frozenset[str]] = {}
        """{name: metadata keys in its sidecar that come from that list}."""
        self.waiting: set[str] = set()
        self.refused: dict[str, str] = {}
        """{user's name of an unreadable file: the reason}."""
        self.closed = False
        self._place: Folder | None = None
        self._numbers = itertools.count(1)
        self._lock = threading.Lock()

    @property
    def folder(self) -> Path:
        """The tab's folder, created when first needed; deleted by `close` or at exit."""
        if self._place is None:
            if self.closed:
                raise UploadError("this tab was closed")
            self._place = Folder()
            with _DOOR:
                _OPEN.add(self)
        return self._place.path

    @property
    def files_in_use(self) -> list[Upload]:
        """Return the files that pages use."""
        return [f for f in list(self.files) if f.key not in self.waiting]

    def check_room(self, name: str, size: int) -> None:
        """Raise UploadError if a file of this size is too large, or if there are too many."""
        label = clean_name(name)
        if is_sidecar(name):
            if size > SIDECAR:
                raise UploadError(
                    f"{label}: {size // 1024} kB is too large for a sidecar; the limit is 64 kB"
                )
            if len(self.sidecars) >= 2 * MAX_FILES:
                raise UploadError(
                    f"{label}: not used, because the limit of {2 * MAX_FILES} sidecars is reached"
                )
            return
        if size > LARGEST:
            raise UploadError(
                f"{label}: {size / 2**20:.0f} MB is too large for the page, which accepts "
                f"{LARGEST // 2**20} MB; the commands read up to 1 GB"
            )
        if len(self.files) >= MAX_FILES:
            raise UploadError(
                f"{label}: not used, because at most {MAX_FILES} measurements are allowed"
            )
        if sum(f.size for f in self.files) + size > ALL_TOGETHER:
            raise UploadError(f"{label}: not used, because all files together would exceed 500 MB")

    def store_file(self, name: str, data: bytes, waits: bool = False) -> Upload | None:
        """Store a file and return it; store a sidecar and return None. Raises UploadError.

        No page uses the file while it `waits`, and it may be dropped again.
        """
        with self._lock:
            self.check_room(name, len(data))
            label = clean_name(name)
            if is_sidecar(name):
                try:
                    self.sidecars[label[: -len(".toml")]] = decode_toml(data, label)
                except FileError as err:
                    raise UploadError(str(err)) from None
                return None
            digest = hashlib.sha256(data).hexdigest()
            for file in self.files:
                if file.digest == digest and waits and file.key in self.waiting:
                    return file
                if file.digest == digest:
                    raise UploadError(f"{label} has the same content as {file.shown}")
            ending = Path(label).suffix.lower()
            ending = ending if ending in ENDINGS else ".dat"
            path = self.folder / f"{OURS}{next(self._numbers):04d}{ending}"
            path.write_bytes(data)
            upload = Upload(self._unused_name(label), path, digest=digest, size=len(data))
            if waits:
                self.waiting.add(upload.key)
            self.files.append(upload)
            return upload

    def restore_file(self, name: str, data: bytes, sidecar: str) -> None:
        """Store a session's file and its sidecar, for immediate use; raises UploadError.

        If the same content is already stored, the stored file is used.
        """
        label = clean_name(name)
        if len(sidecar.encode()) > SIDECAR:
            raise UploadError(f"{label}: its sidecar is larger than {SIDECAR // 1024} kB")
        digest = hashlib.sha256(data).hexdigest()
        existing = next((f for f in list(self.files) if f.digest == digest), None)
        upload = existing or self.store_file(name, data)
        if upload is None:
            raise UploadError(f"{label}: is named like a sidecar, not like a measurement")
        self.waiting.discard(upload.key)
        if existing is None and sidecar:
            self.sidecars[upload.shown] = sidecar

    def _unused_name(self, name: str) -> str:
        """Return the name, with a number added if a different file already has it."""
        names, path = {f.shown for f in self.files}, Path(name)
        candidates = (f"{path.stem} ({n}){path.suffix}" for n in itertools.count(2))
        return next(n for n in itertools.chain([name], candidates) if n not in names)

    async def receive_file(self, file: FileUpload, waits: bool = False) -> str:
        """Store a file from the browser; return the reason if it is rejected."""
        try:
            self.check_room(file.name, file.size())
            await run.io_bound(self.store_file, file.name, await file.read(), waits)
        except UploadError as err:
            return str(err)
        except OSError as err:
            return f"{clean_name(file.name)}: could not be stored: {err.strerror or 'no room'}"
        return ""

    def write_sidecar(self, upload: Upload, text: str) -> Upload:
        """Write text as a measurement's sidecar, unless empty; return the updated measurement."""
        if text:
            sidecar_of(upload.path).write_text(text, encoding="utf-8", newline="\n")
        else:
            sidecar_of(upload.path).unlink(missing_ok=True)
        edited = text != self.sidecars.get(upload.shown, "")
        return replace(upload, sidecar=text, edited=edited)

    def remove_files(self, keys: Iterable[str]) -> None:
        """Remove files from the tab and from the disk."""
        key_set = set(keys)
        for file in [f for f in self.files if f.key in key_set]:
            file.path.unlink(missing_ok=True)
            sidecar_of(file.path).unlink(missing_ok=True)
            self.files.remove(file)
            self.waiting.discard(file.key)
            self.sidecars.pop(file.shown, None)
            self.from_list.pop(file.shown, None)

    def take_over_files(self, source: "Uploads") -> bool:
        """Move another store's files here and close that store; return whether files were moved.

        Nothing is moved if there are already files here.
        """
        with self._lock, source._lock:
            if self.closed or self.files or source.closed or source._place is None:
                return False
            self._place, source._place = source._place, None
            self._numbers, source.closed = source._numbers, True
            for name in ("files", "sidecars", "listed", "from_list", "waiting"):
                mine, theirs = getattr(self, name), getattr(source, name)
                setattr(self, name, theirs)
                setattr(source, name, mine)
        with _DOOR:
            _OPEN.add(self)
        return True

    def close(self) -> None:
        """Delete the folder and its content; computations that use it end with an error."""
        self.closed = True
        self.files.clear()
        self.sidecars.clear()
        self.listed.clear()
        self.from_list.clear()
        self.waiting.clear()
        if self._place is not None:
            self._place.remove()
            self._place = None


_OPEN: weakref.WeakSet[Uploads] = weakref.WeakSet()
_DOOR = threading.Lock()


def delete_folders() -> None:
    """Delete every tab's folder, because a terminated server may skip Python's normal exit."""
    with _DOOR:
        tabs = list(_OPEN)
    for tab in tabs:
        tab.close()


def clean_name(name: str) -> str:
    """Return the last component of a path in NFC, printable, at most LONGEST_NAME characters."""
    last = re.split(r"[/\\]", unicodedata.normalize("NFC", str(name)[-4 * LONGEST_NAME :]))[-1]
    text = " ".join("".join(c if c.isprintable() else " " for c in last).split())
    if len(text) > LONGEST_NAME:
        tail = Path(text).suffix[:12]
        tail = ".csv.toml" if text.lower().endswith(".csv.toml") else tail
        text = text[: LONGEST_NAME - len(tail) - 3] + "..." + tail
    return text if text.strip(".") else "unnamed"


def is_sidecar(name: str) -> bool:
    """Return whether a file is named NAME.csv.toml, the sidecar of another file."""
    text = clean_name(name).lower()
    return text.endswith(".toml") and "." in text[: -len(".toml")]


def restore_names(text: str, names: Mapping[str, str]) -> str:
    """Return TOML text with the user's file names, escaped for its basic strings."""
    names_quoted = {k: v.replace("\\", "\\\\").replace('"', '\\"') for k, v in names.items()}
    result: str = rename_files(text, names_quoted)
    return result


def zip_files(files: Mapping[str, bytes]) -> bytes:
    """Return a ZIP archive of {name: content}."""
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in files.items():
            archive.writestr(name, data)
    return out.getvalue()
