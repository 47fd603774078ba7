"""All errors that a user can cause, under one base class.

A message is one plain sentence that names the quantity, its value, its unit and what is allowed.
"""

import contextlib
import difflib
import functools
import inspect
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Any, ClassVar, Self, TypeVar

from layerjam.core.installation import install_command

T = TypeVar("T")


class Notice(str):
    """A warning that accompanies a result: a sentence for people, and a key for programs."""

    key: str

    def __new__(cls, sentence: str, key: str = "note") -> "Notice":
        """Return a notice; programs should use `key` and never parse the sentence."""
        notice = super().__new__(cls, sentence)
        notice.key = key
        return notice

    def __reduce__(self) -> "tuple[type[Notice], tuple[str, str]]":
        return (Notice, (str(self), self.key))


def make_notices(sentences: Iterable[str]) -> list[Notice]:
    """Return the sentences as notices; those that are notices already keep their keys."""
    return [s if isinstance(s, Notice) else Notice(s) for s in sentences]


class LayerjamError(Exception):
    """Base of all errors of this package; they make the command line exit with code 2."""

    key: ClassVar[str] = "error"
    """Kind of error, for use by programs; the message is for people."""
    quantity: str | None = None
    """Dotted path or name of the quantity that the error concerns, or None."""


class QuantityError(LayerjamError, ValueError):
    """A value that lacks a unit, has the wrong dimension, is not a number or is out of bounds."""

    key = "quantity"

    def __init__(self, message: str, *, quantity: str | None = None) -> None:
        super().__init__(message)
        self.quantity = quantity

    @classmethod
    def of(cls, quantity: str, reason: str) -> Self:
        """Return an error about one quantity; its sentence begins with the quantity's name."""
        return cls(f"{quantity}: {reason}", quantity=quantity)


def find_error_quantity(error: LayerjamError | None) -> str | None:
    """Return the name of the quantity that an error is about, or None."""
    return error.quantity if isinstance(error, QuantityError) else None


class FileError(LayerjamError):
    """A file that cannot be read or written; the message names the file and, if known, the line."""

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
        """Build the message; `how` is its ending, which names the option that helps.

        `asks` names the missing choice: "columns", "force-sign", "elongation-sign", "decimal",
        "specimen", "sheet", "speed" or "reading". A page shows its own control for this choice
        below the text `plain`.
        """
        place = f"{path}, line {line}" if line else f"{path}"
        super().__init__(f"{place}: {reason}{how}")
        self.path = str(path)
        self.reason = reason + how
        self.plain = reason
        self.asks = asks
        self.line = line


class UnknownNameError(LayerjamError, KeyError):
    """A name that is not in a catalogue; the message suggests the nearest names."""

    key = "unknown-name"

    def __init__(
        self, kind: str, name: str, names: Iterable[str], *, quantity: str | None = None
    ) -> None:
        self.quantity = quantity
        names = sorted(names)
        suggestions = difflib.get_close_matches(name.lower(), names, n=3, cutoff=0.3) or names
        hint = f"did you mean {' or '.join(suggestions[:4])}?" if names else "none exists"
        self.message = f"unknown {kind} '{name[:80]}'; {hint}"
        super().__init__(self.message)

    def __str__(self) -> str:
        return self.message


class ArgumentError(LayerjamError, TypeError):
    """A missing argument of a function, or one that the function does not have."""

    key = "argument"


def explain_arguments(target: T) -> T:
    """Make a function or a dataclass raise ArgumentError for arguments it does not accept."""
    is_class = isinstance(target, type)
    call: Any = target.__init__ if is_class else target  # type: ignore[misc]

    @functools.wraps(call)
    def wrapper(*args: Any, **keywords: Any) -> Any:
        try:
            return call(*args, **keywords)
        except TypeError as error:
            if error.__traceback__ is None or error.__traceback__.tb_next is not None:
                raise  # the error comes from inside the call
            words = _explain_call(call, is_class, args, keywords)
            name = target.__name__ if is_class else call.__name__  # type: ignore[attr-defined]
            raise ArgumentError(f"{name}() {words}") from None

    if not is_class:
        return wrapper  # type: ignore[return-value]
    target.__init__ = wrapper  # type: ignore[misc]
    return target


