"""Names and units of columns, from the header lines above the numbers."""

import re
from collections.abc import Sequence

from layerjam.measure.readers import words
from layerjam.measure.readers.columns import Header, find_role, split_unit
from layerjam.measure.readers.lines import can_be_number, split_line
from layerjam.measure.readers.unit_words import unit_role, weight_unit
from layerjam.measure.readers.words import normalise_name

MOST_COLUMNS = 300
_BRACKETED = re.compile(r"[(\[<{].*[)\]>}]")
_GROUPS = re.compile(r"[^()\[\]]*[(\[][^()\[\]]*[)\]]")
_COMMENT = re.compile(r"^\s*(?:#+|%+|//|!|\*)\s*")
_OTHER_UNIT = re.compile(
    r"[-\u2013]|%|°|[kmMG]?Pa|.{0,6}/.{1,6}|[kmM]?V|°?[CF]|deg|N·?m|[kmcµ]?m[²³23]|#|--*|Hz|J|psi|ksi"
)


def find_head(above: Sequence[tuple[int, str]], separator: str, width: int) -> Header | None:
    """Return names and units from the lines (number, text) above `width` columns of numbers.

    The last line may contain the units, with the names above it, or the names with their units. If
    it contains neither, the lines above it are tried. None if no line has enough fields.
    """
    rows = [(n, _split_fields(text, separator, width)) for n, text in above]
    best: Header | None = None
    for count in range(min(3, len(rows))):
        remaining = rows[: len(rows) - count]
        if count and not _is_skippable(rows[len(remaining)][1]):
            break
        head = _read_head(remaining, width)
        if head is not None and head.style:
            return head
        best = best or head
    return best


def _is_skippable(fields: Sequence[str]) -> bool:
    """Return whether a line can be skipped because none of its fields names a column."""
    return not any(find_role(f) or unit_role(f) for f in fields if f)


def _read_head(rows: Sequence[tuple[int, list[str]]], width: int) -> Header | None:
    """Return the header that ends with the last of `rows`."""
    number, last = rows[-1]
    if not 2 <= len(last) <= MOST_COLUMNS:
        return None
    units = _read_unit_row(last)
    if units is not None:
        for distance in (2, 3):
            if len(rows) < distance:
                break
            above_number, above = rows[-distance]
            if len(last) <= len(above) <= MOST_COLUMNS and not _are_numbers(above):
                return _make_head(above_number, above, units, last, rows[:-distance])
            if len(above) >= 2 and not _are_numbers(above):
                break
        if {r[0] for u in units if u and (r := unit_role(u))} >= {"force", "elongation"}:
            return Header(
                tuple(f"column {i + 1}" for i in range(len(last))), units, "units", number
            )
    pairs = [split_unit(f) for f in last]
    if any(u is not None and unit_role(u) for _, u in pairs):
        style = "names"
    else:
        style = "names" if any(u is not None for _, u in pairs) else ""
        upper = _read_unit_row(rows[-2][1]) if len(rows) > 1 else None
        if upper is not None and len(upper) == len(last):
            return Header(tuple(last), upper, "units above", number)
    return Header(
        tuple(n for n, _ in pairs),
        tuple(u for _, u in pairs),
        style,
        number,
        _find_label(rows[:-1]),
    )


def _make_head(
    number: int,
    names: Sequence[str],
    units: tuple[str | None, ...],
    fields: Sequence[str],
    above: Sequence[tuple[int, list[str]]],
) -> Header:
    all_units = units + (None,) * (len(names) - len(units))
    columns = list(zip(names, map(split_unit, names), all_units, strict=True))
    in_brackets = all(_BRACKETED.fullmatch(f) for f in fields if f)
    return Header(
        tuple(p[0] if u is None or p[1] else n for n, p, u in columns),
        tuple(_choose_unit(p[1], u) for _, p, u in columns),
        "bracket row" if in_brackets else "plain row",
        number,
        _find_label(above),
    )


