"""Tables in a text: blocks of numbers, each with names and units above it."""

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import pairwise

import numpy as np

from layerjam.core.errors import FileError
from layerjam.laboratory.measure.readers import words
from layerjam.laboratory.measure.readers.column_names import find_role, split_unit
from layerjam.laboratory.measure.readers.header import Header
from layerjam.laboratory.measure.readers.lines import Lines, Table, can_be_number, split_line
from layerjam.laboratory.measure.readers.unit_words import unit_role
from layerjam.laboratory.measure.readers.words import normalise_name

_MOST_BLOCKS = 2000
_MOST_HEADS = 200
_LINES_ABOVE = 8
MOST_COLUMNS = 300
_BRACKETED = re.compile(r"[(\[<{].*[)\]>}]")
_GROUPS = re.compile(r"[^()\[\]]*[(\[][^()\[\]]*[)\]]")
_COMMENT = re.compile(r"^\s*(?:#+|%+|//|!|\*)\s*")
_OTHER_UNIT = re.compile(
    r"[-\u2013]|%|°|[kmMG]?Pa|.{0,6}/.{1,6}|[kmM]?V|°?[CF]|deg|N·?m|[kmcµ]?m[²³23]|#|--*|Hz|J|psi|ksi"
)


@dataclass(frozen=True)
class Block:
    """Consecutive lines of numbers with the lines above them; lines are counted from 0.

    `rows` is the number of non-blank lines, `width` the number of fields in the first line. A
    `pure` block contains only numbers. `table` is the table to read, None if no line above can
    contain names.
    """

    first: int
    last: int
    rows: int
    width: int
    pure: bool
    above: tuple[int, ...]
    table: Table | None
    title: str = ""

    @property
    def has_units(self) -> bool:
        """Return whether there are units above the block."""
        return self.table is not None and bool(self.table.header.style)


def find_headless_table(lines: Lines, blocks: list[Block]) -> Table | None:
    """Return a header at the end of the file, without numbers below it."""
    first_line = blocks[-1].last + 1 if blocks else 0
    text_lines = _select_text_lines(lines, range(first_line, len(lines.starts)))
    head = _find_head(lines, text_lines[-_LINES_ABOVE:], 0)
    return Table(head, lines.separator, len(lines.source.data)) if head else None


def make_bare_table(lines: Lines, block: Block) -> Table:
    """Return the table of a block whose columns the user lists, ignoring the lines above."""
    names = tuple(f"column {i + 1}" for i in range(block.width))
    path = lines.source.path
    header = Header(names, (None,) * block.width, "", block.first + 1, path=path)
    return _make_table(header, lines, block)


def _make_table(header: Header, lines: Lines, block: Block) -> Table:
    first, last = int(lines.starts[block.first]), int(lines.stops[block.last]) + 1
    only_blanks_follow = bool(lines.blank[block.last + 1 :].all())
    return Table(header, lines.separator, first, None if only_blanks_follow else last, block.rows)


def _find_head(lines: Lines, above: Sequence[tuple[int, str]], width: int) -> Header | None:
    header = find_head([(n + 1, t) for n, t in above], lines.separator, width) if above else None
    return replace(header, path=lines.source.path) if header else None


def find_blocks(lines: Lines) -> list[Block]:
    """Return the blocks of numbers in order; raises FileError if there are too many.

    Headers are searched for only above the two hundred largest blocks.
    """
    rows = np.flatnonzero(~lines.blank)
    number = lines.number[rows]
    # a header may contain a number and follow rows of numbers, such as 2,Time,Load
    for place in np.flatnonzero(number & ~lines.pure[rows])[: 2 * _MOST_BLOCKS]:
        _mark_header_numbers(lines, rows, number, int(place))
    if len(rows) and number[0]:
        _mark_header_numbers(lines, rows, number, 0)
    _mark_statistics(lines, rows, number)
    change = np.flatnonzero(np.diff(number)) + 1
    bounds = [0, *change.tolist(), len(rows)]
    spans = [(a, b) for a, b in pairwise(bounds) if a < b and number[a]]
    if len(spans) > _MOST_BLOCKS:
        raise FileError(
            lines.source.path, f"has {len(spans)} blocks of numbers separated by text; not a table"
        )
    sizes = sorted((b - a for a, b in spans), reverse=True)
    min_size = sizes[_MOST_HEADS] if len(sizes) > _MOST_HEADS else 0
    blocks, line_before = [], 0
    for a, b in spans:
        above = tuple(rows[line_before:a][-_LINES_ABOVE:].tolist()) if b - a > min_size else ()
        blocks.append(_make_block(lines, rows[a:b], above))
        line_before = b
    return blocks


