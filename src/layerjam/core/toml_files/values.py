"""Texts and lists as values of a file, with methods to read, check and write them.

`QuantitySpec` has the same methods, so a reader need not distinguish the kinds of value.
"""

from dataclasses import MISSING, dataclass, field, fields
from typing import Any, NamedTuple, Protocol

from layerjam.core.errors import QuantityError, UnknownNameError
from layerjam.core.threads import cache_threadsafe


class ValueSpec(Protocol):
    """Definition of one value of a file: its meaning, allowed values and written form."""

    @property
    def text(self) -> str:
        """Meaning of the value."""

    def limits(self) -> str:
        """Return the allowed values as a phrase."""

    def read(self, text: object, name: str) -> Any:
        """Return the value in SI from a TOML value; raises QuantityError or UnknownNameError."""

    def check(self, value: Any, name: str) -> Any:
        """Return `value` if it is allowed; raises as `read` does."""

    def to_toml(self, value: Any) -> object:
        """Return the TOML value of an SI value; `read` reverses it."""


class AsItIs:
    """Default methods of a ValueSpec: every readable value is allowed and written unchanged."""

    def limits(self) -> str:
        """Return the phrase "any", which allows every value."""
        return "any"

    def check(self, value: Any, name: str) -> Any:
        """Return `value` unchanged."""
        return value

    def to_toml(self, value: Any) -> object:
        """Return `value` unchanged."""
        return value


@dataclass(frozen=True, kw_only=True)
class TextSpec(AsItIs):
    """A text, which must be one of `choices` if there are any."""

    text: str = ""
    choices: tuple[str, ...] = ()
    blank: bool = True
    """Whether the text may be empty."""

    def limits(self) -> str:
        """Return the choices as a phrase."""
        return f"one of {', '.join(self.choices)}" if self.choices else "text in quotes"

    def read(self, text: object, name: str) -> str:
        """Return the text."""
        if not isinstance(text, str) or not (self.blank or text.strip()):
            meaning = f", {self.text}" if self.text else ""
            raise QuantityError.of(name, f"must be text in quotes{meaning}")
        return self.check(text, name)

    def check(self, value: Any, name: str) -> Any:
        """Return `value` if it is one of the choices; a record is allowed in place of a text."""
        if self.choices and value not in self.choices:
            leaf = name.rpartition(".")[2]
            raise UnknownNameError(leaf, str(value), self.choices, quantity=name)
        return value

    def to_toml(self, value: Any) -> object:
        """Return the text, or the name of the record in its place."""
        return value if isinstance(value, str) else value.name


@dataclass(frozen=True, kw_only=True)
class ListSpec(AsItIs):
    """A list of values of one kind."""

    each: ValueSpec
    distinct: bool = False
    """Whether each value may occur only once."""
    single: bool = False
    """Whether a single value may omit the brackets."""

    @property
    def text(self) -> str:
        """Meaning of the entries."""
        return self.each.text

    def limits(self) -> str:
        """Return the allowed values of an entry as a phrase."""
        return self.each.limits()

    def read(self, text: object, name: str) -> tuple[Any, ...]:
        """Return the values as a tuple."""
        if self.single and not isinstance(text, list):
            text = [text]
        if not isinstance(text, list):
            raise QuantityError.of(name, f"must be a list in [ ], such as [{text!r}]")
        return self.check(tuple(self.each.read(entry, name) for entry in text), name)

    def check(self, value: Any, name: str) -> Any:
        """Return `value` if each entry is allowed."""
        for entry in value:
            self.each.check(entry, name)
        if self.distinct and len(set(value)) < len(value):
            raise QuantityError.of(name, "contains the same value twice")
        return value

    def to_toml(self, value: Any) -> object:
        """Return the entries as a list."""
        return [self.each.to_toml(entry) for entry in value]


def value(spec: ValueSpec, default: Any = MISSING, table: bool = False) -> Any:
    """Return a dataclass field for a file's value that is not a plain quantity.

    `table` is as in `Entry`.
    """
    return field(default=default, metadata={"value": spec, "table": table})


class Entry(NamedTuple):
    """One value that a file may contain."""

    spec: ValueSpec
    required: bool = False
    in_optional: bool = False
    """Whether the value belongs to an optional table, without which it is not required."""
    default: Any = None
    table: bool = False
    """Whether the value itself is a table, and not a value with its source."""


@cache_threadsafe
def entries(
    cls: type, prefix: str = "", in_optional: bool = False
) -> tuple[tuple[str, Entry], ...]:
    """Return (dotted path, Entry) of every field of a record class that a file may set."""
    rows: list[tuple[str, Entry]] = []
    for f in fields(cls):
        spec = f.metadata.get("quantity") or f.metadata.get("value")
        required = f.default is MISSING
        if spec is not None:
            default = None if required else f.default
            table = bool(f.metadata.get("table"))
            rows.append((prefix + f.name, Entry(spec, required, in_optional, default, table)))
        elif "record" in f.metadata:
            inner = f.metadata["record"]
            rows += entries(inner, f"{prefix}{f.name}.", in_optional or f.default is None)
    return tuple(rows)
