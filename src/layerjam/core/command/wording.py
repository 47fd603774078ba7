"""Values and sentences as printed by the command line."""

import textwrap
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from layerjam.core.units import show

NAMED = 3
"""Number of files that are named in a line about files that were read alike."""


def format_words(value: Any, unit: str) -> str:
    """Return a value as text; for an array, its shape and range instead of its elements."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, int | float):
        return show(float(value), unit or "1")
    if hasattr(value, "shape") and hasattr(value, "dtype"):
        if not value.shape:
            return format_words(value.item(), unit)
        low, high = (show(float(edge), unit or "1") for edge in (value.min(), value.max()))
        return f"{' × '.join(map(str, value.shape))} values, {low} to {high}"
    if isinstance(value, list | tuple):
        return ", ".join(format_words(v, unit) for v in value)
    return str(value)


def format_share(share: float) -> str:
    """Return a share as text, such as "95 %"."""
    return f"{share * 100:.4g} %"


def format_interval(ends: tuple[float | None, float | None], unit: str, value: Any) -> str:
    """Return such as " (95 %: 1 kPa to 2 kPa)" for a value; empty if no end or width is known."""
    text = format_ends(ends, unit, value)
    return f" ({text})" if text else ""


def format_ends(
    ends: tuple[float | None, float | None], unit: str, value: Any, digits: int = 4
) -> str:
    """Return such as "95 %: 1 kPa to 2 kPa" for a value; empty if no end or width is known."""
    low, high = (None if end is None else show(end, unit, digits, like=value) for end in ends)
    if low == high:
        return ""
    if low is None or high is None:
        return f"95 %: {'above' if high is None else 'below'} {high or low}"
    return f"95 %: {low} to {high}"


def format_readings(readings: Mapping[str, Sequence[str]] | Sequence[str]) -> Iterator[str]:
    """Yield how files were read: one line for each, or for all that were read alike.

    `readings` is {file: sentences}, or the sentences about the only file.
    """
    by_file = readings if isinstance(readings, Mapping) else {"": readings}
    names_by_reading: dict[tuple[str, ...], list[str]] = {}
    for file, sentences in by_file.items():
        if sentences:
            names_by_reading.setdefault(tuple(dict.fromkeys(sentences)), []).append(Path(file).name)
    for sentences, files in names_by_reading.items():
        names = ", ".join(files[:NAMED]) + (
            f" and {len(files) - NAMED} more" * (len(files) > NAMED)
        )
        yield f"{names}: {'; '.join(sentences)}" if names else "; ".join(sentences)


def list_section(title: str, entries: Iterable[str], width: int) -> list[str]:
    """Return a title and indented entries, wrapped to `width`; nothing if there are none."""
    lines = [line for entry in entries for line in wrap_text(f"  {entry}", "", width)]
    return ["", title, *lines] if lines else []


def raise_powers(text: str) -> str:
    """Return the text with raised exponents: m/s²."""
    return text.replace("^2", "²").replace("^3", "³")


def strip_control_codes(line: str) -> str:
    """Return the line without characters that a terminal would interpret as commands."""
    return "".join(c if c.isprintable() else "?" for c in line)


def wrap_text(text: str, head: str, width: int) -> list[str]:
    """Return the lines of a text, wrapped to `width`; `head` precedes the first line."""
    body = text.lstrip(" ")
    indent = " " * (len(text) - len(body))
    hang = " " * len(head) if head else indent + "    "
    lines = textwrap.wrap(
        body,
        width,
        initial_indent=head + indent,
        subsequent_indent=hang,
        break_long_words=False,
        break_on_hyphens=False,
    )
    return lines or [head.rstrip()]
