"""What a command prints: one JSON object, or lines that fit a terminal."""

from __future__ import annotations

import json
import math
import os
import shutil
import sys
import textwrap
from collections.abc import Mapping, Sequence
from typing import Any

from layerjam.commands.answer import Answer
from layerjam.units import show


def say(
    answer: Answer,
    as_json: bool,
    *,
    lines: Sequence[str] = (),
    hidden: Sequence[str] = (),
    shown: Mapping[str, str] | None = None,
) -> int:
    """Print an answer the way that was asked for; gives the exit code.

    For people: keys in `hidden` are left out, those in `shown` stand as the text given, `lines`
    follow. 1 where the answer is "cannot", 3 where some of several files were refused, else 0.
    """
    if as_json:
        whole = {
            **answer.values, "units": answer.units, "warnings": list(dict.fromkeys(answer.warnings))
        }  # fmt: skip
        text = json.dumps(_plain(whole), indent=2, allow_nan=False)
    else:
        width = min(shutil.get_terminal_size((80, 24)).columns, 100)
        plain = (
            "".join(c if c.isprintable() else "?" for c in line)
            for line in table(answer, width, lines, hidden, shown or {})
        )
        text = "\n".join(plain)
    try:
        print(text, flush=True)
    except BrokenPipeError:  # a reader such as `head` has seen enough; the answer stands
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    if answer.values.get("feasible") is False:
        return 1
    return 3 if answer.refused else 0


def table(
    answer: Answer,
    width: int,
    lines: Sequence[str],
    hidden: Sequence[str],
    shown: Mapping[str, str],
) -> list[str]:
    """The lines of the table, no longer than `width`."""
    rows = {k: v for k, v in answer.values.items() if k not in hidden}
    wide = max((len(k) for k in rows), default=0)
    out = []
    for key, value in rows.items():
        text = shown.get(key) or _text(value, answer.units.get(key, ""))
        out += _wrapped(text, f"{key.replace('_', ' '):<{wide}}  ", width)
    for line in lines:
        out += _wrapped(line, "", width) if line else [""]
    if answer.refused:
        out += ["", "refused:"]
        for path, why in answer.refused.items():
            out += _wrapped(f"  {path}: {why}", "", width)
    for warning in dict.fromkeys(answer.warnings):
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
