"""Changes by name to numbers of records and their files, with the checks of a file."""

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
from typing import Any, ClassVar, Generic, Self, TypeVar

from layerjam.errors import FileError, QuantityError, UnknownNameError, explain_arguments
from layerjam.toml_files.reader import Reader
from layerjam.toml_files.shipped import load_text
from layerjam.toml_files.source import KINDS, Source
from layerjam.toml_files.toml import quote
from layerjam.toml_files.values import Entry, entries
from layerjam.toml_files.writer import commented_lines, literal, update_text
from layerjam.units import build, get, quantities, show
from layerjam.verdict import Acceptance

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
            leaf if count[leaf] == 1 and path not in optional else path.replace(".", "_"): path
            for path, leaf in paths.items()
        }
    )


def resolve_changes(cls: type, changes: Mapping[str, Change]) -> dict[str, float | None]:
    """Return {dotted path: SI value or None} for changes given by name.

    Raises UnknownNameError with the nearest names, or QuantityError.
    """
    paths = quantity_names(cls)
    specs = {path: (spec, is_required) for path, spec, is_required in quantities(cls)}
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
    return build(type(rec), {path: v for path, v in values.items() if v is not None})


def collect_values(rec: Any) -> dict[str, Any]:
    """Return {dotted path: value} of all known values of a record."""
    values = {path: get(rec, path) for path, _ in entries(type(rec))}
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
        return cls(name=name, title=title, sources=reader.sources, text=reader.text, **fields)

    @classmethod
    def from_record(cls, record: R, name: str = "unnamed") -> Self:
        """Return a file for a plain record; raises FileError if a file cannot contain it."""
        fields: dict[str, Any] = {cls.holds: record}
        bare = cls(name=name, sources={}, text="", **fields)
        return cls.read(bare.render(name), f"{cls.holds} {name[:80]}")

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

    @property
    def known_values(self) -> dict[str, Any]:
        """{dotted path: value in SI} of all known values."""
        return collect_values(self.record)

    def rows(self) -> Iterator[tuple[str, str, str]]:
        """Yield (dotted path, value in a readable unit, kind of its source) of each number."""
        for path, value in collect_values(self.record).items():
            unit = getattr(self.fields[path].spec, "unit", None)
            kind = self.sources[path].kind if path in self.sources else ""
            yield path, str(value) if unit is None else show(value, unit), kind

    def __str__(self) -> str:
        rows = list(self.rows())
        wide, wider = (max(len(row[column]) for row in rows) for column in (0, 1))
        lines = (f"  {path:<{wide}}  {text:<{wider}}  {kind}".rstrip() for path, text, kind in rows)
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
        text = self.text if self._is_text_current() else self.render(self.name)
        # a key that is not in the file need not be removed
        edits = {p: c for p, c in changes.items() if c or p in self.known_values}
        new_text = update_text(text, self.fields, edits, name=name, tables=tables)
        return self.read(new_text, f"{self.holds} {(name or self.name)[:80]}")

    from_reader, edited, of = build_from_reader, edit, from_record  # former names

    def _is_text_current(self) -> bool:
        """Return whether the text still describes the record, which may have been replaced."""
        try:
            return self.read(self.text, self.name).record == self.record
        except FileError:
            return False

    def render(self, name: str) -> str:
        """Return a complete, commented file: every field with its meaning and bounds."""
        lines = [
            f"# {self.heading} Every quantity has a unit; change the values that differ.",
            "# A number can state its source:",
            '#   width = { value = "13 mm", kind = "measured", source = "caliper, 3 places" }',
            f"# kind: {', '.join(KINDS)}",
            f"name = {quote(name)}",
        ]
        if self.title:
            lines.append(f"title = {quote(self.title)}")
        rows = sorted(self.fields.items(), key=lambda row: "." in row[0])
        lines += commented_lines(rows, self.known_values, self.sources)
        for entry in self.accepted:
            lines += ["", "[[accepted]]"]
            lines += [f"{key} = {literal(word)}" for key, word in entry.to_toml().items()]
        return "\n".join(lines) + "\n"


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
