"""Values and sentences as printed by the command line."""

import textwrap
from typing import Any

from layerjam.units import show


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
