"""Texts that `help` and `dir` show for commands and for their results."""

from __future__ import annotations

import inspect
import textwrap
from collections.abc import Callable, Iterable
from typing import Any

_NAMES = """
    record warnings verdict failed_checks accepted exit_code values units require interval table
    json save plot to_frame to_xarray
"""
PUBLIC = frozenset(_NAMES.split())
"""Members of every result that are listed; those of a subclass are listed too."""


def list_members(names: Iterable[str], base: type) -> list[str]:
    """Return the names without those that `base` defines for the program's own use."""
    internal = {*vars(base)} - PUBLIC
    return sorted(n for n in names if n.startswith("__") or n not in internal)


def document(function: Callable[..., Any]) -> None:
    """Give the function of a command a short signature, and a docstring with its parameters.

    The module of the command must be complete, because annotations name its contents.
    """
    declaration: Any = function.declaration  # type: ignore[attr-defined]
    parameters = list({p.name: p for p in declaration.parameters}.values())
    places = sorted(map(_place_parameter, parameters), key=lambda place: place.kind)
    function.__signature__ = inspect.Signature(places)  # type: ignore[attr-defined]
    lines = (_describe_parameter(p) for p in parameters if p.name != "progress")
    function.__doc__ = "\n".join([declaration.doc, "", "Parameters:", *lines])


def _place_parameter(p: Any) -> inspect.Parameter:
    """Return the place of a declared parameter in the signature."""
    kind = (
        inspect.Parameter.POSITIONAL_OR_KEYWORD if p.positional else inspect.Parameter.KEYWORD_ONLY
    )
    if p.several:
        return inspect.Parameter(p.name, inspect.Parameter.VAR_POSITIONAL)
    default = inspect.Parameter.empty if p.required else p.default
    return inspect.Parameter(p.name, kind, default=default)


def _describe_parameter(p: Any) -> str:
    """Return the line of a parameter in a docstring: unit, meaning and default."""
    unit = f" [{p.spec.unit}]" if p.spec is not None and p.spec.unit != "1" else ""
    has_default = not p.required and p.default not in (None, ())
    default = f" Default {p.default_text or p.default}." if has_default else ""
    sentence = p.sentence or f"One of {', '.join(p.words)}."
    return textwrap.fill(
        f"{p.name}{unit}: {sentence}{default}",
        96,
        initial_indent=" " * 4,
        subsequent_indent=" " * 8,
    )