def _choose_unit(in_name: str | None, in_row: str | None) -> str | None:
    """Return the unit of a column, which may be in its name and in the row of units."""
    name_role, row_role = unit_role(in_name or ""), unit_role(in_row or "")
    if name_role and row_role and name_role != row_role:
        return f"{in_name} and {in_row}"  # treat the unit as unknown: the file contradicts itself
    return in_row if in_row is not None else in_name


def _are_numbers(fields: Sequence[str]) -> bool:
    return all(can_be_number(f) for f in fields if f)


def _find_label(above: Sequence[tuple[int, list[str]]]) -> tuple[str, ...]:
    """Return the line above the names, which may contain the numbers of the specimens."""
    return tuple(above[-1][1]) if above else ()


def _read_unit_row(fields: Sequence[str]) -> tuple[str | None, ...] | None:
    """Return the units in a line that contains nothing else; None for any other line."""
    start = re.match(r"[^:]{2,20}:\s*(?=\S)", fields[0])
    if start and re.search(words.UNIT, normalise_name(start[0])):
        fields = [fields[0][start.end() :], *fields[1:]]  # for example: Units: s, mm, N
    units = tuple(re.sub(r"^[(\[<{]\s*|\s*[)\]>}]$", "", f).strip() or None for f in fields)
    if any(len(u or "") > 20 for u in units):
        return None
    known_units = sum(u is not None and unit_role(u) is not None for u in units)
    in_brackets = sum(bool(_BRACKETED.fullmatch(f)) for f in fields)
    other_units = sum(
        unit_role(u or "") is None and (_OTHER_UNIT.fullmatch(u or "") is not None) for u in units
    )
    units_present = sum(u is not None for u in units)
    # a name may look like a unit ("m"), so most fields of the line must be units
    if known_units and (
        in_brackets == units_present or (known_units + other_units) * 2 >= units_present
    ):
        return units
    return None


def _split_fields(text: str, separator: str, width: int) -> list[str]:
    """Return the fields of a header line, with any separator, without comment signs."""
    text = _COMMENT.sub("", text) if _COMMENT.match(text) else text
    if separator != " ":
        fields = trim_fields(split_line(text, separator))
        if len(fields) > 1 or width < 2:
            return fields
        for mark in ("\t", ";", ",", "|"):
            cells = trim_fields(split_line(text, mark))
            if mark != separator and len(cells) == width:
                return cells
        return fields
    for cells in _list_splits(text):
        if len(cells) == width:
            return cells
    return text.split()


def _list_splits(text: str) -> list[list[str]]:
    """Return the ways to split a header line at blanks, commas or tabs, most likely first."""
    ways = [trim_fields(split_line(text, mark)) for mark in ("\t", ";", ",", "|") if mark in text]
    ways.append([w.strip() for w in re.split(r"\s{2,}|\t", text.strip())])
    ways.append(text.split())
    if len(text) < 2000:
        ways.append([w.strip(" ,;") for w in _GROUPS.findall(text)])
    return ways


def trim_fields(fields: list[str]) -> list[str]:
    """Return the fields without empty ones at the end, which are due to trailing separators."""
    count = len(fields)
    while count and not fields[count - 1]:
        count -= 1
    return fields[:count]


def find_stated_units(texts: Sequence[str]) -> dict[str, str]:
    """Return units stated in lines above the table, such as `Force unit;kN`, `Einheit Weg: mm`."""
    units_of: dict[str, set[str]] = {"time": set(), "elongation": set(), "force": set()}
    for text in texts:
        if len(text) > 200:
            continue
        match = re.match(
            r"\W*([^:=;,\t|\"]+?)\"?\s*[:=;,\t|]+\s*\"?([^:=;,\t|\"]+?)\"?[\s;,\t|]*$", text
        )
        if not match or not re.search(words.UNIT, normalise_name(match[1])):
            continue
        unit, role_named = unit_role(match[2]), find_role(match[1])
        if unit and role_named == unit[0]:
            units_of[unit[0]].add(match[2])
        elif role_named == "force" and weight_unit(match[2]):
            units_of["force"].add(match[2])
    return {role: units.pop() for role, units in units_of.items() if len(units) == 1}
