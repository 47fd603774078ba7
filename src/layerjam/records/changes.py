"""Records and their files with some numbers changed by name, checked like a file."""

from __future__ import annotations

import hashlib
import re
from abc import ABC, abstractmethod
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, fields, is_dataclass, replace
from functools import cache
from types import MappingProxyType
from typing import Any, ClassVar, Generic, Self, TypeVar

from layerjam.errors import FileError, QuantityError, UnknownNameError
from layerjam.records.reader import Reader
from layerjam.records.source import KINDS, Source
from layerjam.records.toml import quoted
from layerjam.records.values import Entry, entries
from layerjam.records.writer import commented, literal, updated
from layerjam.units import build, get, quantities
from layerjam.verdict import Acceptance

R = TypeVar("R")
Change = str | float | None
"""Text with a unit, an SI number, or None: not known, or as the default says."""
WITH = Source(kind="assumed", text="set with with_()")


@cache
def names(cls: type) -> Mapping[str, str]:
    """{name to change it by: dotted path} of every quantity of a record class.

    The name is that of the field where it is the only one and its record is always there; otherwise
    the record's name stands before it: `width`, `film_modulus`, `rope_stiffness`.
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


def by_path(cls: type, changes: Mapping[str, Change]) -> dict[str, float | None]:
    """{dotted path: SI value or None} of changes by name.

    Raises UnknownNameError with the nearest names, or QuantityError.
    """
    known = names(cls)
    specs = {path: (spec, required) for path, spec, required in quantities(cls)}
    made: dict[str, float | None] = {}
    for name, change in changes.items():
        if name not in known:
            raise UnknownNameError("quantity", name, known, quantity=name)
        spec, required = specs[known[name]]
        if change is None and required:
            raise QuantityError(f"{name}: {spec.text} cannot be left out", quantity=known[name])
        made[known[name]] = None if change is None else spec.si(change, known[name])
    return made


def changed(rec: R, changes: Mapping[str, Change]) -> R:
    """The record with other numbers by name, each within its bounds; raises as `by_path` does."""
    values = values_of(rec) | by_path(type(rec), changes)
    return build(type(rec), {path: v for path, v in values.items() if v is not None})


def values_of(rec: Any) -> dict[str, Any]:
    """{dotted path: value} of all that is known of a record."""
    found = {path: get(rec, path) for path, _ in entries(type(rec))}
    return {path: value for path, value in found.items() if value is not None}


@dataclass(frozen=True, kw_only=True)
class RecordFile(ABC, Generic[R]):
    """A record with its name, the text of its file, and where each of its numbers comes from."""

    name: str
    sources: Mapping[str, Source] = field(repr=False)
    text: str = field(repr=False)
    title: str = ""
    path: str = field(default="", repr=False, compare=False)
    """What the text was read from, for errors that are found later; empty where there is none."""
    notes: Mapping[str, Any] = field(default_factory=dict)
    """The table [made_by], which describes and does not count."""
    accepted: tuple[Acceptance, ...] = ()
    """Failed checks of the numbers that somebody accepted, from [[accepted]]."""

    fields: ClassVar[Mapping[str, Entry]]
    """All that such a file may set, by dotted path."""
    holds: ClassVar[str]
    """Name of the attribute that holds the record."""
    heading: ClassVar[str]
    """What such a file describes, as its first comment."""
    kind: ClassVar[type]
    """Class of the record."""
    named: ClassVar[tuple[str, str]] = (r"(?s).*\S.*", "name is missing")
    """Pattern of its name, and what is said of another."""

    @classmethod
    @abstractmethod
    def read(cls, text: str, path: object) -> Self:
        """The file from its TOML text; raises FileError with file and line."""

    @staticmethod
    @abstractmethod
    def check(record: Any, /) -> None:
        """Raise QuantityError for a record that is out of bounds or contradicts itself."""

    @classmethod
    def taken(cls, reader: Reader, *required: str, **more: Any) -> Self:
        """The file of what a reader has taken, complete and checked; raises FileError."""
        reader.require(*required)
        with reader.located():
            record: R = reader.record(cls.kind)
            cls.check(record)
        name, (pattern, wrong) = reader.words.get("name", ""), cls.named
        if not re.fullmatch(pattern, name):
            raise reader.fail("name", wrong)
        held: dict[str, Any] = {cls.holds: record, "path": str(reader.path), **more}
        title = reader.words.get("title", "")
        held["accepted"] = tuple(replace(one, file=str(reader.path)) for one in reader.accepted)
        held["notes"] = reader.notes
        return cls(name=name, title=title, sources=reader.sources, text=reader.text, **held)

    @classmethod
    def of(cls, record: R, name: str = "unnamed") -> Self:
        """The file of a record that has none; raises FileError for what such a file cannot hold."""
        held: dict[str, Any] = {cls.holds: record}
        bare = cls(name=name, sources={}, text="", **held)
        return cls.read(bare.rendered(name), f"{cls.holds} {name[:80]}")

    @property
    def record(self) -> R:
        """The record itself."""
        made: R = getattr(self, self.holds)
        return made

    @property
    def given(self) -> dict[str, Any]:
        """{dotted path: value in SI} of all that is known."""
        return values_of(self.record)

    @property
    def sha256(self) -> str:
        """Digest of its text; of the rendered one where it has none."""
        return hashlib.sha256((self.text or self.rendered(self.name)).encode()).hexdigest()

    @property
    def verdict(self) -> str | None:
        """`accepted` or `passed`; None if no command of layerjam judged the numbers."""
        return "accepted" if self.accepted else "passed" if "verdict" in self.notes else None

    def with_(self, **changes: Change) -> Self:
        """The file with other numbers by name, such as width="14 mm" or film_modulus="2.5 GPa".

        Text carries its unit, a number is SI, None is "not known" or the default. What is not
        changed keeps its source. Raises UnknownNameError with the nearest names, QuantityError for
        a number out of bounds, FileError for numbers that contradict each other.
        """
        given = by_path(type(self.record), changes)
        return self.edited({p: None if v is None else (v, WITH) for p, v in given.items()})

    def edited(
        self,
        changes: Mapping[str, tuple[Any, Source] | None],
        *,
        name: str | None = None,
        tables: Mapping[str, Mapping[str, Any] | None] = MappingProxyType({}),
    ) -> Self:
        """The file with other values by dotted path, its text in step; None takes a key out.

        `tables` are replaced as a whole, or taken out, before. Raises FileError for values that
        contradict each other.
        """
        text = self.text if self._in_step() else self.rendered(self.name)
        # what is not known already need not be taken out
        wanted = {p: c for p, c in changes.items() if c or p in self.given}
        made = updated(text, self.fields, wanted, name=name, tables=tables)
        return self.read(made, f"{self.holds} {(name or self.name)[:80]}")

    def _in_step(self) -> bool:
        """Whether the text says what the record holds; a replaced record may differ."""
        try:
            return self.read(self.text, self.name).record == self.record
        except FileError:
            return False

    def rendered(self, name: str) -> str:
        """A complete, commented file: every field with its meaning and what is allowed."""
        lines = [
            f"# {self.heading} Every quantity carries its unit; edit what differs for yours.",
            "# A number can say where it comes from:",
            '#   width = { value = "13 mm", kind = "measured", source = "caliper, 3 places" }',
            f"# kind: {', '.join(KINDS)}",
            f"name = {quoted(name)}",
        ]
        if self.title:
            lines.append(f"title = {quoted(self.title)}")
        rows = sorted(self.fields.items(), key=lambda row: "." in row[0])
        lines += commented(rows, self.given, self.sources)
        for one in self.accepted:
            lines += ["", "[[accepted]]"]
            lines += [f"{key} = {literal(entry)}" for key, entry in one.to_toml().items()]
        return "\n".join(lines) + "\n"


def record_files(values: Iterable[Any]) -> Iterator[RecordFile[Any]]:
    """Iterate over the record files among arguments: in lists, mappings and option records too."""
    for value in values:
        if isinstance(value, RecordFile):
            yield value
        elif isinstance(value, list | tuple):
            yield from record_files(value)
        elif isinstance(value, Mapping):
            yield from record_files(value.values())
        elif is_dataclass(value) and not isinstance(value, type):
            yield from record_files(getattr(value, f.name) for f in fields(value))


def paths_of(sources: Mapping[str, Source], kind: str) -> list[str]:
    """Dotted paths of the numbers that come from one kind of source."""
    return [path for path, source in sources.items() if source.kind == kind]
