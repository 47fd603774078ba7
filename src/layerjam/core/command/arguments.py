"""Arguments of a call by name, their errors, and the types that an annotation allows."""

import difflib
import inspect
import os
import types
import typing
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, get_args, get_origin

from layerjam.core.errors import ArgumentError, QuantityError, UnknownNameError, short_text


def bind_arguments(
    function: str,
    signature: inspect.Signature,
    record_fields: Iterable[str],
    required: Mapping[str, str],
    args: Sequence[Any],
    keyword_values: Mapping[str, Any],
) -> dict[str, Any]:
    """Return the arguments of a call, keyed by name.

    `record_fields` are the names of fields that may be given instead of a whole record, `required`
    is {required parameter: meaning}. Raises ArgumentError for an unknown name, with the nearest
    names, and for missing arguments, with their meanings.
    """
    names = [*signature.parameters, *record_fields]
    for name in keyword_values:
        if name not in signature.parameters:
            suggestions = difflib.get_close_matches(name, names, n=2, cutoff=0.5)
            hint = (
                f"did you mean {' or '.join(suggestions)}?"
                if suggestions
                else f"its parameters are {', '.join(names)}"
            )
            raise ArgumentError(f"{function}() has no parameter '{name}'; {hint}")
    try:
        return dict(signature.bind(*args, **keyword_values).arguments)
    except TypeError:
        missing = [name for name in list(required)[len(args) :] if name not in keyword_values]
        meanings = "; ".join(f"{name} ({required[name].rstrip('.')})" for name in missing)
        order = [n for n, p in signature.parameters.items() if p.kind is p.POSITIONAL_OR_KEYWORD]
        twice = [name for name in order[: len(args)] if name in keyword_values]
        keywords = [name for name in signature.parameters if name not in order]
        if missing:
            words = f"needs {meanings}"
        elif twice:
            words = f"got {twice[0]} twice"
        else:
            words = (
                f"accepts {', '.join(order) or 'nothing'} by position, not {len(args)} values; "
                f"pass the others by name, such as {(keywords or order)[0]}=..."
            )
        raise ArgumentError(f"{function}() {words}") from None


def gather_options(
    name: str, cls: type, record: Any, loose: Mapping[str, Any], options: Sequence[str]
) -> Mapping[str, Any]:
    """Return a record's options by name, given as one `record` or as `loose` single fields.

    Raises ArgumentError if both are given, UnknownNameError for an option that the record does not
    have, and QuantityError for an object that is not such a record.
    """
    if isinstance(record, Mapping):
        record, loose = None, {**record, **loose}
    if unknown := [key for key in loose if key not in options]:
        raise UnknownNameError(f"option of {name}", str(unknown[0]), options)
    if record is None:
        return loose
    if loose:
        raise ArgumentError(f"give {name} or {', '.join(loose)}, not both")
    if not all(hasattr(record, key) for key in options):
        raise QuantityError.of(name, f"{short_text(record)} is not a {cls.__name__} or a mapping")
    return {key: getattr(record, key) for key in options}


def make_list(value: Any, kind: Any) -> Any:
    """Return an iterator as a list; a single member becomes a list if only lists are allowed."""
    if isinstance(value, Iterator):
        return list(value)
    return [value] if not is_of_kind(value, kind) and is_of_kind([value], kind) else value


def check_kind(value: Any, kind: Any, name: str) -> None:
    """Raise QuantityError if an argument is not of its declared type."""
    if not is_of_kind(value, kind):
        raise QuantityError.of(name, f"{short_text(value)} is not {describe_type(kind)}")


def is_of_kind(value: Any, kind: Any) -> bool:
    """Return whether an argument is of a declared type.

    A type known only to type checkers accepts any argument.
    """
    origin, type_arguments = get_origin(kind), get_args(kind)
    if origin in (typing.Union, types.UnionType):
        return any(is_of_kind(value, member) for member in type_arguments)
    if origin is typing.Literal:
        return value in type_arguments
    if origin is Callable:
        return callable(value)
    if origin is Mapping:
        return isinstance(value, Mapping)
    if origin in (Sequence, Collection):
        is_list = isinstance(value, Iterable) and not isinstance(value, str | bytes | Mapping)
        return (
            is_list
            and not hasattr(value, "columns")
            and all(is_of_kind(member, type_arguments[0]) for member in value)
        )
    if kind is float:  # its specification checks the value, in any unit
        return not isinstance(value, str | list | tuple | Mapping)
    if kind is str:  # a path may also be given as text
        return isinstance(value, str | os.PathLike)
    if kind is Path:
        return isinstance(value, os.PathLike)
    if kind is bool:
        return type(value).__name__ in ("bool", "bool_")
    return not isinstance(kind, type) or isinstance(value, kind)


def describe_type(kind: Any) -> str:
    """Return a declared type as a phrase, such as "text, a path or a list of them"."""
    words: dict[Any, str] = {str: "text", Path: "a path", bool: "True or False", float: "a number"}
    words |= {Callable: "a function", Mapping: "a mapping"}
    members = [member for member in variants(kind) if member is not types.NoneType]
    lists = [member for member in members if get_origin(member) in (Sequence, Collection)]
    names = ((get_origin(member) or member) for member in members if member not in lists)
    phrases = list(dict.fromkeys(words.get(name) or f"a {name.__name__}" for name in names))
    for (inner,) in map(get_args, lists):
        has_phrase = phrases and set(variants(inner)) <= set(members)
        phrases.append(f"a list of {'them' if has_phrase else describe_type(inner)}")
    return " or ".join(filter(None, [", ".join(phrases[:-1]), phrases[-1]]))


def variants(kind: Any) -> Iterator[Any]:
    """Return the members of a union, or the annotation itself."""
    if get_origin(kind) in (typing.Union, types.UnionType):
        for inner in get_args(kind):
            yield from variants(inner)
    else:
        yield kind


def command_line_name(python_name: str, group: str = "") -> str:
    """Return the command line name of a function, after the word `group`, such as "export c"."""
    words = python_name.removeprefix(f"{group.replace('-', '_')}_") if group else python_name
    return f"{group} {words.replace('_', '-')}".lstrip()
