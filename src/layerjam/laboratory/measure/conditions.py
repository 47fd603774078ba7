"""Conditions of a test, from its sidecar, a list for the whole folder, or the file name."""

import csv
import io
import re
import unicodedata
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import Any

from layerjam.core.errors import FileError, QuantityError, UnknownNameError
from layerjam.core.toml_files.table_text import restore_cell
from layerjam.core.toml_files.toml import read_text
from layerjam.core.toml_files.values import entries
from layerjam.core.units import FlagSpec, QuantitySpec, show
from layerjam.laboratory.measure.options import ReadingOptions
from layerjam.laboratory.measure.readers.column_names import split_unit
from layerjam.laboratory.measure.readers.unit_words import convert_unit
from layerjam.laboratory.measure.sidecar import Facts, read_facts

LIST = "conditions.csv"
"""Name of a table in the folder of the files: one row per file, whose name is in column `file`."""
FILE = "file"
_FIELDS = {name: entry for name, entry in entries(Facts) if not isinstance(entry.spec, FlagSpec)}
_IN_NAMES = {
    name: entry.spec for name, entry in _FIELDS.items() if isinstance(entry.spec, QuantitySpec)
}
_NUMBER = r"\d+(?:[.,p]\d+)?"


def read_conditions(path: str | Path, options: ReadingOptions) -> Facts:
    """Return the conditions of a test from its sidecar, the folder's list and the file name.

    `options.names` is the pattern of the file name, `options.speed` [m/s] the default speed. Raises
    FileError if a list or a name cannot be read or two sources disagree, and QuantityError for an
    invalid pattern.
    """
    facts = read_facts(path)
    sources = {"its sidecar": _select_sidecar_values(facts), LIST: _read_list_values(Path(path))}
    if options.names is not None:
        sources["its name"] = _parse_name_values(Path(path), options.names)
    joined_values: dict[str, Any] = {}
    source_of: dict[str, str] = {}
    for source, values in sources.items():
        for name, value in values.items():
            if name in joined_values and joined_values[name] != value:
                first, second = (_format_value(name, v) for v in (joined_values[name], value))
                raise FileError(
                    path,
                    (
                        f"{source_of[name]} states {name} {first}, but {source} states "
                        f"{second}; correct one"
                    ),
                )
            joined_values[name], source_of[name] = value, source
    facts_found = replace(facts, **joined_values)
    return (
        facts_found if facts_found.speed is not None else replace(facts_found, speed=options.speed)
    )


def _select_sidecar_values(facts: Facts) -> dict[str, Any]:
    return {name: v for name in _FIELDS if (v := getattr(facts, name)) not in (None, "")}


def _format_value(name: str, value: Any) -> str:
    spec = _FIELDS[name].spec
    return show(value, spec.unit) if isinstance(spec, QuantitySpec) else f"'{value}'"


def _read_list_values(path: Path) -> Mapping[str, Any]:
    place = path.parent / LIST
    try:
        status = place.stat()
    except (OSError, ValueError):
        return {}
    name = unicodedata.normalize("NFC", path.name)
    return _read_list(place, status.st_mtime_ns, status.st_size).get(name, {})


@lru_cache(maxsize=16)
def _read_list(path: Path, _time: int, _size: int) -> dict[str, dict[str, Any]]:
    return parse_list(read_text(path), path)


