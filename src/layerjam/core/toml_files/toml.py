"""TOML text: parsing, line numbers of keys, and quoting."""

import codecs
import difflib
import re
import tomllib
from pathlib import Path
from typing import Any

from layerjam.core.errors import FileError

MAX_NAMES = 5_000
"""Maximum number of names in a folder that are compared with a missing file's name."""


def suggest_nearby(path: Path) -> str:
    """Return a suggestion: the nearest name in a missing file's folder, or ""."""
    try:
        if path.exists():
            return ""
        names = [p.name for p, _ in zip(path.parent.iterdir(), range(MAX_NAMES), strict=False)]
    except (OSError, ValueError):
        return ""
    matches = difflib.get_close_matches(path.name, names, n=1, cutoff=0.8)
    return f"; did you mean {path.with_name(matches[0])}?" if matches else ""


MAX_BYTES = 1_000_000


def parse_toml(text: str, path: object) -> dict[str, Any]:
    """Return the tables of a TOML text; raises FileError with the line if it is not TOML."""
    if len(text) > MAX_BYTES:
        raise FileError(path, f"is larger than {MAX_BYTES // 1000} kB, the limit for TOML files")
    for number, row in enumerate(text.split("\n"), 1):
        if row.count(".") > 300:  # tomllib takes minutes for a key with thousands of parts
            raise FileError(path, "has a line with more than 300 dots, the limit", number)
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as err:
        match = re.search(r"\(at line (\d+), column (\d+)\)", str(err))
        reason = re.sub(r"\s*\(at .*\)", "", str(err))
        line = int(match.group(1)) if match else text.count("\n") + 1
        reason += f", at column {match.group(2)}" if match else ""
        wrong = text.splitlines()[line - 1 : line] if line <= text.count("\n") + 1 else []
        if wrong and re.search(r"=\s*[\d.]+\s*[A-Za-z%µ]", wrong[0][:200]):
            reason += '; put a quantity in quotes, such as "0.254 mm"'
        raise FileError(path, f"is not valid TOML: {reason}", line) from None
    except (ValueError, RecursionError) as err:
        raise FileError(path, f"is not valid TOML: {str(err)[:80]}") from None


def read_text(path: Path) -> str:
    """Return the text of a small TOML file; raises FileError if it cannot be read."""
    try:
        if path.is_dir():
            raise FileError(path, "is a folder, not a file")
        # opening a pipe or a device may block indefinitely
        if path.exists() and not path.is_file():
            raise FileError(path, "is not a regular file")
        with path.open("rb") as handle:
            raw = handle.read(MAX_BYTES + 1)
    except (OSError, ValueError) as err:
        problem = f"cannot be read: {getattr(err, 'strerror', None) or err}"
        raise FileError(path, problem, how=suggest_nearby(path)) from None
    if len(raw) > MAX_BYTES:
        raise FileError(path, f"is larger than {MAX_BYTES // 1000} kB, the limit for TOML files")
    return decode_toml(raw, path)


def decode_toml(raw: bytes, path: object) -> str:
    """Return the text of a TOML file in UTF-8, or in UTF-16 as written by PowerShell's `>`.

    Raises FileError if the bytes are neither.
    """
    is_wide = raw.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE))
    try:
        return raw.decode("utf-16" if is_wide else "utf-8-sig")
    except UnicodeDecodeError as err:
        line = raw[: err.start].count(b"\n") + 1
        raise FileError(path, "is not UTF-8 text; save it as UTF-8", line) from None


def find_line(text: str, path: str) -> int | None:
    """Return the line on which a dotted path is set, or None.

    In an array of tables, [[name]], the first table that sets it is used.
    """
    table, _, key = path.rpartition(".")
    section = ""
    table_line = None
    for number, line in enumerate(text.splitlines(), 1):
        if len(line) > 400:  # keys are never indented that far, and the pattern below is slow there
            continue
        head = re.match(r"\[{1,2}([^\[\]]+)\]", line.strip())
        if head:
            section = head.group(1).strip()
            if section in (path, table):
                table_line = table_line or number
            if section == path:
                return number
        elif (section == table and re.match(rf"\s*\"?{re.escape(key)}\"?\s*[=.]", line)) or (
            not section and re.match(rf"\s*{re.escape(path)}\s*[=.]", line)
        ):
            return number
    return table_line or (find_line(text, table) if "." in table else None)


def find_row(text: str, words: str) -> int | None:
    """Return the number of the first line that contains some words, or None."""
    rows = enumerate(text.splitlines(), 1)
    return next((number for number, row in rows if words and words in row), None)


def quote(text: str) -> str:
    """Return a text as a quoted TOML string."""
    out = []
    for char in text:
        if char in '"\\':
            out.append("\\" + char)
        elif ord(char) < 32 or 127 <= ord(char) < 160 or char in "\u2028\u2029":
            out.append(f"\\u{ord(char):04x}")
        else:
            out.append(char)
    return '"' + "".join(out) + '"'
