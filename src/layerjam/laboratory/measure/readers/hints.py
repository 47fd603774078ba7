"""Hints of errors about columns: options that work when they are typed."""

from collections.abc import Collection, Mapping, Sequence

from layerjam.core.system import quote_word
from layerjam.laboratory.measure.options import SKIP, ColumnEntry
from layerjam.laboratory.measure.readers.column_names import find_role
from layerjam.laboratory.measure.readers.header import Column, Header, Want
from layerjam.laboratory.measure.readers.unit_words import (
    convert_unit,
    force_unit_for,
    is_other_unit,
)
from layerjam.laboratory.measure.readers.words import normalise_name

SYMBOLS = {
    "time": ("t",),
    "elongation": ("x", "s", "u", "d", "l", "δ"),
    "slip": ("x", "s", "u", "d"),
    "force": ("f", "p"),
    "pressure": ("p",),
    "acceleration": ("a",),
    "stress": ("σ", "s"),
    "strain": ("ε", "e"),
}
"""{role: symbols that may name its column}; they guide a hint, and never a reading."""


def suggest_columns(
    header: Header, wants: Sequence[Want], entries: Mapping[str, ColumnEntry]
) -> str:
    """Return " (--columns ...)", naming a column for every required quantity that has none.

    It keeps the user's valid entries, and is empty if no column could be meant. If neither names
    nor units identify any column, it lists all of them in order.
    """
    if not entries and not header.style and not any(map(find_role, header.names)):
        order = suggest_order(header, wants)
        return f" ({order})" if order else ""
    parts, used = [], set()
    for want in wants:
        entry = entries.get(want.role)
        keeps = [c for _, c in header.candidates(want, entry)] if entry else []
        if entry and keeps:
            parts.append(format_entry(want.role, entry.unit, header.name_column(keeps[0].index)))
            used.add(keeps[0].index)
            continue
        if want.optional and entry is None:
            continue
        candidates = header.candidates(want)
        best = [c for rank, c in candidates if rank == min(candidates, key=lambda c: c[0])[0]]
        if best:
            used.add(best[0].index)
            if len(best) > 1 or entry:
                parts.append(format_entry(want.role, "", header.name_column(best[0].index)))
            continue
        index = guess_column(header, want, used)
        if index is None:
            return ""
        used.add(index)
        unit = force_unit_for(header.units[index] or "") if want.si == "N" else None
        parts.append(format_entry(want.role, unit or want.units[0], header.name_column(index)))
    return f" (specify it: --columns {quote_word(','.join(parts))})" if parts else ""


def suggest_order(
    header: Header, wants: Sequence[Want], columns_given: Mapping[int, Column] | None = None
) -> str:
    """Return "--columns ..." with one entry for each column, in order; empty if there are too few.

    Names, symbols and units decide if they can; the other columns follow in the usual order.
    """
    required_columns = [w for w in wants if not w.optional] or list(wants[:2])
    if len(header.names) > len(required_columns):
        required_columns = [w for w in wants if w in required_columns or w.role == "time"]
    roles: dict[int, str] = {
        i: format_entry(c.role, c.unit) for i, c in (columns_given or {}).items()
    }
    roles_taken = {c.role for c in (columns_given or {}).values()}
    open_columns = [w for w in required_columns if w.role not in roles_taken]
    for want in list(open_columns):
        index = guess_column(header, want, roles, by_order=False)
        candidates = header.candidates(want)
        if candidates and index is None:
            index = min(candidates, key=lambda pair: pair[0])[1].index
        if index is None or index in roles:
            continue
        unit = header.units[index] or ""
        known = convert_unit(unit, want.si) is not None
        roles[index] = format_entry(want.role, unit if known else want.units[0])
        open_columns.remove(want)
    for want in open_columns:
        index = next((i for i in range(len(header.names)) if i not in roles), None)
        if index is None:
            return ""
        roles[index] = format_entry(want.role, want.units[0])
    entries = (roles.get(i, SKIP) for i in range(len(header.names)))
    return f"--columns {quote_word(','.join(entries))}"


def format_entry(role: str, unit: str, name: str = "") -> str:
    """Return an entry of `columns`: ROLE:UNIT=NAME, or ROLE:UNIT for a list in order."""
    return role + (f":{unit}" if unit else "") + (f"={name}" if name else "")


def guess_column(
    header: Header, want: Want, taken_columns: Collection[int], by_order: bool = True
) -> int | None:
    """Return the column without a unit of another quantity that most likely has this quantity."""
    free = [
        i
        for i, (name, unit) in enumerate(header.columns)
        if i not in taken_columns
        and (name or unit)
        and not (unit and is_other_unit(unit, want.units[0], want.si) and not force_unit_for(unit))
    ]
    by_name = [i for i in free if want.can_be_named(header.names[i])]
    symbols = [i for i in free if normalise_name(header.names[i]) in SYMBOLS.get(want.role, ())]
    heavy = [i for i in free if want.si == "N" and force_unit_for(header.units[i] or "")]
    bare_columns = [i for i in free if not header.units[i] and not find_role(header.names[i])]
    return next(iter([*by_name, *symbols, *heavy, *(bare_columns if by_order else ())]), None)