def parse_list(text: str, path: str | Path) -> dict[str, dict[str, Any]]:
    """Return {file name: {key: SI value}} from a list; a FileError names `path` and the line."""
    mark = max(",;\t", key=text.partition("\n")[0].count)
    rows = [(n, row) for n, row in enumerate(csv.reader(io.StringIO(text), delimiter=mark), 1)]
    rows = [
        (n, [restore_cell(cell.strip()) for cell in row])
        for n, row in rows
        if any(map(str.strip, row))
    ]
    if not rows:
        raise FileError(path, "is empty")
    heads = [split_unit(cell) for cell in rows[0][1]]
    names = [name.strip().lower().replace(" ", "_") for name, _ in heads]
    for name in names:
        if name not in (FILE, *_FIELDS):
            raise FileError(path, str(UnknownNameError("column", name, [FILE, *_FIELDS])), 1)
    if FILE not in names or len(set(names)) < len(names):
        raise FileError(path, f"needs one column '{FILE}' with the file names", 1)
    out: dict[str, dict[str, Any]] = {}
    for number, row in rows[1:]:
        cells = dict(zip(names, zip(row, (u for _, u in heads), strict=False), strict=False))
        file = unicodedata.normalize("NFC", cells.pop(FILE, ("", None))[0])
        if not file or file in out:
            fault = f"lists '{file}' twice" if file else "has a row without a file name"
            raise FileError(path, fault, number)
        try:
            out[file] = {
                name: _cell_value(name, cell.replace(",", ".") if mark != "," else cell, unit)
                for name, (cell, unit) in cells.items()
                if cell
            }
        except QuantityError as err:
            raise FileError(path, str(err), number) from None
    return out


def _cell_value(name: str, text: str, unit: str | None) -> Any:
    """Return the SI value of a cell or of part of a name; the column heading may state its unit."""
    of_number = name in _IN_NAMES and unit is not None
    return _FIELDS[name].spec.read(f"{text} {unit}" if of_number else text, name)


def _parse_name_values(path: Path, names: str) -> dict[str, Any]:
    """Return the values in a file name, by the first of the patterns that matches it."""
    matches = (
        (pattern.fullmatch(path.name) or pattern.fullmatch(path.stem), units)
        for pattern, units in _parse_patterns(names)
    )
    match, units = next((pair for pair in matches if pair[0] is not None), (None, {}))
    if match is None:
        hint = "" if "|" in names else "; for two kinds of names, separate two patterns by |"
        fault = f"its name does not follow the pattern '{names}'"
        raise FileError(path, fault, how=f" (--names{hint})")
    try:
        return {
            name: _cell_value(name, re.sub(r"(?<=\d)[,p](?=\d)", ".", text), units[name])
            for name, text in match.groupdict().items()
        }
    except QuantityError as err:
        raise FileError(path, f"its name, read with the pattern '{names}': {err}") from None


@lru_cache(maxsize=64)
def _parse_patterns(names: str) -> list[tuple[re.Pattern[str], dict[str, str | None]]]:
    """Return the patterns between | signs; raises QuantityError if none has a quantity."""
    patterns = [_compile_pattern(part) for part in names.split("|")]
    if not any(units for _, units in patterns):
        raise QuantityError(f"names: '{names[:60]}' contains no quantity; {_describe_pattern()}")
    return patterns


def _compile_pattern(names: str) -> tuple[re.Pattern[str], dict[str, str | None]]:
    """Return the regular expression of a pattern, and the unit of each quantity in it."""
    units: dict[str, str | None] = {}
    parts: list[str] = []
    for part in re.split(r"(\{[^{}]*\}|\*)", names):
        if part == "*":
            parts.append(".*?")
        elif part.startswith("{"):
            name, _, unit = (word.strip() for word in part[1:-1].partition(":"))
            parts.append(_make_quantity_group(name, unit, units))
        else:
            parts.append(re.escape(part))
    return re.compile("".join(parts)), units


def _make_quantity_group(name: str, unit: str, units: dict[str, str | None]) -> str:
    if name not in _IN_NAMES:
        raise UnknownNameError("quantity in a file name", name, _IN_NAMES)
    if name in units:
        raise QuantityError(f"names: {{{name}}} appears twice")
    si = _IN_NAMES[name].unit
    if unit and (si == "1" or convert_unit(unit, si) is None):
        raise QuantityError(f"names: '{unit[:20]}' is not a unit of {name}; {_describe_pattern()}")
    units[name] = unit or None
    in_name = "" if unit or si == "1" else r"\s?[A-Za-zµ]+(?:/[A-Za-z]+)?"
    return rf"(?P<{name}>{_NUMBER}{in_name})"


def _describe_pattern(quantities: Sequence[str] = tuple(_IN_NAMES)) -> str:
    return (
        f"use a pattern such as 'pull_{{vacuum}}_{{speed:mm/s}}_*' with {', '.join(quantities)}; "
        "put a unit inside the braces if the name has none, and * for any text"
    )
