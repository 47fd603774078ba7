"""TOML files of records: read with file and line in every error, each number with its source."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from layerjam.device.source import KINDS, Source
from layerjam.errors import FileError, LayerjamError, UnknownNameError
from layerjam.units import QuantitySpec

MAX_BYTES = 1_000_000
PLAIN = {"name", "title", "note"}
_ENTRY = {"value", "kind", "source", "spread", "conflict"}


def parse_toml(text: str, path: object) -> dict[str, Any]:
    """The tables of a TOML text; raises FileError with the line for anything that is not TOML."""
    if len(text) > MAX_BYTES:
        raise FileError(path, f"is larger than {MAX_BYTES // 1000} kB, too large for such a file")
    for number, row in enumerate(text.split("\n"), 1):
        if row.count(".") > 300:  # tomllib takes minutes over a key of thousands of parts
            raise FileError(path, "has a line of more than 300 dots, no such file", number)
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as err:
        match = re.search(r"\(at line (\d+), column \d+\)", str(err))
        reason = re.sub(r"\s*\(at .*\)", "", str(err))
        line = int(match.group(1)) if match else text.count("\n") + 1
        wrong = text.splitlines()[line - 1 : line] if line <= text.count("\n") + 1 else []
        if wrong and re.search(r"=\s*[\d.]+\s*[A-Za-z%µ]", wrong[0][:200]):
            reason += '; a quantity stands in quotes, such as "0.254 mm"'
        raise FileError(path, f"is not TOML: {reason}", line) from None
    except (ValueError, RecursionError) as err:
        raise FileError(path, f"is not TOML that can be read: {str(err)[:80]}") from None


def read_text(path: Path) -> str:
    """The text of a small UTF-8 file; raises FileError where there is none."""
    try:
        if path.is_dir():
            raise FileError(path, "is a folder, not a file")
        # opening a pipe or a device may wait for ever
        if path.exists() and not path.is_file():
            raise FileError(path, "is no regular file")
        with path.open("rb") as handle:
            raw = handle.read(MAX_BYTES + 1)
    except (OSError, ValueError) as err:
        raise FileError(path, f"cannot be read: {getattr(err, 'strerror', None) or err}") from None
    if len(raw) > MAX_BYTES:
        raise FileError(path, f"is larger than {MAX_BYTES // 1000} kB, too large for such a file")
    try:
        return raw.decode("utf-8-sig")
    except UnicodeDecodeError as err:
        line = raw[: err.start].count(b"\n") + 1
        raise FileError(path, "is not UTF-8 text", line) from None


class Reader:
    """Collects SI values and sources of the fields of a record, under dotted paths."""

    def __init__(
        self, text: str, path: object, fields: Mapping[str, tuple[QuantitySpec, bool]]
    ) -> None:
        self.text, self.path, self.fields = text, path, fields
        self.tables = {p.split(".")[0] for p in fields if "." in p}
        self.values: dict[str, Any] = {}
        self.sources: dict[str, Source] = {}

    def fail(self, key: str, reason: str) -> FileError:
        """The error, with the line the key stands on."""
        return FileError(self.path, reason, line_of(self.text, key))

    def take_material(self, table: str, use: object, known: Mapping[str, str]) -> None:
        """What a `use` names, from the catalogue."""
        if not isinstance(use, str) or use not in known:
            unknown = UnknownNameError(f"material for [{table}]", str(use), known or ["none here"])
            raise self.fail(f"{table}.use", str(unknown))
        material = parse_toml(known[use], f"material {use}")
        inner = Reader(known[use], f"material {use}", self.fields)
        inner.take({table: {k: v for k, v in material.items() if k not in PLAIN}})
        self.values |= inner.values
        self.sources |= inner.sources

    def take(self, tables: Mapping[str, Any]) -> dict[str, Any]:
        """Every entry of a file; gives the tables that describe and do not count."""
        notes: dict[str, Any] = {}
        for key, value in tables.items():
            if key in PLAIN:
                if not isinstance(value, str):
                    raise self.fail(key, f"{key} must be a text in quotes")
            elif key in self.tables:
                if not isinstance(value, dict):
                    raise self.fail(key, f"{key} must be a table, [{key}]")
                for inner, entry in value.items():
                    self.entry(f"{key}.{inner}", entry)
            elif key in self.fields:
                self.entry(key, value)
            elif key == "made_by" and isinstance(value, dict):
                notes = value
            else:
                raise self.fail(key, self.unknown(key))
        return notes

    def unknown(self, key: str) -> str:
        """What to say of a key nobody knows."""
        names = [*self.fields, *self.tables, *PLAIN, "made_by"]
        return str(UnknownNameError("key", key, names))

    def entry(self, path: str, entry: object) -> None:
        """One value, plain or with where it comes from."""
        if path not in self.fields:
            raise self.fail(path, self.unknown(path))
        value, source = entry, Source()
        if isinstance(entry, dict):
            odd = set(entry) - _ENTRY
            if odd or "value" not in entry:
                what = f"does not know {', '.join(sorted(odd))[:60]}" if odd else "has no value"
                raise self.fail(path, f"{path} {what}; a table holds {', '.join(sorted(_ENTRY))}")
            for word in _ENTRY - {"value"}:
                if not isinstance(entry.get(word, ""), str):
                    raise self.fail(path, f"{path}.{word} must be a text in quotes")
            kind = entry.get("kind", "unstated")
            if kind not in KINDS:
                raise self.fail(path, str(UnknownNameError("kind", kind, KINDS)))
            value = entry["value"]
            source = Source(
                kind=kind,
                text=entry.get("source", ""),
                spread=entry.get("spread", ""),
                conflict=entry.get("conflict", ""),
            )
        try:
            self.values[path] = self.fields[path][0].read(value, path)
        except LayerjamError as err:
            raise self.fail(path, str(err)) from None
        self.sources[path] = source


def line_of(text: str, path: str) -> int | None:
    """The line on which a dotted path is set, None where it cannot be found."""
    table, _, key = path.rpartition(".")
    here = ""
    table_line = None
    for number, line in enumerate(text.splitlines(), 1):
        if len(line) > 400:  # no key stands so far in, and the pattern below takes its time
            continue
        head = re.match(r"\[([^\[\]]+)\]", line.strip())
        if head:
            here = head.group(1).strip()
            if here in (path, table):
                table_line = table_line or number
            if here == path:
                return number
        elif (here == table and re.match(rf"\s*\"?{re.escape(key)}\"?\s*[=.]", line)) or (
            not here and re.match(rf"\s*{re.escape(path)}\s*[=.]", line)
        ):
            return number
    return table_line


def quoted(text: str) -> str:
    """A TOML string."""
    out = []
    for char in text:
        if char in '"\\':
            out.append("\\" + char)
        elif ord(char) < 32 or 127 <= ord(char) < 160 or char in "\u2028\u2029":
            out.append(f"\\u{ord(char):04x}")
        else:
            out.append(char)
    return '"' + "".join(out) + '"'
