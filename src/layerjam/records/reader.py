"""One reader for all files of records: units, sources, and the line in every error."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from contextlib import contextmanager
from typing import Any, TypeVar

from layerjam.errors import FileError, LayerjamError, UnknownNameError
from layerjam.records.source import Source
from layerjam.records.toml import line_of, parse_toml, row_with
from layerjam.records.values import Entry, TextSpec, entries
from layerjam.units import build
from layerjam.verdict import Acceptance

R = TypeVar("R")
DESCRIBING = {word: Entry(TextSpec()) for word in ("name", "title", "note")}
"""Texts that any file may hold and that count for nothing."""


class Reader:
    """Collects SI values and sources under dotted paths.

    `values` holds what `fields` allows, `words` the texts that only describe, `notes` the table
    [made_by], `accepted` the tables [[accepted]].
    """

    def __init__(
        self,
        text: str,
        path: object,
        fields: Mapping[str, Entry],
        words: Mapping[str, Entry] = DESCRIBING,
    ) -> None:
        self.text, self.path, self.fields, self.described = text, path, fields, words
        self.tables = {p.split(".")[0] for p in fields if "." in p}
        self.values: dict[str, Any] = {}
        self.sources: dict[str, Source] = {}
        self.words: dict[str, str] = {}
        self.notes: dict[str, Any] = {}
        self.accepted: tuple[Acceptance, ...] = ()

    def fail(self, key: str, reason: object) -> FileError:
        """The error, with the line the key stands on."""
        return FileError(self.path, str(reason), line_of(self.text, key))

    @contextmanager
    def located(self, key: str = "") -> Iterator[None]:
        """Errors inside become FileErrors, with the line of the quantity they name or of `key`.

        What they name may also be a text of the file, such as a constraint.
        """
        try:
            yield
        except FileError:
            raise
        except LayerjamError as err:
            named = err.quantity or ""
            line = line_of(self.text, named) or row_with(self.text, named)
            line = line or line_of(self.text, key)
            raise FileError(self.path, str(err), line) from None

    def take(self, tables: Mapping[str, Any] | None = None, table: str = "") -> None:
        """Every entry of a file, or of one of its tables."""
        given = parse_toml(self.text, self.path) if tables is None else tables
        for key, value in given.items():
            path = f"{table}.{key}" if table else key
            if path in self.fields:
                self.entry(path, value)
            elif not table and key in self.described:
                with self.located(key):
                    self.words[key] = self.described[key].spec.read(value, key)
            elif not table and key in self.tables:
                if not isinstance(value, dict):
                    raise self.fail(key, f"{key} must be a table, [{key}]")
                self.take(value, key)
            elif path == "made_by" and isinstance(value, dict):
                self.notes = value
            elif path == "accepted" and isinstance(value, list):
                with self.located(path):
                    self.accepted = tuple(Acceptance.read(row) for row in value)
            else:
                raise self.fail(path, self.unknown(path))

    def unknown(self, key: str) -> UnknownNameError:
        """What to say of a key nobody knows."""
        return UnknownNameError("key", key, [*self.fields, *self.tables, *self.described])

    def entry(self, path: str, entry: object) -> None:
        """One value, plain or with where it comes from."""
        if path not in self.fields:
            raise self.fail(path, self.unknown(path))
        value, source = entry, Source()
        if isinstance(entry, dict) and not self.fields[path].table:
            with self.located(path):
                value, source = Source.read(entry, path)
        with self.located(path):
            self.values[path] = self.fields[path].spec.read(value, path)
        self.sources[path] = source

    def rows(self, key: str, given: object, cls: type[R]) -> tuple[R, ...]:
        """One record for each table of an array of tables, [[key]]."""
        if not isinstance(given, list) or not all(isinstance(row, dict) for row in given):
            raise self.fail(key, f"{key}: each begins with a line [[{key}]]")
        known = dict(entries(cls, f"{key}."))
        made = []
        for row in given:
            inner = Reader(self.text, self.path, known)
            inner.take(row, key)
            inner.require()
            made.append(inner.record(cls, f"{key}."))
        return tuple(made)

    def require(self, *more: str) -> None:
        """Raise FileError where a required value, or one of `more`, is missing."""
        begun = {p.rpartition(".")[0] for p in self.values}
        due = [
            path
            for path, e in self.fields.items()
            if path not in self.values
            and (path in more or (e.required and not self._absent(path, e, begun)))
        ]
        if due:
            what = ", ".join(f"{p} ({self.fields[p].spec.text})" for p in due[:4])
            reason = f"{what} {'is' if len(due) == 1 else 'are'} missing"
            raise self.fail(due[0] if "." in due[0] else "", reason)

    @staticmethod
    def _absent(path: str, entry: Entry, begun: Collection[str]) -> bool:
        return entry.in_optional and path.rpartition(".")[0] not in begun

    def record(self, cls: type[R], prefix: str = "") -> R:
        """The record of the values read under a prefix."""
        inside = (p for p, _ in entries(cls, prefix) if p in self.values)
        with self.located():
            return build(cls, {p.removeprefix(prefix): self.values[p] for p in inside})
