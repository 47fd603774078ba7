"""What a file holds for the records: a record, others inside it, and what they come from."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from hashlib import sha256
from typing import Any

from layerjam.device.file import BrakeFile
from layerjam.fluid.file import LineFile
from layerjam.records.changes import RecordFile


@dataclass(frozen=True)
class Cited:
    """What a record says it comes from: a digest or the number of a run, its role, its name."""

    key: str
    role: str
    name: str


@dataclass(frozen=True, kw_only=True)
class Piece:
    """One record: its kind, the columns of its table but the common ones, what it cites."""

    kind: str
    columns: Mapping[str, Any]
    cited: tuple[Cited, ...] = ()


@dataclass(frozen=True, kw_only=True)
class Content:
    """A file: `file` are the columns of `files`, `what` the record it is, if it is one.

    `others` are records inside it that stand for themselves, by the role in which it comes from
    them; `notes` is what is to be said of it.
    """

    path: str
    file: Mapping[str, Any]
    what: Piece | None = None
    cited: tuple[Cited, ...] = ()
    others: Mapping[str, Piece] = field(default_factory=dict)
    notes: tuple[str, ...] = ()


def storable(text: str) -> str:
    """A text without what a database refuses: NUL, and bytes of a name that are no UTF-8."""
    return text.replace("\0", "\ufffd").encode("utf-8", "replace").decode("utf-8")


def hex_of(value: Any) -> str | None:
    """A SHA-256 in hex, None for anything else."""
    right = isinstance(value, str) and re.fullmatch("[0-9a-f]{64}", value)
    return str(value) if right else None


def made_of_text(kind: str, text: str, path: str) -> Piece:
    """The record of a brake or a line of this text; raises FileError."""
    file: RecordFile[Any] = (BrakeFile if kind == "brake" else LineFile).read(text, path)
    notes: Mapping[str, Any] = getattr(file, "notes", {})
    columns = {
        "name": file.name,
        "toml": text,
        "sha256": text_digest(text),
        "rendered_sha256": text_digest(file.render(file.name)),
        "parent": hex_of(notes.get("brake_sha256")),
    }
    return Piece(kind=kind, columns=columns)


def text_digest(text: str) -> str:
    """SHA-256 of a text in UTF-8."""
    return sha256(text.encode()).hexdigest()
