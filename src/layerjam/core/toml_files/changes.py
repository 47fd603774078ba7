"""Changes by name to numbers of records and their files, with the checks of a file."""

import contextlib
import hashlib
import re
from abc import ABC, abstractmethod
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, fields, is_dataclass, replace
from functools import cache
from html import escape
from pathlib import Path
from types import MappingProxyType
from typing import Any, ClassVar, Generic, Self, TypeVar, cast

from layerjam.core.errors import FileError, QuantityError, UnknownNameError, explain_arguments
from layerjam.core.store import store_file
from layerjam.core.toml_files.plugin_tables import (
    build_table,
    check_tables,
    keyword,
    known_entries,
    load_table_class,
    named_tables,
    plugin_groups,
    plugin_tables,
)
from layerjam.core.toml_files.reader import Reader
from layerjam.core.toml_files.shipped import load_text
from layerjam.core.toml_files.source import KINDS, Source
from layerjam.core.toml_files.toml import quote
from layerjam.core.toml_files.values import Entry, entries
from layerjam.core.toml_files.writer import commented_lines, literal, update_text
from layerjam.core.units import build, get, quantities, show
from layerjam.core.verdict import Acceptance, remaining

R = TypeVar("R")
Change = str | float | None
"""Text with a unit, an SI number, or None for unknown or the default."""
SET_BY_HAND = Source(kind="assumed", text="set with with_()")


@cache
def _read_shipped(cls: Any, text: str, name: str) -> Any:
    return cls.read(text, name)


@cache
def quantity_names(cls: type) -> Mapping[str, str]:
    """Return {short name: dotted path} of every quantity of a record class.

    The short name is the field's name if it is unique and its record is always present. Otherwise
    the record's name comes first: `width`, `film_modulus`, `rope_stiffness`.
    """
    paths = {path: path.rpartition(".")[2] for path, _, _ in quantities(cls)}
    count = Counter(paths.values())
    optional = {path for path, entry in entries(cls) if entry.in_optional}
    return MappingProxyType(
        {
            leaf if count[leaf] == 1 and path not in optional else keyword(path): path
            for path, leaf in paths.items()
        }
    )


def resolve_changes(cls: type, changes: Mapping[str, Change]) -> dict[str, float | None]:
    """Return {dotted path: SI value or None} for changes given by name.

    Raises UnknownNameError with the nearest names, or QuantityError.
    """
    paths = dict(quantity_names(cls))
    specs = {path: (spec, is_required) for path, spec, is_required in quantities(cls)}
    for table, part in named_tables(cls, changes):
        for path, spec, is_required in quantities(part, f"{table}."):
            paths[keyword(path)], specs[path] = path, (spec, is_required)
    values: dict[str, float | None] = {}
    for name, change in changes.items():
        if name not in paths:
            raise UnknownNameError("quantity", name, paths, quantity=name)
        spec, is_required = specs[paths[name]]
        if change is None and is_required:
            raise QuantityError(f"{name}: {spec.text} cannot be omitted", quantity=paths[name])
        values[paths[name]] = None if change is None else spec.si(change, paths[name])
    return values


def with_changes(rec: R, changes: Mapping[str, Change]) -> R:
    """Return the record with numbers changed by name; raises the errors of `resolve_changes`."""
    values = collect_values(rec) | resolve_changes(type(rec), changes)
    known_values = {path: v for path, v in values.items() if v is not None}
    new = build(type(rec), known_values | _rebuild_plugins(rec, known_values))
    old_paths = [path for path, v in values.items() if v is None]
    return attach_accepted(new, remaining(list_accepted(rec), removals=old_paths))


def _rebuild_plugins(rec: Any, values: Mapping[str, Any]) -> dict[str, tuple[Any, ...]]:
    """Return {field: records of other packages} with `values` by dotted path."""
    out, cls = {}, cast("Any", type(rec))
    for key in plugin_groups(cls):
        parts = [(table, part) for table, part in plugin_tables(rec) if table.startswith(key)]
        classes = {table: type(part) for table, part in parts if table != key}
        new = {p.rpartition(".")[0] for p in values if p.startswith(f"{key}.")} - classes.keys()
        classes |= {table: load_table_class(cls, table) for table in sorted(new)}
        rebuilt = {t: build_table(c, values, t) for t, c in classes.items()}
        stated_before = [rebuilt.pop(table, part) for table, part in parts]
        out[key] = (*stated_before, *rebuilt.values())
    return out


def collect_values(rec: Any) -> dict[str, Any]:
    """Return {dotted path: value} of all known values of a record."""
    values = {path: get(rec, path) for path, _ in entries(type(rec))}
    for table, part in plugin_tables(rec):
        if "." in table:
            values |= {f"{table}.{path}": v for path, v in collect_values(part).items()}
    return {path: value for path, value in values.items() if value is not None}


