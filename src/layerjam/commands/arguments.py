"""Arguments of a call by name, their errors, and the members of an annotation."""

from __future__ import annotations

import difflib
import inspect
import types
import typing
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any, get_args, get_origin

from layerjam.errors import ArgumentError


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
    except TypeError as error:
        missing = [name for name in list(needed)[len(args) :] if name not in named]
        meanings = "; ".join(f"{name} ({needed[name].rstrip('.')})" for name in missing)
        words = f"needs {meanings}" if missing else str(error)
        raise ArgumentError(f"{function}() {words}") from None


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
