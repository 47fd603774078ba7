"""The state of a desk as a file: brake, line, settings, pinned curves, and the files in use."""

import base64
import binascii
import json
import zlib
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any, NamedTuple

from layerjam.core.errors import FileError, QuantityError
from layerjam.workbench.state import InvalidStateError, State, read_state
from layerjam.workbench.uploads import LARGEST, MAX_FILES, Uploads

ENDING = ".json"
KIND, VERSION = "session of the layerjam workbench", 1


@dataclass(frozen=True)
class KeptFile:
    """A dropped file in a session: the user's name for it, its bytes and its sidecar's text."""

    name: str
    data: bytes
    sidecar: str = ""


class Session(NamedTuple):
    """Content of a session file."""

    state: State
    files: tuple[KeptFile, ...] = ()


def read_kept_files(uploads: Uploads) -> tuple[KeptFile, ...]:
    """Return the files that the pages of a tab use."""
    return tuple(
        KeptFile(file.shown, file.path.read_bytes(), uploads.sidecars.get(file.shown, ""))
        for file in uploads.files_in_use
    )


def format_session(state: State, files: Sequence[KeptFile] = ()) -> str:
    """Return a session's text; raises QuantityError if its files make it too large to open."""
    document: dict[str, Any] = {"kind": KIND, "version": VERSION, **asdict(state)}
    if files:
        document["files"] = [
            {
                "name": f.name,
                "sidecar": f.sidecar,
                "content": base64.b64encode(zlib.compress(f.data)).decode(),
            }
            for f in files
        ]
    text = json.dumps(document, indent=1, allow_nan=False, ensure_ascii=False) + "\n"
    size = max(len(text.encode()), sum(len(f.data) for f in files))
    if files and size > LARGEST:
        raise QuantityError(
            f"session: {size / 2**20:.0f} MB with its files; the limit is "
            f"{LARGEST // 2**20} MB, so remove a file"
        )
    return text


def parse_session(data: bytes, name: str) -> Session:
    """Return the session in a file's bytes; raises FileError if it is not a session."""
    if len(data) > LARGEST:  # the page writes smaller sessions, because 1 MB is read for each brake
        raise FileError(name, f"is larger than {LARGEST // 2**20} MB, the limit for a session")
    try:
        text = data.decode("utf-8-sig")
        document = json.loads(text)
    except (ValueError, RecursionError):
        raise FileError(name, "is not JSON, so it is not a session") from None
    if not isinstance(document, dict) or document.get("kind") != KIND:
        raise FileError(name, f'is not a session: its "kind" is not "{KIND}"')
    if document.get("version") != VERSION:
        reason = (
            "a session from a different version; open it with the layerjam version that wrote it"
        )
        raise FileError(name, f"is {reason}")
    try:
        return Session(read_state(text), tuple(_unpack_files(document.get("files", []))))
    except InvalidStateError as err:
        raise FileError(name, f"contains unknown fields: {err}") from None


def _unpack_files(entries: Any) -> list[KeptFile]:
    """Return a session's files, at most LARGEST bytes in all; raises InvalidStateError."""
    if not isinstance(entries, list) or len(entries) > MAX_FILES:
        raise InvalidStateError(f"files: expected a list of at most {MAX_FILES}")
    files, bytes_left = [], LARGEST
    for place, entry in enumerate(entries):
        fields = entry if isinstance(entry, dict) else {}
        name, sidecar, content = (fields.get(key) for key in ("name", "sidecar", "content"))
        if not (isinstance(name, str) and isinstance(sidecar, str) and isinstance(content, str)):
            raise InvalidStateError(f"files.{place}: name, sidecar and content must be strings")
        reader = zlib.decompressobj()
        try:
            data = reader.decompress(base64.b64decode(content, validate=True), bytes_left + 1)
        except (binascii.Error, zlib.error, ValueError):
            raise InvalidStateError(f"files.{place}.content: it cannot be decompressed") from None
        bytes_left -= len(data)
        if bytes_left < 0:
            raise InvalidStateError(f"files: together they are larger than {LARGEST // 2**20} MB")
        if not reader.eof:
            raise InvalidStateError(f"files.{place}.content: it is truncated")
        files.append(KeptFile(name, data, sidecar))
    return files
