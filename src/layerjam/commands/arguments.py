"""Arguments of a call by name, and the errors for those that are missing or unknown."""

from __future__ import annotations

import difflib
import inspect
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

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
            near = difflib.get_close_matches(name, names, n=2, cutoff=0.5)
            hint = f"did you mean {' or '.join(near)}?" if near else f"it has {', '.join(names)}"
            raise ArgumentError(f"{function}() has no parameter '{name}'; {hint}")
    try:
        return dict(signature.bind(*args, **named).arguments)
    except TypeError as error:
        missing = [name for name in list(needed)[len(args) :] if name not in named]
        each = "; ".join(f"{name} ({needed[name].rstrip('.')})" for name in missing)
        words = f"needs {each}" if missing else str(error)
        raise ArgumentError(f"{function}() {words}") from None
