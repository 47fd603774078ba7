"""CSV text that a spreadsheet does not interpret as formulas.

A cell that begins with `=`, `+`, `-`, `@`, a tab or a carriage return, and is not a number, gets a
leading apostrophe, which spreadsheets interpret as "text". The same applies to a piece of a comment
line, because a spreadsheet splits the line at commas, semicolons or tabs. `restore_cell` and
`restore_comment` remove the apostrophe, so that every text is restored exactly.
"""

import re
from collections.abc import Iterable, Sequence

_NUMBER = r"[+-]?(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][+-]?\d+)?|[+-]?(?:inf|nan)"
_FORMULA = re.compile(rf"(?!(?:{_NUMBER})\Z)['\"]*[=+\-@\t\r]")
_MARKED = re.compile(r"'['\"]*[=+\-@\t\r]")
_QUOTED = re.compile(r'[",\r\n]')
_PIECES = (re.compile(r"(?<=\t)[^\t]*"), re.compile(r"(?<=[,;])[^,;]*"))
"""Pieces of a comment line; tabs come first, because a tab may begin a piece after a semicolon."""
Cell = str | float | None


def format_cell(value: Cell) -> str:
    """Return a value as a cell: a number with all its digits, None as empty text."""
    if isinstance(value, str):
        return _guard_cell(value)
    return "" if value is None else repr(value)


def restore_cell(text: str) -> str:
    """Return the text that was passed to `format_cell`."""
    return text[1:] if _MARKED.match(text) else text


def format_rows(rows: Iterable[Sequence[Cell]]) -> str:
    """Return the rows of a table as CSV, one line each."""
    return "".join(",".join(_quote(format_cell(value)) for value in row) + "\n" for row in rows)


def comment(text: str) -> str:
    """Return a text as a comment line above a table; line breaks become spaces."""
    line = "# " + " ".join(text.splitlines())
    for piece in _PIECES:
        line = piece.sub(lambda m: _guard_cell(m[0]), line)
    return line


def restore_comment(line: str) -> str:
    """Return a comment line without the apostrophes that `comment` added."""
    for piece in reversed(_PIECES):
        line = piece.sub(lambda m: restore_cell(m[0]), line)
    return line


def _guard_cell(text: str) -> str:
    return f"'{text}" if _FORMULA.match(text) else text


def _quote(text: str) -> str:
    return '"' + text.replace('"', '""') + '"' if _QUOTED.search(text) else text
