"""CSV as every file of ours is written: no text in it is a formula to a spreadsheet.

A cell that begins with `=`, `+`, `-`, `@`, a tab or a carriage return, and is no number, gets an
apostrophe in front, which spreadsheets take as "text". So does such a piece of a comment line,
which a spreadsheet cuts at commas, semicolons or tabs. `plain_cell` and `plain_comment` take it off
again: every text comes back as it was.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence

_NUMBER = r"[+-]?(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][+-]?\d+)?|[+-]?(?:inf|nan)"
_FORMULA = re.compile(rf"(?!(?:{_NUMBER})\Z)['\"]*[=+\-@\t\r]")
_MARKED = re.compile(r"'['\"]*[=+\-@\t\r]")
_QUOTED = re.compile(r'[",\r\n]')
_PIECES = (re.compile(r"(?<=\t)[^\t]*"), re.compile(r"(?<=[,;])[^,;]*"))
"""A tab may begin a piece between semicolons, so tabs come first."""
Cell = str | float | None


def cell(value: Cell) -> str:
    """A value as a cell: a number in all its digits, None as nothing."""
    if isinstance(value, str):
        return _guarded(value)
    return "" if value is None else repr(value)


def plain_cell(text: str) -> str:
    """The text that `cell` was given."""
    return text[1:] if _MARKED.match(text) else text


def rows_text(rows: Iterable[Sequence[Cell]]) -> str:
    """Rows of a table as CSV, a line each."""
    return "".join(",".join(_quoted(cell(one)) for one in row) + "\n" for row in rows)


def comment(text: str) -> str:
    """A line above a table, `# ` before the text; line ends in it become spaces."""
    line = "# " + " ".join(text.splitlines())
    for piece in _PIECES:
        line = piece.sub(lambda m: _guarded(m[0]), line)
    return line


def plain_comment(line: str) -> str:
    """A comment line as it was before it was made safe."""
    for piece in reversed(_PIECES):
        line = piece.sub(lambda m: plain_cell(m[0]), line)
    return line


def _guarded(text: str) -> str:
    return f"'{text}" if _FORMULA.match(text) else text


def _quoted(text: str) -> str:
    return '"' + text.replace('"', '""') + '"' if _QUOTED.search(text) else text