def _explain_call(
    call: Callable[..., Any], is_class: bool, args: tuple[Any, ...], keywords: Mapping[str, Any]
) -> str:
    parameters = dict(inspect.signature(call).parameters)
    if parameters.pop("self", None):
        args = args[1:]
    if any(p.kind is p.VAR_KEYWORD for p in parameters.values()):
        return "accepts only named values, such as width='14 mm'"
    unknown = [name for name in keywords if name not in parameters]
    if unknown:
        suggestions = difflib.get_close_matches(unknown[0], parameters, n=2) or parameters
        kind = "field" if is_class else "parameter"
        return f"has no {kind} '{unknown[0]}'; did you mean {' or '.join(suggestions)}?"
    needed_names = [name for name, p in parameters.items() if p.default is p.empty]
    missing = [name for name in needed_names if name not in keywords]
    if missing and not args:
        return f"needs {', '.join(missing)}"
    return f"takes {', '.join(parameters)}"


class NotKnownError(LayerjamError, ValueError):
    """A required value that is unknown, or a result that is infeasible."""

    key = "not-known"


class PrecisionError(LayerjamError):
    """A call of a law while JAX works in single precision."""

    key = "precision"

    def __init__(self) -> None:
        super().__init__(
            "layerjam's laws need double precision: call "
            'jax.config.update("jax_enable_x64", True) first, or set JAX_ENABLE_X64=1'
        )


class PlatformError(LayerjamError):
    """A platform of JAX, named in JAX_PLATFORMS, that this machine does not have."""

    key = "platform"

    def __init__(self, platforms: str) -> None:
        super().__init__(
            f"JAX_PLATFORMS={platforms}: JAX cannot start this platform here; unset the variable, "
            "or use JAX_PLATFORMS=cpu"
        )


class ProcedureError(LayerjamError, ValueError):
    """A test procedure that cannot be read or that contradicts itself."""

    key = "procedure"


class FitError(LayerjamError, ValueError):
    """Measurements that do not determine a quantity; `path` is set if one file is at fault."""

    key = "fit"
    path: str = ""
    reason: str = ""
    notice: str = ""
    """Key of the notice whose remedy also helps here."""

    @classmethod
    def of(cls, path: object, reason: str) -> Self:
        """Return an error about one file; its sentence begins with the path."""
        error = cls(f"{path}: {reason}")
        error.path, error.reason = str(path), reason
        return error


class MissingExtraError(LayerjamError, ImportError):
    """A required optional package that is not installed."""

    key = "missing-extra"

    def __init__(self, feature: str, extra: str) -> None:
        super().__init__(f"{feature} needs an optional package: {install_command(extra)}")

    @classmethod
    @contextlib.contextmanager
    def raise_if_missing(cls, feature: str, extra: str) -> Iterator[None]:
        """Raise this error if an import inside the block fails, unless it was interrupted."""
        try:
            yield
        except ImportError as error:
            raise_interrupt(error)
            raise cls(feature, extra) from None


class InstallationError(LayerjamError):
    """A layerjam that was not installed, or whose installation is older than its files."""

    key = "installation"

    def __init__(self, missing: str) -> None:
        super().__init__(
            f"{missing} are missing, because this copy of layerjam is not installed or its "
            f"installation is out of date; install it: {install_command()}"
        )


class CompilerError(LayerjamError):
    """A C compiler that is not installed, or that cannot build the code."""

    key = "compiler"


def raise_interrupt(error: BaseException) -> None:
    """Raise KeyboardInterrupt if it caused the error.

    A compiled module that is interrupted while it loads raises ImportError, as if it were missing.
    """
    cause: BaseException | None = error
    while cause is not None:
        if isinstance(cause, KeyboardInterrupt):
            raise KeyboardInterrupt from None
        cause = cause.__cause__ or cause.__context__


def short_text(value: object) -> str:
    """Return a value as text on one short line, for an error message."""
    if shape := getattr(value, "shape", None):
        return f"{type(value).__name__} of shape {shape}"
    try:
        text = " ".join((value if isinstance(value, str) else repr(value)).split())
    except ValueError:  # Python refuses to print integers with more than 4,300 digits
        text = "a number with thousands of digits"
    text = text if len(text) <= 60 else text[:57] + "..."
    return f"'{text}'" if isinstance(value, str) else text


def count_text(number: int, noun: str) -> str:
    """Return a number with its noun, such as "1 pull" or "3 pulls"."""
    return f"{number} {noun}{'s' * (number != 1)}"


def are_text(number: int, noun: str) -> str:
    """Return a number with its noun and "is" or "are", such as "1 pull is" or "3 pulls are"."""
    return f"{count_text(number, noun)} {'is' if number == 1 else 'are'}"
