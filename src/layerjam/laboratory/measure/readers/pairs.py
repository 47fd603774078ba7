"""Channels with times of their own: each column of numbers follows its column of time."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

from layerjam.laboratory.measure.options import ColumnEntry
from layerjam.laboratory.measure.readers.header import Column, Want
from layerjam.laboratory.measure.readers.lines import Rows


def pair_times(rows: Rows, wants: Sequence[Want], entries: Mapping[str, ColumnEntry]) -> Rows:
    """Return the rows with only the channel of the required quantity, if each has its own times.

    Files such as `Time, Hammer, Time, Acceleration` have a column of time before every channel.
    The first required quantity other than time selects the channel. The channels may end at
    different rows. Other files are unchanged.
    """
    header = rows.table.header
    clock = next((w for w in wants if w.role == "time" and w.role not in entries), None)
    main_column = next((w for w in wants if w.role != "time" and not w.optional), None)
    times = [c.index for _, c in header.candidates(clock)] if clock else []
    if (
        main_column is None
        or len(times) < 2
        or {header.names[i] for i in times} != {header.names[times[0]]}
    ):
        return rows
    channel = _find_only_column(header.candidates(main_column, entries.get(main_column.role)))
    if channel is None or channel.index < times[0]:
        return rows
    start = max(i for i in times if i < channel.index)
    end = min((i for i in times if i > start), default=len(header.names))
    part = header.select(range(start, end))
    return replace(rows, table=replace(rows.table, header=part), shared=True)


def _find_only_column(candidates: Sequence[tuple[int, Column]]) -> Column | None:
    """Return the column with the best rank, None unless there is exactly one."""
    best = min((rank for rank, _ in candidates), default=None)
    first = [column for rank, column in candidates if rank == best]
    return first[0] if len(first) == 1 else None