@dataclass(frozen=True, kw_only=True)
class RecordFile(ABC, Generic[R]):
    """A record with its name, the text of its file, and the source of each of its numbers."""

    name: str
    sources: Mapping[str, Source] = field(repr=False)
    text: str = field(repr=False)
    title: str = ""
    path: str = field(default="", repr=False, compare=False)
    """Path or description of the text's origin, for later errors; may be empty."""
    notes: Mapping[str, Any] = field(default_factory=dict)
    """The descriptive table [made_by]."""
    accepted: tuple[Acceptance, ...] = ()
    """Accepted failed checks of the numbers, from [[accepted]]."""

    fields: ClassVar[Mapping[str, Entry]]
    """{dotted path: Entry} of everything that such a file may set."""
    holds: ClassVar[str]
    """Name of the attribute that holds the record."""
    heading: ClassVar[str]
    """First comment of such a file."""
    kind: ClassVar[type]
    """Class of the record."""
    name_rule: ClassVar[tuple[str, str]] = (r"(?s).*\S.*", "name is missing")
    """Pattern that its name must match, and the error message if it does not."""

    @classmethod
    @abstractmethod
    def read(cls, text: str, path: object) -> Self:
        """Return the file from its TOML text; raises FileError with file and line."""

    @staticmethod
    @abstractmethod
    def check(record: Any, /) -> None:
        """Raise QuantityError for a record that is out of bounds or contradicts itself."""

    @classmethod
    def build_from_reader(cls, reader: Reader, *required: str, **more: Any) -> Self:
        """Return the complete, checked file from the values in a reader; raises FileError."""
        reader.check_required(*required)
        with reader.locate_errors():
            record: R = reader.build_record(cls.kind)
            cls.check(record)
        name, (pattern, wrong) = reader.words.get("name", ""), cls.name_rule
        if not re.fullmatch(pattern, name):
            raise reader.make_error("name", wrong)
        fields: dict[str, Any] = {cls.holds: record, "path": str(reader.path), **more}
        title = reader.words.get("title", "")
        fields["accepted"] = tuple(replace(a, file=str(reader.path)) for a in reader.accepted)
        fields["notes"] = reader.notes
        attach_accepted(record, fields["accepted"])
        return cls(name=name, title=title, sources=reader.sources, text=reader.text, **fields)

    @classmethod
    def from_record(cls, record: R, name: str = "unnamed") -> Self:
        """Return a file for a plain record; raises FileError if a file cannot contain it.

        The file has the accepted failures of the file from which the record was read, if any.
        """
        fields: dict[str, Any] = {cls.holds: record, "accepted": list_accepted(record)}
        new_file = cls(name=name, sources={}, text="", **fields)
        return cls.read(new_file.render(name), f"{cls.holds} {name[:80]}")

    @classmethod
    def load(cls, source: str | Path, texts: Mapping[str, str]) -> Self:
        """Return a shipped file by its name in `texts`, or a user's file by its path.

        Raises UnknownNameError (with the nearest names) or FileError.
        """
        text, place = load_text(cls.holds, source, texts)
        if place not in texts:
            return cls.read(text, place)
        file: Self = _read_shipped(cls, text, place)
        values = {f.name: getattr(file, f.name) for f in fields(file)}
        # callers may change the mappings
        copies: dict[str, Any] = {k: dict(v) for k, v in values.items() if isinstance(v, dict)}
        return replace(file, **copies)

    @property
    def record(self) -> R:
        """The record itself."""
        record: R = getattr(self, self.holds)
        return record

    def all_fields(self, paths: Iterable[str] = ()) -> Mapping[str, Entry]:
        """Return `fields`, those of other packages' tables in the file, and those of `paths`.

        Raises QuantityError for a table that no installed package provides.
        """
        foreign = known_entries(self.record, paths)
        return {**self.fields, **foreign} if foreign else self.fields

    @property
    def known_values(self) -> dict[str, Any]:
        """{dotted path: value in SI} of all known values."""
        return collect_values(self.record)

    def rows(self) -> Iterator[tuple[str, str, str]]:
        """Yield (dotted path, value in a readable unit, kind of its source) of each number."""
        fields = self.all_fields()
        for path, value in collect_values(self.record).items():
            unit = getattr(fields[path].spec, "unit", None)
            kind = self.sources[path].kind if path in self.sources else ""
            yield path, str(value) if unit is None else show(value, unit), kind

    def __str__(self) -> str:
        rows = list(self.rows())
        first_width, second_width = (max(len(row[column]) for row in rows) for column in (0, 1))
        lines = (
            f"  {path:<{first_width}}  {text:<{second_width}}  {kind}".rstrip()
            for path, text, kind in rows
        )
        return "\n".join([f"{self.holds} {self.title or self.name}", *lines])

    def _repr_html_(self) -> str:
        body = "".join(
            f"<tr><th>{path}</th><td>{escape(text)}</td><td>{kind}</td></tr>"
            for path, text, kind in self.rows()
        )
        return f"<table><caption>{escape(self.title or self.name)}</caption>{body}</table>"

    @property
    def sha256(self) -> str:
        """Digest of the text, or of the rendered text if there is none."""
        return hashlib.sha256((self.text or self.render(self.name)).encode()).hexdigest()

    @property
    def verdict(self) -> str | None:
        """Verdict on the numbers: `accepted` or `passed`; None if no command checked them."""
        return "accepted" if self.accepted else "passed" if "verdict" in self.notes else None

    @explain_arguments
    def with_(self, **changes: Change) -> Self:
        """Return the file with some numbers changed by name: width="14 mm", film_modulus="2.5 GPa".

        Text includes its unit, a number is in SI, and None means unknown or the default. Other
        values keep their sources. Raises UnknownNameError with the nearest names, QuantityError for
        a number out of bounds, FileError for numbers that contradict each other.
        """
        values = resolve_changes(type(self.record), changes)
        return self.edit({p: None if v is None else (v, SET_BY_HAND) for p, v in values.items()})

    def edit(
        self,
        changes: Mapping[str, tuple[Any, Source] | None],
        *,
        name: str | None = None,
        tables: Mapping[str, Mapping[str, Any] | None] = MappingProxyType({}),
    ) -> Self:
        """Return the file with values, also texts, changed by dotted path; None removes a key.

        `tables` are first replaced or removed as a whole. Raises FileError for values that
        contradict each other.
        """
        text = self._current_text()
        # a key that is not in the file need not be removed
        edits = {p: c for p, c in changes.items() if c or p in self.known_values}
        fields = self.all_fields(edits)
        new_text = update_text(text, fields, edits, name=name, tables=tables)
        return self.read(new_text, f"{self.holds} {(name or self.name)[:80]}")

    def save(self, path: str | Path, *, overwrite: bool = False) -> Path:
        """Write the file as .toml, with its comments and sources; return its path.

        Raises FileError for another extension, or if the file exists and `overwrite` is not set.
        """
        path = Path(path)
        if path.suffix.lower() != ".toml":
            raise FileError(path, f"extension '{path.suffix}' is unknown; use .toml")
        return store_file(path, self._current_text(), overwrite)

    from_reader, edited, of = build_from_reader, edit, from_record  # former names

    def _current_text(self) -> str:
        """Return the text if it still describes the record, which may have been replaced."""
        with contextlib.suppress(FileError):
            if self.read(self.text, self.name).record == self.record:
                return self.text
        return self.render(self.name)

    def render(self, name: str) -> str:
        """Return a complete, commented file: every field with its meaning and bounds.

        Raises QuantityError for a record of another package that a file cannot state.
        """
        check_tables(self.record)
        lines = [
            f"# {self.heading} Every quantity has a unit; change the values that differ.",
            "# A number can state its source:",
            '#   width = { value = "13 mm", kind = "measured", source = "caliper, 3 places" }',
            f"# kind: {', '.join(KINDS)}",
            f"name = {quote(name)}",
        ]
        if self.title:
            lines.append(f"title = {quote(self.title)}")
        rows = sorted(self.all_fields().items(), key=lambda row: "." in row[0])
        lines += commented_lines(rows, self.known_values, self.sources)
        for entry in self.accepted:
            lines += ["", "[[accepted]]"]
            lines += [f"{key} = {literal(word)}" for key, word in entry.to_toml().items()]
        return "\n".join(lines) + "\n"


def attach_accepted(record: R, acceptances: Iterable[Acceptance]) -> R:
    """Return the record with the accepted failures of its numbers, for use without its file.

    They are not a field: two records with the same numbers are equal.
    """
    if values := tuple(acceptances):
        object.__setattr__(record, "_accepted", values)
    return record


def list_accepted(record: Any) -> tuple[Acceptance, ...]:
    """Return the accepted failures that `attach_accepted` attached to a record."""
    return tuple(getattr(record, "_accepted", ()))


def find_record_files(values: Iterable[Any]) -> Iterator[RecordFile[Any]]:
    """Yield the record files among arguments, also those inside lists, mappings and dataclasses."""
    for value in values:
        if isinstance(value, RecordFile):
            yield value
        elif isinstance(value, list | tuple):
            yield from find_record_files(value)
        elif isinstance(value, Mapping):
            yield from find_record_files(value.values())
        elif is_dataclass(value) and not isinstance(value, type):
            yield from find_record_files(getattr(value, f.name) for f in fields(value))


def find_paths(sources: Mapping[str, Source], kind: str) -> list[str]:
    """Return the dotted paths of the numbers whose source is of a given kind."""
    return [path for path, source in sources.items() if source.kind == kind]
