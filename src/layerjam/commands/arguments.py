"""Arguments of a call by name, their errors, and the members of an annotation."""

from __future__ import annotations

import difflib
import inspect
import os
import types
import typing
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, get_args, get_origin

from layerjam.errors import ArgumentError, QuantityError, UnknownNameError, abbreviate


def bind(
    function: str,
    signature: inspect.Signature,
    flattened: Iterable[str],
    needed: Mapping[str, str],
    args: Sequence[Any],
    named: Mapping[str, Any],
) -> dict[str, Any]:
    """Return the arguments of a call by name.

    `flattened` are names of parameters that stand for fields of others, `needed` is
    {required parameter: its meaning}. Raises ArgumentError for an unknown name, with the nearest
    ones, and for missing arguments, with their meaning.
    """
    names = [*signature.parameters, *flattened]
    for name in named:
        if name not in signature.parameters:
            suggestions = difflib.get_close_matches(name, names, n=2, cutoff=0.5)
            hint = (
                f"did you mean {' or '.join(suggestions)}?"
                if suggestions
                else f"it has {', '.join(names)}"
            )
            raise ArgumentError(f"{function}() has no parameter '{name}'; {hint}")
    try:
        return dict(signature.bind(*args, **named).arguments)
    except TypeError:
        missing = [name for name in list(needed)[len(args) :] if name not in named]
        meanings = "; ".join(f"{name} ({needed[name].rstrip('.')})" for name in missing)
        order = [n for n, p in signature.parameters.items() if p.kind is p.POSITIONAL_OR_KEYWORD]
        twice = [name for name in order[: len(args)] if name in named]
        rest = [name for name in signature.parameters if name not in order]
        if missing:
            words = f"needs {meanings}"
        elif twice:
            words = f"got {twice[0]} twice"
        else:
            words = (
                f"takes {', '.join(order) or 'nothing'} without a name, not {len(args)} values; "
                f"write the others by name, such as {(rest or order)[0]}=..."
            )
        raise ArgumentError(f"{function}() {words}") from None


def settings_of(
    name: str, cls: type, given: Any, loose: Mapping[str, Any], known: Sequence[str]
) -> Mapping[str, Any]:
    """Return the `known` options of a record, `given` as a whole or `loose`, by name.

    Raises ArgumentError for both, UnknownNameError for an option that the record does not have, and
    QuantityError for what is not such a record.
    """
    if isinstance(given, Mapping):
        given, loose = None, {**given, **loose}
    if unknown := [key for key in loose if key not in known]:
        raise UnknownNameError(f"option of {name}", str(unknown[0]), known)
    if given is None:
        return loose
    if loose:
        raise ArgumentError(f"give {name} or {', '.join(loose)}, not both")
    if not all(hasattr(given, key) for key in known):
        raise QuantityError.of(name, f"{abbreviate(given)} is not a {cls.__name__} or a mapping")
    return {key: getattr(given, key) for key in known}


def several(value: Any, kind: Any) -> Any:
    """Return an iterator, or one member where only a list of them is allowed, as a list."""
    if isinstance(value, Iterator):
        return list(value)
    return [value] if not fits(value, kind) and fits([value], kind) else value


def check_kind(value: Any, kind: Any, name: str) -> None:
    """Raise QuantityError for an argument that is not of its declared type."""
    if not fits(value, kind):
        raise QuantityError.of(name, f"{abbreviate(value)} is not {describe(kind)}")


def fits(value: Any, kind: Any) -> bool:
    """Return whether an argument is of a declared type; what only type checkers know fits all."""
    origin, inside = get_origin(kind), get_args(kind)
    if origin in (typing.Union, types.UnionType):
        return any(fits(value, one) for one in inside)
    if origin is typing.Literal:
        return value in inside
    if origin is Callable:
        return callable(value)
    if origin is Mapping:
        return isinstance(value, Mapping)
    if origin in (Sequence, Collection):
        each = isinstance(value, Iterable) and not isinstance(value, str | bytes | Mapping)
        return each and not hasattr(value, "columns") and all(fits(one, inside[0]) for one in value)
    if kind is float:  # its specification checks it, in each unit
        return not isinstance(value, str | list | tuple | Mapping)
    if kind is Path:
        return isinstance(value, os.PathLike)
    if kind is bool:
        return type(value).__name__ in ("bool", "bool_")
    return not isinstance(kind, type) or isinstance(value, kind)


def describe(kind: Any) -> str:
    """Return a declared type as a phrase, such as "text, a path or a list of them"."""
    words: dict[Any, str] = {str: "text", Path: "a path", bool: "True or False", float: "a number"}
    words |= {Callable: "a function", Mapping: "a mapping"}
    members = [one for one in union(kind) if one is not types.NoneType]
    lists = [one for one in members if get_origin(one) in (Sequence, Collection)]
    names = ((get_origin(one) or one) for one in members if one not in lists)
    phrases = list(dict.fromkeys(words.get(name) or f"a {name.__name__}" for name in names))
    for (each,) in map(get_args, lists):
        same = phrases and set(union(each)) <= set(members)
        phrases.append(f"a list of {'them' if same else describe(each)}")
    return " or ".join(filter(None, [", ".join(phrases[:-1]), phrases[-1]]))


def union(kind: Any) -> Iterator[Any]:
    """The members of an annotation: those of a union, or itself."""
    if get_origin(kind) in (typing.Union, types.UnionType):
        for inner in get_args(kind):
            yield from union(inner)
    else:
        yield kind


def typed(python_name: str, under: str = "") -> str:
    """Return the name on the command line of a function, after the word `under`: "export c"."""
    rest = python_name.removeprefix(f"{under.replace('-', '_')}_") if under else python_name
    return f"{under} {rest.replace('_', '-')}".lstrip()
