"""One reader for all files of records, with units, sources, and the line in every error."""

from collections.abc import Collection, Iterator, Mapping
from contextlib import contextmanager
from typing import Any, TypeVar

from layerjam.core.errors import FileError, LayerjamError, UnknownNameError
from layerjam.core.toml_files.plugin_tables import build_table, load_table_class, plugin_groups
from layerjam.core.toml_files.source import Source
from layerjam.core.toml_files.toml import find_line, find_row, parse_toml
from layerjam.core.toml_files.values import Entry, TextSpec, entries
from layerjam.core.units import build
from layerjam.core.verdict import Acceptance

R = TypeVar("R")
DESCRIBING = {word: Entry(TextSpec()) for word in ("name", "title", "note")}
"""Descriptive texts that any file may contain."""


class Reader:
    """Collector of SI values and sources by dotted path.

    `values` contains the entries of `fields`, `words` the descriptive texts, `notes` the [made_by]
    table, `accepted` the [[accepted]] tables. `kind` is the record class, if other packages may add
    tables to it.
    """

    def __init__(
        self,
        text: str,
        path: object,
        fields: Mapping[str, Entry],
        words: Mapping[str, Entry] = DESCRIBING,
        kind: type | None = None,
    ) -> None:
        self.text, self.path, self.fields, self.described = text, path, fields, words
        self.tables = {p.split(".")[0] for p in fields if "." in p}
        self.values: dict[str, Any] = {}
        self.sources: dict[str, Source] = {}
        self.words: dict[str, str] = {}
        self.notes: dict[str, Any] = {}
        self.accepted: tuple[Acceptance, ...] = ()
        self.kind = kind
        self.groups = plugin_groups(kind) if kind is not None else {}
        self.plugins: dict[str, type] = {}
        """{table: record class} of the tables of other packages, such as [effects.humidity]."""

    def make_error(self, key: str, reason: object) -> FileError:
        """Return an error for `reason`, with the line of the key."""
        return FileError(self.path, str(reason), find_line(self.text, key))

    @contextmanager
    def locate_errors(self, key: str = "") -> Iterator[None]:
        """Turn errors inside the block into FileErrors, with the line of the quantity or `key`.

        The quantity of an error may also be a text in the file, such as a constraint.
        """
        try:
            yield
        except FileError:
            raise
        except LayerjamError as err:
            name = err.quantity or ""
            line = find_line(self.text, name) or find_row(self.text, name)
            line = line or find_line(self.text, key)
            raise FileError(self.path, str(err), line) from None

    def read_all(self, tables: Mapping[str, Any] | None = None, table: str = "") -> None:
        """Read every entry of a file, or of one of its tables."""
        entries_of_table = parse_toml(self.text, self.path) if tables is None else tables
        for key, value in entries_of_table.items():
            path = f"{table}.{key}" if table else key
            if path in self.fields:
                self.read_entry(path, value)
            elif not table and key in self.described:
                with self.locate_errors(key):
                    self.words[key] = self.described[key].spec.read(value, key)
            elif not table and key in self.tables:
                if not isinstance(value, dict):
                    raise self.make_error(key, f"{key} must be a table, [{key}]")
                self.read_all(value, key)
            elif not table and key in self.groups:
                self._read_plugins(key, value)
            elif path == "made_by" and isinstance(value, dict):
                self.notes = value
            elif path == "accepted" and isinstance(value, list):
                with self.locate_errors(path):
                    self.accepted = tuple(Acceptance.read(row) for row in value)
            else:
                raise self.make_error(path, self.unknown_key_error(path))

    def _read_plugins(self, key: str, tables: object) -> None:
        """Read the tables of other packages, [key.NAME], each with the fields of its record."""
        if not isinstance(tables, dict) or not all(isinstance(t, dict) for t in tables.values()):
            raise self.make_error(key, f"{key} must be tables, each after a line [{key}.NAME]")
        for name, inner in tables.items():
            table = f"{key}.{name}"
            with self.locate_errors(table):
                cls = load_table_class(self.kind, table)
            self.plugins[table] = cls
            self.fields = {**self.fields, **dict(entries(cls, f"{table}."))}
            self.read_all(inner, table)

    def unknown_key_error(self, key: str) -> UnknownNameError:
        """Return the error for an unknown key."""
        return UnknownNameError("key", key, [*self.fields, *self.tables, *self.described])

    def read_entry(self, path: str, entry: object) -> None:
        """Read one value, plain or with its source."""
        if path not in self.fields:
            raise self.make_error(path, self.unknown_key_error(path))
        value, source = entry, Source()
        if isinstance(entry, dict) and not self.fields[path].table:
            with self.locate_errors(path):
                value, source = Source.read(entry, path)
        with self.locate_errors(path):
            self.values[path] = self.fields[path].spec.read(value, path)
        self.sources[path] = source

    def read_rows(self, key: str, tables: object, cls: type[R]) -> tuple[R, ...]:
        """Return one record for each table of an array of tables, [[key]]."""
        if not isinstance(tables, list) or not all(isinstance(row, dict) for row in tables):
            raise self.make_error(key, f"{key} must be tables, each after a line [[{key}]]")
        fields = dict(entries(cls, f"{key}."))
        records = []
        for row in tables:
            inner = Reader(self.text, self.path, fields)
            inner.read_all(row, key)
            inner.check_required()
            records.append(inner.build_record(cls, f"{key}."))
        return tuple(records)

    def check_required(self, *more: str) -> None:
        """Raise FileError if a required value, or one of `more`, is missing."""
        tables = {p.rpartition(".")[0] for p in self.values}
        missing_paths = [
            path
            for path, e in self.fields.items()
            if path not in self.values
            and (path in more or (e.required and not self._is_absent(path, e, tables)))
        ]
        if missing_paths:
            names = ", ".join(f"{p} ({self.fields[p].spec.text})" for p in missing_paths[:4])
            reason = f"{names} {'is' if len(missing_paths) == 1 else 'are'} missing"
            raise self.make_error(missing_paths[0] if "." in missing_paths[0] else "", reason)

    @staticmethod
    def _is_absent(path: str, entry: Entry, tables: Collection[str]) -> bool:
        return entry.in_optional and path.rpartition(".")[0] not in tables

    def build_record(self, cls: type[R], prefix: str = "") -> R:
        """Return the record of the values read under a prefix."""
        known_paths = (p for p, _ in entries(cls, prefix) if p in self.values)
        values = {p.removeprefix(prefix): self.values[p] for p in known_paths}
        for key in self.groups if cls is self.kind else ():
            values[key] = tuple(self._build_plugins(key))
        with self.locate_errors():
            return build(cls, values)

    def _build_plugins(self, key: str) -> Iterator[Any]:
        for table, cls in self.plugins.items():
            if table.startswith(f"{key}."):
                with self.locate_errors(table):
                    yield build_table(cls, self.values, table)