def _mark_header_numbers(lines: Lines, rows: np.ndarray, number: np.ndarray, place: int) -> None:
    """Mark names or units that contain a number ("Time (s)", "1") as text."""
    for k in range(place, min(place + 3, len(rows))):
        if lines.pure[rows[k]]:
            return
        fields = [f for f in lines.fields(int(rows[k])) if f]
        spec = sum(bool(find_role(f) or unit_role(f)) for f in fields if not can_be_number(f))
        if spec * 2 < len(fields) or spec < 2:
            return
        number[k] = False


def _mark_statistics(lines: Lines, rows: np.ndarray, number: np.ndarray) -> None:
    """Mark statistics below the numbers ("Mean;1.2;3.4") as text if only statistics follow.

    They begin with the name of a statistic, or follow a blank line.
    """
    pure = lines.pure[rows]
    pure_rows = np.flatnonzero(pure)
    if not pure_rows.size or pure_rows[-1] == len(rows) - 1 or len(rows) - pure_rows[-1] > 200:
        return
    first = int(pure_rows[-1]) + 1
    is_separate = rows[first] - rows[first - 1] > 1
    head = next((f for f in lines.fields(int(rows[first])) if f), "")
    if not can_be_number(head) and (
        is_separate or re.search(words.STATISTIC, words.normalise_name(head))
    ):
        number[first:] = False


def _make_block(lines: Lines, inside: np.ndarray, above: tuple[int, ...]) -> Block:
    first, last = int(inside[0]), int(inside[-1])
    width = len(trim_fields(lines.fields(first)))
    texts = _select_text_lines(lines, above)
    head = _drop_empty_columns(_find_head(lines, texts, width), width)
    titles = [lines.text(n).strip(' \t;,"|#') for n in above if n not in {t[0] for t in texts}]
    title = titles[-1] if titles else ""
    pure = bool(lines.pure[inside].all())
    block = Block(first, last, len(inside), width, pure, above, None, title)
    return replace(block, table=_make_table(head, lines, block)) if head else block


def _drop_empty_columns(head: Header | None, width: int) -> Header | None:
    if head is None or not 2 <= width < len(head.names) or any(head.units[width:]):
        return head
    return replace(head, names=head.names[:width], units=head.units[:width])


def _select_text_lines(lines: Lines, above: tuple[int, ...] | range) -> list[tuple[int, str]]:
    """Return the number and text of the lines above that have at least two fields."""
    texts = []
    for line in above:
        if lines.blank[line]:
            continue
        text = lines.text(line)
        if sum(1 for f in _split_text(text, lines.separator) if f) >= 2:
            texts.append((line, text))
    return texts


@lru_cache(maxsize=1024)
def _split_text(text: str, separator: str) -> list[str]:
    fields = split_line(text, separator)
    others = (split_line(text, mark) for mark in ("\t", ";", ",", "|") if mark in text)
    return fields if len(fields) > 1 else max(others, key=len, default=fields)


def share_headers(lines: Lines, blocks: list[Block]) -> Iterator[Block]:
    """Yield the blocks; below a title such as "Specimen 2", the previous header is used."""
    block_before: Block | None = None
    for plain_block in blocks:
        block = plain_block
        if (
            block_before is not None
            and block_before.table is not None
            and block.width == block_before.width
            and not block.has_units
            and 0 < len(block.above) <= 3
            and re.search(words.SPECIMEN, words.normalise_name(lines.text(block.above[0])))
        ):
            title = lines.text(block.above[0]).strip(' ;,"\t')
            table = _make_table(block_before.table.header, lines, block)
            block = replace(block, table=table, title=title)
        yield block
        if block.has_units:
            block_before = block


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
