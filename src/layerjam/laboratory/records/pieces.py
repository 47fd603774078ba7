"""Content of a file for the database: its record, other records in it, and their sources."""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from hashlib import sha256
from typing import Any

from layerjam.brake.device.brake_file import BrakeFile
from layerjam.brake.fluid.line_file import LineFile
from layerjam.core.toml_files.changes import RecordFile


@dataclass(frozen=True)
class Cited:
    """A source that a record cites: its digest or run number, its role and its name."""

    key: str
    role: str
    name: str


@dataclass(frozen=True, kw_only=True)
class Piece:
    """One record: its kind, its own columns and its citations."""

    kind: str
    columns: Mapping[str, Any]
    cited: tuple[Cited, ...] = ()


@dataclass(frozen=True, kw_only=True)
class Content:
    """A file: `file` contains its columns in `files`, `piece` its record, if any.

    `others` contains independent records inside the file, keyed by their role as a source of its
    record. `notes` contains messages about the file.
    """

    path: str
    file: Mapping[str, Any]
    piece: Piece | None = None
    cited: tuple[Cited, ...] = ()
    others: Mapping[str, Piece] = field(default_factory=dict)
    notes: tuple[str, ...] = ()


def clean_text(text: str) -> str:
    """Return a text that a database accepts: without NUL and invalid UTF-8."""
    return text.replace("\0", "\ufffd").encode("utf-8", "replace").decode("utf-8")


def parse_digest(value: Any) -> str | None:
    """Return a SHA-256 in hexadecimal, or None for anything else."""
    right = isinstance(value, str) and re.fullmatch("[0-9a-f]{64}", value)
    return str(value) if right else None


def make_piece(kind: str, text: str, path: str) -> Piece:
    """Return the record of the brake or vacuum line in a text; raises FileError."""
    file: RecordFile[Any] = (BrakeFile if kind == "brake" else LineFile).read(text, path)
    notes: Mapping[str, Any] = getattr(file, "notes", {})
    columns = {
        "name": file.name,
        "toml": text,
        "sha256": text_digest(text),
        "rendered_sha256": text_digest(file.render(file.name)),
        "parent": parse_digest(notes.get("brake_sha256")),
    }
    return Piece(kind=kind, columns=columns)


def text_digest(text: str) -> str:
    """Return the SHA-256 digest of a text in UTF-8."""
    return sha256(text.encode()).hexdigest()
