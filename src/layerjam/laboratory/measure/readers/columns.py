"""Assignment of columns to quantities, by units first, then by names in several languages.

A unit has priority over a name: a column in s is the time, whatever its name. Among several columns
of one dimension, the name determines the choice (standard travel before absolute crosshead
position), and the trace states the choice. If neither identifies it, the file is rejected.
"""

from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction

from layerjam.laboratory.measure.options import SKIP, ColumnEntry
from layerjam.laboratory.measure.readers.column_names import shorten
from layerjam.laboratory.measure.readers.header import (
    PULL,
    Column,
    Header,
    MachineWant,
    Want,
    find_conflict,
)
from layerjam.laboratory.measure.readers.hints import suggest_columns, suggest_order
from layerjam.laboratory.measure.readers.unit_words import (
    convert_unit,
    force_unit_for,
    is_other_unit,
)


def assign_by_order(
    header: Header, wants: Sequence[Want], entries: Mapping[str, ColumnEntry], count: int
) -> "Assignment":
    """Return the columns in the user's order; raises FileError if the file has more or fewer."""
    if count != len(header.names):
        raise header.error(
            f"has {len(header.names)} columns",
            f", but --columns lists {count}; write one entry per column, '{SKIP}' for unused ones "
            f"({suggest_order(header, wants)})",
        )
    columns = {}
    for want in wants:
        if (entry := entries.get(want.role)) is not None and entry.index is not None:
            known = convert_unit(entry.unit, want.si) or (Fraction(1), 0.0)
            name = header.names[entry.index]
            columns[want.role] = Column(want.role, entry.index, name, entry.unit, *known, True)
        elif not want.optional:
            raise header.error(
                f"the list has no column of {want.role}", f" ({suggest_order(header, wants)})"
            )
    return columns, [column.describe() for column in columns.values()]


Assignment = tuple[dict[str, Column], list[str]]
"""{role: column}, and sentences that describe the interpretation."""


def assign_columns(
    header: Header,
    wants: Sequence[Want],
    entries: Mapping[str, ColumnEntry],
    are_equal: Callable[[Sequence[Column]], bool] | None = None,
) -> Assignment:
    """Return the column of each required quantity, and sentences that describe the choice.

    `are_equal` returns whether several columns are the same measurement; the first is then used.
    Raises FileError if a column is missing or ambiguous, or has no unit or a wrong dimension.
    """
    columns: dict[str, Column] = {}
    sentences = []
    for want in wants:
        entry = entries.get(want.role)
        candidates = header.candidates(want, entry)
        if not candidates:
            if entry is not None or not want.optional:
                reason = _explain_missing(header, want, entry)
                raise header.error(reason, suggest_columns(header, wants, entries))
            sentences += _note_unread_column(header, want)
            continue
        best = min(rank for rank, _ in candidates)
        first = [c for rank, c in candidates if rank == best]
        spare = want.optional and want.role == "time"
        if len(first) > 1 and not spare and not (are_equal and are_equal(first)):
            labels = [f"'{header.name_column(c.index)}'" for c in first[:4]]
            if want.optional and entry is None:
                names = ", ".join(labels)
                sentences.append(
                    f"the {want.role} is not read: several columns may be it ({names})"
                )
                continue
            raise header.error(
                f"does not state which column is the {want.role}: {' or '.join(labels)}; name one",
                suggest_columns(header, wants, entries),
            )
        columns[want.role] = column = first[0]
        if column.given and (conflict := find_conflict(header, column, want.si)):
            raise header.error(
                f"{conflict}; give the unit that the file states, or, if the file is wrong, list "
                "its columns in order",
                f" ({suggest_order(header, wants, {column.index: column})})",
            )
        others = [c for _, c in candidates if c is not column]
        sentences += _note_unknown_unit(header, column, want.si)
        by_unit = isinstance(want, MachineWant) and not want.can_be_named(column.name)
        sentences.append(column.describe(others, by_unit))
    return columns, sentences


def has_all_columns(
    header: Header, entries: Mapping[str, ColumnEntry], wants: Sequence[Want] = PULL
) -> bool:
    """Return whether there is a column for every required quantity."""
    return all(header.candidates(w, entries.get(w.role)) for w in wants if not w.optional)


def _explain_missing(header: Header, want: Want, entry: ColumnEntry | None) -> str:
    same_name = [
        index
        for index, name in enumerate(header.names)
        if (index in header.find_columns(entry.name or "") if entry else want.can_be_named(name))
    ]
    if same_name and (entry is None or not header.units[same_name[0]]):
        return _explain_unit(want, *header.columns[same_name[0]])
    mass_columns = [(n, u) for n, u in header.columns if u and force_unit_for(u)]
    if entry is None and want.si == "N" and len(mass_columns) == 1:
        return _explain_unit(want, *mass_columns[0])
    if entry is not None:
        name = shorten(entry.name or "")
        return f"has no column '{name}' with a unit of {want.role}; {header.describe()}"
    return f"has no column with a unit of {want.role} ({want.unit_names}); {header.describe()}"


def _note_unread_column(header: Header, want: Want) -> list[str]:
    for name, unit in header.columns:
        if want.can_be_named(name):
            reason = (
                f"is in '{shorten(unit)}', which is not a unit of {want.role}"
                if unit
                else "has no unit"
            )
            return [f"the {want.role} is not read: column '{shorten(name)}' {reason}"]
    return []


def _note_unknown_unit(header: Header, column: Column, si: str) -> list[str]:
    """Return a note if the user's unit replaces one in the file that is not known."""
    file_unit = header.units[column.index]
    if not column.given or not file_unit or convert_unit(file_unit, si):
        return []
    name = shorten(header.names[column.index])
    return [
        f"the unit of column '{name}', '{shorten(file_unit)}', is unknown: {column.unit} is used"
    ]


def list_unit_conflicts(
    header: Header, columns: Mapping[str, Column], wants: Sequence[Want]
) -> list[str]:
    """Return the conflicts between the units in the file and those that the user lists."""
    conflicts = [find_conflict(header, columns[w.role], w.si) for w in wants if w.role in columns]
    return [f"{conflict}; the given unit takes precedence" for conflict in conflicts if conflict]


def _explain_unit(want: Want, name: str, unit: str | None) -> str:
    role, label = want.role, shorten(name)
    if not unit:
        return f"column '{label}' has no unit; {role} needs a unit such as {want.unit_names}"
    text = f"column '{label}' is in '{shorten(unit)}', which is not a unit of {role}"
    weight = force_unit_for(unit) if want.si == "N" else None
    if weight:
        return f"{text}, a unit of mass; if its weight is meant, that is {weight}"
    if is_other_unit(unit, want.units[0], want.si):
        return f"{text}; name another column"
    return f"{text}; it needs a unit such as {want.unit_names}"
