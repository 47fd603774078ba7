"""What else than a quantity a file may hold: texts and lists; each reads and writes itself.

`QuantitySpec` answers the same questions, so that a reader need not know which one it has.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import MISSING, dataclass, field, fields
from typing import Any, NamedTuple, Protocol

from layerjam.errors import QuantityError, UnknownNameError


class ValueSpec(Protocol):
    """What is known of one value of a file: its meaning, what is allowed, how it is written."""

    @property
    def text(self) -> str:
        """Its meaning."""

    def limits(self) -> str:
        """What is allowed, as a phrase."""

    def read(self, text: object, name: str) -> Any:
        """The value in SI from what TOML holds; raises QuantityError or UnknownNameError."""

    def check(self, value: Any, name: str) -> Any:
        """`value`, if it is allowed; raises as `read` does."""

    def to_toml(self, value: Any) -> object:
        """What TOML holds of a value in SI; `read` gives the same value back."""


class AsItIs:
    """The usual answers of a ValueSpec: everything that can be read is allowed, and written so."""

    def limits(self) -> str:
        """Nothing to add."""
        return "any"

    def check(self, value: Any, name: str) -> Any:
        """`value` itself."""
        return value

    def to_toml(self, value: Any) -> object:
        """`value` itself."""
        return value


@dataclass(frozen=True, kw_only=True)
class TextSpec(AsItIs):
    """A text, one of `choices` where there are any."""

    text: str = ""
    choices: tuple[str, ...] = ()
    blank: bool = True
    """Whether it may be empty."""

    def limits(self) -> str:
        """The choices."""
        return f"one of {', '.join(self.choices)}" if self.choices else "a text in quotes"

    def read(self, text: object, name: str) -> str:
        """The text itself."""
        if not isinstance(text, str) or not (self.blank or text.strip()):
            meaning = f", {self.text}" if self.text else ""
            raise QuantityError.of(name, f"must be a text in quotes{meaning}")
        return self.check(text, name)

    def check(self, value: Any, name: str) -> Any:
        """`value`, if it is one of the choices; a record in a text's place is not looked at."""
        if self.choices and value not in self.choices:
            leaf = name.rpartition(".")[2]
            raise UnknownNameError(leaf, str(value), self.choices, quantity=name)
        return value

    def to_toml(self, value: Any) -> object:
        """The text, or the name of the record that stands in its place."""
        return value if isinstance(value, str) else value.name


@dataclass(frozen=True, kw_only=True)
class ListSpec(AsItIs):
    """A list of values of one kind."""

    each: ValueSpec
    distinct: bool = False
    """Whether a value may stand only once."""
    single: bool = False
    """Whether a value may stand without brackets."""

    @property
    def text(self) -> str:
        """The meaning of its entries."""
        return self.each.text

    def limits(self) -> str:
        """What is allowed of each entry."""
        return self.each.limits()

    def read(self, text: object, name: str) -> tuple[Any, ...]:
        """The values as a tuple."""
        if self.single and not isinstance(text, list):
            text = [text]
        if not isinstance(text, list):
            raise QuantityError.of(name, f"must be a list in [ ], such as [{text!r}]")
        return self.check(tuple(self.each.read(entry, name) for entry in text), name)

    def check(self, value: Any, name: str) -> Any:
        """`value`, if each entry is allowed."""
        for entry in value:
            self.each.check(entry, name)
        if self.distinct and len(set(value)) < len(value):
            raise QuantityError.of(name, "holds the same value twice")
        return value

    def to_toml(self, value: Any) -> object:
        """The entries as a list."""
        return [self.each.to_toml(entry) for entry in value]


def value(spec: ValueSpec, default: Any = MISSING, table: bool = False) -> Any:
    """A dataclass field that a file may set and that is not a plain quantity.

    `table` is as in an Entry.
    """
    return field(default=default, metadata={"value": spec, "table": table})


class Entry(NamedTuple):
    """One value that a file may hold."""

    spec: ValueSpec
    required: bool = False
    in_optional: bool = False
    """Whether it belongs to a table that may be absent; it is then due only with the table."""
    default: Any = None
    table: bool = False
    """Whether a table is the value itself, not a value with its source."""


def entries(cls: type, prefix: str = "", in_optional: bool = False) -> Iterator[tuple[str, Entry]]:
    """(dotted path, Entry) of everything a file may set in a record class, and nested."""
    for f in fields(cls):  # type: ignore[arg-type]
        spec = f.metadata.get("quantity") or f.metadata.get("value")
        required = f.default is MISSING
        if spec is not None:
            default = None if required else f.default
            table = bool(f.metadata.get("table"))
            yield prefix + f.name, Entry(spec, required, in_optional, default, table)
        elif "record" in f.metadata:
            inner = f.metadata["record"]
            yield from entries(inner, f"{prefix}{f.name}.", in_optional or f.default is None)
