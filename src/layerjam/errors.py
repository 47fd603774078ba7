"""Every error a user can cause, under one base class.

A message is one plain sentence that names the quantity, its value, its unit and what is allowed.
"""

from __future__ import annotations

import contextlib
import difflib
import functools
from collections.abc import Iterable, Iterator
from dataclasses import MISSING, fields
from typing import Any, ClassVar, Self, TypeVar

T = TypeVar("T")


class Notice(str):
    """A warning next to a result: a sentence for people, and a key for programs."""

    key: str

    def __new__(cls, sentence: str, key: str = "note") -> Notice:
        """Return a notice; programs use `key` and never parse the sentence."""
        notice = super().__new__(cls, sentence)
        notice.key = key
        return notice

    def __reduce__(self) -> tuple[type[Notice], tuple[str, str]]:
        return (Notice, (str(self), self.key))


class LayerjamError(Exception):
    """Base of all errors of this package; the command line then exits with code 2."""

    key: ClassVar[str] = "error"
    """Kind of error, for programs; the sentence is for people."""
    quantity: str | None = None
    """Dotted path or name of the quantity that the error concerns, or None."""


class QuantityError(LayerjamError, ValueError):
    """A value without unit, of the wrong dimension, not a number, or outside its bounds."""

    key = "quantity"

    def __init__(self, message: str, *, quantity: str | None = None) -> None:
        super().__init__(message)
        self.quantity = quantity

    @classmethod
    def of(cls, quantity: str, reason: str) -> Self:
        """Return an error about one quantity; its sentence begins with the quantity's name."""
        return cls(f"{quantity}: {reason}", quantity=quantity)


class FileError(LayerjamError):
    """A file that cannot be read or written; names the file and, where known, the line."""

    key = "file"

    def __init__(
        self,
        path: object,
        reason: str,
        line: int | None = None,
        *,
        how: str = "",
        asks: str = "",
    ) -> None:
        """Build the message: `how` ends it with the option that helps.

        `asks` names the missing choice: "columns", "force-sign", "elongation-sign", "decimal",
        "specimen", "sheet", "speed" or "reading". A page offers it in its own way, after `plain`.
        """
        place = f"{path}, line {line}" if line else f"{path}"
        super().__init__(f"{place}: {reason}{how}")
        self.path = str(path)
        self.reason = reason + how
        self.plain = reason
        self.asks = asks
        self.line = line


class UnknownNameError(LayerjamError, KeyError):
    """A name that is not in a catalogue; the message offers the nearest names."""

    key = "unknown-name"

    def __init__(
        self, kind: str, name: str, names: Iterable[str], *, quantity: str | None = None
    ) -> None:
        self.quantity = quantity
        names = sorted(names)
        suggestions = difflib.get_close_matches(name.lower(), names, n=3, cutoff=0.3) or names
        hint = f"did you mean {' or '.join(suggestions[:4])}?" if names else "there is none"
        self.message = f"unknown {kind} '{name[:80]}'; {hint}"
        super().__init__(self.message)

    def __str__(self) -> str:
        return self.message


class ArgumentError(LayerjamError, TypeError):
    """An argument of a function that is missing, or that the function does not have."""

    key = "argument"


def explain_arguments(cls: type[T]) -> type[T]:
    """Make a dataclass raise ArgumentError for fields it does not have, or that are missing."""
    fill = cls.__init__

    @functools.wraps(fill)
    def initialise(self: Any, *args: Any, **named: Any) -> None:
        try:
            fill(self, *args, **named)
        except TypeError as error:
            if error.__traceback__ is None or error.__traceback__.tb_next is not None:
                raise  # inside the constructor
            all_fields = {f.name: f for f in fields(cls)}  # type: ignore[arg-type]
            unknown = [name for name in named if name not in all_fields]
            without_default = [
                n for n, f in all_fields.items() if f.default is f.default_factory is MISSING
            ]
            missing = ", ".join(name for name in without_default if name not in named)
            words = f"needs {missing}" if missing and not args else f"takes {', '.join(all_fields)}"
            if unknown:
                suggestions = difflib.get_close_matches(unknown[0], all_fields, n=2) or all_fields
                words = f"has no field '{unknown[0]}'; did you mean {' or '.join(suggestions)}?"
            raise ArgumentError(f"{cls.__name__}() {words}") from None

    cls.__init__ = initialise  # type: ignore[method-assign]
    return cls


class NotKnownError(LayerjamError, ValueError):
    """A number that is not known, or a result that is infeasible, from which one was required."""

    key = "not-known"


class PrecisionError(LayerjamError):
    """A law was called while JAX works in single precision."""

    key = "precision"

    def __init__(self) -> None:
        super().__init__(
            "layerjam's laws need double precision: call "
            'jax.config.update("jax_enable_x64", True) first, or set JAX_ENABLE_X64=1'
        )


class ProcedureError(LayerjamError, ValueError):
    """A test procedure that cannot be read or contradicts itself."""

    key = "procedure"


class FitError(LayerjamError, ValueError):
    """Measurements that do not determine a quantity; `path` if it concerns one file."""

    key = "fit"
    path: str = ""
    reason: str = ""

    @classmethod
    def of(cls, path: object, reason: str) -> Self:
        """Return an error about one file; its sentence begins with the path."""
        error = cls(f"{path}: {reason}")
        error.path, error.reason = str(path), reason
        return error


class MissingExtraError(LayerjamError, ImportError):
    """An optional part that is not installed."""

    key = "missing-extra"

    def __init__(self, feature: str, extra: str) -> None:
        # double quotes: Windows' shell knows no others
        super().__init__(f'{feature} needs an optional part: pip install "layerjam[{extra}]"')

    @classmethod
    @contextlib.contextmanager
    def raise_if_missing(cls, feature: str, extra: str) -> Iterator[None]:
        """Raise this error if an import inside the block fails."""
        try:
            yield
        except ImportError:
            raise cls(feature, extra) from None


class CompilerError(LayerjamError):
    """A C compiler that is not installed, or that cannot build the code."""

    key = "compiler"


def abbreviate(value: object) -> str:
    """Return a value as one short line for an error message."""
    if shape := getattr(value, "shape", None):
        return f"{type(value).__name__} of the shape {shape}"
    try:
        text = " ".join((value if isinstance(value, str) else repr(value)).split())
    except ValueError:  # Python prints no integer of more than 4,300 digits
        text = "a number of thousands of digits"
    text = text if len(text) <= 60 else text[:57] + "..."
    return f"'{text}'" if isinstance(value, str) else text


def count_of(number: int, noun: str) -> str:
    """Return a number with its noun, such as "1 pull" or "3 pulls"."""
    return f"{number} {noun}{'s' * (number != 1)}"
