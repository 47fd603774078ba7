"""What a command prints: one JSON object, or lines that fit a terminal."""

from __future__ import annotations

import json
import math
import shutil
import textwrap
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from layerjam.units import show


@dataclass(kw_only=True)
class Answer:
    """One command's answer: keys as in the contract, SI values, units, warnings.

    `lines` are further lines for people only; keys in `hidden` are left out of the table, those in
    `shown` stand there as the text given.
    """

    values: dict[str, Any]
    units: dict[str, str]
    warnings: Sequence[str] = ()
    lines: Sequence[str] = ()
    hidden: Sequence[str] = ()
    shown: Mapping[str, str] = field(default_factory=dict)

    def print(self, as_json: bool) -> None:
        """Print it the way that was asked for."""
        if as_json:
            whole = {**self.values, "units": self.units, "warnings": list(self.warnings)}
            print(json.dumps(_plain(whole), indent=2, allow_nan=False))
            return
        width = min(shutil.get_terminal_size((80, 24)).columns, 100)
        for line in self.table(width):
            print(line)

    def table(self, width: int) -> list[str]:
        """The lines of the table, no longer than `width`."""
        rows = {k: v for k, v in self.values.items() if k not in self.hidden}
        wide = max((len(k) for k in rows), default=0)
        out = []
        for key, value in rows.items():
            text = self.shown.get(key) or _text(value, self.units.get(key, ""))
            out += _wrapped(text, f"{key.replace('_', ' '):<{wide}}  ", width)
        for line in self.lines:
            out += _wrapped(line, "", width) if line else [""]
        for warning in dict.fromkeys(self.warnings):
            out += _wrapped(warning, "note: ", width)
        return out


def _wrapped(text: str, head: str, width: int) -> list[str]:
    body = text.lstrip(" ")
    indent = " " * (len(text) - len(body))
    hang = " " * len(head) if head else indent + "    "
    return textwrap.wrap(
        body,
        width,
        initial_indent=head + indent,
        subsequent_indent=hang,
        break_long_words=False,
        break_on_hyphens=False,
    ) or [head.rstrip()]


def _text(value: Any, unit: str) -> str:
    if value is None:
        return "-"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, int | float):
        return show(float(value), unit or "1")
    return str(value)


def _plain(value: Any) -> Any:
    """JSON has no NaN: what is not finite is not known."""
    if isinstance(value, Mapping):
        return {str(k): _plain(v) for k, v in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(v) for v in value]
    if isinstance(value, bool | int | str) or value is None:
        return value
    number = float(value)
    return number if math.isfinite(number) else None
